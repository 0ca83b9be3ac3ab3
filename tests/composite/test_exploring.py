"""Sections by the big steps of their events, and by diagrams of all markings: the composite is the same."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from hypothesis import event, given

from mcpn.composite import explored_section as exploring
from mcpn.composite.composing import composite_space
from mcpn.composite.explored_section import Explored, explore_and_prove, explore_local
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.permanent_loss import mortal
from mcpn.drawing.sections import SectionParts
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Hardware
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.stable import big_steps
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from tests.draws import composed, fewer
from tests.small import activity, hw, mission, robot


def told(mission_net: MissionNet, *, may_die: bool) -> tuple[Any, ...] | type[Exception]:
    """What a composite says: sizes, firings by transition, what leads where."""
    try:
        space = composite_space(mission_net, may_die=may_die)
    except (ConfluenceError, DivergenceError) as error:
        return type(error)
    goals = [space.marked([mission_net.success]), space.marked([mission_net.failure]), space.dead]
    oos = [p for p, (role, _) in mission_net.roles.items() if role == "oos"]
    goals += [space.marked([place]) for place in oos]
    sets = [
        *(space.reaching(goal) for goal in goals),
        *(space.reached(goal) for goal in goals),
        *(space.before(goal) for goal in goals),
        *(space.reaching(goals[0], along=space.everything - goal) for goal in goals[3:]),
    ]
    return (
        space.everything.count(),
        sorted(space.firings(space.everything).items()),
        [found.count() for found in (*goals, *sets)],
        {t: found.count() for goal in goals for t, found in space.crossing(space.everything, goal)},
    )


@fewer(0.5)
@given(missions() | missions(events=2, sections=8) | missions(late=True, sections=6) | stacked_missions())
def test_a_section_is_the_same_in_big_steps_and_by_all_markings(of: Mission) -> None:
    mission_net = composed(of)
    for may_die in (False, True):
        steps = told(mission_net, may_die=may_die)
        event("confluent" if isinstance(steps, tuple) else "not confluent")
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(big_steps, "MOST_SINGLY", 0)
            assert told(mission_net, may_die=may_die) == steps
        if not isinstance(steps, tuple):  # dying is asked of what is confluent
            return


TWO = mission(
    robot(hw("h", "g"), activity("d", ("h",), ("g",), produces=("s",)), activity("a", ("s",), ("g",))),
    Recursive(
        name="r", blocks=(Objective(name="o", activities=("a",)), Objective(name="p", activities=("a",)))
    ),
)


def test_past_the_bound_sections_are_diagrams(monkeypatch: pytest.MonkeyPatch) -> None:
    found = compose(TWO)
    net = local_net(SectionParts(found.usage).alone(found.graph.sections[0])).net
    assert explore_local(net).steps
    monkeypatch.setattr(big_steps, "MOST_SINGLY", 1)
    assert explore_local(net).steps is None


def test_many_steps_come_after_all_markings(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are found one by one only where the diagram of all markings hits its limit."""
    found = compose(TWO)
    net = local_net(SectionParts(found.usage).alone(found.graph.sections[0])).net
    stable = explore_local(net).space.reachable.count()
    monkeypatch.setattr(big_steps, "MOST_SINGLY", 1)
    by_markings = explore_local(net)
    assert by_markings.steps is None
    assert by_markings.space.stable is not None
    assert by_markings.space.stable.count() == stable

    def limited(_: PetriNet) -> None:
        raise LimitError("too many bytes")

    monkeypatch.setattr(exploring, "reach", limited)
    after_all = explore_local(net)
    assert after_all.steps is not None
    assert after_all.space.reachable.count() == stable
    monkeypatch.setattr(exploring, "MOST_STEPS", 1)
    with pytest.raises(LimitError, match="too many bytes"):
        explore_local(net)


@pytest.mark.parametrize("apart", [True, False])
def test_many_branches_are_reached_by_markings_as_by_big_steps(
    apart: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    ways = [(f"h{i}",) if apart or i else ("h0", "h1") for i in range(7)]
    of = robot(
        tuple(Hardware(name=f"h{i}", shared=True) for i in range(7)),
        *(activity(f"a{i}", way) for i, way in enumerate(ways)),
    )
    work = tuple(Objective(name=f"o{i}", activities=(f"a{i}",)) for i in range(7))
    found = compose(mission(of, Parallel(name="p", blocks=work)))
    said = []
    for most in (big_steps.MOST_SINGLY, 0):
        monkeypatch.setattr(big_steps, "MOST_SINGLY", most)
        space = composite_space(found)
        said.append((space.everything.count(), space.firings(space.everything)))
    assert said[0] == said[1]


@pytest.mark.parametrize("stepped", [True, False])
@pytest.mark.parametrize("dies", [True, False])
def test_what_is_explored_goes_from_process_to_process(
    stepped: bool, dies: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = compose(TWO)
    local = local_net(SectionParts(found.usage).alone(found.graph.sections[0]))
    dying = mortal(local).net if dies else None
    if not stepped:
        monkeypatch.setattr(big_steps, "MOST_SINGLY", 0)
    here = explore_and_prove(local.net, dying)
    there: Explored = pickle.loads(pickle.dumps(here))
    assert (there.steps is not None) == (here.steps is not None) == stepped
    one, other = here.alternatives(), there.alternatives()
    for transition in (None, *one.waiting):
        asked = None if transition is None else [transition]
        for name in ("after", "before"):
            states = [getattr(space, name)(space.everything, asked) for space in (one, other)]
            assert states[0].to_bytes() == states[1].to_bytes()
    assert dies or (there.ends and not there.conflicts)


def test_a_section_in_big_steps_holds_no_transient_marking() -> None:
    found = compose(TWO)
    local = local_net(SectionParts(found.usage).alone(found.graph.sections[0])).net
    explored = explore_local(local)
    whole = reach(local)
    assert whole.stable is not None
    assert explored.space.reachable.count() == whole.stable.count() < whole.reachable.count()
