"""Errors taken one by one, or at once with a transition for each set of them: what follows is the same."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.drawing.templates.activities import MAX_TOGETHER, MOST_AT_ONCE, draw_activity
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Activity
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import Shape, missions
from mcpn.testing.data import data_sharing_missions
from mcpn.testing.kit.corpus import wide
from tests.draws import fewer
from tests.judge.lockstep import Judge
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

ALL_AT_ONCE = 99


class Handling(PaperTemplates):
    """The templates, with another number of errors that are taken at a time."""

    def __init__(self, at_once: int) -> None:
        self.at_once = at_once

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        draw_activity(canvas, activity, at_once=self.at_once)


Followed = dict[tuple[str, ...], dict[str, tuple[str, ...]]]
"""By stable marking, the one that each event leads to."""


def followed(found: MissionNet, most: int = 3000) -> Followed | str:
    """The alternatives graph by names of marked places and of transitions, or what the proof comes to."""
    net = found.net
    try:
        graph = direct(net, max_states=most)
    except SemanticsError as error:
        return type(error).__name__
    names = [
        tuple(place.name for place, tokens in zip(net.places, graph.marking(s), strict=True) if tokens)
        for s in range(graph.states)
    ]
    return {
        names[s]: {net.transitions[t].name: names[after] for t, after in graph.successors(s)}
        for s in range(graph.states)
    }


@st.composite
def fusing_missions(draw: st.DrawFn) -> Mission:
    """Missions in which an alternative consumes four data or more, which fail together or in turn."""
    hardware = tuple(replace(h, shared=draw(st.booleans())) for h in hw("h0", "h1"))
    shared = [h.name for h in hardware if h.shared]
    owned = [h.name for h in hardware if not h.shared]
    made = [f"d{i}" for i in range(draw(st.integers(4, 5)))]
    activities = []
    for i, datum in enumerate(made):
        own = [owned.pop()] if owned else []
        tried = st.sampled_from([*own, *shared, *made[:i]] or [""])
        always = draw(st.integers(0, 4)) == 0
        found = draw(st.lists(tried, min_size=1, max_size=2, unique=True))
        ways = list(dict.fromkeys([*found, *([""] if always else [])]))
        consumed = [(way,) if way else () for way in ways]
        back = len(ways) > 1 and draw(st.integers(0, 3)) == 0
        activities.append(replace(activity(f"make{i}", *consumed, produces=(datum,)), switch_back=back))
    wide = (*made, *draw(st.sampled_from([(), tuple(shared)])))
    others: list[list[tuple[str, ...]]] = [[], [(made[0],)], [()], [tuple(made[1:])]]
    other = draw(st.sampled_from(others))
    activities.append(activity("fuse", wide, *other))
    activities.append(activity("watch", (made[-1],)))
    together = draw(st.booleans())
    blocks = (
        Objective(name="x", activities=("fuse", "watch") if together else ("fuse",)),
        Objective(name="y", activities=("watch",)),
    )
    return mission(robot(hardware, *activities), *blocks)


@fewer(0.5)
@given(fusing_missions())
def test_many_errors_are_taken_one_by_one(drawn: Mission) -> None:
    """As with a transition for each set of them, and as the interpreter says, which draws no net."""
    usual, at_once = (compose(drawn, Handling(number)) for number in (MOST_AT_ONCE, ALL_AT_ONCE))
    event(f"one by one: {'fuse_werr1' in usual.net.place_index}, {'fuse_err1' in usual.net.place_index}")
    expected = followed(at_once)
    event(expected if isinstance(expected, str) else "confluent")
    assert followed(usual) == expected
    event(Judge(drawn).judge().kind)


@fewer(0.75)
@given(
    missions()
    | missions(Shape(own_hardware=True, shared_activities=False, hardware=4), events=2)
    | data_sharing_missions()
)
def test_any_number_of_errors_at_a_time_gives_the_same_graph(drawn: Mission) -> None:
    nets = [compose(drawn, Handling(at_once)) for at_once in (0, ALL_AT_ONCE)]
    one_by_one, at_once = nets
    if len(one_by_one.net.places) == len(at_once.net.places):
        returns_early("nothing can be in error")
        return
    event(f"ranks: {len(at_once.net.internal_ranks) > 1}")
    try:
        found, expected = (followed(each) for each in nets)
    except LimitError:
        returns_early("too many states")
        return
    event(expected if isinstance(expected, str) else "confluent")
    assert found == expected


def test_a_net_grows_with_the_data_that_one_alternative_consumes() -> None:
    sizes = [len(compose(wide(number)).net.transitions) for number in (4, 14, 24)]
    assert sizes[2] - sizes[1] == sizes[1] - sizes[0]


def test_five_errors_are_taken_one_by_one() -> None:
    drawn = wide(5)
    place = compose(drawn).net.place_index
    assert {"fuse_err1", "fuse_werr1"} <= place.keys()
    assert Judge(drawn).judge().kind == "agree"


def test_hardware_of_one_alternative_has_no_limit() -> None:
    names = tuple(f"H{i}" for i in range(13))
    net = compose(
        mission(robot(hw(*names), activity("a", names)), Objective(name="x", activities=("a",)))
    ).net
    assert len([t for t in net.transitions if t.name.startswith("a_err1")]) == 13


def test_too_many_resources_of_an_alternative_that_waits_hit_a_limit() -> None:
    names = tuple(f"H{i}" for i in range(MAX_TOGETHER))
    activities = (activity("d", ("h",), produces=("s",)), activity("a", ("s", *names)), activity("b", ("h",)))
    branches = tuple(Objective(name=f"o{a}", activities=(a,)) for a in "ab")
    with pytest.raises(
        LimitError, match="activity a: 13 resources consumed by one alternative that may wait"
    ):
        compose(mission(robot(hw("h", *names), *activities), Parallel(name="both", blocks=branches)))
