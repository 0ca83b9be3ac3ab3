"""BehaviorTree.CPP itself judges what is read: each of its runs is one of the imported mission.

The library is PyPI's ``behaviortreepy`` 0.1.4, which is BehaviorTree.CPP 4.8.2 with leaves in Python. Leaves
answer at once, later, or not at all, where they are halted; nodes are skipped as scripts say.
What is held: after each tick, answers in their order and what runs then; in the end, how it has ended.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from mcpn.errors import InputError
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.table import TABLE
from mcpn.trees.nodes.versions import BTCPP
from tests.shares import returns_early
from tests.trees.languages import Side, TooMuch, sides
from tests.trees.library import Tick, library, played, throws
from tests.trees.test_import import LEAVES, A, B, C, X, Y, imported, node, trees

VERSION = "4.8"
"""Of the library that PyPI has."""
SKIPPED = (
    '<a _skipIf="s1"/>',
    '<IsX _skipIf="s2"/>',
    node("Sequence", '<b _skipIf="s3"/>', '<c _skipIf="s4"/>'),
)


def agree(
    folder: Path,
    tree: str,
    seeds: range,
    read_as: str = f"btcpp={VERSION}",
    play: Callable[[Path, int], list[Tick]] = played,
) -> int:
    """How many runs of a library are runs of the mission.

    Args:
        folder: Where the tree may be written.
        tree: The tree, as a node or whole.
        seeds: Of the runs.
        read_as: The library as which it is read.
        play: Plays a tree by that library.

    Raises:
        AssertionError: One is none.
    """
    made, ticked = imported(folder, tree, (read_as,))
    ticked.quick |= {"WasEntryUpdated", "ScriptCondition"}
    if made.ledger.kind is Kind.LEFT_OUT:
        return 0
    both = sides(made, ticked)
    for seed in seeds:
        mission = Side(both.mission_moves, both.mission_rest)
        there = mission.closed([((), both.mission.initial)])
        ticks = play(folder / "tree.xml", seed)
        for tick in ticks:
            for place, answer in enumerate(tick.seen):
                # Asked again by a reactive node, a leaf that answers at once has not been seen to run.
                unseen = there if place in tick.beside else frozenset()
                there = mission.behind(there).get(answer, frozenset()) | unseen
            assert there, (seed, ticks, tick)
            rests = mission.rests(there, both.mission_shows)
            if tick.status != "running":
                assert (END[tick.status],) in rests, (seed, ticks, tick)
            else:
                assert any(same(tick.running, rest, tree) for rest in rests) or not tick.running, (
                    ticks,
                    tick,
                )
    return len(seeds)


BETWEEN = ("SequenceWithMemory", "Async", "Retry", "Repeat", "KeepRunning", "SuccessIsRunning", "Loop")
"""Nodes that return between their children or rounds, where in the mission the next one has begun."""


def same(running: tuple[str, ...], rest: tuple[str, ...], tree: str) -> bool:
    """Whether what runs in the library is what runs in the mission, but for what has begun there already."""
    more, less = Counter(rest), Counter(running)
    return not less - more and (not more - less or any(f"<{each}" in tree for each in BETWEEN))


END = {"success": "success", "failure": "failure", "skipped": "abort"}
"""How a mission ends by what the library returns: a tree that is skipped leaves by abort."""

EACH = {
    "Sequence": node("Sequence", A, X, B),
    "Fallback": node("Fallback", A, X, B),
    "AsyncSequence": node("ReactiveFallback", X, node("AsyncSequence", A, Y, B)),
    "AsyncFallback": node("ReactiveSequence", X, node("AsyncFallback", A, Y, B)),
    "SequenceWithMemory": node("RetryUntilSuccessful", node("SequenceWithMemory", A, B), num_attempts=3),
    "ReactiveSequence": node("ReactiveSequence", X, A),
    "ReactiveFallback": node("ReactiveFallback", X, A),
    "Parallel": node("Parallel", A, node("Sequence", B, C), success_count=1, failure_count=2),
    "ParallelAll": node("ParallelAll", A, B, C, max_failures=2),
    "IfThenElse": node("IfThenElse", A, B, C),
    "WhileDoElse": node("WhileDoElse", X, A, B),
    "Switch2": node("Switch2", A, B, C, variable="2", case_1="1", case_2="2"),
    "Switch3": node("Switch3", A, B, C, A, variable="7", case_1="1", case_2="2", case_3="3"),
    "Switch4": node("Switch4", A, B, C, A, B, variable="4", case_1="1", case_2="2", case_3="3", case_4="4"),
    "Switch5": node("Switch5", A, B, C, A, B, C, variable="1", **{f"case_{i}": i for i in range(1, 6)}),
    "Switch6": node("Switch6", A, B, C, A, B, C, A, variable="9", **{f"case_{i}": i for i in range(1, 7)}),
    "Inverter": node("Inverter", A),
    "ForceSuccess": node("ForceSuccess", A),
    "ForceFailure": node("ForceFailure", A),
    "RetryUntilSuccessful": node("RetryUntilSuccessful", A, num_attempts=3),
    "Repeat": node("Repeat", A, num_cycles=3),
    "KeepRunningUntilFailure": node("KeepRunningUntilFailure", A),
    "Timeout": node("Timeout", A, msec=0),
    "Delay": node("Delay", A, delay_msec=0),
    "RunOnce": node("Repeat", node("RunOnce", A, then_skip="false"), num_cycles=2),
    "Precondition": node("Precondition", A, **{"if": "s1", "else": "SUCCESS"}),
    "LoopInt": node("LoopInt", A, queue="1;2", value="{v}"),
    "LoopBool": node("LoopBool", A, queue="true;false;true", value="{v}"),
    "LoopDouble": node("LoopDouble", A, queue="1.5", value="{v}"),
    "LoopString": node("LoopString", A, queue="x;y", value="{v}"),
    "SkipUnlessUpdated": node("Sequence", node("SkipUnlessUpdated", A, entry="{s1}"), B),
    "WaitValueUpdate": node("Sequence", node("WaitValueUpdate", A, entry="{s1}"), B),
    "AlwaysSuccess": node("Sequence", A, "<AlwaysSuccess/>"),
    "AlwaysFailure": node("Fallback", "<AlwaysFailure/>", A),
    "Script": node("Sequence", '<Script code="y:=1"/>', A),
    "ScriptCondition": node("ReactiveSequence", '<ScriptCondition code="s1"/>', A),
    "SetBlackboard": node("Sequence", '<SetBlackboard value="1" output_key="y"/>', A),
    "UnsetBlackboard": node("Sequence", '<UnsetBlackboard key="y"/>', A),
    "WasEntryUpdated": node("Fallback", '<WasEntryUpdated entry="{s1}"/>', A),
    "Sleep": node("Sequence", A, '<Sleep msec="0"/>', B),
}


def test_each_node_of_the_table_that_the_library_has_is_played() -> None:
    """What it has not is named here: of version 3, of 4.9, what needs a terminal, and queues."""
    names = {
        row.node
        for row in TABLE
        if row.library == BTCPP and VERSION in row.versions and row.exact != "refused"
    }
    assert names - EACH.keys() == {"SequenceStar"}  # the old name, where the library is built with it


@pytest.mark.parametrize("name", EACH)
def test_each_node(name: str, tmp_path: Path) -> None:
    library()
    assert agree(tmp_path, EACH[name], range(12)) == 12


ODD = {
    "nothing follows the last separator": node("LoopString", A, queue="x;;y;"),
    "failures are compared for equality": node(
        "Parallel", "<AlwaysFailure/>", A, B, success_count=1, failure_count=0
    ),
    "failures, at the first tick": node("Parallel", A, B, success_count=1, failure_count=0),
    "no success is needed": node("Parallel", A, B, success_count=0),
}
"""Values of ports that are rare, and mean what nobody would guess."""


@pytest.mark.parametrize("name", ODD)
def test_rare_values_of_ports(name: str, tmp_path: Path) -> None:
    library()
    assert agree(tmp_path, ODD[name], range(12)) == 12


@pytest.mark.parametrize("skipped", SKIPPED)
@pytest.mark.parametrize("around", [name for name in EACH if "<a" in EACH[name]])
def test_each_node_with_children_that_are_skipped(around: str, skipped: str, tmp_path: Path) -> None:
    """Or the ledger says that this is left out."""
    library()
    agree(tmp_path, EACH[around].replace(A, skipped, 1), range(12))


@pytest.mark.parametrize("around", ["KeepRunningUntilFailure", "LoopInt"])
def test_rounds_of_an_inverted_child_that_may_be_skipped(around: str, tmp_path: Path) -> None:
    """Its success ends the rounds, though it goes on where it is skipped."""
    library()
    ports = {"queue": "1;2", "value": "{v}"} if around == "LoopInt" else {}
    assert agree(tmp_path, node(around, node("Inverter", '<a _skipIf="s1"/>'), **ports), range(12)) == 12


@pytest.mark.parametrize("name", ["SkipUnlessUpdated", "WaitValueUpdate"])
def test_what_does_not_halt_its_child(name: str, tmp_path: Path) -> None:
    """In 4.8 two children of a WhileDoElse run at once then, which the mission does not do."""
    library()
    tree = node("WhileDoElse", X, node(name, A, entry="{s1}"), C)
    assert imported(tmp_path, tree)[0].ledger.kind is Kind.LEFT_OUT
    ticks = [tick for seed in range(40) for tick in played(tmp_path / "tree.xml", seed)]
    assert any(tick.running == ("a", "c") for tick in ticks)


NOT_THERE = frozenset({"RecoveryNode", "PipelineSequence", "RoundRobin", "RateController", "TryCatch"})
"""Nodes of Nav2, and of a later version."""
TIMED = frozenset({"Timeout", "Delay"})
"""Nodes whose time is not free there."""
MAY_SKIP = st.one_of(LEAVES, st.sampled_from([each for each in SKIPPED if "Sequence" not in each]))
DRAWN = trees(2, MAY_SKIP, NOT_THERE | TIMED)


def held(folder: Path, tree: str) -> None:
    try:
        if not agree(folder, tree, range(4)):
            returns_early("what the ledger says is left out")
    except TooMuch:
        returns_early("too many states")


@pytest.mark.parametrize(
    "tree",
    [
        node("ReactiveFallback", A, node("Sequence", B, C)),
        node("ReactiveFallback", A, node("Parallel", B, C)),
        node("ReactiveSequence", A, node("Sequence", B, C)),
    ],
)
def test_leaves_that_are_asked_again(tree: str, tmp_path: Path) -> None:
    library()
    assert agree(tmp_path, tree, range(100)) == 100


@given(tree=DRAWN)
def test_drawn_trees(tree: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    library()
    held(tmp_path_factory.mktemp("drawn"), tree)


@pytest.mark.slow
@settings(max_examples=500, phases=[Phase.generate, Phase.shrink])
@given(tree=DRAWN)
def test_five_hundred_drawn_trees(tree: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    library()
    held(tmp_path_factory.mktemp("drawn"), tree)


@pytest.mark.parametrize(
    "tree",
    [
        node("Parallel", A, B, success_count=3),
        node("Parallel", A, B, failure_count=3),
        node("ParallelAll", A, B, max_failures=3),
        node("Parallel", A, B, success_treshold=1),
        node("Sequence", A, odd=1),
        node("Repeat", A),
        node("Repeat", A, num_cycles="many"),
        node("Timeout", A, msec=-1),
        node("TryCatch", A, B),
        '<Sequence ID="x"><a/></Sequence>',
        '<Sleep msec="-1"/>',
        node("Repeat", A, num_cycles=" 3"),
        node("Repeat", A, num_cycles="+3"),
        node("RunOnce", A, then_skip="tRUE"),
        node("Precondition", A, **{"if": "true", "else": "success"}),
        node("LoopInt", A, queue="1;x", value="{v}"),
        '<a _skipIf=""/>',
        f'{A}</BehaviorTree><BehaviorTree ID="Sequence">{B}',
    ],
)
def test_what_the_library_refuses_is_refused(tree: str, tmp_path: Path) -> None:
    library()
    assert throws(whole(tree))
    with pytest.raises(InputError):
        imported(tmp_path, whole(tree), (f"btcpp={VERSION}",))


def whole(tree: str, more: str = "") -> str:
    head = '<root BTCPP_format="4" main_tree_to_execute="M"><BehaviorTree ID="M">'
    return f"{head}{tree}</BehaviorTree>{more}</root>"


@pytest.mark.parametrize(
    ("tree", "more", "said"),
    [
        ("<sequence><a/></sequence>", "", "sequence is read as Sequence"),
        (node("ReactiveSequence", '<Action ID="a"/>'), "", "<Action ID='a'> in a ReactiveSequence"),
        (
            '<SubTree ID="S"/>',
            '<BehaviorTree ID="S"><a/></BehaviorTree><TreeNodesModel><SubTree ID="S">'
            '<input_port name="goal"/></SubTree></TreeNodesModel>',
            "S does not give goal",
        ),
        (
            '<a gaol="1"/>',
            '<TreeNodesModel><Action ID="a"><input_port name="goal"/></Action></TreeNodesModel>',
            "a has no port 'gaol' in its model, which has goal",
        ),
    ],
)
def test_what_the_library_refuses_and_is_read_is_warned_of(
    tree: str, more: str, said: str, tmp_path: Path
) -> None:
    library()
    assert throws(whole(tree, more))
    made, _ = imported(tmp_path, whole(tree, more), (f"btcpp={VERSION}",))
    assert said in " ".join(each.message for each in made.ledger.warnings)
    allowed = tree.replace("sequence", "Sequence").replace('Action ID="a"', "a").replace("gaol", "goal")
    allowed = allowed.replace('ID="S"', 'ID="S" goal="1"')
    assert not imported(tmp_path, whole(allowed, more), (f"btcpp={VERSION}",))[0].ledger.warnings
