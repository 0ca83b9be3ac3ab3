"""Composition: the composite of local graphs is the alternatives graph of the whole mission."""

from __future__ import annotations

from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from hypothesis import event, given, reject
from hypothesis import strategies as st

from mcpn.controller.hierarchy import hierarchical_controller
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import (
    Activity,
    Alternative,
    Hardware,
    Mission,
    Objective,
    Recursive,
    Robot,
    Software,
)
from mcpn.net.compose import MissionNet, compose
from mcpn.net.events import Event
from mcpn.net.sections import junction_part
from mcpn.net.templates import Canvas, PaperTemplates
from mcpn.space.alternatives import AlternativesGraph, by_reduction, direct
from mcpn.space.explicit import explore
from mcpn.space.graph import Mask
from mcpn.space.local.composite import Composite
from mcpn.space.local.diagram import LocalDiagram
from mcpn.space.local.expand import expand
from mcpn.space.local.gluing import glue
from mcpn.space.local.junction import is_confluent, sharing_pairs
from mcpn.space.local.placing import Making, local_graphs
from mcpn.space.local.protocol import OUTCOMES, Outcome, PremiseError
from mcpn.testing import missions


def composed(mission_net: MissionNet, most_listed: int | None = None) -> Composite:
    return glue(mission_net.usage, mission_net.graph, Making(most_listed=most_listed))


def check_equal(found: AlternativesGraph, expected: AlternativesGraph) -> None:
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name


def test_ulysse(ulysse: Mission, ulysse_net: MissionNet) -> None:
    composite = composed(ulysse_net)
    # Table 1 of the paper.
    assert (composite.states, composite.edges) == (260, 1332)
    assert len({id(placed.local) for placed in composite.sections}) == 2
    check_equal(expand(composite, ulysse_net), direct(ulysse_net.net))


def rounds(count: int, retries: int) -> Composite:
    driver = Activity(
        name="driver", produces=("S",), alternatives=(Alternative(name="driver", consumes=("H",)),)
    )
    travel = Activity(name="travel", alternatives=(Alternative(name="travel", consumes=("S",)),))
    robot = Robot(
        name="r",
        hardware=(Hardware(name="H"), Hardware(name="other")),
        software=(Software(name="S"),),
        activities=(driver, travel),
    )
    visit = Objective(name="visit", activities=("travel",), retries=retries)
    each = Recursive(name="tour", blocks=(visit,), repeat=count)
    return composed(compose(Mission(name="m", robots=(robot,), blocks=(each,))))


def test_rounds_and_tries_are_of_one_type() -> None:
    one, more = rounds(1, 0), rounds(500, 3)
    assert (len(one.sections), len(more.sections)) == (1, 2000)
    assert len({id(placed.local) for placed in more.sections}) == 1
    assert more.local_states == one.local_states
    around = 3 * 4  # before the start and at both ends, by the hardware out of service
    assert more.states - around == 2000 * (one.states - around)
    assert len(hierarchical_controller(more).types) == 1


@given(missions())
def test_the_composite_is_the_whole(mission: Mission) -> None:
    mission_net = compose(mission)
    usage = mission_net.usage
    try:
        whole = by_reduction(explore(mission_net.net, max_states=50_000))
    except LimitError:
        reject()
    except (ConfluenceError, DivergenceError):
        event("not confluent")
        assert usage.contentions
        with pytest.raises((ConfluenceError, DivergenceError)):
            composed(mission_net)
        return
    composite = composed(mission_net)
    torn = any(p.listed.graph.torn for p in composite.sections) or composite.junctions
    event(f"contention that the mission does not come to: {bool(torn)}")
    event(f"{len(composite.sections)} sections, {len({id(p.local) for p in composite.sections})} types")
    assert (composite.states, composite.edges) == (whole.states, whole.edges)
    check_equal(expand(composite, mission_net), whole)
    success, failure = whole.marked(mission_net.success), whole.marked(mission_net.failure)
    assert ("success" in composite.ends) == success.any()
    assert ("failure" in composite.ends) == failure.any()
    wanted: list[tuple[set[Outcome], Mask]] = [
        ({"success"}, success),
        ({"failure"}, failure),
        (set(OUTCOMES), success | failure),
    ]
    for goals, ends in wanted:
        assert _losing(composite, goals) == int((~whole.reaching(ends)).sum())


SOME_DIAGRAMS = st.sampled_from([-1, 1])
"""Hardware up to which sections are listed: none of them are, or a part."""


@given(missions(), SOME_DIAGRAMS)
def test_diagrams_of_sections_say_what_lists_say(mission: Mission, most_listed: int) -> None:
    mission_net = compose(mission)
    try:
        by_lists = composed(mission_net)
    except (ConfluenceError, DivergenceError) as error:
        event("not confluent")
        with pytest.raises(type(error)):
            composed(mission_net, most_listed)
        return
    composite = composed(mission_net, most_listed)
    diagrams = sum(isinstance(p.local, LocalDiagram) for p in composite.sections)
    event(f"{diagrams} diagrams among {len(composite.sections)} sections")
    assert (composite.states, composite.edges) == (by_lists.states, by_lists.edges)
    assert (composite.events, composite.ends) == (by_lists.events, by_lists.ends)
    assert composite.entered.keys() == by_lists.entered.keys()
    for name, entered in composite.entered.items():
        assert np.array_equal(entered.masks(), by_lists.entered[name].masks())
    for goals in ({"success"}, {"failure"}, set(OUTCOMES)):
        assert _losing(composite, goals) == _losing(by_lists, goals)  # type: ignore[arg-type]


