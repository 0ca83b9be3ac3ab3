"""Parts of formulas that say nothing, against the definition: every truth of the part, state by state."""

from __future__ import annotations

from itertools import product
from typing import Any

from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.requirements import RequirementAnswer, asked_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import compose
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import every_path
from mcpn.logic.vacuity import idle_parts, signs_of
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.goal import DEADLOCK, AtMost, Fires, Formula
from tests.conftest import ROOT
from tests.logic import formulas
from tests.logic.ltl import tableau
from tests.logic.test_ctl import names
from tests.nets.nets import made_safe, nets, state_machines
from tests.shares import returns_early

MOST_STATES = 6
NETS = nets(max_places=4, max_transitions=5).map(made_safe) | state_machines().map(lambda drawn: drawn[0])


def holds_with(space: ArraySpace, formula: Formula, part: Formula, truth: Any) -> bool:
    """Whether a formula holds where one part of it is true in these states and nowhere else."""
    evaluation = Evaluation(space)
    evaluation._known[part] = truth
    return evaluation.holds(formula)


@given(NETS, st.data())
def test_a_part_is_idle_if_no_truth_of_it_matters(net: PetriNet, data: st.DataObject) -> None:
    space = ArraySpace(explore(net))
    if space.everything.count() > MOST_STATES:
        returns_early("many states")
        return
    if data.draw(st.booleans(), "on paths"):
        written = data.draw(tableau.formulas(*names(net)), "written")
        formula = every_path(tableau.read(written, net))
    else:
        formula = formulas.read(data.draw(formulas.formulas(*names(net)), "written"), net)
    evaluation = Evaluation(space)
    if not evaluation.holds(formula):
        formula = ~formula
    idle = list(idle_parts(formula, (), evaluation.holds))
    states = [space.single(number) for number in range(space.everything.count())]
    for part, stands in signs_of(formula, ()).items():
        if not isinstance(part, AtMost | Fires) or len(stands) > 1 or part in (formula, DEADLOCK):
            continue
        truths = (
            [state for state, true in zip(states, chosen, strict=True) if true]
            for chosen in product((False, True), repeat=len(states))
        )
        matters = not all(holds_with(space, formula, part, union(space, truth)) for truth in truths)
        event("matters" if matters else "idle")
        assert (part in idle) == (not matters)


def union(space: ArraySpace, states: list[Any]) -> Any:
    found = space.nothing
    for state in states:
        found = found | state
    return found


def test_requirements_of_ulysse_say_what_is_idle() -> None:
    of = compose(read_mission(ROOT / "experiments" / "ulysse" / "mission.xml"))
    answers = {answer.asked.name: answer for answer in check(of).requirements}
    # The dive ends some day: fairness alone gives what is asked for.
    assert "oos(GPS_sensor)" in answers["transect.goes_on_without_GPS"].vacuous
    assert answers["transect.films_below"].vacuous == ()
    assert answers["failure_on_the_surface"].vacuous == ()  # it does not hold
    (asked, *_) = asked_of(of)
    assert RequirementAnswer(asked, True, vacuous=("a", "b")).says_nothing_of == (
        "It says nothing of a, of b: it holds whatever each of these alone is."
    )
