#!/usr/bin/env bash
# Guess: what bteng's reader of XML does not know is refused, or it takes success_count of a Parallel, BehaviorTree.CPP's
#   word, as it takes num_attempts and msec; and a tree with a leaf that nobody has registered is refused by each of its
#   readers.
# Package: PyPI bteng 0.2.8
# Seen: Attributes that it does not know are passed by: a Parallel that needs one success of two needs both. Read into a
#   registry the tree with the unknown leaf is not there, and nothing is said; read alone it is a ValueError.
# Source: bteng/xml_parser/parser.py (_control_kwargs; _parse_all_to_registry passes each exception by)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q bteng==0.2.8 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from bteng import ActionNode, NodeFactory, NodeStatus, XMLTreeParser


class Works(ActionNode):
    def tick(self):
        return NodeStatus.SUCCESS


class Fails(ActionNode):
    def tick(self):
        return NodeStatus.FAILURE


for leaf in (Works, Fails):
    NodeFactory.get_instance().register(leaf, leaf.__name__)


def parallel(attributes):
    text = f'<BTEng><Tree ID="m"><Parallel {attributes}><Works/><Fails/></Parallel></Tree></BTEng>'
    return XMLTreeParser().parse_string(text).execute_tick()


found = [parallel(said) for said in ('success_threshold="1" failure_threshold="2"', 'success_count="1" failure_count="2"')]
print(found)
assert found == [NodeStatus.SUCCESS, NodeStatus.FAILURE], "the behaviour has changed"
home = '<Tree ID="home"><Sequence><Works/><Land/></Sequence></Tree>'
trees = XMLTreeParser().parse_string_to_registry(f'<BTEng><Tree ID="m"><Works/></Tree>{home}</BTEng>').ids()
print("trees:", trees)
assert trees == ["m"], "the behaviour has changed"
try:
    XMLTreeParser().parse_string(f"<BTEng>{home}</BTEng>")
except ValueError as error:
    print(error)
else:
    raise SystemExit("the behaviour has changed")
PYTHON
