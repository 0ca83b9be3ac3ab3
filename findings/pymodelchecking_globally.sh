#!/usr/bin/env bash
# Guess: in a model of one state in which q holds for ever, LTL's A G q is true, as CTL's is.
# Package: PyPI pyModelChecking 1.3.4
# Seen: LTL.modelcheck says false of each formula with a G in it (or a negated F): A G q, A G F q, A not F not q. CTL
#   and F, U and X alone are right; CTL* is right for A G q, and wrong for A G F q.
# Source: pyModelChecking/LTL/model_checking.py; found by running it beside another checker
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pyModelChecking==1.3.4 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pyModelChecking import Kripke
from pyModelChecking.CTL import modelcheck as ctl
from pyModelChecking.CTLS import modelcheck as ctls
from pyModelChecking.LTL import modelcheck as ltl

model = Kripke(S=[0], R=[(0, 0)], L={0: {"q"}})  # q for ever
assert ctl(model, "A G q") == {0}, "the behaviour has changed"
assert ctls(model, "A G q") == {0}, "the behaviour has changed"
for formula in ("A F q", "A X q", "A (q U q)"):
    assert ltl(model, formula) == {0}, "the behaviour has changed"
for formula in ("A G q", "A G F q", "A not F not q"):
    print(formula, ltl(model, formula))
    assert ltl(model, formula) == set(), f"the behaviour has changed: {formula}"
print("CTL*: A G F q", ctls(model, "A G F q"))
assert ctls(model, "A G F q") == set(), "the behaviour has changed"
PYTHON
