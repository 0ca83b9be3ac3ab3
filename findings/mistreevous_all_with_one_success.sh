#!/usr/bin/env bash
# Guess: A node named all succeeds where all of its children do, and retry [2] fails with its child's second failure.
# Package: npm mistreevous 4.3.1
# Seen: all succeeds where at least one child has, and fails where all have failed; parallel is the node that needs all. After
#   its second and last attempt retry [2] says running for a tick more, in which its child is not asked; so does repeat [2].
# Source: the package's README, All; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >/dev/null
npm install --silent mistreevous@4.3.1 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > run.js <<'JAVASCRIPT'
const { BehaviourTree, State } = require("mistreevous");

function run(tree) {
  const asked = [];
  const leaf = (name, state) => () => {
    asked.push(name);
    return state;
  };
  const agent = { Works: leaf("Works", State.SUCCEEDED), Fails: leaf("Fails", State.FAILED) };
  const behaviour = new BehaviourTree(`root { ${tree} }`, agent);
  const states = [];
  do {
    behaviour.step();
    states.push(behaviour.getState().split(".").pop());
  } while (states[states.length - 1] === "running");
  return `${states.join(" ")}; asked ${asked.join(" ")}`;
}

const expected = {
  "all { action [Works] action [Fails] }": "succeeded; asked Works Fails",
  "all { action [Fails] action [Fails] }": "failed; asked Fails Fails",
  "parallel { action [Works] action [Fails] }": "failed; asked Works Fails",
  "retry [2] { action [Fails] }": "running running failed; asked Fails Fails",
  "repeat [2] { action [Works] }": "running running succeeded; asked Works Works",
};
let same = true;
for (const [tree, states] of Object.entries(expected)) {
  const found = run(tree);
  console.log(tree, "->", found);
  same = same && found === states;
}
if (!same) {
  console.log("the behaviour has changed");
  process.exit(1);
}
JAVASCRIPT
node run.js
