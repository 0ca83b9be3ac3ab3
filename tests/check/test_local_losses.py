"""Cut sets by composition against those of the whole graph, contention inside sections included."""

from __future__ import annotations

import time
from dataclasses import replace

import pytest
from hypothesis import event, given, settings

from mcpn.check import local_losses
from mcpn.check.causes import find_causes, find_causes_locally
from mcpn.check.cutsets import Losses, Moment
from mcpn.check.local_losses import LocalLosses
from mcpn.check.losing import CriticalEvent, Outlook
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.flatten import ParallelSection, flatten
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Parallel, Robot
from mcpn.mission.usage import Usage
from mcpn.net.compose import MissionNet, compose
from mcpn.space.alternatives import direct
from mcpn.testing import missions
from tests.check.oracle import fragile_missions
from tests.check.test_availability import redundant
from tests.shares import returns_early


def agree(found: MissionNet, max_states: int) -> None:
    try:
        whole = Losses(Outlook(found, direct(found.net, max_states=max_states)))
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    try:
        local = LocalLosses(found.usage)
    except ConfluenceError:
        return  # in a section that no run enters
    assert local.hardware == whole.hardware
    goal = whole.outlook.mission

    def same(one: int, other: int) -> None:
        assert local.families.members(one) == whole.families.members(other)  # type: ignore[arg-type]

    for moment in (Moment.START, Moment.WHENEVER, Moment.SOMETIME):
        same(local.mission_at(moment), whole.cut_sets(goal, moment))
    for section in found.graph.sections:
        if whole.entry(section.name).any():
            same(local.mission_entering(section.name), whole.cut_sets(goal, Moment.ENTRY, section.name))
    for moment in (Moment.ENTRY, Moment.WHENEVER, Moment.SOMETIME):
        functions = local.objective_at(moment)
        for name, objective in whole.outlook.objectives.items():
            if objective.running.any():
                same(functions[name], whole.cut_sets(objective, moment, name))


Situations = set[tuple[str, tuple[str, ...], tuple[tuple[str, str], ...]]]


def situations(found: list[CriticalEvent] | None) -> Situations:
    assert found is not None
    return {(str(c.event), c.objectives, tuple(sorted(c.mode.items()))) for c in found}


def agree_on_reports(found: MissionNet, max_states: int) -> None:
    """What is reported by composition is what is reported on the whole graph."""
    try:
        outlook = Outlook(found, direct(found.net, max_states=max_states))
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    whole = find_causes(found, outlook)
    try:
        local = find_causes_locally(found)
    except ConfluenceError:
        return  # in a section that no run enters
    if found.usage.contentions:
        assert local.mission.critical is None
    else:
        assert situations(local.mission.critical) == situations(whole.mission.critical)
    assert situations(local.mission.critical_with_repairs) == situations(whole.mission.critical_with_repairs)
    assert local.mission.cut_sets == whole.mission.cut_sets
    for name, goal in whole.objectives.items():
        if outlook.objectives[name].running.any():
            assert local.objectives[name].cut_sets == goal.cut_sets
            assert situations(local.objectives[name].critical) == situations(goal.critical)
    entered = {s.section: s for s in local.survival}
    for survival in whole.survival:
        if survival.section in entered:
            assert replace(survival, run=None) == entered[survival.section]


def agree_on_regions(found: MissionNet, max_states: int) -> None:
    """The losing regions have as many states by composition as on the whole graph."""
    try:
        outlook = Outlook(found, direct(found.net, max_states=max_states))
        local = LocalLosses(found.usage)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    for repairs in (True, False):
        assert local.losing_states(repairs) == outlook.losing(outlook.mission, repairs).sum()
        for name, goal in outlook.objectives.items():
            assert local.losing_states(repairs, name) == outlook.losing(goal, repairs).sum()


def test_ulysse(ulysse_net: MissionNet) -> None:
    agree(ulysse_net, 1000)
    agree_on_reports(ulysse_net, 1000)
    agree_on_regions(ulysse_net, 1000)


@settings(max_examples=100)
@given(missions(max_objectives=3, max_sections=6, max_hardware=3) | fragile_missions(max_hardware=4))
def test_losing_regions_by_composition_are_those_of_the_whole(mission: Mission) -> None:
    agree_on_regions(compose(mission), 1000)


@settings(max_examples=100)
@given(missions(max_objectives=3, max_sections=6, max_hardware=3) | fragile_missions(max_hardware=4))
def test_composition_reports_what_the_whole_reports(mission: Mission) -> None:
    agree_on_reports(compose(mission), 1000)


