#!/usr/bin/env bash
# Guess: a graph that is read from GraphML and written again is the same graph; data have the names that attr.name of their key says.
# Package: PyPI pygraphml 2.4.2
# Seen: Data are named by the id of their key, which no tool means to be read, and a node is written with what its data "label" say
#   in place of its id: where a key has another id than "label", as with networkx and igraph, all nodes are written with the id "",
#   and all edges go from "" to "". Each edge of a directed graph is written with directed="false". Default values are left out.
# Source: http://graphml.graphdrawing.org/primer/graphml-primer.html (attr.name, default, edgedefault); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pygraphml==2.4.2 2>pip.log || { cat pip.log; exit 1; }
cat >in.graphml <<'XML'
<graphml xmlns="http://graphml.graphdrawing.org/xmlns">
  <key id="d0" for="node" attr.name="label" attr.type="string"/>
  <key id="d1" for="edge" attr.name="event" attr.type="string"><default>none</default></key>
  <graph edgedefault="directed">
    <node id="a"><data key="d0">idle</data></node>
    <node id="b"><data key="d0">driving</data></node>
    <edge source="a" target="b"><data key="d1">start</data></edge>
    <edge source="b" target="a"/>
  </graph>
</graphml>
XML
venv/bin/python - <<'PYTHON'
import xml.etree.ElementTree as ET

from pygraphml import GraphMLParser

graph = GraphMLParser().parse("in.graphml")
data = [{name: value.value for name, value in edge.attributes().items()} for edge in graph.edges()]
GraphMLParser().write(graph, "out.graphml")
written = ET.parse("out.graphml").getroot()
ids = [node.get("id") for node in written.iter("node")]
edges = [edge.attrib for edge in written.iter("edge")]
print(data, ids, edges)
assert data == [{"d1": "start"}, {}] and ids == ["", ""], "the behaviour has changed"
assert edges == [{"source": "", "target": "", "directed": "false"}] * 2, "the behaviour has changed"
PYTHON
