#!/usr/bin/env bash
# Guess: of two transitions that one event enables the first in the document is taken, as in SCXML.
# Package: PyPI sismic 1.6.14
# Seen: NonDeterminismError for two of one state; ConflictingTransitionsError where one leaves a parallel state and one stays in
#   another region. An inner transition does take precedence over an outer one.
# Source: sismic/interpreter/default.py (_sort_transitions); https://www.w3.org/TR/scxml/#SelectingTransitions
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q sismic==1.6.14 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from sismic.exceptions import ConflictingTransitionsError, NonDeterminismError
from sismic.interpreter import Interpreter
from sismic.io import import_from_yaml


def after_an_event(states):
    root = f"name: r, initial: a, states: [{states}]"
    run = Interpreter(import_from_yaml(f"statechart: {{name: c, root state: {{{root}}}}}"))
    run.execute()
    run.queue("e")
    run.execute()
    return run.configuration


def to(target):
    return f"{{event: e, target: {target}}}"


inner = f"{{name: a, initial: i, transitions: [{to('c')}], states: [{{name: i, transitions: [{to('b')}]}}, {{name: b}}]}}"
print(after_an_event(f"{inner}, {{name: c}}"))
assert "b" in after_an_event(f"{inner}, {{name: c}}"), "the behaviour has changed"
region = "{{name: R{0}, initial: {0}, states: [{{name: {0}, transitions: [{1}]}}, {{name: {0}2}}]}}"
parallel = f"{{name: a, parallel states: [{region.format('x', to('x2'))}, {region.format('y', to('out'))}]}}"
for states, expected in (
    (f"{{name: a, transitions: [{to('b')}, {to('c')}]}}, {{name: b}}, {{name: c}}", NonDeterminismError),
    (f"{parallel}, {{name: out}}", ConflictingTransitionsError),
):
    try:
        raise SystemExit(f"the behaviour has changed: {after_an_event(states)}")
    except expected as error:
        print(type(error).__name__)
PYTHON
