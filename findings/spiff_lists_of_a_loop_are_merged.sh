#!/usr/bin/env bash
# Guess: in a loop of three rounds a script that appends 1 to a list leaves three more, and one that counts up its members
#   leaves each three larger, as x = x + 1 does with a number.
# Package: PyPI SpiffWorkflow 3.2.0
# Seen: [0] and three times x.append(1) is [0, 1]; [0, 5] is unchanged by x = [x[0] + 1, x[1] + 1] and by x[0] = x[0] + 1.
#   What a round leaves of a list is merged into the list before: values that it has not are put behind it, and it is cut to
#   the new length. So only lists that grow by new values or lose their last ones come out right.
# Source: BPMN 2.0.2, 13.3.6 (a loop is the activity again); util/deep_merge.py (merge_array); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q SpiffWorkflow==3.2.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from lxml import etree
from SpiffWorkflow.bpmn.parser.BpmnParser import BpmnParser
from SpiffWorkflow.bpmn.workflow import BpmnWorkflow

PROCESS = """<definitions xmlns="http://www.omg.org/spec/BPMN/20100524/MODEL" targetNamespace="t"><process id="p" isExecutable="true">
<startEvent id="start"/><sequenceFlow id="f0" sourceRef="start" targetRef="first"/>
<scriptTask id="first"><script>x = {first}</script></scriptTask><sequenceFlow id="f1" sourceRef="first" targetRef="again"/>
<scriptTask id="again"><script>{again}</script><standardLoopCharacteristics loopMaximum="3"/></scriptTask>
<sequenceFlow id="f2" sourceRef="again" targetRef="end"/><endEvent id="end"/></process></definitions>"""


def run(first, again):
    parser = BpmnParser()
    parser.add_bpmn_xml(etree.fromstring(PROCESS.format(first=first, again=again)))
    workflow = BpmnWorkflow(parser.get_spec("p"))
    workflow.do_engine_steps()
    assert workflow.is_completed()
    return workflow.last_task.data["x"]


expected = {
    ("0", "x = x + 1"): 3,
    ("[]", "x.append(len(x))"): [0, 1, 2],
    ("[0]", "x.append(1)"): [0, 1],
    ("[0]", "x = x + [1]"): [0, 1],
    ("[0, 5]", "x[0] = x[0] + 1"): [0, 5],
    ("[0, 5]", "x = [x[0] + 1, x[1] + 1]"): [0, 5],
}
found = {asked: run(*asked) for asked in expected}
for (first, again), x in found.items():
    print(f"x = {first}, then three times {again}: {x}")
assert found == expected, "the behaviour has changed"
PYTHON
