"""Composition: the composite of local graphs is the alternatives graph of the whole mission."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from hypothesis import event, given, reject
from hypothesis.strategies import booleans

from mcpn.composite.composing import composite_space
from mcpn.composite.composite import CompositeSpace
from mcpn.composite.nonconfluent_sections import sharing_pairs
from mcpn.composite.section_type import SectionType
from mcpn.composite.sections import NOWHERE
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.permanent_loss import mortal
from mcpn.drawing.sections import junction_part
from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, PremiseError
from mcpn.events import Event
from mcpn.mission.core.objectives_graph import Section
from mcpn.mission.model import Mission, Objective, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction, direct
from mcpn.spaces.stable.confluence_by_sets import prove_confluent
from mcpn.spaces.stable.written_out import written_out
from mcpn.steps import Doing, WorkStep, heard_by
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from mcpn.workers import using
from tests.draws import composed, fewer
from tests.logic.test_properties import play
from tests.shares import returns_early
from tests.small import activity, mission, robot


def check_equal(found: AlternativesGraph, expected: AlternativesGraph) -> None:
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name


def sizes(space: CompositeSpace) -> tuple[int, int]:
    return space.everything.count(), sum(space.firings(space.everything).values())


def types(space: CompositeSpace) -> set[SectionType]:
    return {placed.type for placed in space.sections.values()}


def test_ulysse_by_sections_has_the_states_of_the_reference_net(ulysse_net: MissionNet) -> None:
    composite = composite_space(ulysse_net)
    assert sizes(composite) == (260, 1332)  # the reference net's
    assert len(types(composite)) == 2
    check_equal(written_out(composite, "local", 1000), direct(ulysse_net.net))


def rounds(count: int, retries: int) -> MissionNet:
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
    return compose(Mission(name="m", robots=(robot,), blocks=(each,)))


def test_rounds_and_tries_are_of_one_type() -> None:
    nets = rounds(1, 0), rounds(500, 3)
    one, more = map(composite_space, nets)
    assert (len(one.sections), len(more.sections)) == (1, 2000)
    assert len(types(more)) == 1
    around = 3 * 4  # before the start and at both ends, by the hardware out of service
    assert sizes(more)[0] - around == 2000 * (sizes(one)[0] - around)
    assert len(generate(nets[1]).types) == 1


@given(
    missions()
    | missions(events=2, sections=8)
    | missions(lasting=True, crashes=True, sections=6)
    | missions(late=True, sections=6)
    | missions(late=True, lasting=True, crashes=True, faults=1, timeouts=1, facts=2, sections=6)
    | stacked_missions()
)
def test_the_composite_is_the_whole(mission: Mission) -> None:
    mission_net = composed(mission)
    try:
        whole = by_reduction(explore(mission_net.net, max_states=50_000))
    except LimitError:
        reject()
    except (ConfluenceError, DivergenceError):
        event("not confluent")
        assert mission_net.usage.contentions
        with pytest.raises((ConfluenceError, DivergenceError)):
            composite_space(mission_net)
        return
    composite = composite_space(mission_net)
    event(f"{len(composite.sections)} sections, {len(types(composite))} types")
    assert sizes(composite) == (whole.states, whole.edges)
    check_equal(written_out(composite, "local", 50_000), whole)
    ends = [mission_net.success], [mission_net.failure], [mission_net.success, mission_net.failure]
    for places in ends:
        reaching = composite.reaching(composite.marked(places))
        goal = np.any([whole.marked(p) for p in places], axis=0)
        assert reaching.count() == int(whole.reaching(goal).sum())


@fewer(0.3)
@given(missions() | missions(late=True) | stacked_missions(), booleans())
def test_sections_lie_in_the_whole_where_their_own_nets_have_the_same_names(
    mission: Mission, may_die: bool
) -> None:
    try:
        composite = composite_space(composed(mission), may_die=may_die)
    except (ConfluenceError, DivergenceError):
        returns_early("not confluent")
        return
    whole = composite.net
    for placed in composite.sections.values():
        local = local_net(placed.part)
        own = (mortal(local) if may_die else local).net
        both = (
            (placed.places, own.places, whole.place_index),
            (placed.transitions, own.transitions, whole.transition_index),
        )
        for found, drawn, index in both:
            of_mission = [d.provenance is not None and d.provenance.kind == "mission" for d in drawn]
            there = [index.get(d.name, NOWHERE) for d in drawn]
            assert list(found) == [NOWHERE if m else t for m, t in zip(of_mission, there, strict=True)]
    shared = len({placed.part.used for placed in composite.sections.values()}) < len(composite.sections)
    event(f"sections that use the same: {shared}")


@fewer(0.5, least=8)
@given(missions() | missions(late=True))
def test_junctions_are_confluent_where_their_sections_are(mission: Mission) -> None:
    """The argument of papers/composition.md against a proof on the net of both sections."""
    mission_net = composed(mission)
    try:
        composite = composite_space(mission_net)
    except (ConfluenceError, DivergenceError):
        returns_early("not confluent")
        return

    def calm(section: Section) -> bool:
        try:
            prove_confluent(composite.sections[section.name].type.net.net)
        except (ConfluenceError, DivergenceError):
            return False
        return True

    for first, second in sharing_pairs(composite):
        if calm(first) and calm(second):
            event(f"gated: {second.name in mission_net.usage.handover.gated}")
            part = junction_part(mission_net.usage, first, second)
            prove_confluent(local_net(part).net)


class Compared(int):
    """A number that counts how often one is compared with another of its kind."""

    times = 0

    def __eq__(self, other: object) -> bool:
        Compared.times += isinstance(other, Compared)
        return int(self) == other

    __hash__ = int.__hash__


def test_no_section_compares_equal_sets_of_transitions() -> None:
    blocks = [Objective(name=f"o{i}", activities=("a",)) for i in range(30)]
    composite = composite_space(compose(mission(robot((), activity("a", ())), *blocks)))
    every = range(len(composite.net.transitions))

    def after_all() -> int:
        """How many transitions are compared as all sections are asked for what follows some of them."""
        before = Compared.times
        composite.after(composite.everything, frozenset(map(Compared, every)))
        return Compared.times - before

    after_all()
    assert after_all() <= 2 * len(every)


def test_each_section_is_asked_once_what_leads_to_those_behind_it() -> None:
    """A section with two routes is asked with both at once, where no route leads back."""
    names = [f"o{i}" for i in range(30)]
    blocks = [
        Objective(name=name, activities=("a",), failure=after)
        for name, after in zip(names, [*names[2:], None, None], strict=True)
    ]
    composite = composite_space(compose(mission(robot((), activity("a", ())), *blocks)))
    goal, asked = composite.marked([composite.mission_net.success]), list[SectionType]()
    for type_ in {stage.type for stage in composite.stages.values()}:

        def ending(*given: Any, of: SectionType = type_, ask: Callable[..., Any] = type_.ending) -> Any:
            asked.append(of)
            return ask(*given)

        vars(type_)["ending"] = ending
    assert composite.reaching(goal, composite.everything)
    assert 0 < len(asked) < len(composite.stages)


def test_what_edges_may_carry_is_one_object_for_equal_transitions() -> None:
    blocks = [Objective(name=name, activities=("a",)) for name in ("o0", "o1", "o2")]
    composite = composite_space(compose(mission(robot((), activity("a", ())), *blocks)))
    every = range(len(composite.net.transitions))
    assert composite.filtered(every)("o0") is composite.filtered([*every])("o1")


def test_sections_see_those_of_some_transitions_that_they_have(ulysse_net: MissionNet) -> None:
    composite = composite_space(ulysse_net)
    for every in (range(0, len(composite.net.transitions), 3), range(70), range(70, 150)):
        allowed = composite.filtered(every)
        for name, stage in composite.stages.items():
            local = stage.type.net.net.transitions
            own = frozenset(i for i, t in enumerate(stage.transitions) if t in every and local[i].event)
            assert allowed(name).local == own


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


class Distrustful(PaperTemplates):
    """A user's templates in which hardware, once suspected, is so for good."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        draw = canvas.transition

        def drawn(transition: str, **arcs: Any) -> None:
            if transition == "h_8s":
                arcs["consume"].remove("h_suspected")
                arcs["produce"].remove("h_trusted")
                arcs["read"] = ["h_suspected"]
            draw(transition, **arcs)

        canvas.transition = drawn  # type: ignore[method-assign, assignment]
        super().hardware(canvas, resource)
        canvas.transition = draw  # type: ignore[method-assign]


