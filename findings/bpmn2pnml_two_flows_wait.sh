#!/usr/bin/env bash
# Guess: the net that is made of a BPMN process has its behaviour: a task with two incoming flows runs for each of them, an inclusive
#   gateway takes one branch or both; its PNML says the type of the net on the net; and a net that gets stuck is not called clean.
# Package: PyPI bpmn2pnml-ltl-analyzer 0.1.0
# Seen: The task waits for both flows: behind an exclusive gateway, which takes one, the net is stuck before it, and the analysis of
#   the net finds no defect there. The inclusive gateway is a parallel one as it splits, and passes each token on as it joins, so that
#   what follows runs twice. type and id stand on <pnml>, and <net> has neither; no namespace.
# Source: BPMN 2.0.2, 13.3.1 (uncontrolled flow) and 13.4.3 (inclusive gateway); ISO/IEC 15909-2; the nets below are played
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q bpmn2pnml-ltl-analyzer==0.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - 2>log <<'PYTHON' || { tail -5 log; exit 1; }
import xml.etree.ElementTree as ET
from collections import Counter

import bpmn2pnml_ltl

BPMN = "http://www.omg.org/spec/BPMN/20100524/MODEL"


def process(nodes, flows):
    flows = {f"f{number}": flow for number, flow in enumerate(flows)}
    text = f'<definitions xmlns="{BPMN}" id="d" targetNamespace="urn:d"><process id="p">'
    for name, kind in nodes.items():
        inside = "".join(f"<incoming>{key}</incoming>" for key, (_, end) in flows.items() if end == name)
        inside += "".join(f"<outgoing>{key}</outgoing>" for key, (begin, _) in flows.items() if begin == name)
        text += f'<{kind} id="{name}" name="{name}">{inside}</{kind}>'
    for key, (begin, end) in flows.items():
        text += f'<sequenceFlow id="{key}" sourceRef="{begin}" targetRef="{end}"/>'
    return text + "</process></definitions>"


def answer(name, nodes, flows):
    with open(f"{name}.bpmn", "w") as file:
        file.write(process(nodes, flows))
    return bpmn2pnml_ltl.run_pipeline(f"{name}.bpmn")


def ends(pnml):
    """The markings in which the net stops, as its arcs and its initial marking say."""
    (net,) = ET.fromstring(pnml)
    start = Counter({place.get("id"): int(place.find("initialMarking/text").text) for place in net.iter("place")})
    moves = {step.get("id"): (Counter(), Counter()) for step in net.iter("transition")}
    for arc in net.iter("arc"):
        begin, end = arc.get("source"), arc.get("target")
        if end in moves:
            moves[end][0][begin] += 1
        else:
            moves[begin][1][end] += 1
    seen, found, left = set(), set(), [start]
    while left:
        marking = left.pop()
        key = tuple(sorted((+marking).items()))
        if key in seen:
            continue
        seen.add(key)
        following = [marking - taken + given for taken, given in moves.values() if taken <= marking]
        left += following
        if not following:
            found.add(key)
    return found


flows = [("s", "g"), ("g", "a"), ("g", "b"), ("a", "j"), ("b", "j"), ("j", "e")]
kinds = {"s": "startEvent", "a": "task", "b": "task", "e": "endEvent"}
merged = answer("merged", kinds | {"g": "exclusiveGateway", "j": "task"}, flows)
inclusive = answer("inclusive", kinds | {"g": "inclusiveGateway", "j": "inclusiveGateway"}, flows)
found = {name: ends(report["pnml"]) for name, report in (("task", merged), ("inclusive", inclusive))}
root = ET.fromstring(merged["pnml"])
print(found, merged["comparison"]["pnml_verdict"], root.attrib, root[0].attrib)
assert found["task"] == {(("f3", 1),), (("f4", 1),)}, "the behaviour has changed"
assert merged["comparison"]["pnml_verdict"] == "clean", "the behaviour has changed"
assert found["inclusive"] == {(("end_p_e", 2),)}, "the behaviour has changed"
assert root.tag == "pnml" and set(root.attrib) == {"type", "id"} and not root[0].attrib, "the behaviour has changed"
PYTHON
