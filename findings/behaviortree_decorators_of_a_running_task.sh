#!/usr/bin/env bash
# Guess: a decorator of a task that is still running goes on with that task at the next step: the pause of a CooldownDecorator
#   begins when the task has ended, and a round of a LoopDecorator is over when its task is.
# Package: npm behaviortree 2.1.0
# Seen: CooldownDecorator asks the running task once and fails at each step of the pause; the task is neither continued nor
#   ended (end is not called). LoopDecorator counts running as a round: in one step
#   the task is started twice, and ended once. InvertDecorator goes on as guessed.
# Source: the package's README (end is called unless the task is running, start unless it resumes); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent --no-fund --no-audit behaviortree@2.1.0 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > steps.cjs <<'JS'
const { BehaviorTree, Task, RUNNING, SUCCESS, decorators } = require("behaviortree");

function steps(Decorator, config, count) {
  const told = [];
  let asked = 0;
  const task = new Task({
    start() { told.push("start"); },
    run() { asked += 1; told.push(asked < 2 ? "runs" : "succeeds"); return asked < 2 ? RUNNING : SUCCESS; },
    end() { told.push("end"); },
  });
  const tree = new BehaviorTree({ tree: new Decorator({ node: task, config }), blackboard: {} });
  for (let step = 0; step < count; step += 1) { tree.step(); told.push("|"); }
  return told.join(" ");
}

const found = {
  cooldown: steps(decorators.CooldownDecorator, { cooldown: 60 }, 3),
  loop: steps(decorators.LoopDecorator, { loop: 2 }, 1),
  invert: steps(decorators.InvertDecorator, {}, 2),
};
console.log(found);
const expected = {
  cooldown: "start runs | | |",
  loop: "start runs start succeeds end |",
  invert: "start runs | succeeds end |",
};
if (JSON.stringify(found) !== JSON.stringify(expected)) { console.log("the behaviour has changed"); process.exit(1); }
JS
node steps.cjs
