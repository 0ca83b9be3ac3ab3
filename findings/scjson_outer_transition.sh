#!/usr/bin/env bash
# Guess: scjson's engine takes the transition of the inner state where an outer one has another for the same event, as
#   SCXML says; and the package can be imported where it is installed.
# Package: PyPI scjson 0.4.2, with xsdata-pydantic 24.5, which it imports and does not ask for
# Seen: Alone it is "No module named 'xsdata_pydantic'". With that package the transition of the outer state is taken: the
#   chart goes to far, where the standard goes to near.
# Source: https://www.w3.org/TR/scxml/#SelectingTransitions; found by running it beside other interpreters
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q scjson==0.4.2 2>pip.log || { cat pip.log; exit 1; }
cat > chart.scxml <<'XML'
<scxml xmlns="http://www.w3.org/2005/07/scxml" version="1.0" initial="outer">
  <state id="outer" initial="inner">
    <transition event="go" target="far"/>
    <state id="inner"><transition event="go" target="near"/></state>
    <state id="near"/>
  </state>
  <state id="far"/>
</scxml>
XML
echo '{"event": "go"}' > events.jsonl
if venv/bin/scjson --help > help.txt 2>&1; then echo "the behaviour has changed"; exit 1; fi
tail -1 help.txt
grep -q "No module named 'xsdata_pydantic'" help.txt || { echo "the behaviour has changed"; exit 1; }
venv/bin/pip install -q xsdata-pydantic==24.5 2>pip.log || { cat pip.log; exit 1; }
venv/bin/scjson engine-trace -I chart.scxml --xml -e events.jsonl -o trace.jsonl
tail -1 trace.jsonl
tail -1 trace.jsonl | grep -q '"configuration": \["far"\]' || { echo "the behaviour has changed"; exit 1; }
