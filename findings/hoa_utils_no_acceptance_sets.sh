#!/usr/bin/env bash
# Guess: A reader of HOA takes an automaton of safety, "acc-name: all, Acceptance: 0 t", the simplest that the format
#   has.
# Package: PyPI hoa-utils 0.1.0 (setuptools below 81, which it imports)
# Seen: ValueError: max() arg is an empty sequence, of an acceptance condition without sets; with one set it is read.
# Source: https://adl.github.io/hoaf (acceptance specifications: all); hoa/parsers.py
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


found = told("acc-name: all\nAcceptance: 0 t"), told(BUCHI)
print(*found, sep="\n")
assert "max()" in found[0] or "acceptance" in found[0], "the behaviour has changed"
assert found[1] == "read", "the behaviour has changed"
PYTHON
