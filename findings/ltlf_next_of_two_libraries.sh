#!/usr/bin/env bash
# Guess: X a of a formula on finite traces is one thing for two libraries of one field, whose users pass formulas on: a
#   strong next, false at the last instant, as ltlf2dfa has it.
# Package: PyPI pylogics 0.2.1 and ltlf2dfa 2.0.0
# Seen: pylogics reads X a as WeakNext, true at the last instant, and has X[!] a for the strong one; ltlf2dfa reads X a as
#   the strong one, has WX a for the other, and neither reads the other's word. Only X a is read by both.
# Source: pylogics/parsers/ltl.lark, which follows the spelling of the tool Spot; ltlf2dfa's README
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pylogics==0.2.1 ltlf2dfa==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from ltlf2dfa.parser.ltlf import LTLfParser
from pylogics.parsers import parse_ltl


def read(parse, text):
    try:
        return type(parse(text)).__name__
    except Exception as error:
        return f"not read: {type(error).__name__}"


found = {text: (read(parse_ltl, text), read(LTLfParser(), text)) for text in ("X a", "X[!] a", "WX a")}
print(found)
assert found["X a"] == ("WeakNext", "LTLfNext"), "the behaviour has changed"
assert found["X[!] a"][0] == "Next" and found["X[!] a"][1].startswith("not read"), "the behaviour has changed"
assert found["WX a"][0].startswith("not read") and found["WX a"][1] == "LTLfWeakNext", "the behaviour has changed"
PYTHON
