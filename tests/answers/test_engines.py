"""One mission, three engines: the same verdicts, sizes, modes and warnings."""

from __future__ import annotations

import networkx as nx
import numpy as np
from hypothesis import event, given

from mcpn.answers.spaces_by_engine import MissionSpaces, spaces_of
from mcpn.answers.verdicts.mission import REQUIRED, MissionCheck, Verdict, _verdicts, check
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Robot
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.engines import Choice
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.run import Run
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.testing import missions
from tests.drawing.settling import stabilise
from tests.draws import fewer
from tests.shares import returns_early

ENGINES: tuple[Asked, ...] = ("auto", "explicit")

MOST_STATES = 200_000
"""Larger missions are drawn now and then; to list their markings takes minutes."""


def answers(found: MissionCheck) -> dict[str, bool | None]:
    return {name: verdict.holds for name, verdict in found.verdicts.items()}


def modes(checked: MissionCheck) -> dict[str, list[list[tuple[str, str]]]]:
    return {name: sorted(sorted(mode.items()) for mode in found) for name, found in checked.modes.items()}


def lengths(verdict: Verdict) -> list[int]:
    return [len(run.events) for run in verdict.runs]


def compare(mission_net: MissionNet) -> None:
    explicit = check(mission_net, engine="explicit", max_states=MOST_STATES)
    if explicit.verdicts["bounded"].holds is None:  # not confluent, and too many markings to be listed
        assert not explicit.verdicts["confluent"].holds
        returns_early("too many markings")
        return
    symbolic = check(mission_net, engine="symbolic")
    assert answers(symbolic) == answers(explicit)
    assert explicit.marking_sizes in (symbolic.marking_sizes, None)  # they may be too many to be listed
    assert symbolic.unselectable == explicit.unselectable
    assert symbolic.stable_sizes == explicit.stable_sizes
    for name, verdict in explicit.verdicts.items():
        told = {len(verdict.runs), len(symbolic.verdicts[name].runs)}
        # Either of two faults may be told, where a mission has both.
        assert len(told) == 1 or (name == "confluent" and told == runs_of_faults(mission_net))
        if verdict.holds is not None and explicit.verdicts["confluent"].holds:
            # Both are shortest.
            assert lengths(symbolic.verdicts[name]) == lengths(verdict)
    if not explicit.verdicts["confluent"].holds:
        return
    assert modes(symbolic) == modes(explicit)
    local = check(mission_net, engine="local")
    if not local.verdicts["confluent"].holds:  # contention where the mission does not come
        assert mission_net.usage.contentions
        return
    assert answers(local) == answers(explicit)
    assert local.stable_sizes == explicit.stable_sizes
    assert local.unselectable == explicit.unselectable
    assert modes(local) == {name: found for name, found in modes(explicit).items() if name in local.modes}
    for name, verdict in local.verdicts.items():
        for run in verdict.runs:
            replayed(mission_net, run, name)


def by_markings(mission_net: MissionNet, most: int) -> MissionCheck:
    """A check of all markings, reduced to the stable ones as the paper does: what listing must agree with."""
    graph = explore(mission_net.net, max_states=most)
    alternatives: ArraySpace | None = None
    decided = Verdict("confluent", True)
    try:
        alternatives = ArraySpace(by_reduction(graph))
    except SemanticsError:
        decided = Verdict("confluent", False)
    return _verdicts(MissionSpaces(mission_net), Choice("explicit"), decided, ArraySpace(graph), alternatives)


def listing_agrees(mission_net: MissionNet) -> None:
    whole = by_markings(mission_net, 20_000)
    for engine in ENGINES if spaces_of(mission_net).few() else ("explicit",):
        listed = check(mission_net, engine=engine)
        assert listed.choice.engine == "explicit"
        assert answers(listed) == answers(whole)
        assert listed.marking_sizes == whole.marking_sizes
        assert listed.stable_sizes == whole.stable_sizes
        assert (listed.markings is None) == whole.verdicts["confluent"].holds
        assert listed.unselectable == whole.unselectable
        assert modes(listed) == modes(whole)
        for name, verdict in whole.verdicts.items():
            if name != "confluent":  # of several faults any may be told
                assert listed.verdicts[name].runs == verdict.runs
    if not whole.verdicts["confluent"].holds:
        event("not confluent")
        assert len(listed.verdicts["confluent"].runs) in runs_of_faults(mission_net)


