"""Composition: the paper's nets, and every general mission's promises."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from random import Random

import networkx as nx
import numpy as np
import pytest
from hypothesis import Phase, assume, event, find, given, settings

from mcpn.controller.generate import generate
from mcpn.controller.minimise import minimise
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.errors import ConfluenceError, DivergenceError, InputError, LimitError
from mcpn.events import Event
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Each, Mission, Objective, Parallel, Recursive, walk
from mcpn.mission.robot import Activity, Hardware, Robot
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.xml import read_mission
from mcpn.nets.formats import read_net
from mcpn.nets.petri import PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.markings.graph import StateGraph
from mcpn.spaces.stable.alternatives import by_reduction, direct
from mcpn.testing import Shape, missions
from mcpn.testing.data import data_sharing_missions
from tests.drawing.promises import check_promises
from tests.draws import fewer
from tests.shares import returns_early
from tests.small import activity, hw, robot
from tests.small import mission as small_mission

LIMIT = 40_000


def test_the_closed_hardware_resource_has_the_markings_of_figure_10(reference: Path) -> None:
    graph = explore(read_net(reference / "hardware_resource_fig10.net"))
    check_figure_10(graph, "Rx")


def test_our_hardware_template_has_the_markings_of_figure_10() -> None:
    # The paper, 7.1: the resource closed by the simulated events TAKE, RELEASE and ERROROK.
    mission = Mission(name="m", robots=robots(hw("Rx"), activity("a", ())), blocks=(objective("x", "a"),))
    canvas = Canvas("fig10", Usage(mission, flatten(mission)))
    PaperTemplates().hardware(canvas, mission.hardware[0])
    for word, before, after in (
        ("TAKE", "available", "take"),
        ("RELEASE", "answer", "release"),
        ("ERROROK", "error", "release"),
    ):
        name = f"Rx_EV_{word}"
        canvas.transition(name, consume=[f"Rx_{before}"], produce=[f"Rx_{after}"], event=Event.parse(name))
    check_figure_10(explore(canvas.build()), "Rx")


def check_figure_10(graph: StateGraph, resource: str) -> None:
    found = {
        frozenset(p.removeprefix(f"{resource}_") for p in graph.net.marked(graph.marking(s)))
        for s in range(graph.states)
    }
    # Fig. 10, with the states that the paper calls stable or transient in its text.
    stable = [{"free", "available"}, {"busy", "answer"}, {"OOS"}]
    transient = [{"free", "take"}, {"failing", "available"}, {"busy", "release"}, {"failing", "release"}]
    assert found == {frozenset(m) for m in (*stable, *transient, {"failing", "error"})}
    assert (graph.states, graph.edges) == (8, 10)


def bipartite(net: PetriNet) -> nx.DiGraph[tuple[str, int]]:
    """A net as a coloured graph; names of internal transitions and of places are left out."""
    graph: nx.DiGraph[tuple[str, int]] = nx.DiGraph()
    for number, place in enumerate(net.places):
        graph.add_node(("p", number), colour=f"place {place.initial}")
    for number, t in enumerate(net.transitions):
        graph.add_node(("t", number), colour="internal" if t.internal else "event")
        consume, produce, read = dict(t.consume), dict(t.produce), dict(t.read)
        for p in consume.keys() | read.keys():
            kind = "read" if p in read or p in produce else "consume"
            graph.add_edge(("p", p), ("t", number), kind=kind)
        for p in produce.keys() - consume.keys():
            graph.add_edge(("t", number), ("p", p), kind="produce")
    return graph


@pytest.mark.filterwarnings("ignore:The hashes produced for directed graphs changed")
def test_ulysse_is_isomorphic_to_the_reference(ulysse_net: MissionNet, reference: Path) -> None:
    ours = bipartite(ulysse_net.net)
    theirs = bipartite(read_net(reference / "ulysse_reference.net"))
    digest = [
        nx.weisfeiler_lehman_graph_hash(g, node_attr="colour", edge_attr="kind", iterations=8)
        for g in (ours, theirs)
    ]
    assert digest[0] == digest[1]
    assert nx.is_isomorphic(
        ours,
        theirs,
        node_match=lambda a, b: bool(a["colour"] == b["colour"]),
        edge_match=lambda a, b: bool(a["kind"] == b["kind"]),
    )


def test_ulysse_written_flat_bears_the_paper_s_names(reference: Path, tmp_path: Path) -> None:
    flat = tmp_path / "flat.xml"
    robot = (Path(__file__).parents[2] / "experiments/ulysse/robot.xml").read_text()
    inner = robot[robot.index("<robot") :]
    flat.write_text(
        '<mission name="ulysse" xmlns="urn:mcpn:mission:1">'
        + inner
        + """
        <objective name="localized_observation" failure="transect">
          <objective name="manual_moving" activities="manual_moving"/>
          <objective name="isopheric_observation" activities="isopheric_observation"/>
        </objective>
        <objective name="transect">
          <objective name="diving" activities="diving" failure="go_surface"/>
          <parallel name="census" failure="go_surface">
            <objective name="filming" activities="filming"/>
            <objective name="advancing" activities="advancing"/>
            <objective name="temperature" activities="temperature"/>
          </parallel>
          <objective name="go_surface" activities="go_surface"/>
        </objective></mission>"""
    )
    ours, theirs = compose(read_mission(flat)).net, read_net(reference / "ulysse_reference.net")
    assert {p.name for p in ours.places} == {p.name for p in theirs.places}
    assert sorted(t.event for t in ours.transitions if t.event) == sorted(
        t.event for t in theirs.transitions if t.event
    )

    def arcs(net: PetriNet) -> set[tuple[Event | None, frozenset[str], frozenset[str]]]:
        def names(*sides: tuple[tuple[int, int], ...]) -> frozenset[str]:
            return frozenset(net.places[p].name for side in sides for p, _ in side)

        return {(t.event, names(t.consume, t.read), names(t.produce, t.read)) for t in net.transitions}

    assert arcs(ours) == arcs(theirs)


def test_every_place_and_transition_of_ulysse_knows_its_line(ulysse_net: MissionNet) -> None:
    net = ulysse_net.net
    origins = [p.provenance for p in net.places] + [t.provenance for t in net.transitions]
    assert all(origin and origin.source and origin.source.line for origin in origins)


def test_sizes_of_the_templates(ulysse_net: MissionNet) -> None:
    # The sizes that the paper's Table 1 adds up to: 133 places and 150 transitions.
    net = ulysse_net.net
    assert (len(net.places), len(net.transitions)) == (133, 150)

    def size(*elements: str) -> tuple[int, int]:
        def made(origins: list[Provenance | None]) -> int:
            return sum(str(origin).split(".")[0] in elements for origin in origins)

        return made([p.provenance for p in net.places]), made([t.provenance for t in net.transitions])

    assert size("hardware GPS_sensor") == (9, 7)
    assert size("software location") == (11, 8)
    assert size("activity gps_driver", "alternative gps_driver") == (3, 5)
    assert size("activity localisation", "alternative localisation") == (6, 10)
    assert size("activity diving", "alternative diving") == (5, 9)
    assert size("activity filming", "alternative filming") == (3, 2)


@given(missions())
def test_every_mission_keeps_its_promises(mission: Mission) -> None:
    found = compose(mission)
    usage = found.usage
    try:
        markings = explore(found.net, max_states=LIMIT)  # 1-safety is checked at each firing
    except LimitError:
        assume(False)
    check_promises(found, markings)
    try:
        reduced = by_reduction(markings)
    except (ConfluenceError, DivergenceError):
        # What refuses and is asked again at once may go round, if what it needs is contended.
        assert usage.contentions
        with pytest.raises((ConfluenceError, DivergenceError)):
            direct(found.net)
        return
    for graph in (direct(found.net), direct(found.net, proof=False)):
        assert np.array_equal(graph.markings, reduced.markings)
        assert np.array_equal(graph.offsets, reduced.offsets)
        assert np.array_equal(graph.targets, reduced.targets)
        assert np.array_equal(graph.labels, reduced.labels)


UNCONTENDED = Shape(own_hardware=True, shared_activities=False, hardware=4, alternatives=2, activities=3)


@given(missions(UNCONTENDED) | missions(UNCONTENDED, events=2))
def test_a_mission_in_which_nothing_contends_is_confluent(mission: Mission) -> None:
    """The theorem of papers/templates.md: what runs together may share software and hardware in any chain."""
    found = compose(mission)
    assert found.usage.contentions == ()
    event(f"shared: {bool(found.usage.sharing.consumers)}")
    event(f"ranks: {len(found.net.internal_ranks) > 1}")
    for element, drawn in new_elements(mission).items():
        event(f"{element}: {drawn}")
    try:
        markings = explore(found.net, max_states=LIMIT)
    except LimitError:
        event("too large")
        return
    check_promises(found, markings)
    by_reduction(markings)


@settings(max_examples=max(settings().max_examples, 100))  # one mission in twenty tells an early stop
@given(data_sharing_missions())
def test_branches_that_share_data_are_confluent(mission: Mission) -> None:
    """The theorem where producers go on, stop and change their alternatives beside one another."""
    found = compose(mission)
    assert found.usage.contentions == ()
    try:
        direct(found.net, max_states=1500)
    except LimitError as error:
        returns_early(type(error).__name__)


@fewer(0.5)
@given(missions(disjoint_branches=True))
def test_sharing_adds_nothing_where_no_two_want_the_same(mission: Mission) -> None:
    """There the net is the paper's, place for place, whether software and hardware are shared or reserved.

    Software that is asked for again as soon as it is given back is another matter: each who asks for it
    then has an interface of its own.
    """

    def said(shared: bool) -> MissionNet:
        (robot,) = mission.robots
        software = tuple(replace(s, exclusive=not shared) for s in robot.software)
        hardware = tuple(replace(h, shared=shared) for h in robot.hardware)
        robots = (replace(robot, software=software, hardware=hardware),)
        return compose(replace(mission, robots=robots))

    shared, reserved = said(True), said(False)
    assert not shared.usage.wanted_together
    event(f"software: {bool(mission.software)}")
    again = shared.usage.wanted_again
    event(f"asked for again: {bool(again)}")
    assert shared.usage.sharing.consumers.keys() == again
    assert again or shared.net == reserved.net


def new_elements(mission: Mission) -> dict[str, bool]:
    """Which of the elements that the paper's missions do not have are in a mission."""
    blocks = list(walk((*mission.blocks, *(b for p in mission.protocols for b in p.blocks))))
    handlers = (*mission.handlers, *(h for b in blocks for h in b.handlers))
    return {
        "rounds": any(b.repeat is not None or isinstance(b, Each) for b in blocks),
        "retries": any(b.retries for b in blocks),
        "handlers": bool(handlers),
        "handlers once": any(h.once for h in handlers),
        "switch back": any(a.switch_back for a in mission.activities),
        "shared hardware": any(h.shared for h in mission.hardware),
    }


