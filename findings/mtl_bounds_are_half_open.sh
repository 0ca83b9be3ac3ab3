#!/usr/bin/env bash
# Guess: `F[0, 2] a` holds at 0 s where a becomes true at 2 s, since both bounds belong to an interval in brackets.
# Package: PyPI metric-temporal-logic 0.4.1
# Seen: It is false at 0 s, with values of truth and with robustness, and true a step (dt) later: the upper bound is left
#   out. `F[0, 2.1] a` is true.
# Source: own run; the README writes F[0, 2] and does not say which ends belong
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q metric-temporal-logic==0.4.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import mtl

SEEN = {"a": [(0, False), (2, True), (3, False)]}
MEASURED = {"a": [(0, -1.0), (2, 3.0), (3, -1.0)]}
at = {bound: mtl.parse(f"F[0, {bound}] a")(SEEN, time=0, quantitative=False) for bound in ("2", "2.1")}
robustness = mtl.parse("F[0, 2] a")(MEASURED, time=0, quantitative=True)
print(at, robustness)
raise SystemExit(None if (at, robustness) == ({"2": False, "2.1": True}, -1.0) else "the behaviour has changed")
PYTHON
