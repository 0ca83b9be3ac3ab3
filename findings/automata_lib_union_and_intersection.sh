#!/usr/bin/env bash
# Guess: a regular expression a|b&c, in which & is the intersection, is a or the intersection of b and c, as "and" binds before
#   "or" in logic and in Java's regular expressions; so it accepts a.
# Package: PyPI automata-lib 9.2.0
# Seen: | and & bind alike, from the left: it is (a|b)&c, which accepts nothing. a|(b&c) accepts a. The shuffle ^ binds alike, too:
#   ab|c^d is (ab|c)^d and accepts cd and adb.
# Source: automata/regex/parser.py (UnionToken, IntersectionToken and ShuffleToken have one precedence); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q automata-lib==9.2.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from automata.fa.nfa import NFA


def accepted(expression):
    nfa = NFA.from_regex(expression, input_symbols=set("abcd"))
    return [word for word in ("", "a", "b", "c", "ab", "cd", "dc", "adb") if nfa.accepts_input(word)]


found = {expression: accepted(expression) for expression in ("a|b&c", "(a|b)&c", "a|(b&c)", "ab|c^d", "ab|(c^d)")}
print(found)
assert found["a|b&c"] == found["(a|b)&c"] == [] and found["a|(b&c)"] == ["a"], "the behaviour has changed"
assert found["ab|c^d"] == ["cd", "dc", "adb"] and found["ab|(c^d)"] == ["ab", "cd", "dc"], "the behaviour has changed"
PYTHON
