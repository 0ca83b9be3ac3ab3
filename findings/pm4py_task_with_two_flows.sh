#!/usr/bin/env bash
# Guess: In the Petri net that pm4py makes of a BPMN model, both flows out of a task are taken, as BPMN says of activities,
#   and an inclusive gateway takes at least one of its flows.
# Package: PyPI pm4py 2.7.23.11
# Seen: Of a task's two flows one is taken, as behind an exclusive gateway: b or c follows a, and never both. The inclusive
#   gateway may take none, and both tasks between it and its join are passed by.
# Source: BPMN 2.0.2, execution semantics (sequence flows of activities; inclusive gateway); to_petri_net.py of
#   pm4py/objects/conversion/bpmn/variants; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pm4py==2.7.23.11 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import pm4py
from pm4py.objects.petri_net.semantics import enabled_transitions, execute

HEAD = '<definitions xmlns="http://www.omg.org/spec/BPMN/20100524/MODEL" id="d" targetNamespace="t"><process id="p">'


def runs(nodes, flows):
    # What the tasks of a model can do until nothing is enabled.
    parts = []
    for kind, name in nodes:
        ends = "".join(f"<incoming>f{place}</incoming>" for place, flow in enumerate(flows) if flow[1] == name)
        ends += "".join(f"<outgoing>f{place}</outgoing>" for place, flow in enumerate(flows) if flow[0] == name)
        parts.append(f'<{kind} id="{name}" name="{name}">{ends}</{kind}>')
    parts += [f'<sequenceFlow id="f{place}" sourceRef="{a}" targetRef="{b}"/>' for place, (a, b) in enumerate(flows)]
    with open("model.bpmn", "w") as file:
        file.write(HEAD + "".join(parts) + "</process></definitions>")
    net, marking, _ = pm4py.convert_to_petri_net(pm4py.read_bpmn("model.bpmn"))
    found, left = set(), [(marking, "")]
    while left:
        marking, word = left.pop()
        enabled = enabled_transitions(net, marking)
        left += [(execute(transition, net, marking), word + (transition.label or "")) for transition in enabled]
        if not enabled:
            found.add(word)
    return sorted(found)


tasks = [("startEvent", "s"), ("task", "a"), ("task", "b"), ("task", "c"), ("endEvent", "x"), ("endEvent", "y")]
fork = runs(tasks, [("s", "a"), ("a", "b"), ("a", "c"), ("b", "x"), ("c", "y")])
gates = [("inclusiveGateway", "g"), ("inclusiveGateway", "j"), *tasks[:1], *tasks[2:5]]
inclusive = runs(gates, [("s", "g"), ("g", "b"), ("g", "c"), ("b", "j"), ("c", "j"), ("j", "x")])
print("a task with two flows", fork)
print("an inclusive gateway", inclusive)
assert fork == ["ab", "ac"], "the behaviour has changed"
assert inclusive == ["", "b", "bc", "c", "cb"], "the behaviour has changed"
PYTHON
