#!/usr/bin/env bash
# Guess: the precondition (not (lit ?l)) lets an action switch on the lamps that are off, as (and (not (lit ?l)) (seen ?l)) does of
#   those that are seen: the package names negated atoms in preconditions as supported.
# Package: PyPI lifted-pddl 1.2.7
# Seen: Where the negated atom is the only condition, with (and ...) around it or without, the "not" is dropped: the action can
#   switch on the one lamp that is lit, and none that is off. With a second condition beside it it is read as it is meant. A goal
#   (not (lit l1)) alone is (lit l1), too; an effect (not (lit ?l)) alone is right.
# Source: the package's page, Limitations ("we only support negated atoms in preconditions"); found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q lifted-pddl==1.2.7 2>pip.log || { cat pip.log; exit 1; }
cat > domain.pddl <<'PDDL'
(define (domain lamps) (:requirements :strips :typing :negative-preconditions)
 (:types lamp)
 (:predicates (lit ?l - lamp) (seen ?l - lamp))
 (:action alone :parameters (?l - lamp) :precondition (not (lit ?l)) :effect (lit ?l))
 (:action in-and :parameters (?l - lamp) :precondition (and (not (lit ?l))) :effect (lit ?l))
 (:action with-another :parameters (?l - lamp) :precondition (and (not (lit ?l)) (seen ?l)) :effect (lit ?l))
 (:action switch-off :parameters (?l - lamp) :precondition (lit ?l) :effect (not (lit ?l))))
PDDL
cat > problem.pddl <<'PDDL'
(define (problem p) (:domain lamps) (:objects l1 l2 l3 - lamp) (:init (lit l1) (seen l1) (seen l2) (seen l3)) (:goal (not (lit l1))))
PDDL
venv/bin/python - <<'PYTHON'
from lifted_pddl import Parser

parser = Parser()
parser.parse_domain("domain.pddl")
parser.parse_problem("problem.pddl")
possible = {action: sorted(lamp + 1 for (lamp,) in found) for action, found in parser.get_applicable_actions().items()}
off = next(effects for name, _, _, effects in parser.actions if name == "switch-off")
print(possible, parser.goals, off)
assert possible == {"alone": [1], "in-and": [1], "with-another": [2, 3], "switch-off": [1]}, "the behaviour has changed"
assert parser.goals == {(True, "lit", (0,))} and off == ((False, "lit", (0,)),), "the behaviour has changed"
PYTHON
