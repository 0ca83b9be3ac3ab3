"""Composition: the composite of local graphs is the alternatives graph of the whole mission."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from hypothesis import event, given, reject

from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Robot
from mcpn.net.compose import MissionNet, compose
from mcpn.net.templates import Canvas, PaperTemplates
from mcpn.space.alternatives import AlternativesGraph, by_reduction, direct
from mcpn.space.composite import Composite
from mcpn.space.expand import expand
from mcpn.space.explicit import explore
from mcpn.space.graph import Mask
from mcpn.space.local import MAX_FAULTY, OUTCOMES, Outcome, PremiseError, local_graphs
from mcpn.testing import missions


def composed(mission_net: MissionNet) -> Composite:
    graph, usage = mission_net.graph, mission_net.usage
    return Composite(usage, graph, tuple(local_graphs(usage, graph)))


def check_equal(found: AlternativesGraph, expected: AlternativesGraph) -> None:
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name


def test_ulysse(ulysse: Mission, ulysse_net: MissionNet) -> None:
    composite = composed(ulysse_net)
    # Table 1 of the paper.
    assert (composite.states, composite.edges) == (260, 1332)
    assert len({id(placed.local) for placed in composite.sections}) == 2
    check_equal(expand(composite, ulysse_net), direct(ulysse_net.net))


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
        assert usage.contentions or usage.exchanges
        with pytest.raises((ConfluenceError, DivergenceError)):
            composed(mission_net)
        return
    try:
        composite = composed(mission_net)
    except (ConfluenceError, DivergenceError):
        # A section or a junction that the mission never comes to, or not so, is judged all the same.
        event("refused: contention that the mission does not come to")
        assert usage.contentions or usage.exchanges
        return
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


def _losing(composite: Composite, goals: set[Outcome]) -> int:
    """States of the whole from which no goal is reached, by the composite's arithmetic."""
    count = len(composite.faulty)
    losing = composite.losing(goals)
    inside = sum(int(mask.sum()) << count - len(composite.by_name[n].faulty) for n, mask in losing.items())
    first = composite.by_name[composite.graph.entry]
    wins = composite.leading_to(goals)[composite.graph.entry][first.local.entry]
    before = 0 if wins.any() else 1 << count
    return inside + before + (len(composite.ends - goals) << count)


# --- the premise ---------------------------------------------------------------------------------------


class Outliving(PaperTemplates):
    """A user's templates in which the activity ``filming`` uses up its film for good."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        if activity.name == "filming":
            pen = canvas.of("activity", activity.name, activity.source)
            film, running = pen.place("filming_film", initial=1), f"{activity.name}_active1"
            pen.transition("filming_used", [film], [], read=[running], event="FILMING_EV_USED")


class Holding(PaperTemplates):
    """A user's templates in which a resource, once used, is not what it was."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        super().hardware(canvas, resource)
        if resource.name == "thruster_actuator":
            pen = canvas.of("hardware", resource.name, resource.source)
            new, busy = pen.place("thruster_actuator_new", initial=1), "thruster_actuator_busy"
            pen.transition("thruster_worn", [new], [], read=[busy], event="THRUSTER_EV_WORN")


@pytest.mark.parametrize(
    ("templates", "place", "section"),
    [
        (Outliving(), "filming_film", "transect.census"),
        (Holding(), "thruster_actuator_new", "coral_head.manual_moving"),
    ],
)
def test_a_section_that_leaves_something_behind_is_refused(
    ulysse: Mission, templates: PaperTemplates, place: str, section: str
) -> None:
    mission_net = compose(ulysse, templates)
    with pytest.raises(PremiseError, match="use --engine explicit or symbolic") as caught:
        local_graphs(mission_net.usage, mission_net.graph, templates=templates)
    assert (caught.value.place, caught.value.section) == (place, section)
    assert caught.value.runs


def test_too_much_hardware_in_one_section_is_a_limit_that_says_so() -> None:
    ways = tuple(Alternative(name=f"w{i}", consumes=(f"h{i}",)) for i in range(MAX_FAULTY + 1))
    robot = Robot(
        name="r",
        hardware=tuple(Hardware(name=f"h{i}") for i in range(MAX_FAULTY + 1)),
        activities=(Activity(name="a", alternatives=ways),),
    )
    mission_net = compose(
        Mission(name="m", blocks=(Objective(name="o", activities=("a",)),), robots=(robot,))
    )
    with pytest.raises(LimitError, match="section o uses 17 hardware resources that can fail"):
        composed(mission_net)


# --- elsewhere -----------------------------------------------------------------------------------------


def test_local_graphs_are_made_by_any_executor(ulysse_net: MissionNet) -> None:
    done: list[tuple[int, int]] = []
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        placed = local_graphs(
            ulysse_net.usage, ulysse_net.graph, executor=pool, progress=lambda *at: done.append(at)
        )
    assert Composite(ulysse_net.usage, ulysse_net.graph, tuple(placed)).states == 260
    assert done
    assert done[-1][0] == done[-1][1] == len(done)


def test_local_graphs_are_made_on_a_dask_cluster(ulysse_net: MissionNet) -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with (
        distributed.LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        placed = local_graphs(ulysse_net.usage, ulysse_net.graph, executor=client.get_executor())
    composite = Composite(ulysse_net.usage, ulysse_net.graph, tuple(placed))
    assert (composite.states, composite.edges) == (260, 1332)
