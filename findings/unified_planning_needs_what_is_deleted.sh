#!/usr/bin/env bash
# Guess: a plan in which an action needs a fact at the very instant at which another deletes it is refused, as PDDL 2.1 asks.
# Package: PyPI unified-planning 1.3.0 (its validator of time-triggered plans)
# Seen: It is valid. The end of one action that needs the light and the end of another that switches it off may be at 5 s both,
#   and a third may begin at 5 s that needs it. The conditions of an instant are asked before its effects. Only two effects that
#   contradict each other are refused; so is an action that needs what is added at that instant.
# Source: Fox, Long (2003), PDDL2.1, definition 13 (no fact is needed and changed at one time); found by running it beside
#   kairos-planner 1.0.6, whose validator says of both that they "happen at the same time and interfere"
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q unified-planning==1.3.0 2>pip.log || { cat pip.log; exit 1; }
cat > domain.pddl <<'PDDL'
(define (domain lamp) (:requirements :strips :durative-actions)
 (:predicates (lit) (off) (seen))
 (:durative-action switch-off :parameters () :duration (= ?duration 5) :condition (and)
  :effect (and (at end (not (lit))) (at end (off))))
 (:durative-action switch-on :parameters () :duration (= ?duration 5) :condition (and)
  :effect (and (at end (lit)) (at end (seen))))
 (:durative-action look :parameters () :duration (= ?duration 5) :condition (and (at end (lit)))
  :effect (and (at end (seen))))
 (:durative-action photograph :parameters () :duration (= ?duration 1) :condition (and (at start (lit)))
  :effect (and (at end (seen)))))
PDDL
venv/bin/python - <<'PYTHON'
from unified_planning.io import PDDLReader
from unified_planning.shortcuts import PlanValidator, get_environment

get_environment().credits_stream = None


def verdict(plan, facts="(lit)", goal="(off) (seen)"):
    with open("problem.pddl", "w") as file:
        file.write(f"(define (problem p) (:domain lamp) (:init {facts}) (:goal (and {goal})))")
    with open("plan", "w") as file:
        file.write("\n".join(f"{start:.1f}: ({action}) [{length:.1f}]" for start, action, length in plan) + "\n")
    problem = PDDLReader().parse_problem("domain.pddl", "problem.pddl")
    plan = PDDLReader().parse_plan(problem, "plan")
    with PlanValidator(problem_kind=problem.kind, plan_kind=plan.kind) as validator:
        return validator.validate(problem, plan).status.name


off = (0, "switch-off", 5)
found = {
    "both end at 5 s": verdict([off, (0, "look", 5)]),
    "one ends, one begins": verdict([off, (5, "photograph", 1)]),
    "on and off at once": verdict([off, (0, "switch-on", 5)]),
    "needs what is added": verdict([(0, "switch-on", 5), (5, "photograph", 1)], "", "(seen)"),
}
print(*found.items(), sep="\n")
assert list(found.values()) == ["VALID", "VALID", "INVALID", "INVALID"], "the behaviour has changed"
PYTHON
