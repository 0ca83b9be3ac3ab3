#!/usr/bin/env bash
# Guess: an edge with directed="false" in a directed graph is undirected when read, or refused; the default of a key of type
#   double is a number for edges without data; an integer above 2^53 is exact, or refused.
# Package: PyPI rustworkx 0.18.1, igraph 1.0.0, networkx 3.5; npm graphology 0.26.0 with graphology-graphml 0.5.2
# Seen: networkx refuses the edge; rustworkx, igraph and graphology-graphml read it as b -> c alone, without a word.
#   graphology-graphml gives the default as the text "1.5", beside the number 2 of the other edge. igraph and graphology-graphml
#   read 9007199254740993 as ...992; of a boolean that is not given igraph says False.
# Source: the GraphML Primer (directed of an edge overwrites edgedefault; a default has the type of its key); found by running them
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q rustworkx==0.18.1 igraph==1.0.0 networkx==3.5 2>pip.log || { cat pip.log; exit 1; }
npm init -y >/dev/null
npm install --silent --no-fund graphology@0.26.0 graphology-graphml@0.5.2 @xmldom/xmldom@0.9.8 >npm.log 2>&1 || { cat npm.log; exit 1; }
cat > graph.graphml <<'XML'
<?xml version="1.0" encoding="UTF-8"?>
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="ok" for="node" attr.name="ok" attr.type="boolean"/>
  <key id="n" for="node" attr.name="n" attr.type="long"/>
  <key id="w" for="edge" attr.name="w" attr.type="double"><default>1.5</default></key>
  <graph id="g" edgedefault="directed">
    <node id="a"><data key="ok">true</data><data key="n">9007199254740993</data></node><node id="b"/><node id="c"/>
    <edge source="a" target="b"/><edge source="b" target="c" directed="false"><data key="w">2</data></edge>
  </graph>
</graphml>
XML
cat > read.py <<'PYTHON'
import igraph
import networkx
import rustworkx

name = "graph.graphml"
try:
    networkx.read_graphml(name)
except networkx.NetworkXError as error:
    print("networkx:", error)
(graph,) = rustworkx.read_graphml(name)
edges = [(graph[s]["id"], graph[t]["id"], data["w"]) for s, t, data in graph.weighted_edge_list()]
print("rustworkx:", type(graph).__name__, edges, graph[0]["n"], graph[1]["ok"])
graph = igraph.Graph.Read_GraphML(name)
edges = [(*(graph.vs[v]["id"] for v in edge.tuple), edge["w"]) for edge in graph.es]
print("igraph:", "directed" if graph.is_directed() else "", edges, int(graph.vs[0]["n"]), graph.vs[1]["ok"])
PYTHON
cat > read.cjs <<'JS'
const { DOMParser } = require("@xmldom/xmldom");
global.DOMParser = DOMParser;
global.Document = class {};
const Graph = require("graphology");
const { parse } = require("graphology-graphml");
const graph = parse(Graph, require("fs").readFileSync("graph.graphml", "utf8"));
const edges = graph.mapEdges((edge, data, from, to) => [from, to, graph.isUndirected(edge) ? "undirected" : "directed", data.w]);
console.log("graphology-graphml:", JSON.stringify(edges), graph.getNodeAttribute("a", "n"));
JS
{ venv/bin/python read.py; node read.cjs; } | tee seen
cat > expected <<'TEXT'
networkx: directed=false edge found in directed graph.
rustworkx: PyDiGraph [('a', 'b', 1.5), ('b', 'c', 2.0)] 9007199254740993 None
igraph: directed [('a', 'b', 1.5), ('b', 'c', 2.0)] 9007199254740992 False
graphology-graphml: [["a","b","directed","1.5"],["b","c","directed",2]] 9007199254740992
TEXT
diff expected seen || { echo "the behaviour has changed"; exit 1; }