@settings(max_examples=150)
@given(missions(max_objectives=3, max_sections=6, max_hardware=3) | fragile_missions(max_hardware=4))
def test_composition_gives_the_cut_sets_of_the_whole(mission: Mission) -> None:
    agree(compose(mission), 1500)


def long_mission(sections: int, ways: int) -> Mission:
    """Sections in a row, the odd ones with two branches that share a chain of software; own hardware each."""
    hardware, activities, blocks = [], [], []
    for i in range(sections):
        own = [Hardware(name=f"h{i}_{k}") for k in range(ways)]
        hardware += own
        alternatives = tuple(Alternative(name=f"way{h.name}", consumes=(h.name,)) for h in own)
        activities.append(Activity(name=f"a{i}", alternatives=alternatives))
        free = Activity(name=f"free{i}", alternatives=(Alternative(name="free"),))
        activities.append(free)
        alone = Objective(name=f"x{i}", activities=(f"a{i}",))
        beside = Objective(name=f"y{i}", activities=(f"free{i}",))
        blocks.append(Parallel(name=f"p{i}", blocks=(alone, beside)) if i % 2 else alone)
    robot = Robot(name="r", hardware=tuple(hardware), activities=tuple(activities))
    return Mission(name="long", robots=(robot,), blocks=tuple(blocks))


def test_thirty_resources_in_ten_sections_take_seconds() -> None:
    mission = long_mission(10, 3)
    started = time.process_time()
    local = LocalLosses(Usage(mission, flatten(mission)))
    # Closed form: a section is lost with its three resources, the mission with any section.
    expected = [(3 * i, 3 * i + 1, 3 * i + 2) for i in range(10)]
    assert local.families.members(local.mission) == expected
    for number in range(10):
        entering = local.mission_entering(f"p{number}" if number % 2 else f"x{number}")
        assert local.families.members(entering) == expected[number:]
    # Once the last objective has succeeded and only the one beside it runs, no loss does harm.
    assert local.families.members(local.mission_at(Moment.WHENEVER)) == []
    assert local.families.members(local.mission_at(Moment.SOMETIME)) == expected
    assert time.process_time() - started < 10


def test_a_chain_of_thirty_resources_under_one_objective() -> None:
    found = compose(redundant(10, 3))
    started = time.process_time()
    causes = find_causes_locally(found)
    # Closed form: each resource of the chain is lost with its three sensors, and with nothing less.
    assert causes.mission.cut_sets == [tuple(f"h{i}_{k}" for k in range(3)) for i in range(10)]
    assert causes.mission.critical_events is not None
    assert {str(e) for e in causes.mission.critical_events} == {
        "OBJ_go_EV_FAIL",
        *(f"h{i}_{k}_EV_OOS" for i in range(10) for k in range(3)),
    }
    assert (causes.survival[0].always, causes.survival[0].at_most) == (2, 20)
    assert time.process_time() - started < 10


@settings(max_examples=100)
@given(fragile_missions(max_hardware=4))
def test_text_sections_say_what_local_graphs_say(mission: Mission) -> None:
    found = compose(mission)
    with pytest.MonkeyPatch.context() as patch:
        try:
            by_graph = find_causes_locally(found)
        except ConfluenceError as error:
            returns_early(type(error).__name__)
            return
        patch.setattr(local_losses, "MAX_FAULTY", -1)
        patch.setattr(local_losses, "TEXT_BEYOND", -1)
        by_text = find_causes_locally(found)
    assert by_text.survival == by_graph.survival
    blocks = any(
        isinstance(s, ParallelSection) and s.name in {e.section for e in by_graph.survival}
        for s in found.graph.sections
    )
    event(f"parallel blocks: {blocks}")
    if blocks:
        assert by_text.mission.critical is None
    else:
        assert by_text.mission.critical_events == by_graph.mission.critical_events
    pairs = [(by_text.mission, by_graph.mission)]
    pairs += [(goal, by_graph.objectives[name]) for name, goal in by_text.objectives.items()]
    for one, other in pairs:
        assert one.moments == {moment: other.moments[moment] for moment in one.moments}
        assert blocks or one.moments.keys() == other.moments.keys()
    for name, goal in by_text.objectives.items():
        assert goal.critical_events == by_graph.objectives[name].critical_events
    # Diagrams do not tell functioning modes apart.
    assert modeless(by_text.mission.critical_with_repairs) == modeless(by_graph.mission.critical_with_repairs)


def modeless(events: list[CriticalEvent]) -> dict[tuple[str, tuple[str, ...]], int]:
    """Critical events with how many edges they have, whatever the functioning mode."""
    found: dict[tuple[str, tuple[str, ...]], int] = {}
    for critical in events:
        key = str(critical.event), critical.objectives
        found[key] = found.get(key, 0) + critical.edges
    return found
