#!/usr/bin/env bash
# Guess: minimalcuts and minimalcuts_optimized of a network give the same minimal cuts, and each of the algorithms that
#   evaluate_availability names gives its availability.
# Package: PyPI pyrbd3 0.1.3 (with networkx 3.6.1)
# Seen: Of a - hub - b with a camera at b, minimalcuts gives the hub, and the hub with the camera, which is not minimal; the ends,
#   each a cut by itself, are not listed. minimalcuts_optimized gives the three. With algorithm="pyrbd" the network is a TypeError,
#   for a cut of one node is a number there and not a list; "sdp", "mcs" and "pathset" give 0.729.
# Source: a cut is minimal if no part of it is one; 0.9 to the power of 3; found by running it beside all subsets of drawn networks
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pyrbd3==0.1.3 networkx==3.6.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import networkx
from pyrbd3 import evaluate_availability, minimalcuts, minimalcuts_optimized

A, HUB, B, CAMERA = 0, 1, 2, 3
network = networkx.Graph([(A, HUB), (HUB, B), (B, CAMERA)])


def sets(cuts):
    return sorted(sorted(cut) if isinstance(cut, (list, tuple, set)) else [cut] for cut in cuts)


def availability(algorithm):
    try:
        answer = evaluate_availability(network, dict.fromkeys(network, 0.9), src=A, dst=B, algorithm=algorithm)
    except TypeError:
        return "TypeError"
    return round(answer[-1] if isinstance(answer, tuple) else answer, 6)


found = sets(minimalcuts(network, A, B)), sets(minimalcuts_optimized(network, A, B))
print(*found, sep="\n")
assert found == ([[HUB], [HUB, CAMERA]], [[A], [HUB], [B]]), "the behaviour has changed"
answers = {algorithm: availability(algorithm) for algorithm in ("sdp", "mcs", "pathset", "pyrbd")}
print(answers)
assert list(answers.values()) == [0.729, 0.729, 0.729, "TypeError"], "the behaviour has changed"
PYTHON