def test_a_section_that_still_suspects_hardware_is_refused() -> None:
    late = Hardware(name="h", detected="late")
    of = mission(robot((late,), activity("use", ("h",))), Objective(name="o", activities=("use",), retries=1))
    composite_space(compose(of))
    net = compose(of, Distrustful())
    with pytest.raises(PremiseError) as caught:
        composite_space(net, templates=Distrustful())
    assert caught.value.place in ("h_trusted", "h_suspected")
    # What is asked of the whole net where the mission has ended says the same.
    ended = play(net, ["MISSION_EV_START", "h_EV_OOS", "OBJ_o_try1_EV_FAIL", "OBJ_o_try2_EV_FAIL"])
    assert ended[net.failure]
    assert net.not_idle(ended) == ["h_suspected"]


def test_late_hardware_is_asked_in_document_order_whoever_uses_it_first() -> None:
    """Sections that differ in names alone but for that order are not of one type."""
    late = tuple(Hardware(name=name, detected="late") for name in ("a", "b"))
    ways = ("x", ("a", "b")), ("y", ("b", "a"))
    of = robot(late, *(activity(name, *((h,) for h in way)) for name, way in ways))
    both = mission(of, *(Objective(name=name.upper(), activities=(name,), retries=1) for name, _ in ways))
    composite = composite_space(compose(both))
    assert len(types(composite)) == 2
    check_equal(written_out(composite, "local", 10_000), direct(composite.net))


