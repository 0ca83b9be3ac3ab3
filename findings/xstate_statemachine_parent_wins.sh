#!/usr/bin/env bash
# Guess: a machine in XState's JSON does the same in Python's xstate-statemachine as in XState: where one region of a parallel
#   state takes an event, the transition of the parallel state for it is not taken; all states are left before any is entered;
#   and a transition of a state to itself begins again with its first child.
# Package: PyPI xstate-statemachine 0.11.0 and npm xstate 5.33.3
# Seen: In Python the parallel state's transition is taken after the region's, so that the machine is in aborted, where XState is in
#   w.p.paused. Regions are left and entered one by one. The transition to itself does nothing, where XState enters the first
#   child again.
# Source: https://stately.ai/docs/parallel-states ; W3C SCXML, 3.13 (conflicting transitions: the descendant's is taken; exit sets
#   before entry sets); found by running both on one text
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q xstate-statemachine==0.11.0 2>pip.log || { cat pip.log; exit 1; }
npm init -y >/dev/null
npm install --silent --no-fund --no-audit xstate@5.33.3 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > machines.json <<'JSON'
{"parallel": {"id": "m", "initial": "w", "states": {"aborted": {}, "w": {"type": "parallel", "on": {"E": "aborted"}, "states": {
   "p": {"initial": "drives", "states": {"drives": {"on": {"E": "paused"}}, "paused": {}}},
   "q": {"initial": "looks", "states": {"looks": {}}}}}}},
 "order": {"id": "m", "type": "parallel", "states": {
   "p": {"initial": "a", "states": {"a": {"on": {"E": "b"}, "exit": "leave p.a"}, "b": {"entry": "enter p.b"}}},
   "q": {"initial": "a", "states": {"a": {"on": {"E": "b"}, "exit": "leave q.a"}, "b": {"entry": "enter q.b"}}}}},
 "itself": {"id": "m", "initial": "s", "states": {"s": {"initial": "first", "on": {"E": "s"}, "states": {
   "first": {"always": "second", "entry": "enter first"}, "second": {}}}}}}
JSON
cat > run.py <<'PYTHON'
import json

from xstate_statemachine import MachineLogic, SyncInterpreter, create_machine

found = {}
for name, machine in json.load(open("machines.json")).items():
    told = []
    names = ("leave p.a", "enter p.b", "leave q.a", "enter q.b", "enter first")
    actions = {action: lambda *_, action=action: told.append(action) for action in names}
    interpreter = SyncInterpreter(create_machine(machine, logic=MachineLogic(actions=actions))).start()
    told.clear()
    interpreter.send("E")
    found[name] = [sorted(interpreter.current_state_ids), told]
print(json.dumps(found))
PYTHON
cat > run.cjs <<'JS'
const { createActor, createMachine } = require("xstate");
const machines = JSON.parse(require("fs").readFileSync("machines.json"));
const found = {};
for (const [name, machine] of Object.entries(machines)) {
  const told = [];
  const names = ["leave p.a", "enter p.b", "leave q.a", "enter q.b", "enter first"];
  const actions = Object.fromEntries(names.map((action) => [action, () => told.push(action)]));
  const actor = createActor(createMachine(machine).provide({ actions })).start();
  told.length = 0;
  actor.send({ type: "E" });
  const leaves = actor.getSnapshot()._nodes.filter((node) => ["atomic", "final"].includes(node.type));
  found[name] = [leaves.map((node) => node.id).sort(), told];
}
console.log(JSON.stringify(found));
JS
venv/bin/python run.py 2>/dev/null | tail -n 1 | tee python.json
node run.cjs | tee javascript.json
venv/bin/python - <<'PYTHON'
import json

python, javascript = json.load(open("python.json")), json.load(open("javascript.json"))
assert python["parallel"][0] == ["m.aborted"], "the behaviour has changed"
assert javascript["parallel"][0] == ["m.w.p.paused", "m.w.q.looks"], "the behaviour has changed"
assert python["order"][1] == ["leave p.a", "enter p.b", "leave q.a", "enter q.b"], "the behaviour has changed"
assert javascript["order"][1] == ["leave q.a", "leave p.a", "enter p.b", "enter q.b"], "the behaviour has changed"
assert python["itself"][1] == [] and javascript["itself"][1] == ["enter first"], "the behaviour has changed"
PYTHON
