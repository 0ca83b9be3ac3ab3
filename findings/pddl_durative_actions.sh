#!/usr/bin/env bash
# Guess: the package pddl reads durative actions, which PlanSys2's domains consist of.
# Package: PyPI pddl 0.5.1
# Seen: :durative-actions is no requirement that it knows: the parser stops at the word.
# Source: pddl/parser/domain.lark; PDDL 2.1 (2003); PlanSys2's own examples
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pddl==0.5.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from pddl.parser.domain import DomainParser

HEAD = "(define (domain d) (:requirements :strips :typing {}) (:types robot) (:predicates (at ?r - robot))"
PLAIN = "(:action go :parameters (?r - robot) :precondition (at ?r) :effect (not (at ?r)))"
print(DomainParser()(HEAD.format("") + PLAIN + ")").name)
TIMED = "(:durative-action go :parameters (?r - robot) :duration (= ?duration 5)"
TIMED += " :condition (at start (at ?r)) :effect (at end (not (at ?r))))"
try:
    DomainParser()(HEAD.format(":durative-actions") + TIMED + ")")
except Exception as error:
    print(type(error).__name__, str(error).splitlines()[0])
else:
    raise SystemExit("the behaviour has changed")
PYTHON