def test_each_new_element_is_drawn_where_nothing_contends() -> None:
    strategy = missions(UNCONTENDED, events=2)
    unshrunk = settings(phases=[Phase.generate], max_examples=500, database=None)
    for element in new_elements(Mission(name="m", blocks=())):

        def has(mission: Mission, element: str = element) -> bool:
            return new_elements(mission)[element]

        found = find(strategy, has, settings=unshrunk, random=Random(1))
        assert compose(found).usage.contentions == ()


def robots(hardware: tuple[Hardware, ...], *activities: Activity) -> tuple[Robot, ...]:
    return (robot(hardware, *activities),)


def objective(name: str, *activities: str, **routing: str) -> Objective:
    return Objective(name=name, activities=activities, **routing)  # type: ignore[arg-type]


def stable(mission: Mission) -> tuple[MissionNet, StateGraph]:
    found = compose(mission)
    return found, direct(found.net)


def test_a_retry_starts_the_same_activity_at_once() -> None:
    mission = Mission(
        name="m",
        robots=robots(hw("H"), activity("a", ("H",))),
        blocks=(objective("x", "a", failure="x"),),
    )
    found, graph = stable(mission)
    assert "a_idle" in found.net.place_index
    assert "OBJ_x_enter" in found.net.place_index
    # The mission begins, runs and ends, each with the hardware in and out of service; the activity may have
    # been refused before the hardware was ready again. All by hand: begin 2, running 1, refused 2, success 2.
    assert graph.states == 7


