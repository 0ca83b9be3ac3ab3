#!/usr/bin/env bash
# Guess: In a dynamic fault tree of the Galileo format csp is a cold spare, which cannot fail while it is not used, and hsp a hot
#   one, which fails as if it were; the dormancy factor matters to wsp alone.
# Package: PyPI stormpy 2.0.0 (Storm's reader of Galileo)
# Seen: All three kinds, and "spare", are one: dorm alone decides. csp of events without dorm is hot, so that a spare that cannot
#   fail does; hsp of events with dorm=0 is cold. Nothing is said.
# Source: Galileo user's manual (csp, wsp, hsp; dorm); two events of rate 1 by time 1: (1-1/e)^2 hot, 1-2/e cold; found by
#   running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q stormpy==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import math

import stormpy
import stormpy.dft

(failed,) = stormpy.parse_properties('P=? [F<=1 "failed"]')


def probability(gate, dormancy):
    with open("tree.dft", "w") as file:
        file.write(f'toplevel "T";\n"T" {gate} "A" "B";\n"A" lambda=1{dormancy};\n"B" lambda=1{dormancy};\n')
    return stormpy.dft.analyze_dft(stormpy.dft.load_dft_galileo_file("tree.dft"), [failed])[0]


hot, cold = (1 - math.exp(-1)) ** 2, 1 - 2 * math.exp(-1)
for gate in ("csp", "wsp", "hsp"):
    found = {dormancy: probability(gate, dormancy) for dormancy in ("", " dorm=0", " dorm=1")}
    print(gate, {dormancy: round(value, 6) for dormancy, value in found.items()})
    for dormancy, expected in (("", hot), (" dorm=0", cold), (" dorm=1", hot)):
        assert abs(found[dormancy] - expected) < 1e-6, "the behaviour has changed"
PYTHON
