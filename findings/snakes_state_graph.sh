#!/usr/bin/env bash
# Guess: a StateGraph of SNAKES holds the states of its net: len says how many.
# Package: PyPI SNAKES 0.9.33
# Seen: It holds the initial one alone until build() is called, and says 1 for the size of any net.
# Source: snakes/nets.py (StateGraph.__len__, build)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q SNAKES==0.9.33 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import snakes.nets as nets

net = nets.PetriNet("n")
for number in range(4):
    net.add_place(nets.Place(f"p{number}", [nets.dot] if number == 0 else []))
for number in range(3):
    net.add_transition(nets.Transition(f"t{number}"))
    net.add_input(f"p{number}", f"t{number}", nets.Value(nets.dot))
    net.add_output(f"p{number + 1}", f"t{number}", nets.Value(nets.dot))
graph = nets.StateGraph(net)
before = len(graph)
graph.build()
print(before, len(graph))
assert (before, len(graph)) == (1, 4), "the behaviour has changed"
PYTHON
