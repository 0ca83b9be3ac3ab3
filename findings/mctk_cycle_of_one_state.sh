#!/usr/bin/env bash
# Guess: In a model of two states, s0 where p holds and after it s1 where q holds for ever, EG q is true in s1, and AF p
#   is false there: from s1 there is no way back.
# Package: PyPI mctk-py 0.1.1
# Seen: EG q is true nowhere and AF p everywhere: a cycle of one state is not counted as one. Where s1 is two states that
#   take turns, both answers are right. AX, EX and EU are.
# Source: mctk/checking.py (EG begins with strongly connected components of more than one state)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q mctk-py==0.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from mctk import AF, AX, EG, KripkeStruct, SAT_atom


def model(labels, arcs):
    of = KripkeStruct()
    of.set_atoms(["p", "q"])
    for state, atoms in labels.items():
        of.add_state(state, atoms)
    of.set_starts(["s0"])
    of.add_trans(arcs)
    return of


def answers(of):
    p, q = SAT_atom(of, "p"), SAT_atom(of, "q")
    return {name: sorted(states) for name, states in (("EG q", EG(of, q)), ("AX q", AX(of, q)), ("AF p", AF(of, p)))}


loop = answers(model({"s0": ["p"], "s1": ["q"]}, {"s0": ["s1"], "s1": ["s1"]}))
print("stays in s1:", loop)
of = model({"s0": [], "s1": ["q"], "s2": ["p", "q"]}, {"s0": ["s1"], "s1": ["s2"], "s2": ["s1"]})
turns = EG(of, SAT_atom(of, "q"))
print("takes turns in s1 and s2: EG q", sorted(turns))
assert loop == {"EG q": [], "AX q": ["s0", "s1"], "AF p": ["s0", "s1"]}, "the behaviour has changed"
assert turns == {"s1", "s2"}, "the behaviour has changed"
PYTHON