def test_nothing_is_added_where_it_cannot_happen(ulysse_net: MissionNet) -> None:
    added = ("_idle", "_enter", "_quiet", "_failed", "_unused", "_running", "_refusing")
    assert not [p.name for p in ulysse_net.net.places if p.name.endswith(added)]


def test_contention_at_the_same_moment_is_an_error_with_two_runs() -> None:
    mission = Mission(
        name="m",
        robots=robots(hw("H"), activity("filming", ("H",)), activity("advancing", ("H",))),
        blocks=(
            Parallel(name="census", blocks=(objective("film", "filming"), objective("advance", "advancing"))),
        ),
    )
    found = compose(mission)
    (contention,) = found.usage.contentions
    assert str(contention) == "advancing and filming, both in parallel block census, both need H"
    with pytest.raises(ConfluenceError, match="filming") as caught:
        direct(found.net)
    assert len(caught.value.runs) == 2
    ends = set()
    for run in caught.value.runs:
        marking = found.net.initial
        for name in run:
            number = found.net.transition_index[name]
            assert number in found.net.enabled(marking)
            marking = found.net.fire(marking, number)
        assert not any(found.net.transitions[t].internal for t in found.net.enabled(marking))
        ends.add(marking)
    assert len(ends) == 2


def test_the_second_who_asks_later_waits_and_can_be_stopped() -> None:
    mission = Mission(
        name="m",
        robots=robots(hw("H"), activity("a", ("H",)), activity("b", ("H",)), activity("c", ())),
        blocks=(
            Parallel(
                name="both",
                blocks=(
                    objective("x", "a"),
                    # The second branch asks for H only after its first objective.
                    Recursive(name="late", blocks=(objective("y", "c"), objective("z", "b"))),
                ),
            ),
        ),
    )
    found, graph = stable(mission)
    waiting = graph.marked(found.net.place_index["b_Start"])
    assert waiting.any()
    failed = {
        graph.net.transitions[label].name
        for state in np.flatnonzero(waiting).tolist()
        for label, _ in graph.successors(state)
    }
    assert "OBJ_z_EV_FAIL" in failed
    assert "OBJ_z_EV_OK" not in failed