def _losing(composite: Composite, goals: set[Outcome]) -> int:
    """States of the whole from which no goal is reached, by the composite's arithmetic."""
    count = len(composite.faulty)
    losing = composite.losing(goals)
    inside: int = sum(
        states.count() << count - len(composite.by_name[n].faulty) for n, states in losing.items()
    )
    before = 0 if composite.hopeful(goals)[composite.graph.entry] else 1 << count
    return inside + before + (len(composite.ends - goals) << count)


# --- junctions ---------------------------------------------------------------------------------------------


@given(missions())
def test_junctions_are_confluent_where_their_sections_are(mission: Mission) -> None:
    """The argument of papers/composition.md against a proof on the net of both sections."""
    mission_net = compose(mission)
    usage, graph = mission_net.usage, mission_net.graph
    placed = {p.section.name: p for p in local_graphs(usage, graph, Making(most_listed=None))}
    calm = {name for name, p in placed.items() if not p.listed.graph.torn}
    for first, second in sharing_pairs(graph, placed):
        if {first.section.name, second.section.name} <= calm:
            handover = usage.handover.awaited.get(second.section.name)
            event(f"gated: {handover is not None}")
            assert is_confluent(junction_part(usage, first.section, second.section).net().net, 1_000_000)


# --- the premise ---------------------------------------------------------------------------------------


@contextmanager
def leaving_out(canvas: Canvas, name: str) -> Iterator[None]:
    """A transition that a user's template forgets to draw."""
    draw = canvas.transition

    def drawn(transition: str, **more: Any) -> None:
        if transition != name:
            draw(transition, **more)

    canvas.transition = drawn  # type: ignore[method-assign, assignment]
    try:
        yield
    finally:
        canvas.transition = draw  # type: ignore[method-assign]


class Outliving(PaperTemplates):
    """A user's templates in which the activity ``filming`` goes on when its objective tells it to stop."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        with leaving_out(canvas, "filming_stop1"):
            super().activity(canvas, activity)


class Keeping(PaperTemplates):
    """A user's templates in which a resource is asked to be released and is not."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        with leaving_out(canvas, "thruster_actuator_8"):
            super().hardware(canvas, resource)


class Spending(PaperTemplates):
    """A user's templates in which the activity ``filming`` uses up its film for good."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        if activity.name == "filming":
            pen = canvas.of("activity", activity.name, activity.source)
            film, running = pen.place("film", initial=1), f"{activity.name}_active1"
            pen.transition("used", [film], [], read=[running], event=Event.parse("FILMING_EV_USED"))


class Wearing(PaperTemplates):
    """A user's templates in which a resource, once used, is not what it was."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        super().hardware(canvas, resource)
        if resource.name == "thruster_actuator":
            pen = canvas.of("hardware", resource.name, resource.source)
            new, busy = pen.place("new", initial=1), "thruster_actuator_busy"
            pen.transition("worn", [new], [], read=[busy], event=Event.parse("THRUSTER_EV_WORN"))


@pytest.mark.parametrize("most_listed", [None, -1], ids=["listed", "diagrams"])
@pytest.mark.parametrize(
    ("templates", "place", "section"),
    [
        (Outliving(), "filming_Stop", "transect.census"),
        (Keeping(), "thruster_actuator_free", "coral_head.manual_moving"),
        (Spending(), "filming_film", "transect.census"),
        (Wearing(), "thruster_actuator_new", "coral_head.manual_moving"),
    ],
)
def test_a_section_that_leaves_something_behind_is_refused(
    ulysse: Mission, templates: PaperTemplates, place: str, section: str, most_listed: int | None
) -> None:
    mission_net = compose(ulysse, templates)
    with pytest.raises(PremiseError, match="use --engine explicit or symbolic") as caught:
        glue(mission_net.usage, mission_net.graph, Making(templates, most_listed=most_listed))
    assert (caught.value.place, caught.value.section) == (place, section)
    assert caught.value.runs


# --- elsewhere -----------------------------------------------------------------------------------------


def test_local_graphs_are_made_by_any_executor(ulysse_net: MissionNet) -> None:
    done: list[tuple[int, int]] = []
    alone: list[tuple[int, int]] = []
    usage, graph = ulysse_net.usage, ulysse_net.graph
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        composite = glue(usage, graph, Making(executor=pool, progress=lambda *at: done.append(at)))
        diagrams = glue(usage, graph, Making(executor=pool, most_listed=-1))
        own = glue(usage, graph, Making(PaperTemplates(), pool, progress=lambda *at: alone.append(at)))
    assert composite.states == diagrams.states == 260
    assert (composite.edges, diagrams.edges) == (1332, 1332)
    # Two types of sections. Of a caller's templates nothing is known: five sections, then their junctions,
    # one to the next, and one of them to the last by its failure.
    assert done == [(1, 2), (2, 2)]
    assert alone[:5] == [(number, 5) for number in range(1, 6)]
    assert alone[5:] == [(number, 6) for number in range(1, 7)]
    assert (own.states, own.edges) == (260, 1332)


def test_local_graphs_are_made_on_a_dask_cluster(ulysse_net: MissionNet) -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with (
        distributed.LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        composite = glue(ulysse_net.usage, ulysse_net.graph, Making(executor=client.get_executor()))
    assert (composite.states, composite.edges) == (260, 1332)
