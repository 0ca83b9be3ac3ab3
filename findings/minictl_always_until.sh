#!/usr/bin/env bash
# Guess: A[p U q], "on each path p until q", is false where a path has no q at all; it says at least what AF q says.
# Package: PyPI minictl 0.1.9
# Seen: It is true in each state from which some path never comes to q: where a robot moves for ever and never docks, A[moving U
#   docked] holds and AF docked does not. It comes out as not E[not q U (not p and not q)] or EG not q, in place of the negation
#   of both. The other operators were right in 3,000 drawn models and formulas.
# Source: Clarke, Emerson (1981): A[p U q] is the least set that holds q, and p where all successors are in it; found by drawing
#   models and comparing with that fixpoint
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q minictl==0.1.9 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from minictl import CTLChecker, CTLFormula, Model, State

MODELS = {
    "moves for ever": ({"a": ["a"]}, {"a": {"moving"}}),
    "docks or stops": ({"a": ["b", "c"], "b": ["b"], "c": ["c"]}, {"a": {"moving"}, "b": {"docked"}, "c": set()}),
    "docks": ({"a": ["b"], "b": ["b"]}, {"a": {"moving"}, "b": {"docked"}}),
    "docks after a pause": ({"a": ["b"], "b": ["b"]}, {"a": set(), "b": {"docked"}}),
}
SEEN = {
    "moves for ever": ("a", ""),
    "docks or stops": ("abc", "b"),
    "docks": ("ab", "ab"),
    "docks after a pause": ("b", "ab"),
}
for name, (edges, labels) in MODELS.items():
    checker = CTLChecker(Model([State(state, holds) for state, holds in labels.items()], edges))
    found = [
        "".join(sorted(checker.check(CTLFormula.parse(formula)))) for formula in ("A[moving U docked]", "AF docked")
    ]
    print(f"{name}: A[moving U docked] in {found[0] or 'no state'}, AF docked in {found[1] or 'no state'}")
    assert tuple(found) == SEEN[name], "the behaviour has changed"
PYTHON
