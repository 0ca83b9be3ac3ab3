#!/usr/bin/env bash
# Guess: a => b => c, a chain of implications as specifications have it, is a => (b => c) in libraries of formulas, as in logic.
# Package: PyPI dd 0.6.0, pysmt 0.9.6 and omega 0.4.0
# Seen: In all three it is (a => b) => c, false where all are false. Other operators bind as guessed. pysmt writes its own formulas
#   with all parentheses.
# Source: dd/_parser.py and omega/logic/lexyacc.py ("left" for the implication), pysmt/parsing.py; found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q dd==0.6.0 pysmt==0.9.6 omega==0.4.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from dd.autoref import BDD
from omega.logic.lexyacc import Parser
from pysmt.parsing import parse
from pysmt.shortcuts import BOOL, Symbol

diagrams = BDD()
diagrams.declare("a", "b", "c")
chain, left, right = (diagrams.add_expr(text) for text in ("a => b => c", "(a => b) => c", "a => (b => c)"))
for name in "abc":
    Symbol(name, BOOL)
found = {
    "dd": "left" if chain == left else "right" if chain == right else "other",
    "pysmt": parse("a -> b -> c").serialize(),
    "omega": Parser().parse("a => b => c").flatten(),
}
print(found)
assert left != right, "the test is wrong"
assert found == {"dd": "left", "pysmt": "((a -> b) -> c)", "omega": "( ( a => b ) => c )"}, "the behaviour has changed"
PYTHON