@pytest.mark.parametrize(
    ("templates", "place", "section"),
    [
        (Outliving(), "filming_Stop", "transect.census"),
        (Keeping(), "thruster_actuator_busy", "coral_head.manual_moving"),
        (Spending(), "filming_film", "transect.census"),
        (Wearing(), "thruster_actuator_new", "coral_head.manual_moving"),
    ],
)
def test_a_section_that_leaves_something_behind_is_refused(
    ulysse: Mission, templates: PaperTemplates, place: str, section: str
) -> None:
    mission_net = compose(ulysse, templates)
    with pytest.raises(PremiseError, match="use --engine explicit or symbolic") as caught:
        composite_space(mission_net, templates=templates)
    assert (caught.value.place, caught.value.section) == (place, section)
    assert caught.value.runs


class Blinking(PaperTemplates):
    """A user's templates in which a light blinks for ever, by internal firings, while an activity runs."""

    def __init__(self, name: str) -> None:
        self.name = name

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        super().activity(canvas, activity)
        if activity.name == self.name:
            pen = canvas.of("activity", activity.name, activity.source)
            dark, light, running = pen.place("dark", initial=1), pen.place("light"), f"{self.name}_active1"
            pen.transition("on", [dark], [light], read=[running])
            pen.transition("off", [light], [dark])


@pytest.mark.parametrize("name", ["manual_moving", "diving", "filming"])
def test_a_section_that_does_not_come_to_rest_is_refused(
    ulysse: Mission, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the nets of junctions, and without these where the mission comes to it."""
    templates = Blinking(name)
    mission_net = compose(ulysse, templates)
    with pytest.raises(DivergenceError):
        composite_space(mission_net, templates=templates)
    monkeypatch.setattr("mcpn.composite.composing.refuse_open_junctions", lambda composite: None)
    with pytest.raises(DivergenceError) as caught:
        composite_space(mission_net, templates=templates)
    marking, net = mission_net.net.initial, mission_net.net
    for fired in caught.value.runs[0]:
        marking = net.fire(marking, net.transition_index[fired])
    assert any(net.transitions[t].internal for t in net.enabled(marking))


class OfACaller(PaperTemplates):
    """The paper's templates, which nobody knows by this name."""


def test_local_spaces_are_made_by_any_executor(ulysse_net: MissionNet) -> None:
    explored: list[list[tuple[int, int]]] = [[], []]

    class Heard:
        def begins(self, step: WorkStep) -> None:
            if step.doing is Doing.EXPLORING:
                explored[-1].append((step.number, step.total))

        def comes_to(self, states: int, edges: int) -> None:
            pass

    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool, using(pool), heard_by(Heard()):
        own = composite_space(ulysse_net, templates=OfACaller())
        alone = explored.pop()
        composite = composite_space(ulysse_net)
    assert sizes(composite) == sizes(own) == (260, 1332)
    # Two types of sections; of a caller's templates nothing is known, so that each section is its own.
    assert explored == [[(1, 2), (2, 2)]]
    assert alone == [(number, 5) for number in range(1, 6)]


def test_local_spaces_are_made_on_a_dask_cluster(ulysse_net: MissionNet) -> None:
    distributed = pytest.importorskip("distributed", reason="needs mcpn[distributed]")
    with (
        distributed.LocalCluster(1, threads_per_worker=1, processes=False, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
        using(client.get_executor()),
    ):
        composite = composite_space(ulysse_net)
    assert sizes(composite) == (260, 1332)
