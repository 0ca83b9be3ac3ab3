#!/usr/bin/env bash
# Guess: a goal (not (lit lamp)) of a lamp that is lit needs the action that switches it off; or a goal with a "not" is refused,
#   since "not" in a goal is an extension.
# Package: PyPI pddlpy 1.2.2
# Seen: The "not" is dropped: the goal is (lit lamp), which holds, so that the plan is empty, "solved": true; of a lamp that is off
#   the goal that holds is not met. "validate" finds no issues. A precondition with the same "not" is read as it is meant.
# Source: PDDL 1.2 (:negative-preconditions, goals are goal descriptions); pddlpy/pddl.py (goals are all atoms in scope); the
#   package's list of what is to come names or, forall and exists in goals
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q pddlpy==1.2.2 2>pip.log || { cat pip.log; exit 1; }
cat > domain.pddl <<'PDDL'
(define (domain lamps) (:requirements :strips :typing :negative-preconditions)
 (:types lamp)
 (:predicates (lit ?l - lamp) (slept))
 (:action switch-off :parameters (?l - lamp) :precondition (lit ?l) :effect (not (lit ?l)))
 (:action sleep :parameters (?l - lamp) :precondition (not (lit ?l)) :effect (slept)))
PDDL
problem() { # facts, goal
  echo "(define (problem p) (:domain lamps) (:objects one - lamp) (:init $1) (:goal $2))" > problem.pddl
  venv/bin/pddlpy solve domain.pddl problem.pddl --planner bfs > plan.json || true
  venv/bin/pddlpy validate domain.pddl problem.pddl > issues.json || true
  venv/bin/python -c 'import json; plan = json.load(open("plan.json")); issues = json.load(open("issues.json"))["issues"]
print(plan["solved"], [step["action"] for step in plan["steps"] or []], issues)'
}
found="not lit, of a lamp that is lit: $(problem '(lit one)' '(not (lit one))')
not lit, of a lamp that is off: $(problem '' '(not (lit one))')
slept, of a lamp that is lit: $(problem '(lit one)' '(slept)')"
echo "$found"
[ "$found" = "not lit, of a lamp that is lit: True [] []
not lit, of a lamp that is off: False [] []
slept, of a lamp that is lit: True ['switch-off', 'sleep'] []" ] || { echo "the behaviour has changed"; exit 1; }
