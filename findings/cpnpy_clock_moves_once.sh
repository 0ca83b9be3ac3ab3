#!/usr/bin/env bash
# Guess: in the state space of a timed coloured net the clock goes on until a transition is enabled: two tokens that are ready at
#   3 and at 7 are joined at 7.
# Package: PyPI cpnpy 0.2.1 (its build_reachability_graph), with networkx 3.6.1
# Seen: The state space is one marking without a way out, a deadlock that is none: the clock moves to the next time of any token,
#   3, once, and the search gives up where that enables nothing. Both ready at 5, or one at 0 and one at 7, and they are joined.
#   A token that only lies in a last place, with a time to come, has the same effect.
# Source: Jensen, Kristensen (2009), Coloured Petri Nets, 10.3 (the clock goes to the earliest time at which a binding is enabled);
#   cpnpy/analysis/reachability.py, cpn_imp.py (advance_global_clock); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q --no-deps cpnpy==0.2.1 networkx==3.6.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from cpnpy.analysis.reachability import build_reachability_graph
from cpnpy.cpn.cpn_imp import CPN, Arc, ColorSetParser, EvaluationContext, Marking, Place, Transition

timed = ColorSetParser().parse_definitions("colset INT = int timed;")["INT"]


def joined(first, second, last=None):
    # The transitions in the state space of a net that joins two tokens, ready at these times; and one at last in the last place.
    places = [Place(name, timed) for name in ("first", "second", "end")]
    join = Transition("join", variables=["x", "y"])
    net = CPN()
    for place in places:
        net.add_place(place)
    net.add_transition(join)
    for arc in (Arc(places[0], join, "x"), Arc(places[1], join, "y"), Arc(join, places[2], "x")):
        net.add_arc(arc)
    start = Marking()
    start.set_tokens("first", [1], timestamps=[first])
    start.set_tokens("second", [2], timestamps=[second])
    start.set_tokens("end", [0] if last is not None else [], timestamps=[last] if last is not None else [])
    graph = build_reachability_graph(net, start, EvaluationContext())
    return [data["transition"] for _, _, data in graph.edges(data=True)]


found = {"5 and 5": joined(5, 5), "0 and 7": joined(0, 7), "3 and 7": joined(3, 7), "7 and 7, end 3": joined(7, 7, 3)}
print(*found.items(), sep="\n")
assert list(found.values()) == [["join"], ["join"], [], []], "the behaviour has changed"
PYTHON
