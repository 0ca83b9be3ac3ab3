"""Loss functions from the mission's text against those of the state space, and against brute force."""

from __future__ import annotations

from itertools import combinations

from hypothesis import event, given

from mcpn.answers.causes.minimal_cut_sets import CutSet, Moment
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import (
    ABORT,
    Mission,
    Objective,
    Parallel,
    Recursive,
)
from mcpn.mission.static.resource_use import Usage
from mcpn.report.failures.openpsa import Formula, Losses, structured
from mcpn.spaces.stable.alternatives import direct
from tests.draws import fewer
from tests.logic.asked import Asked
from tests.logic.oracle import Play, coming_home, fragile_missions, minimal
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


def test_the_text_says_of_ulysse_what_the_graph_says(ulysse_net: MissionNet) -> None:
    agree(ulysse_net)


@fewer(0.5)
@given(
    fragile_missions(max_hardware=4)
    | fragile_missions(max_hardware=3, faults=2)
    | fragile_missions(max_hardware=2, crashes=True)
    | coming_home()
)
def test_where_nothing_contends_the_text_says_what_the_graph_says(mission: Mission) -> None:
    agree(compose(mission))


def agree(found: MissionNet) -> None:
    try:
        direct(found.net, max_states=5000)
        asked = Asked(found)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    unsafe = set(asked.cuts.aborts.unsafe if asked.cuts.aborts else ())
    tree, losses = structured(found.usage, unsafe), Losses(found.graph)

    def lost_from(section: str) -> list[CutSet]:
        products: list[Formula] = [
            ("and", [("gate", f"objective-{name.replace('.', '-')}") for name in names])
            for names in losses.mission_from(section)
        ]
        tree.gates[f"from-{section}"] = "or", products
        return minimal(tree.cut_sets(f"from-{section}"))

    if found.usage.contentions:
        returns_early("the text alone does not decide")
        return
    assert minimal(tree.cut_sets("mission-lost")) == asked.cut_sets(None, Moment.START)
    safety = asked.cuts.safety
    assert (safety is None) == ("robot-lost" not in tree.gates)
    at_once = {section.name for section in found.graph.sections if section.failure == ABORT}
    if safety is not None:
        event(f"can be aborted, by failures of what should make safe: {bool(unsafe)}")
    if safety is not None and unsafe <= at_once:
        assert minimal(tree.cut_sets("robot-lost")) == asked.cuts.found(safety).minimal[Moment.START]
    for section in found.graph.sections:
        if asked.prospects.entered(section):
            assert lost_from(section.name) == asked.cut_sets(None, Moment.ENTRY, section.name)
    for objective in found.graph.walk():
        if asked.goal(objective.name).running:
            by_text = minimal(tree.cut_sets(f"objective-{objective.name.replace('.', '-')}"))
            for moment in (Moment.WHENEVER, Moment.ENTRY):
                assert by_text == asked.cut_sets(objective.name, moment)


def test_a_block_is_not_left_while_a_branch_never_ends() -> None:
    of = robot(hw("H"), activity("use", ("H",)), activity("free", ()))
    wanted = Objective(name="wanted", activities=("use",))

    def lost_with(success: str) -> list[CutSet]:
        again = Objective(name="again", activities=("free",), success=success, failure="again")
        beside = Recursive(name="beside", blocks=(again,), mandatory=False)
        block = Parallel(name="block", blocks=(wanted, beside), failure="succeed")
        found = compose(mission(of, block))
        agree(found)
        return minimal(structured(found.usage).cut_sets("mission-lost"))

    assert lost_with("succeed") == []  # whether wanted succeeds or fails
    assert lost_with("again") == [()]


def redundant(activities: int, ways: int) -> Mission:
    """A chain of software resources, each made in several ways: from a sensor, and from the one before.

    Resource i comes from resource i - 1 and one of ``ways`` sensors of its own.
    """
    makers = []
    for i in range(activities):
        before = (f"s{i - 1}",) if i else ()
        makers.append(
            activity(f"make{i}", *((f"h{i}_{k}", *before) for k in range(ways)), produces=(f"s{i}",))
        )
    hardware = hw(*(f"h{i}_{k}" for i in range(activities) for k in range(ways)))
    of = robot(hardware, *makers, activity("use", (f"s{activities - 1}",)))
    return mission(of, Objective(name="go", activities=("use",)))


def test_a_chain_of_ten_resources_and_thirty_sensors() -> None:
    mission = redundant(10, 3)
    tree = structured(Usage(mission, flatten(mission)))
    # Closed form: each resource of the chain is lost with its three sensors, and with nothing less.
    assert minimal(tree.cut_sets("mission-lost")) == [(f"h{i}_0", f"h{i}_1", f"h{i}_2") for i in range(10)]
    # A set is survived where each resource of the chain keeps a sensor: one of 7 non-empty sets of three.
    assert tree.images.everything.count() - tree.function(("gate", "mission-lost")).count() == 7**10


def test_the_chain_is_confirmed_by_brute_force_where_that_ends() -> None:
    found = compose(redundant(2, 2))
    play = Play(found)
    hardware = [f"h{i}_{k}" for i in range(2) for k in range(2)]
    lost = []
    for size in range(5):
        for dead in combinations(hardware, size):
            start = play.after(play.initial, [f"{h}_EV_OOS" for h in dead])
            if not play.mission_survives(start, frozenset(dead)):
                lost.append(frozenset(dead))
    found_by_text = minimal(structured(found.usage).cut_sets("mission-lost"))
    assert found_by_text == minimal(lost) == [("h0_0", "h0_1"), ("h1_0", "h1_1")]