def test_hardware_that_cannot_fail_has_no_error_handling() -> None:
    mission = Mission(
        name="m",
        robots=robots(
            hw("H", faulty=False), activity("driver", ("H",), produces=("S",)), activity("a", ("S",))
        ),
        blocks=(objective("x", "a"),),
    )
    net = compose(mission).net
    assert not [p.name for p in net.places if p.name in ("H_OOS", "H_failing", "H_error", "a_error")]
    assert not [
        t.name for t in net.transitions if "err" in t.name or "else" in t.name or t.name == "H_EV_OOS"
    ]


def test_two_resources_out_of_service_together_are_harmless() -> None:
    mission = Mission(
        name="m",
        robots=robots(hw("H", "G"), activity("a", ("H", "G"), ("H",))),
        blocks=(objective("x", "a"),),
    )
    found, graph = stable(mission)
    both = graph.marked(found.net.place_index["H_OOS"]) & graph.marked(found.net.place_index["G_OOS"])
    refused = graph.marked(found.net.place_index["a_error"])
    assert (both & refused).any()


def test_an_activity_with_two_products_serves_both_and_stops_with_the_last() -> None:
    mission = Mission(
        name="m",
        robots=robots(
            hw("H"),
            activity("navigation", ("H",), produces=("position", "heading")),
            activity("steer", ("heading",)),
            activity("log", ("position",)),
        ),
        blocks=(Parallel(name="both", blocks=(objective("x", "steer"), objective("y", "log"))),),
    )
    found, graph = stable(mission)
    index = found.net.place_index
    running = graph.marked(index["navigation_active1"])
    one = graph.marked(index["steer_active1"]) ^ graph.marked(index["log_active1"])
    both = graph.marked(index["steer_active1"]) & graph.marked(index["log_active1"])
    assert (running & one).any()
    assert (running & both).any()
    assert np.array_equal(running, one | both)


