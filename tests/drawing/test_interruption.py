"""Declared events interrupt what runs: where the net goes on, and what is left behind."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from hypothesis import event, given, settings

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.events import Event, What
from mcpn.logic.questions import Questions
from mcpn.mission.core.objectives_graph import ElementarySection, ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import FAIL, SUCCEED, Handler, Mission, Objective, Parallel
from mcpn.mission.robot import DeclaredEvent
from mcpn.nets.petri import Marking
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from mcpn.testing.shape import UNCONTENDED
from tests import small
from tests.shares import returns_early

HARDWARE = ("GPS_sensor", "IMU_sensor", "thruster_actuator")


def said(found: MissionNet, marking: Marking, *kinds: str) -> set[str]:
    """Of which elements a marking says something."""
    return {name for place, (kind, name) in found.roles.items() if kind in kinds and marking[place]}


def nothing_left(found: MissionNet, marking: Marking) -> None:
    """Nothing runs, waits or is in error but what running objectives need, and no order is on its way."""
    sections = {s.name: s for s in found.graph.walk()}
    objectives = said(found, marking, "objective", "pending")
    needed = {b for o in objectives for a in sections[o].activities for b in found.usage.closure(a)}
    assert {
        name.split(".")[0] for name in said(found, marking, "active", "wait", "want", "refused")
    } <= needed
    orders = ("_Stop", "_halt", "_halted", "_halting")
    marked = [p.name for p, tokens in zip(found.net.places, marking, strict=True) if tokens]
    assert not [name for name in marked if name.endswith(orders)]


def begun(graph: ObjectivesGraph, name: str) -> set[str]:
    """The objectives with which a section begins."""
    section = graph.section(name)
    if isinstance(section, ElementarySection):
        return {name}
    assert isinstance(section, ParallelSection)
    return {o for branch in section.branches for o in begun(branch.graph, branch.graph.entry)}


@given(missions(max_events=2) | missions(UNCONTENDED, sections=4, events=2))
@settings(max_examples=60)
def test_an_event_interrupts_in_every_stable_state(mission: Mission) -> None:
    try:
        found = compose(mission)
        graph = direct(found.net, max_states=2000)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    tops = {s.name: {inner.name for inner in _inside(s)} for s in found.graph.sections}
    met = 0
    for state in range(graph.states):
        before = graph.marking(state)
        running = said(found, before, "objective", "pending", "done")
        for label, target in graph.successors(state):
            happens = graph.net.transitions[label].event
            if happens is None or happens.what is not What.DECLARED:
                continue
            met += 1
            after = graph.marking(target)
            assert said(found, before, "oos") == said(found, after, "oos")
            nothing_left(found, after)
            if after[found.success] or after[found.failure]:
                assert found.not_idle(after) == []
                continue
            (top,) = [name for name, inner in tops.items() if running & inner]
            now = said(found, after, "objective", "pending")
            section = found.graph.section(top)
            if isinstance(section, ElementarySection):  # no branch can have handled it
                met_here = (i for i in section.interruptions if i.event == happens.element)
                leads = next(i.target for i in met_here if i.once not in said(found, before, "happened"))
                assert now == begun(found.graph, leads)
            else:  # left whole, or still in some of its branches
                targets = [i.target for i in section.interruptions if i.event == happens.element]
                ways = [*targets, section.success, section.failure]
                entered = [begun(found.graph, way) for way in ways if way not in (SUCCEED, FAIL)]
                assert now <= tops[top] or now in entered
    event(f"interruptions: {'many' if met > 20 else 'some' if met else 'none'}")


def _inside(section: Section) -> Iterator[Section]:
    yield section
    if isinstance(section, ParallelSection):
        for branch in section.branches:
            yield from branch.graph.walk()


def leaking(ulysse: Mission) -> Mission:
    """Ulysse, going up from everywhere below when it leaks; what it requires without leaks is left out."""
    on_leak = (Handler(event="leak", goto="going_up"),)
    transect = next(p for p in ulysse.protocols if p.name == "transect")
    blocks = tuple(b if b.name == "going_up" else replace(b, handlers=on_leak) for b in transect.blocks)
    protocols = (replace(p, blocks=blocks) if p is transect else p for p in ulysse.protocols)
    protocols = (replace(p, requirements=()) for p in protocols)
    robot = replace(ulysse.robots[0], events=(DeclaredEvent(name="leak"),))
    robots = (robot, *ulysse.robots[1:])
    return replace(ulysse, protocols=tuple(protocols), robots=robots, requirements=())


def test_ulysse_goes_up_when_it_leaks(ulysse: Mission) -> None:
    found = compose(leaking(ulysse))
    checked = check(found)
    assert checked.passed
    graph = checked.spaces.listed()
    # The stable markings are those of Ulysse without a leak: 260 (paper, Table 1, as reconstructed).
    assert graph.states == 260
    leak = Event(What.DECLARED, "leak")
    index = found.net.place_index
    below = ["diving", "filming", "advancing", "measuring_temperature"]
    inside = np.zeros(graph.states, bool)
    for name in below:
        inside |= graph.marked(index[f"OBJ_transect.{name}"])
    met = 0
    for state in range(graph.states):
        after = [t for label, t in graph.successors(state) if found.net.transitions[label].event == leak]
        assert len(after) == inside[state]
        for target in after:
            met += 1
            assert graph.marking(target)[index["OBJ_transect.going_up"]]
            # What is out of service stays so; the GPS and the thruster serve going up if they can.
            out = [graph.marking(s)[index[f"{h}_OOS"]] for s in (state, target) for h in HARDWARE]
            assert out[:3] == out[3:]
    assert graph.edges == 1332 + met
    wanted = "AG(event(leak) -> EX objective(going_up))"
    answers = Questions(spaces_of(found), on="alternatives")
    assert answers.answer(wanted).holds


def test_a_handler_happens_once(ulysse: Mission) -> None:
    again = replace(leaking(ulysse), handlers=(Handler(event="leak", goto="coral_head", once=True),))
    found = compose(again)
    assert check(found).passed
    assert found.graph.once() == ["leak"]
    assert [s.name for s in found.graph.walk()] == [s.name for s in compose(leaking(ulysse)).graph.walk()]
    space = ArraySpace(direct(found.net))
    happened = space.marked(found.by_role["happened", "leak"])
    leaks = [t for t, of in enumerate(found.net.transitions) if of.event == Event(What.DECLARED, "leak")]
    there = happened & space.marked(found.by_role["objective", "coral_head.manual_moving"])
    assert there
    assert not there & space.before(space.everything, leaks)


def test_a_wide_block_that_an_event_may_halt_waits_for_all_its_branches() -> None:
    """More branches than are combined, each without resources: closed forms for states and events."""
    n = 7
    of = small.robot(
        (), *(small.activity(f"a{i}", ()) for i in range(n)), small.activity("rest", ()), events=("recall",)
    )
    branches = tuple(Objective(name=f"x{i}", activities=(f"a{i}",)) for i in range(n))
    wide = Parallel(
        name="wide",
        blocks=branches,
        success="home",
        failure="home",
        handlers=(Handler(event="recall", goto="home"),),
    )
    found = compose(small.mission(of, wide, Objective(name="home", activities=("rest",))))
    graph = direct(found.net)
    # Each branch runs or has ended in one of two ways, not all have ended; the begin, home, and two ends.
    inside = 3**n - 2**n
    assert graph.states == inside + 4
    # Each branch that runs succeeds or fails, or all are halted; the start, and the two ends of home.
    assert graph.edges == 2 * n * 3 ** (n - 1) + inside + 3
    checked = check(found)
    assert checked.passed
