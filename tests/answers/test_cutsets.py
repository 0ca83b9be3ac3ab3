"""Losing regions and minimal cut sets against brute force over all subsets, by plain search on the net."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from mcpn.answers.causes.find import Causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.answers.causes.minimal_cut_sets import CutSet, CutSets, Moment
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.mission_names import MissionNames
from mcpn.answers.verdicts.modes import situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.permanent_loss import mortal
from mcpn.errors import LimitError, SemanticsError
from mcpn.events import Event, What
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.syntax import parse
from mcpn.mission.core.objectives_graph import ElementarySection
from mcpn.mission.fact_conditions import FACTS
from mcpn.mission.model import Handler, Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking
from mcpn.spaces.arrays import ArraySet, ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.markings.graph import StateGraph
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.logic.oracle import Play, fragile_missions, minimal
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

IN_TIME = missions(
    max_objectives=2, max_sections=5, max_hardware=2, max_producers=1, timed_blocks=8, depth=2
) | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3, timed_blocks=8, aborts=1)
"""Blocks that are left when their time is over."""
LEFT_BY_FACTS = missions(
    max_objectives=2, max_sections=5, max_hardware=2, producers=1, facts=1, becoming=8, early=2
) | fragile_missions(max_objectives=2, max_sections=5, max_hardware=2, producers=1, facts=1, becoming=8)
"""Blocks that are left as facts become so."""
GUARDED = missions(
    max_objectives=3, max_sections=5, max_hardware=2, producers=1, facts=1, guards=8
) | fragile_missions(max_objectives=3, max_sections=5, max_hardware=2, producers=1, facts=1, guards=8)
"""Blocks that are entered only where facts are so."""

NAVIGATION: list[CutSet] = [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")]
ULYSSE: dict[str, list[CutSet]] = {
    # From the text of the paper, section 8: what consumes location and thruster needs the thruster and one of
    # the two sensors of the localisation; filming and temperature consume nothing.
    "coral_head.manual_moving": NAVIGATION,
    "coral_head.isopheric_observation": NAVIGATION,
    "transect.diving": NAVIGATION,
    "transect.filming": [],
    "transect.advancing": NAVIGATION,
    "transect.measuring_temperature": [],
    "transect.going_up": NAVIGATION,
}


@pytest.fixture(scope="module", params=ENGINES)
def ulysse_asked(ulysse_net: MissionNet, request: pytest.FixtureRequest) -> Asked:
    return Asked(ulysse_net, request.param)


def test_ulysse_cut_sets(ulysse_asked: Asked) -> None:
    asked = ulysse_asked
    for name in asked.prospects.objectives:
        for moment in (Moment.ENTRY, Moment.WHENEVER, Moment.SOMETIME):
            assert asked.cut_sets(name, moment) == ULYSSE[name]
    for moment in (Moment.START, Moment.WHENEVER, Moment.SOMETIME):
        assert asked.cut_sets(None, moment) == NAVIGATION
    # Without navigation diving fails, so that the census is never entered.
    assert asked.cut_sets("transect.filming", Moment.START) == NAVIGATION


def test_ulysse_cut_sets_by_brute_force(ulysse_asked: Asked) -> None:
    confirm(ulysse_asked)


def test_regions_on_markings_and_on_stable_markings_agree(
    ulysse_net: MissionNet, ulysse_markings: StateGraph
) -> None:
    markings: Prospects[ArraySet] = Prospects(ulysse_net, ArraySpace(ulysse_markings))
    alternatives: Prospects[ArraySet] = Prospects(ulysse_net, ArraySpace(direct(ulysse_net.net)))
    graph = direct(ulysse_net.net)
    rows = {row.tobytes(): s for s, row in enumerate(ulysse_markings.markings)}
    stable = np.array([rows[row.tobytes()] for row in graph.markings])
    internal = frozenset(i for i, t in enumerate(ulysse_net.net.transitions) if t.internal)
    pairs = [(alternatives.mission, markings.mission)]
    pairs += [(goal, markings.objectives[name]) for name, goal in alternatives.objectives.items()]
    for on_stable, on_all in pairs:
        for repairs in (True, False):
            one = alternatives.losing(on_stable, repairs=repairs)
            wanted = markings.allowed(on_all, repairs=repairs) | internal
            other = on_all.running - markings.space.reaching(on_all.won, on_all.running, wanted)
            assert np.array_equal(one.mask, other.mask[stable])


def confirm(asked: Asked) -> None:
    """Every cut set at every moment is that of brute force over all subsets of hardware."""
    found, play = asked.found, Play(asked.found)
    everything = play.reach([play.initial])
    begin = play.marks("MISSION_begin")
    forced = play.forced()
    success = play.marks("MISSION_success")
    # A mission that has ended loses nothing more.
    ends = [play.marks(f"MISSION_{end}") for end in found.ends]
    subsets = play.subsets()

    def check(computed: list[CutSet], lost: list[frozenset[str]]) -> None:
        assert computed == minimal(lost)

    at_start = {d: play.without(d) for d in subsets}
    check(
        asked.cut_sets(None, Moment.START),
        [d for d in subsets if not play.mission_survives(at_start[d], d)],
    )
    check(
        asked.cut_sets(None, Moment.WHENEVER),
        [
            d
            for d in subsets
            if not any(
                d <= play.out(m) and play.mission_survives(m, d)
                for m in everything
                if not begin(m) and not success(m)
            )
        ],
    )
    check(
        asked.cut_sets(None, Moment.SOMETIME),
        [
            d
            for d in subsets
            if any(
                d == play.out(m) and not play.mission_survives(m, d)
                for m in forced
                if not begin(m) and not any(ended(m) for ended in ends)
            )
        ],
    )
    if found.abort is not None:
        confirm_safety(asked, play, everything)
    # Losing regions: as many states as plain search finds, with repairs and without.
    for dead in (frozenset[str](), frozenset(play.hardware)):
        lost = asked.prospects.losing(asked.goal(), repairs=not dead)
        assert lost.count() == sum(not play.mission_survives(m, dead) for m in everything)
    for section in found.graph.walk():
        name = section.name
        runs = play.marks(f"OBJ_{name}")
        running = [m for m in everything if runs(m)]
        for dead in (frozenset[str](), frozenset(play.hardware)):
            lost = asked.prospects.losing(asked.goal(name), repairs=not dead)
            assert lost.count() == sum(not play.objective_survives(m, name, dead) for m in running)
        check(
            asked.cut_sets(name, Moment.WHENEVER),
            [
                d
                for d in subsets
                if not any(d <= play.out(m) and play.objective_survives(m, name, d) for m in running)
            ],
        )
        check(
            asked.cut_sets(name, Moment.SOMETIME),
            [
                d
                for d in subsets
                if any(
                    d == play.out(m) and not play.objective_survives(m, name, d) for m in forced if runs(m)
                )
            ],
        )
        check(
            asked.cut_sets(name, Moment.START),
            [d for d in subsets if not play.ever_succeeds(at_start[d], name, d)],
        )
        entered = {
            m
            for before in everything
            for event, m in play.edges(before)
            if runs(m) and (not runs(before) or play.leaves(before, event, m, f"OBJ_{name}"))
        }
        if entered and isinstance(section, ElementarySection) and not pending(found, name):
            events = {str(t.event) for t in found.net.transitions if t.event is not None}
            others = [event for event in events if not event.endswith("_EV_OOS")]
            dying = play.reach(
                entered,
                others,
            )
            check(
                asked.cut_sets(name, Moment.ENTRY),
                [
                    d
                    for d in subsets
                    if not any(d <= play.out(m) and play.objective_survives(m, name, d) for m in dying)
                ],
            )
            check(
                asked.cut_sets(None, Moment.ENTRY, name),
                [
                    d
                    for d in subsets
                    if not any(d <= play.out(m) and play.mission_survives(m, d) for m in dying)
                ],
            )


@given(
    missions(sections=6, hardware=1, producers=0, activities=2, alternatives=1, events=1, interrupted=True)
    | missions(max_objectives=2, max_sections=5, max_hardware=2, max_producers=1),
    st.sampled_from(ENGINES),
)
def test_an_objective_is_entered_where_each_of_its_runs_begins(mission: Mission, engine: Engine) -> None:
    found = small(mission, 400)
    if found is None:
        return
    play, prospects = Play(found), Asked(found, engine).prospects
    everything = play.reach([play.initial])
    others = {str(t.event) for t in found.net.transitions} - {f"{h}_EV_OOS" for h in play.hardware}
    for name, section in prospects.sections.items():
        inside = [*prospects.places("objective", [name]), *prospects.places("pending", [name])]
        begun = {
            after
            for before in everything
            for happened, after in play.edges(before)
            if any(after[p] for p in inside)
            and (
                not any(before[p] for p in inside)
                or play.leaves(before, happened, after, f"OBJ_{name}")  # a try ends, or is interrupted
            )
        }
        assert prospects.entered(section).count() == len(play.reach(begun, others))


@settings(max_examples=max(settings().max_examples, 60))  # of few the critical mode says something
@given(
    missions(max_objectives=2, max_sections=3, max_hardware=3, max_producers=1, max_activities=3)
    | fragile_missions(max_objectives=2, max_sections=3, max_hardware=3)
    | fragile_missions(max_objectives=2, max_sections=3, max_hardware=2, reasons=8)
    | IN_TIME
    | LEFT_BY_FACTS,
    st.sampled_from(ENGINES),
    st.booleans(),
)
def test_critical_events_are_those_of_plain_search(mission: Mission, engine: Engine, repairs: bool) -> None:
    found = small(mission, 200)
    if found is None:
        return
    play, asked = Play(found), Asked(found, engine)
    dead = frozenset[str]() if repairs else frozenset(play.hardware)
    makers = {k: a for a in found.core.activities for k in a.produces}

    def under(resource: str) -> set[str]:
        """What is felt through a resource, losses or facts; nothing where its producer never needs any."""
        if resource not in makers:
            return {resource}.intersection(play.hardware)
        ways = {way: set[str]().union(*map(under, way.consumes)) for way in makers[resource].alternatives}
        refusable = all(needed or way.requires for way, needed in ways.items())
        facts = {FACTS} if any(way.requires for way in ways) else set[str]()
        return facts.union(*ways.values()) if refusable else set()

    def concerned(of: Event) -> set[str]:
        """Those whose alternatives differ in the hardware, or those of the objective that ends."""
        if of.what in (What.SUCCESS, What.FAILURE, What.TIMEOUT):
            section = asked.prospects.sections.get(of.element)  # none where the time of a block is over
            return set(section.activities) if section else set()
        differing = set()
        for name in found.usage.started:
            (activity,) = (a for a in found.core.activities if a.name == name)
            ways = [set[str]().union(*map(under, way.consumes)) for way in activity.alternatives]
            if len({of.element in way for way in ways}) == 2:
                differing.add(name)
        return differing if of.what in (What.OUT_OF_SERVICE, What.REPAIRED) else set()

    def expected(name: str | None) -> Counter[tuple[str, frozenset[str], frozenset[tuple[str, str]]]]:
        runs = play.marks(f"OBJ_{name}") if name else lambda m: not play.marks("MISSION_success")(m)
        told = Counter[tuple[str, frozenset[str], frozenset[tuple[str, str]]]]()
        survives: dict[Marking, bool] = {}
        for before in play.reach([play.initial]):
            for text, after in play.edges(before):
                if not runs(before) or not runs(after) or (not repairs and text.endswith("_EV_RD")):
                    continue
                if name and play.leaves(before, text, after, f"OBJ_{name}"):
                    continue
                for m in (before, after):
                    if m not in survives:
                        survives[m] = (
                            play.objective_survives(m, name, dead) if name else play.mission_survives(m, dead)
                        )
                if survives[before] and not survives[after]:
                    said = situation(found, before)
                    those = concerned(Event.parse(text))
                    mode = frozenset((a, way) for a, way in said.mode.items() if a in those)
                    told[text, frozenset(said.objectives), mode] += 1
        return told

    for name in (None, *asked.prospects.objectives):
        told = asked.prospects.critical(asked.goal(name), repairs=repairs)
        assert {
            (str(c.event), frozenset(c.objectives), frozenset(c.mode.items())): c.edges for c in told
        } == expected(name)


def pending(found: MissionNet, name: str) -> bool:
    return ("pending", name) in found.by_role


def confirm_safety(asked: Asked, play: Play, everything: set[Marking]) -> None:
    """Cut sets and losing regions of the safe ends are those of brute force."""
    aborted, succeeded = play.marks("MISSION_abort"), play.marks("MISSION_success")
    unsafe = play.unsafe
    goal, dying = asked.prospects.safety, asked.cuts.safety
    assert goal is not None
    assert dying is not None
    event(f"can be aborted, by failures of what should make safe: {bool(unsafe)}")

    survives = play.ends_safely
    subsets = play.subsets()
    start = {d: play.without(d) for d in subsets}
    lost = [d for d in subsets if not survives(start[d], d)]
    assert asked.cuts.minimal(asked.cuts.defeating(dying, Moment.START)) == minimal(lost)
    begin = play.marks("MISSION_begin")
    running = [m for m in everything if not aborted(m) and not succeeded(m)]
    open_ = [m for m in running if not begin(m)]
    whenever = [d for d in subsets if not any(d <= play.out(m) and survives(m, d) for m in open_)]
    assert asked.cuts.minimal(asked.cuts.defeating(dying, Moment.WHENEVER)) == minimal(whenever)
    for dead in (frozenset[str](), frozenset(play.hardware)):
        region = asked.prospects.losing(goal, repairs=not dead)
        assert region.count() == sum(not survives(m, dead) for m in running)
        edges = asked.prospects.critical(goal, repairs=not dead)
        crossing = sum(
            (m, happens) in unsafe if aborted(after) else not survives(after, dead)
            for m in running
            if survives(m, dead)
            for happens, after in play.edges(m)
            if not dead or not happens.endswith("_EV_RD")
        )
        assert sum(critical.edges for critical in edges) == crossing
    for found in asked.all.survival if unsafe else ():
        assert found.safety is not None
        if found.safety.run is not None:
            *_, (before, text, _) = play.walked(map(str, found.safety.run.events))
            assert (before, text) not in unsafe
    for run in asked.all.safety.runs.values() if asked.all.safety is not None and unsafe else ():
        if run is not None:
            *_, (before, text, after) = play.walked(map(str, run.events))
            assert not aborted(after) or aborted(before) or (before, text) in unsafe


def small(mission: Mission, max_states: int) -> MissionNet | None:
    """The net of a mission that every engine answers for, or ``None``."""
    found = compose(mission)
    try:
        graph = direct(found.net, max_states=max_states)
        assert Prospects(found, ArraySpace(graph)).objectives
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return None
    return found


@fewer(0.4)
@given(
    missions(max_objectives=2, max_sections=5, max_hardware=3, max_producers=2)
    | missions(max_objectives=2, max_sections=5, max_hardware=3, max_producers=2, events=2)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3, events=2)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=2, faults=2)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=3, lasting=True)
    | missions(max_objectives=2, max_sections=5, max_hardware=3, lasting=True)
    | fragile_missions(max_objectives=2, max_sections=5, max_hardware=2, late=True, lasting=True, events=1)
    | IN_TIME
    | GUARDED
    | LEFT_BY_FACTS
    | missions(max_objectives=2, max_sections=5, max_hardware=2, max_producers=1, early=8),
    st.sampled_from(ENGINES),
)
def test_cut_sets_are_those_of_brute_force(mission: Mission, engine: Engine) -> None:
    found = small(mission, 400)
    if found is not None:
        confirm(Asked(found, engine))


ABORTING = missions(max_sections=5, max_hardware=2, max_producers=1, aborts=6, early=2) | missions(
    max_sections=5, max_hardware=2, max_producers=1, aborts=6, early=2, late=True
)


@fewer(0.6)
@given(ABORTING, st.sampled_from(ENGINES))
def test_cut_sets_of_missions_that_abort(mission: Mission, engine: Engine) -> None:
    found = small(mission, 400)
    if found is not None:
        confirm(Asked(found, engine))


@fewer(0.3)
@given(ABORTING)
def test_engines_agree_on_causes_of_missions_that_abort(mission: Mission) -> None:
    agree_on_all_causes(mission)


@fewer(0.15)
@given(
    missions(max_hardware=3, max_sections=5)
    | missions(max_hardware=3, max_sections=5, events=2)
    | fragile_missions(max_hardware=3)
    | fragile_missions(max_hardware=3, max_sections=5, events=2)
    | missions(max_hardware=3, max_sections=5, events=1, early=6)
    | fragile_missions(max_hardware=2, max_sections=4, faults=1)
    | fragile_missions(max_hardware=3, max_sections=5, lasting=True)
    | missions(max_hardware=2, max_sections=4, events=2, pauses=8)
    | missions(max_hardware=2, max_sections=5, late=True)
    | fragile_missions(max_hardware=2, max_sections=5, late=True, lasting=True)
    | IN_TIME
    | GUARDED
    | LEFT_BY_FACTS
)
def test_engines_agree_on_all_causes(mission: Mission) -> None:
    agree_on_all_causes(mission)


@st.composite
def of_one_type(draw: st.DrawFn) -> Mission:
    """Objectives that differ in names and hardware alone, some of them twice the same."""
    hardware = [f"h{i}" for i in range(draw(st.integers(2, 3)))]
    ways = draw(st.lists(st.permutations(hardware), min_size=2, max_size=2))
    activities = tuple(
        Activity(
            name=f"a{i}", alternatives=tuple(Alternative(name=f"a{i}_{h}", consumes=(h,)) for h in way[:2])
        )
        for i, way in enumerate(ways)
    )
    robot = Robot(name="r", hardware=tuple(Hardware(name=h) for h in hardware), activities=activities)
    sections = draw(st.lists(st.sampled_from(["a0", "a1"]), min_size=2, max_size=3))
    blocks = tuple(
        Objective(
            name=f"x{i}",
            activities=(activity,),
            failure=draw(st.sampled_from(["fail", "succeed", f"x{min(i + 1, len(sections) - 1)}"])),
        )
        for i, activity in enumerate(sections)
    )
    return Mission(name="m", robots=(robot,), blocks=blocks)


@fewer(0.05)
@given(of_one_type())
def test_engines_agree_on_causes_of_sections_of_one_type(mission: Mission) -> None:
    agree_on_all_causes(mission)


def agree_on_all_causes(mission: Mission) -> None:
    found = small(mission, 500)
    if found is None:
        return

    def told(causes: Causes) -> object:
        goals = [causes.mission, *causes.objectives.values()]
        goals += [] if causes.safety is None else [causes.safety]
        return (
            [
                (
                    g.name,
                    g.moments,
                    g.nonmonotone,
                    sorted(map(repr, g.critical)),
                    sorted(map(repr, g.critical_with_repairs)),
                    {names: run is not None for names, run in g.runs.items()},
                )
                for g in goals
            ],
            [(s.section, s.cut_sets, s.always, s.at_most, s.run is None) for s in causes.survival],
            [replace(row) for row in fmeca(causes.prospects)],
        )

    first, *others = (told(Asked(found, engine).all) for engine in ENGINES)
    for other in others:
        assert other == first


@fewer(0.5)
@given(fragile_missions(max_hardware=4, max_alternatives=2), st.sampled_from(ENGINES))
def test_a_cut_set_makes_success_unreachable_and_no_proper_subset_does(
    mission: Mission, engine: Engine
) -> None:
    found = small(mission, 2000)
    if found is None:
        return
    for names in Asked(found, engine).cut_sets(None, Moment.START):
        assert not success_reachable(found, names)
        for back in names:
            assert success_reachable(found, [h for h in names if h != back])


def success_reachable(found: MissionNet, dead: Collection[str]) -> bool:
    """CTL on the net, with some hardware out of service from the initial marking on and never repaired."""
    net = found.net
    play = Play(found)
    marking = play.after(play.initial, [f"{h}_EV_OOS" for h in dead])
    places = [replace(p, initial=tokens) for p, tokens in zip(net.places, marking, strict=True)]
    repairs = [f"{h}_EV_RD" for h in dead]
    kept = [t for t in net.transitions if str(t.event) not in repairs]
    crippled = replace(net, places=tuple(places), transitions=tuple(kept))
    formula = parse("EF success", MissionNames(found, net=crippled))
    return Evaluation(DiagramMarkings(reach(crippled))).holds(formula)


def test_ulysse_cut_sets_by_ctl_on_the_net(ulysse_net: MissionNet) -> None:
    for size in range(4):
        for dead in combinations(("GPS_sensor", "IMU_sensor", "thruster_actuator"), size):
            lost = any(set(names) <= set(dead) for names in NAVIGATION)
            assert success_reachable(ulysse_net, dead) is not lost


def test_hardware_that_cannot_always_fail_is_reported(ulysse_net: MissionNet) -> None:
    asked = Asked(ulysse_net)
    assert all(causes.nonmonotone is None for causes in asked.all.objectives.values())
    # A robot whose GPS never fails once the thruster has, nor the thruster once the GPS has.
    whole = mortal(ulysse_net)
    graph = direct(whole.net, proof=False)
    prospects: Prospects[ArraySet] = Prospects(whole, ArraySpace(graph))
    spared = np.zeros(graph.edges, np.bool_)
    for first, other in (("GPS_sensor", "thruster_actuator"), ("thruster_actuator", "GPS_sensor")):
        fails = np.isin(graph.labels, list(prospects.carrying(What.OUT_OF_SERVICE, first)))
        spared |= fails & graph.marked(whole.by_role["oos", other][0])[graph.sources]
    offsets = np.concatenate(([0], np.cumsum(np.bincount(graph.sources[~spared], minlength=graph.states))))
    fewer = replace(graph, offsets=offsets, targets=graph.targets[~spared], labelled=graph.labels[~spared])
    cuts = CutSets(ulysse_net, ArraySpace(fewer))
    found = cuts.nonmonotone(cuts.defeating(cuts.objectives["transect.diving"], Moment.SOMETIME))
    assert found is not None
    assert found.lost == ("thruster_actuator",)
    assert found.larger == ("GPS_sensor", "thruster_actuator")


@pytest.mark.parametrize(
    "again",
    [
        Objective(name="x", activities=("use",), failure="x"),
        Objective(
            name="x",
            activities=("use",),
            failure="x",
            handlers=(Handler(event="leak", goto="x"),),
        ),
    ],
    ids=["retry", "interruption"],
)
def test_what_begins_again_is_another_run(again: Objective) -> None:
    found = compose(mission(robot(hw("H"), activity("use", ("H",)), events=("leak",)), again))
    prospects = Asked(found).prospects
    (goal,) = prospects.objectives.values()
    # Once refused, the present run is lost whatever is repaired; the mission is not, for x is tried again.
    lost = prospects.losing(goal, repairs=True)
    assert lost
    play = Play(found)
    marking = prospects.space.marking
    assert {marking(s) for s in np.flatnonzero(lost.mask).tolist()} == {
        m
        for m in play.reach([play.initial])
        if play.marks("OBJ_x")(m) and not play.objective_survives(m, "x", frozenset())
    }
    assert not prospects.losing(prospects.mission, repairs=True)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_mission_that_has_ended_loses_nothing(engine: Engine, tmp_path: Path) -> None:
    """As long as it runs a call leads to success without the motor: no moment is one of defeat."""
    (tmp_path / "m.xml").write_text(
        '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><hardware name="motor"/>'
        '<event name="call"/><activity name="drive" consumes="motor"/><activity name="rest"/></robot>'
        '<objective name="go" activities="drive" success="succeed" failure="fail">'
        '<on event="call" goto="extra"/></objective>'
        '<objective name="extra" activities="rest" nominal="optional" failure="extra"/></mission>'
    )
    found = compose(read_mission(tmp_path / "m.xml"))
    assert Asked(found, engine).cut_sets(None, Moment.SOMETIME) == []
    study = Study(found.mission)
    assert study.ctl("AG (oos(motor) & !success & !failure -> EF success)").holds
    assert not study.ctl("AG (oos(motor) & !success -> EF success)").holds
