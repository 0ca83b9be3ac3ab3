#!/usr/bin/env bash
# Guess: sarif summary --check error counts the errors that are left: neither one that has been suppressed, and the suppression
#   accepted, nor one that is absent from the run and stands in the file as what has been mended.
# Package: PyPI sarif-tools 3.0.5
# Seen: Both are counted as errors, and the exit code fails the build. Results without a level are warnings, as the format says.
# Source: SARIF 2.1.0, 3.27.23 (suppressions) and 3.27.24 (baselineState: absent, in the run before alone); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q sarif-tools==3.0.5 2>pip.log || { cat pip.log; exit 1; }
cat > log.py <<'PYTHON'
import json
import sys

more = json.loads(sys.argv[1])
place = {"physicalLocation": {"artifactLocation": {"uri": "mission.xml"}, "region": {"startLine": 3}}}
result = {"ruleId": "unused", "message": {"text": "never used"}, "locations": [place], **more}
run = {"tool": {"driver": {"name": "checker", "rules": [{"id": "unused"}]}}, "results": [result]}
schema = "https://json.schemastore.org/sarif-2.1.0.json"
json.dump({"$schema": schema, "version": "2.1.0", "runs": [run]}, open("log.sarif", "w"))
PYTHON
check() {
  venv/bin/python log.py "$1"
  code=0
  venv/bin/sarif --check error summary log.sarif >out 2>&1 || code=$?
  echo "$1: $(grep -E '^(error|warning): ' out | tr '\n' ' ')exit code $code"
}
{
  check '{"level": "error", "suppressions": [{"kind": "external", "status": "accepted"}]}'
  check '{"level": "error", "baselineState": "absent"}'
  check '{}'
} | tee seen
cat > expected <<'TEXT'
{"level": "error", "suppressions": [{"kind": "external", "status": "accepted"}]}: error: 1 warning: 0 exit code 1
{"level": "error", "baselineState": "absent"}: error: 1 warning: 0 exit code 1
{}: error: 0 warning: 1 exit code 0
TEXT
diff expected seen || { echo "the behaviour has changed"; exit 1; }
