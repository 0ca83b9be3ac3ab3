#!/usr/bin/env bash
# Guess: Headers of a tool's own, which the format asks readers to skip if they begin with a small letter, are
#   skipped.
# Package: PyPI hoa-utils 0.1.0 (setuptools below 81, which it imports)
# Seen: A header that the format does not list is a syntax error, whatever its name.
# Source: https://adl.github.io/hoaf (semantics of headers: a small first letter may be ignored);
#   hoa/grammars/hoa.lark
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q hoa-utils==0.1.0 'setuptools<81' 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from hoa.parsers import HOAParser

TEXT = """HOA: v1
States: 1
Start: 0
AP: 1 "p"
{acceptance}
{more}--BODY--
State: 0
[0] 0
--END--
"""
BUCHI = "acc-name: Buchi\nAcceptance: 1 Inf(0)"

def told(acceptance, more=""):
    try:
        HOAParser()(TEXT.format(acceptance=acceptance, more=more))
    except Exception as error:
        return str(error).strip().splitlines()[0]
    return "read"


found = [told(BUCHI), told(BUCHI, "colours: 1\n"), told(BUCHI, "my-colours: 1\n")]
print(*found, sep="\n")
assert [text == "read" for text in found] == [True, False, False], "the behaviour has changed"
PYTHON
