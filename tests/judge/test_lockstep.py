"""Engines, simulator and controllers do what the interpreter says, on drawn missions of every element."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.drawing.compose import compose
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.mission.model import Handler, Mission, Objective, Parallel, Recursive, walk
from mcpn.mission.passes import core
from mcpn.testing import elements as drawn
from mcpn.testing.judge.interpreter import Seen
from mcpn.testing.judge.lockstep import Mismatch
from tests.draws import composed, fewer
from tests.judge.lockstep import Judge
from tests.judge.players import MODULAR, OfGraph
from tests.small import activity, hw, mission, robot

MOST_STATES = 200
"""A few larger missions took most of the time; ``experiments/judges/judge.py`` draws up to 3,000."""


def check(of: Mission, most: int = MOST_STATES) -> str:
    """All that play a mission agree with the interpreter; says how it was judged."""
    verdict = Judge(of).judge(composed(of), most)
    event(verdict.kind)
    event(f"{verdict.kind}, modular controller: {MODULAR in verdict.pairs}")
    return verdict.kind


@fewer(0.25)
@given(drawn.ANY)
def test_any_mission(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.INTERRUPTED)
def test_missions_with_declared_events(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.ABORTED)
def test_missions_that_abort(of: Mission) -> None:
    check(of)


@given(drawn.EARLY)
def test_blocks_that_end_early(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.EARLY_WIDE)
def test_wide_blocks_that_end_early(of: Mission) -> None:
    check(of)


@given(drawn.WORLD)
def test_missions_with_facts(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.WORLD_ABORTED)
def test_facts_where_blocks_end_early(of: Mission) -> None:
    check(of)


@given(drawn.LEFT_BY_FACTS)
def test_blocks_that_are_left_as_facts_become_so(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.LEFT_BY_FACTS_APART)
def test_blocks_left_by_facts_where_nothing_contends(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.ENDS_AT_ONCE)
def test_branches_that_end_at_the_same_moment(of: Mission) -> None:
    assert check(of) != "undetermined"


@fewer(0.5)
@given(drawn.WORLD_APART)
def test_facts_where_nothing_contends(of: Mission) -> None:
    assert check(of) != "undetermined"


@fewer(0.5)
@given(drawn.COMMON_CAUSES)
def test_missions_with_common_causes(of: Mission) -> None:
    event("a fault affects something" if of.faults else "no fault")
    check(of)


@fewer(0.5)
@given(drawn.LASTING)
def test_missions_whose_hardware_stays_out_of_service(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(drawn.LASTING_APART)
def test_hardware_that_stays_out_of_service_where_nothing_contends(of: Mission) -> None:
    assert check(of) != "undetermined"


@fewer(0.5)
@given(drawn.CRASHING)
def test_missions_whose_activities_crash(of: Mission) -> None:
    event(f"may crash: {min(len(core(of).crashes), 3)}")
    check(of)


@fewer(0.5)
@given(drawn.CRASHING_APART)
def test_crashes_where_nothing_contends(of: Mission) -> None:
    assert check(of) != "undetermined"


@fewer(0.5)
@given(drawn.LATE)
def test_hardware_that_is_detected_late(of: Mission) -> None:
    event(f"detected late: {len(of.late)}")
    check(of)


@fewer(0.5)
@given(drawn.LATE_APART)
def test_late_detection_where_nothing_contends(of: Mission) -> None:
    assert check(of) != "undetermined"


@st.composite
def missions_of_much_late_hardware(draw: st.DrawFn) -> Mission:
    """One objective that may use five resources detected late, beside another or not, and what follows."""
    names = [f"h{i}" for i in range(5)]
    mended = draw(st.sampled_from((None, *names)))
    hardware = [replace(hw(name)[0], detected="late", repairable=name == mended) for name in names]
    cut = draw(st.integers(1, len(names) - 1))
    first, second = (draw(st.permutations(some)) for some in (names[:cut], names[cut:]))
    tasks = [activity("a", tuple(first)), activity("b", tuple(second))]
    if draw(st.booleans()):
        tasks[0] = activity("a", tuple(first), tuple(first[1:]))
    if draw(st.booleans()):
        tasks[1] = activity("b", *((name,) for name in second[:3]))
    looking = replace(activity("look", ()), detects=tuple(draw(st.sets(st.sampled_from(names), max_size=2))))
    timeout = draw(st.sampled_from((None, 1.0)))
    whole = Objective(name="x", activities=("a", "b", "look"), timeout=timeout)
    again = Objective(name="again", activities=draw(st.sampled_from((("a",), ("b", "a")))))
    after = draw(st.sampled_from(("again", "fail")))
    if draw(st.booleans()):
        return mission(robot(tuple(hardware), *tasks, looking), replace(whole, failure=after), again)
    beside = Objective(name="y", activities=("watch",))
    tasks.append(activity("watch", ()))
    both = Parallel(name="both", blocks=(whole, beside), failure=after)
    return mission(robot(tuple(hardware), *tasks, looking), both, again)


@fewer(0.05, least=2)  # hundreds of states each
@given(missions_of_much_late_hardware())
def test_one_objective_may_use_much_hardware_that_is_detected_late(of: Mission) -> None:
    assert check(of, most=2_000) != "undetermined"


@given(drawn.RECOVERING)
def test_blocks_that_recover(of: Mission) -> None:
    event(f"recovers: {any(block.recover for block in walk(of.blocks))}")
    check(of)


@given(drawn.PAUSING)
def test_blocks_that_pause(of: Mission) -> None:
    blocks = [*walk(of.blocks), *(b for p in of.protocols for b in walk(p.blocks))]
    event(f"pauses: {any(h.pause for block in blocks for h in block.handlers)}")
    check(of)


def holds_branches(of: Mission) -> bool:
    """Whether some parallel block of a mission pauses."""
    sections = flatten(of).all_sections()
    return any(isinstance(section, ParallelSection) and section.pause_graphs for section in sections)


@fewer(0.5)
@given(drawn.PAUSING_APART)
def test_blocks_with_branches_that_pause(of: Mission) -> None:
    event(f"branches: {holds_branches(of)}")
    assert check(of) != "undetermined"


@fewer(0.5)
@given(drawn.PAUSING_FACTS)
def test_pauses_and_facts(of: Mission) -> None:
    event(f"branches: {holds_branches(of)}")
    check(of)


@fewer(0.5)
@given(drawn.TIMED)
def test_missions_with_timeouts(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.IN_TIME)
def test_blocks_whose_time_may_be_over(of: Mission) -> None:
    event(f"timed blocks: {min(sum(1 for _ in flatten(of).timed_blocks()), 3)}")
    check(of)


@fewer(0.5)
@given(drawn.PAUSING_IN_TIME)
def test_blocks_whose_time_may_be_over_and_that_pause(of: Mission) -> None:
    event(f"timed blocks: {min(sum(1 for _ in flatten(of).timed_blocks()), 3)}")
    assert check(of) != "undetermined"


def routed(of: Mission) -> str:
    """How many routes for reasons a mission has, and on what."""
    blocks = [*walk(of.blocks), *(b for p in of.protocols for b in walk(p.blocks))]
    routes = [(block, route) for block in blocks for route in block.routes if route.reason]
    inner = sum(not isinstance(block, Objective) or block.retries > 0 for block, _ in routes)
    return f"routes for reasons: {min(len(routes), 3)}, of blocks or tries: {min(inner, 2)}"


@given(drawn.NAMED)
def test_failures_for_reasons(of: Mission) -> None:
    event(routed(of))
    check(of)


@fewer(0.5)
@given(drawn.NAMED_APART)
def test_failures_for_reasons_where_nothing_contends(of: Mission) -> None:
    event(routed(of))
    assert check(of) != "undetermined"


@fewer(0.25)
@given(drawn.IN_ROUNDS)
def test_handlers_in_rounds_and_uses(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(drawn.APART)
def test_missions_without_contention(of: Mission) -> None:
    check(of)


@fewer(0.15)  # hundreds of states each
@given(drawn.SHARING)
def test_branches_that_share_data(of: Mission) -> None:
    check(of)


@fewer(0.5)
@given(drawn.SHARING_FACTS)
def test_branches_that_share_data_and_facts(of: Mission) -> None:
    mission_net = composed(of)
    event(f"keeps a producer: {mission_net.usage.sharing.anything_kept}")
    assert check(of) != "undetermined"


@fewer(0.25)
@given(drawn.DISJOINT)
def test_missions_with_disjoint_branches(of: Mission) -> None:
    check(of)


@fewer(0.15)
@given(drawn.WIDE)
def test_wide_blocks(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(drawn.CHAINS)
def test_missions_of_chains(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(drawn.SAYING)
def test_missions_with_parameters(of: Mission) -> None:
    check(of)


CHAIN = mission(
    robot(
        hw("h", "g"),
        activity("d", ("h",), ("g",), produces=("s",)),
        activity("a", ("s",)),
        activity("b", ("g",)),
    ),
    Recursive(
        name="r", blocks=(Objective(name="o", activities=("a",)), Objective(name="p", activities=("b",)))
    ),
)


def test_every_state_of_every_player_is_compared() -> None:
    verdict = Judge(CHAIN).judge()
    assert verdict.kind == "agree"
    assert set(verdict.pairs.values()) == {verdict.states}
    assert len(verdict.pairs) == 9
    assert verdict.pairs["explicit"] == OfGraph(compose(CHAIN), "explicit", 1000).graph.states


def test_branches_of_a_repeated_block_have_their_own_names() -> None:
    """Sections of one type are named by what stands in each: branches that are blocks, too."""
    inner = tuple(Objective(name=name, activities=(name[1:],), retries=1) for name in ("oa", "ob"))
    twice = mission(
        robot((), activity("a", ()), activity("b", ())), Parallel(name="p", blocks=inner, retries=1)
    )
    assert Judge(twice).judge().kind == "agree"


def test_one_event_in_two_branches_lets_a_producer_return() -> None:
    """A leak stops what one branch consumes, and lets the other begin: the producer stops between the two.

    Drawn missions show it (``experiments/judges/judge.py --missions 150 --jobs 1 --seed 11``, before it was
    mended).
    """
    leak = (Handler(event="leak", goto="fail"),)
    here = Recursive(
        name="here", blocks=(Objective(name="look", activities=("look",), handlers=leak),), retries=1
    )
    first = Objective(name="shoot", activities=("shoot",), failure="succeed")
    there = Recursive(
        name="there", blocks=(first, Objective(name="wait", activities=("wait",), handlers=leak)), retries=1
    )
    of = mission(
        robot(
            hw("sonar", "lamp"),
            activity("locate", ("sonar",), ("lamp",), produces=("place",)),
            activity("look", ("place",)),
            activity("shoot", ("place",)),
            activity("wait", ()),
            events=("leak",),
        ),
        Parallel(name="both", blocks=(here, there)),
    )
    assert Judge(of).judge().kind == "agree"


class _Wrong(OfGraph):
    """A graph of which one state says something else."""

    wrong: dict[str, Any]

    def seen(self, at: int) -> Seen:
        said = super().seen(at)
        return replace(said, **self.wrong) if at == 5 else said


@pytest.mark.parametrize(
    "kind", ["mode", "waiting", "refused", "running", "ended", "out", "pending", "outcome"]
)
def test_a_wrong_state_is_found(kind: str) -> None:
    player = _Wrong(compose(CHAIN), "explicit", 1000)
    player.wrong = {kind: "something else"}
    with pytest.raises(Mismatch) as caught:
        Judge(CHAIN).lockstep("somebody", player)
    assert caught.value.kind == kind


def test_an_event_that_is_missing_is_found() -> None:
    player = OfGraph(compose(CHAIN), "explicit", 1000)
    player.onward(7).popitem()
    with pytest.raises(Mismatch) as caught:
        Judge(CHAIN).lockstep("somebody", player)
    assert caught.value.kind == "possible"
