#!/usr/bin/env bash
# Guess: where the program MONA is not installed, to_dfa raises an error that names it.
# Package: PyPI ltlf2dfa 2.0.0, which does not bring MONA
# Seen: It prints two lines about values that it could not find, and returns an automaton of two states without an edge
#   between them, which looks like an answer; the same one for each formula.
# Source: ltlf2dfa/ltlf2dfa.py (invoke_mona does not look at the exit code of the shell)
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q ltlf2dfa==2.0.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import shutil

from ltlf2dfa.parser.ltlf import LTLfParser

if shutil.which("mona"):
    raise SystemExit("MONA is installed: nothing to see")
parse = LTLfParser()
found = {str(parse(text).to_dfa()) for text in ("G(a -> F b)", "F a", "a U b")}
print(*found)
assert len(found) == 1, "the behaviour has changed"
assert found.pop().startswith("digraph MONA_DFA"), "the behaviour has changed"
PYTHON
