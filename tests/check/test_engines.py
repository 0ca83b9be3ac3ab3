"""One mission, three engines: the same verdicts, sizes, modes and warnings."""

from __future__ import annotations

import pytest
from hypothesis import given

from mcpn.check.by_diagrams import check_by_diagrams
from mcpn.check.composition import check_by_composition
from mcpn.check.properties import REQUIRED, MissionCheck, check_mission
from mcpn.check.runs import Step
from mcpn.errors import LimitError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.testing import missions
from tests.shares import returns_early


def answers(check: MissionCheck) -> dict[str, bool | None]:
    return {name: verdict.holds for name, verdict in check.verdicts.items()}


def modes(check: MissionCheck) -> dict[str, list[list[tuple[str, str]]]]:
    return {name: sorted(sorted(mode.items()) for mode in found) for name, found in check.modes.items()}


def compare(mission_net: MissionNet) -> None:
    explicit = check_mission(mission_net)
    symbolic = check_by_diagrams(mission_net)
    assert answers(symbolic) == answers(explicit)
    assert symbolic.marking_sizes == explicit.marking_sizes
    assert symbolic.unselectable == explicit.unselectable
    assert symbolic.stable_sizes == explicit.stable_sizes
    for name, verdict in explicit.verdicts.items():
        assert len(symbolic.verdicts[name].runs) == len(verdict.runs)
        if verdict.holds is not None and explicit.verdicts["confluent"].holds:
            # Both are shortest.
            assert [len(run) for run in symbolic.verdicts[name].runs] == [len(run) for run in verdict.runs]
    if not explicit.verdicts["confluent"].holds:
        return
    assert modes(symbolic) == modes(explicit)
    if any(section.interruptions for section in mission_net.graph.all_sections()):
        with pytest.raises(LimitError, match="which composition does not take"):
            check_by_composition(mission_net)
        return
    local = check_by_composition(mission_net)
    if not local.verdicts["confluent"].holds:  # contention where the mission does not come
        assert mission_net.usage.contentions or mission_net.usage.exchanges
        return
    assert answers(local) == answers(explicit)
    assert local.stable_sizes == explicit.stable_sizes
    assert local.unselectable == explicit.unselectable
    assert modes(local) == {name: found for name, found in modes(explicit).items() if name in local.modes}
    for name, verdict in local.verdicts.items():
        for run in verdict.runs:
            replayed(mission_net, run, name)


def replayed(mission_net: MissionNet, run: tuple[Step, ...], name: str) -> None:
    """A run through the sections is one of the whole net, and shows what it is said to show."""
    net = mission_net.net
    marking = settled(mission_net, net.initial)
    for step in run:
        (t,) = [t for t in net.enabled(marking) if net.transitions[t].event == step.event]
        marking = settled(mission_net, net.fire(marking, t))
    if name == "success_reachable":
        assert marking[mission_net.success]
    if name == "failure_reachable":
        assert marking[mission_net.failure]
    if name == "deadlock_free":
        assert not net.enabled(marking)


def settled(mission_net: MissionNet, marking: tuple[int, ...]) -> tuple[int, ...]:
    net = mission_net.net
    while (enabled := net.enabled(marking)) and net.transitions[enabled[0]].internal:
        marking = net.fire(marking, enabled[0])
    return marking


@given(missions())
def test_three_engines_on_generated_missions(mission: Mission) -> None:
    try:
        compare(compose(mission))
    except LimitError as error:
        returns_early(type(error).__name__)
        return


@given(missions(max_events=2, max_sections=8))
def test_engines_on_missions_with_events(mission: Mission) -> None:
    try:
        compare(compose(mission))
    except LimitError:
        return


def test_three_engines_on_ulysse(ulysse_net: MissionNet) -> None:
    compare(ulysse_net)
    assert all(check_by_diagrams(ulysse_net).verdicts[name].holds for name in REQUIRED)
