#!/usr/bin/env bash
# Guess: One formula of one package has one answer for one trace, whether the trace is asked when it is over or sample by
#   sample.
# Package: PyPI sentil 0.3.1
# Seen: With samples of x = 1 each second always[1.2,1.8](x<0) holds with robustness inf for the trace, since no sample
#   lies in the window, and eventually[1.2,1.8](x>0) fails with -inf. The online monitor keeps the last sample and says
#   the opposite, -1 and 1. Beyond the end of the trace the first is inf, too, where the second has no verdict yet.
# Source: found by running it; the package's own documentation speaks of one engine for both
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q sentil==0.3.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from sentil import Formula, OnlineMonitor, Trace

trace = Trace([0, 1, 2, 3, 4], {"x": [1, 1, 1, 1, 1]})


def both(text):
    monitor = OnlineMonitor(text)
    for time in range(5):
        verdict = monitor.update(float(time), {"x": 1.0})
    return Formula.parse(text).robustness(trace), verdict.value if verdict.resolved else None


found = {text: both(text) for text in ("always[1.2,1.8](x<0)", "eventually[1.2,1.8](x>0)", "always[5,10](x<0)", "always[1,2](x<0)")}
print(found)
inf = float("inf")
assert list(found.values()) == [(inf, -1.0), (-inf, 1.0), (inf, None), (-1.0, -1.0)], "the behaviour has changed"
PYTHON
