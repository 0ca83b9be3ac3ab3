#!/usr/bin/env bash
# Guess: an inclusive gateway that joins waits for each branch that an inclusive gateway has taken before it, so that what
#   follows runs once; a parallel gateway waits for all branches, also one that was not taken, and so for ever.
# Package: npm bpmn-engine 25.0.1 (bpmn-elements 17.3.0, whose list of what is supported names InclusiveGateway)
# Seen: The other way round. The inclusive gateway passes each token on: with two of three branches taken the task behind it
#   runs twice. A parallel gateway in its place waits for these two, and the task runs once.
# Source: BPMN 2.0.2, 13.4.1 and 13.4.3 (the inclusive gateway waits for all that can still arrive); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund bpmn-engine@25.0.1 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > run.cjs <<'JS'
const { Engine } = require("bpmn-engine");
const { EventEmitter } = require("events");

const flow = (id, from, to, taken) =>
  `<sequenceFlow id="${id}" sourceRef="${from}" targetRef="${to}">` +
  (taken === undefined ? "" : `<conditionExpression xsi:type="tFormalExpression" language="javascript">next(null, ${taken})</conditionExpression>`) +
  "</sequenceFlow>";
const process_ = (join) => `<?xml version="1.0"?>
<definitions xmlns="http://www.omg.org/spec/BPMN/20100524/MODEL" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" targetNamespace="t">
<process id="p" isExecutable="true"><startEvent id="start"/><inclusiveGateway id="fork"/><task id="a"/><task id="b"/><task id="c"/>
<${join} id="join"/><task id="behind"/>${flow("f0", "start", "fork")}${flow("f1", "fork", "a", true)}${flow("f2", "fork", "b", true)}
${flow("f3", "fork", "c", false)}${flow("f4", "a", "join")}${flow("f5", "b", "join")}${flow("f6", "c", "join")}${flow("f7", "join", "behind")}
</process></definitions>`;

async function times(join) {
  const ended = {};
  const listener = new EventEmitter();
  listener.on("activity.end", ({ id }) => (ended[id] = (ended[id] ?? 0) + 1));
  await new Engine({ name: join, source: process_(join) }).execute({ listener });
  await new Promise((resolve) => setTimeout(resolve, 500));
  return [ended.a ?? 0, ended.b ?? 0, ended.c ?? 0, ended.behind ?? 0];
}

(async () => {
  const found = [];
  for (const join of ["inclusiveGateway", "parallelGateway"]) {
    found.push(await times(join));
    console.log(join, "runs of a, b, c and of the task behind:", ...found.at(-1));
  }
  if (JSON.stringify(found) !== "[[1,1,0,2],[1,1,0,1]]") {
    console.log("the behaviour has changed");
    process.exit(1);
  }
  process.exit(0);
})();
JS
node run.cjs
