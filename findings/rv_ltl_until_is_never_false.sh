#!/usr/bin/env bash
# Guess: a monitor of a U b, in the logic of four values RV-LTL, says false as soon as neither a nor b holds: nothing that
#   comes can mend it.
# Package: PyPI rv-ltl 0.1.1
# Seen: It says "presumably false", and for ever while b does not come; false when b does. Always a, in the same run, is
#   false at once.
# Source: Bauer, Leucker, Schallhart, Comparing LTL semantics for runtime verification (2010), which the package
#   implements: false where no continuation satisfies; rv_ltl/monitor.py (UntilMonitor returns before it looks at the left)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rv-ltl==0.1.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from rv_ltl import Always, Atomic, Until

a, b = Atomic(identifier="a"), Atomic(identifier="b")


def verdicts(formula, trace):
    monitor, said = formula.create_monitor(), []
    for now in trace:
        monitor.update({"a": "a" in now, "b": "b" in now})
        said.append(monitor.evaluate().name)
    return said


trace = ("a", "", "", "")
until, always = verdicts(Until(a, b), trace), verdicts(Always(a), trace)
mended = verdicts(Until(a, b), ("a", "", "b"))
print("a U b:", until, "always a:", always, "a U b, where b comes:", mended)
assert until == ["PRESUMABLY_FALSE"] * 4 and always == ["PRESUMABLY_TRUE", *["FALSE"] * 3], "the behaviour has changed"
assert mended[-1] == "FALSE", "the behaviour has changed"
PYTHON
