#!/usr/bin/env bash
# Guess: node [shape=circle] in a file of Graphviz holds for the nodes that come after it, to the end of its subgraph, for who reads
#   the file as for dot: the libraries of npm that read DOT draw the same picture.
# Package: npm ts-graphviz 3.0.7, graphlib-dot 0.6.4; @dagrejs/graphlib-dot 1.0.2, which does it as guessed, beside them
# Seen: ts-graphviz has one set of defaults for each graph, the last ones: written again, a box that stood before them is a circle.
#   In graphlib-dot a default of a subgraph holds after it, too: d is red.
# Source: https://graphviz.org/doc/info/lang.html (a default holds for what is defined after it, in that subgraph); found by running
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm init -y >npm.log
npm install --silent --ignore-scripts ts-graphviz@3.0.7 graphlib-dot@0.6.4 @dagrejs/graphlib-dot@1.0.2 >>npm.log 2>&1 ||
  { cat npm.log; exit 1; }
cat >read.mjs <<'JS'
import assert from "node:assert";
import { createRequire } from "node:module";
import { fromDot, toDot } from "ts-graphviz";
const require = createRequire(import.meta.url);
const text = "digraph { node [shape=box]; a; node [shape=circle]; b; subgraph s { node [color=red]; c } d }";
const shapes = (name) => {
  const graph = require(name).read(text);
  return Object.fromEntries(["a", "b", "c", "d"].map((node) => [node, graph.node(node)]));
};
const written = toDot(fromDot(text)).replace(/\s+/g, " ");
const old = shapes("graphlib-dot");
const kept = shapes("@dagrejs/graphlib-dot");
console.log(written, old, kept);
assert.ok(!written.includes("box") && written.includes('node [ shape = "circle"; ]; "a"'));
assert.deepEqual(old.d, { shape: "circle", color: "red" });
assert.deepEqual(kept, {
  a: { shape: "box" }, b: { shape: "circle" }, c: { shape: "circle", color: "red" }, d: { shape: "circle" },
});
JS
node read.mjs