def test_wide_parallel_blocks_are_left_one_by_one() -> None:
    names = [f"o{i}" for i in range(9)]
    mission = Mission(
        name="m",
        robots=robots(hw("H"), *(activity(f"a{i}", ()) for i in range(9))),
        blocks=(Parallel(name="wide", blocks=tuple(objective(n, f"a{n[1:]}") for n in names)),),
    )
    net = compose(mission).net
    assert len([t for t in net.transitions if t.name.startswith("PAR_wide")]) == 4 * 9 - 2
    graph = direct(net)
    # The first k children are noted (all well or not), the next one runs, each of the others runs or has
    # ended in one of two ways; besides the begin and the two ends; all with the hardware in service or not.
    running = sum((2 if k else 1) * 3 ** (8 - k) for k in range(9))
    assert graph.states == 2 * (running + 1 + 2)


def test_the_order_of_many_children_changes_what_is_noted_and_not_what_they_do() -> None:
    sizes, behaviours = set(), set()
    for order in (range(7), range(6, -1, -1), (3, 6, 5, 2, 0, 4, 1)):
        of = robot(hw("h"), *(activity(f"a{i}", ("h",) if i == 0 else ()) for i in order))
        blocks = tuple(Objective(name=f"o{i}", activities=(f"a{i}",)) for i in order)
        controller = generate(compose(small_mission(of, Parallel(name="p", blocks=blocks))), "flat")
        sizes.add(controller.states)
        behaviours.add(minimise(controller).states)
    assert len(sizes) > 1
    assert len(behaviours) == 1


def test_a_caller_s_templates_replace_the_paper_s() -> None:
    class Patient(PaperTemplates):
        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            super().hardware(canvas, resource)
            canvas.place(f"{resource.name}_mine")

    mission = Mission(name="m", robots=robots(hw("H"), activity("a", ("H",))), blocks=(objective("x", "a"),))
    assert "H_mine" in compose(mission, Patient()).net.place_index

    class Forgetful(PaperTemplates):
        def hardware(self, canvas: Canvas, resource: Hardware) -> None:
            return

    with pytest.raises(InputError, match="names the place H_"):
        compose(mission, Forgetful())


def test_unused_hardware_stays_and_unstarted_activities_go() -> None:
    mission = Mission(
        name="m",
        robots=robots(hw("H"), activity("a", ()), activity("driver", ("H",), produces=("S",))),
        blocks=(objective("x", "a"),),
    )
    places = compose(mission).net.place_index
    assert "H_OOS" in places
    assert "S_free" not in places
    assert "driver_StartByRes" not in places


def test_long_chains_of_activities_are_composed() -> None:
    names = [f"S{i}" for i in range(400)]
    chain = [
        activity(f"make{i}", (names[i - 1] if i else "H",), produces=(name,)) for i, name in enumerate(names)
    ]
    mission = Mission(
        name="m",
        robots=robots(hw("H"), *chain, activity("a", (names[-1],))),
        blocks=(objective("x", "a"),),
    )
    found = compose(mission)
    assert found.usage.hardware_under(names[-1]) == {"H"}
    assert not found.usage.may_wait("a")
    # Hardware 9, each resource 11 and its producer 3, the activity 5, the mission 3 and its objective 1.
    assert len(found.net.places) == 9 + 400 * (11 + 3) + 5 + 3 + 1