def runs_of_faults(mission_net: MissionNet) -> set[int]:
    """How many runs show each fault of internal runs: two where ends differ, one where it need not end."""
    graph = explore(mission_net.net)
    internal = np.array([t.internal for t in mission_net.net.transitions])[graph.labels]
    firings: nx.DiGraph[int] = nx.DiGraph()
    firings.add_nodes_from(range(graph.states))
    firings.add_edges_from(
        zip(graph.sources[internal].tolist(), graph.targets[internal].tolist(), strict=True)
    )
    parts = nx.condensation(firings)
    ends: dict[int, set[int]] = {}
    faults = set()
    for part in reversed(list(nx.topological_sort(parts))):
        members = parts.nodes[part]["members"]
        ends[part] = set().union(*(ends[after] for after in parts.successors(part)))
        if len(members) > 1 or any(firings.has_edge(state, state) for state in members):
            faults.add(1)
        elif not ends[part]:
            ends[part] = set(members)
        if len(ends[part]) > 1:
            faults.add(2)
    return faults


def replayed(mission_net: MissionNet, run: Run, name: str) -> None:
    """A run through the sections is one of the whole net, and shows what it is said to show."""
    net = mission_net.net
    marking = stabilise(net, net.initial)
    for happens in run.events:
        (t,) = [t for t in net.enabled(marking) if net.transitions[t].event == happens]
        marking = stabilise(net, net.fire(marking, t))
    if name == "success_reachable":
        assert marking[mission_net.success]
    if name == "failure_reachable":
        assert marking[mission_net.failure]
    if name == "abort_reachable":
        assert mission_net.abort is not None
        assert marking[mission_net.abort]
    if name == "deadlock_free":
        assert not net.enabled(marking)


@fewer(0.3)
@given(missions() | missions(late=True))
def test_three_engines_on_generated_missions(mission: Mission) -> None:
    try:
        compare(compose(mission))
    except LimitError as error:
        returns_early(type(error).__name__)
        return


@fewer(0.5, least=8)
@given(
    missions(max_objectives=2, max_sections=4, max_hardware=3)
    | missions(max_objectives=3, max_hardware=2)
    | missions(max_objectives=3, max_hardware=3, lasting=True)
    | missions(max_objectives=3, max_hardware=2, crashes=True)
    | missions(max_objectives=3, max_hardware=2, late=True)
)
def test_stable_states_alone_tell_what_all_markings_tell(mission: Mission) -> None:
    try:
        listing_agrees(compose(mission))
    except LimitError as error:
        returns_early(type(error).__name__)


def test_software_that_may_crash_costs_no_states_before_it_runs() -> None:
    """Thirty activities of which one runs: sets of those that have crashed are not sets of lost hardware."""
    activities = tuple(
        Activity(name=f"a{i}", faulty=True, alternatives=(Alternative(name=f"w{i}"),)) for i in range(30)
    )
    net = compose(
        Mission(
            name="m",
            robots=(Robot(name="r", activities=activities),),
            blocks=(Objective(name="go", activities=("a0",)),),
        )
    )
    listed = check(net)
    assert listed.choice.engine == "explicit"
    assert listed.choice.limit is not None
    assert answers(listed) == answers(check(net, engine="explicit")) == answers(check(net, engine="symbolic"))


@fewer(0.25)
@given(missions(aborts=4, timeouts=3, early=3, max_events=1, max_sections=8))
def test_engines_on_missions_that_abort(mission: Mission) -> None:
    try:
        compare(compose(mission))
    except LimitError:
        return


@fewer(0.25)
@given(missions(max_events=2, max_sections=8))
def test_engines_on_missions_with_events(mission: Mission) -> None:
    try:
        compare(compose(mission))
    except LimitError:
        return


def test_three_engines_on_ulysse(ulysse_net: MissionNet) -> None:
    compare(ulysse_net)
    assert check(ulysse_net, engine="explicit").marking_sizes == (44299, 124078)
    assert all(check(ulysse_net, engine="symbolic").verdicts[name].holds for name in REQUIRED)
