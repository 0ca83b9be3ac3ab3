#!/usr/bin/env bash
# Guess: The probability of an OR of two independent events of 0.75 each is 0.9375 in a table of results; or, where cut
#   sets are only summed, at most 1.
# Package: PyPI sfta 0.9.1
# Seen: The column "probability" says 1.5.
# Source: the package's README, "Limitations": contributions of minimal cut sets are simply summed
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q sfta==0.9.1 2>pip.log || { cat pip.log; exit 1; }
printf '%s\n' '- time_unit: h' '' 'Gate: TOP' '- label: top' '- type: OR' '- inputs: A, C' '' \
    'Event: A' '- label: a' '- probability: 0.75' '' 'Event: C' '- label: c' '- probability: 0.75' > tree.txt
venv/bin/sfta tree.txt >/dev/null
cat tree.txt.out/gates.tsv
grep -q "$(printf 'probability\t1.5\t')" tree.txt.out/gates.tsv || { echo "the behaviour has changed"; exit 1; }
