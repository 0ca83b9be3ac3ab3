"""Trees in: what each node becomes, against an interpreter of trees that knows no missions."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.trees.importing import Imported, translate
from mcpn.trees.ledger import Kind
from mcpn.trees.reading import read_forest
from tests.shares import returns_early
from tests.trees.languages import Difference, TooMuch, compare, sides
from tests.trees.ticking import Tree

QUICK = frozenset({"IsX", "IsY"})


def imported(tmp_path: Path, tree: str, library: tuple[str, ...] = ("nav2=1.4",)) -> tuple[Imported, Tree]:
    """A tree as a mission, and as what ticks it; by default with Nav2's nodes of 1.4."""
    path = tmp_path / "tree.xml"
    root = tree if "<root" in tree else f'<BehaviorTree ID="Main">{tree}</BehaviorTree>'
    path.write_text(root if "<root" in tree else f'<root BTCPP_format="4">{root}</root>')
    forest = read_forest(path, library=library)
    return translate(forest, "m", "tree.xml"), Tree(forest, QUICK)


A, B, C, D = (f"<{name}/>" for name in "abcd")
X, Y = "<IsX/>", "<IsY/>"
WELL, BADLY = "<AlwaysSuccess/>", "<AlwaysFailure/>"


def node(tag: str, *children: str, **ports: object) -> str:
    said = "".join(f' {name}="{value}"' for name, value in ports.items())
    return f"<{tag}{said}>{''.join(children)}</{tag}>"


EXACT = {
    "sequence": node("Sequence", A, X, B),
    "fallback": node("Fallback", A, node("Sequence", X, B), C),
    "inverter": node("Fallback", node("Inverter", A), node("ForceFailure", B), node("ForceSuccess", C)),
    "if": node("IfThenElse", X, A, node("Inverter", B)),
    "if without else": node("Fallback", node("IfThenElse", A, B), C),
    "try": node("TryCatch", A, B, C),
    "retry": node("RetryUntilSuccessful", node("Sequence", A, B), num_attempts=3),
    "retry for ever": node("Sequence", node("RetryUntilSuccessful", A, num_attempts=-1), B),
    "repeat of retry": node("Repeat", node("RetryUntilSuccessful", A, num_attempts=2), num_cycles=2),
    "retry of repeat": node("RetryUntilSuccessful", node("Repeat", A, num_cycles=2), num_attempts=2),
    "keep running": node("Fallback", node("KeepRunningUntilFailure", node("Sequence", A, B)), C),
    "parallel": node("Parallel", A, B, node("Sequence", C, D)),
    "parallel, one": node("Parallel", A, B, success_count=1, failure_count=2),
    "parallel, two of three fail": node("Parallel", A, B, C, success_count=1, failure_count=2),
    "inverter of two of three": node("Inverter", node("Parallel", A, B, C, success_count=1, failure_count=2)),
    "parallel all": node("ParallelAll", A, node("Inverter", B), node("Fallback", C, D)),
    "reactive": node("ReactiveSequence", X, node("Inverter", Y), A, B),
    "reactive fallback": node("Fallback", node("ReactiveFallback", X, A), B),
    "reactive, two run": node("ReactiveSequence", A, B),
    "reactive, three run": node("ReactiveFallback", A, B, C),
    "reactive, rounds before a leaf": node(
        "ReactiveFallback", node("RetryUntilSuccessful", A, num_attempts=2), node("Sequence", A, B)
    ),
    "reactive, asked behind one that runs": node("ReactiveSequence", A, X, B, C),
    "reactive, behind a series that asks": node("ReactiveSequence", node("Sequence", X, A), B, Y, C),
    "timeout of no time": node("Fallback", node("Timeout", A, msec=0), B),
    "while": node("WhileDoElse", X, A, node("Sequence", B, C)),
    "while without else": node("WhileDoElse", node("Inverter", X), A),
    "memory": node("RetryUntilSuccessful", node("SequenceWithMemory", A, X, B), num_attempts=3),
    "memory, halted in between": node("ReactiveSequence", A, node("SequenceWithMemory", B, WELL)),
    "memory, fails at once": node("ReactiveFallback", A, node("SequenceWithMemory", BADLY, B)),
    "memory, halted": node(
        "KeepRunningUntilFailure", node("ReactiveFallback", X, node("SequenceWithMemory", A, B))
    ),
    "recovery": node("RecoveryNode", node("Sequence", A, B), node("Fallback", C, D), number_of_retries=2),
    "recovery in vain": node("RecoveryNode", "<AlwaysFailure/>", A, number_of_retries=1),
    "recovery of inverter": node("RecoveryNode", node("Inverter", A), node("Inverter", B)),
    "recoveries": node("RecoveryNode", node("RecoveryNode", A, B), node("RecoveryNode", C, D)),
    "pipeline": node("PipelineSequence", X, A, B),
    "pipeline, one that cannot fail": node("PipelineSequence", node("ForceSuccess", X), A),
    "reactive, one that cannot fail": node("ReactiveSequence", node("ForceSuccess", X), A),
    "pipeline of three": node("PipelineSequence", A, node("Sequence", B, Y), C),
    "pipeline of sequence": node("PipelineSequence", node("Fallback", A, B), node("Sequence", C, D)),
    "round robin": node("KeepRunningUntilFailure", node("RoundRobin", A, node("Sequence", B, C), D)),
    "round robin, one that succeeds at once": node("ReactiveFallback", A, node("RoundRobin", A, WELL)),
    "round robin, one that fails at once": node(
        "RetryUntilSuccessful", node("RoundRobin", A, BADLY), num_attempts=2
    ),
    "round robin, asked behind one that runs": node("ReactiveSequence", A, node("RoundRobin", A, WELL)),
    "reactive, a round robin that cannot fail": node("ReactiveSequence", node("RoundRobin", Y, WELL), A),
    "pipeline, a series that cannot fail": node("PipelineSequence", node("Fallback", X, WELL), A),
    "reactive, a series that cannot succeed": node("ReactiveFallback", node("Sequence", X, BADLY), A),
    "while, a condition that cannot fail": node("WhileDoElse", node("Fallback", X, WELL), A, B),
    "round robin, halted": node(
        "KeepRunningUntilFailure", node("ReactiveFallback", X, node("RoundRobin", A, B))
    ),
    "nothing": "<AlwaysSuccess/>",
    "parallel, none may fail and the first has": node(
        "Parallel", "<AlwaysFailure/>", A, B, success_count=1, failure_count=0
    ),
    "parallel, none may fail and the first has not": node(
        "Parallel", "<AlwaysSuccess/>", A, B, success_count=2, failure_count=0
    ),
    "scripts": node("Sequence", '<Script code="x:=1"/>', A, "<AlwaysFailure/>", B),
}


MORE = {
    "recovery in vain, twice": node("RecoveryNode", "<AlwaysFailure/>", A, number_of_retries=2),
    "parallel, one that decides at once": node("Parallel", A, "<AlwaysSuccess/>", success_count=1),
    "parallel, none need succeed": node("Parallel", A, B, success_count=0),
    "parallel, none may fail": node("Parallel", A, B, success_count=1, failure_count=0),
    "parallel, one that counts late": node("Parallel", A, B, "<AlwaysSuccess/>", success_count=2),
    "parallel all, two may fail": node("ParallelAll", A, B, C, max_failures=2),
    "memory, beside others": node(
        "Parallel", C, node("SequenceWithMemory", A, BADLY), D, success_count=2, failure_count=1
    ),
    "memory, behind a stage that runs": node("PipelineSequence", A, node("SequenceWithMemory", B, WELL)),
    "memory of conditions, asked again": node("ReactiveSequence", A, node("SequenceWithMemory", X, Y)),
    "memory of conditions, in a branch": node(
        "WhileDoElse", X, node("TryCatch", A, B), node("SequenceWithMemory", Y, WELL)
    ),
    "an unknown decorator": node("Strange", node("Sequence", A, B)),
    "reactive, rounds behind rounds": node(
        "ReactiveSequence", node("Repeat", A, num_cycles=2), node("Repeat", B, num_cycles=2)
    ),
    "reactive, rounds behind rounds of what answers at once": node(
        "ReactiveSequence", node("Repeat", WELL, num_cycles=2), node("Repeat", WELL, num_cycles=2)
    ),
    "reactive, two leaves behind rounds": node(
        "ReactiveFallback", node("RetryUntilSuccessful", A, num_attempts=2), B, C
    ),
    "reactive, a moment behind a moment": node(
        "ReactiveFallback", node("AsyncFallback", A, BADLY), node("AsyncFallback", B, BADLY)
    ),
    "round robin, halted from afar": node(
        "KeepRunningUntilFailure", node("ReactiveFallback", X, node("Sequence", C, node("RoundRobin", A, B)))
    ),
}
TIME = {
    "rate": node("PipelineSequence", node("RateController", node("Fallback", A, B), hz=1), C),
    "rate elsewhere": node("Sequence", node("RateController", A, hz=1), B),
    "timeout": node("Fallback", node("Timeout", A, msec=1500), B),
    "timeout around much": node("Repeat", node("Timeout", node("Sequence", A, B), msec=100), num_cycles=2),
    "timeout between the ticks of memory": node(
        "Fallback", node("Timeout", node("SequenceWithMemory", A, "<AlwaysSuccess/>"), msec=1000), B
    ),
    "timeout of one that may fail": node("Fallback", node("Timeout", node("Sequence", A, B), msec=100), C),
    "delay": node("Sequence", node("Delay", A, delay_msec=100), B),
}


@pytest.mark.parametrize("name", EXACT)
def test_exact_nodes(name: str, tmp_path: Path) -> None:
    made, tree = imported(tmp_path, EXACT[name])
    assert made.ledger.kind is Kind.EXACT
    assert compare(sides(made, tree), exact=True) >= 1


@pytest.mark.parametrize("name", TIME)
def test_nodes_that_are_exact_but_for_time(name: str, tmp_path: Path) -> None:
    made, tree = imported(tmp_path, TIME[name])
    assert made.ledger.kind is Kind.TIME
    assert compare(sides(made, tree), exact=True) >= 1


@pytest.mark.parametrize("name", MORE)
def test_nodes_with_more_runs(name: str, tmp_path: Path) -> None:
    made, tree = imported(tmp_path, MORE[name])
    assert made.ledger.kind is Kind.MORE
    if "unknown" not in name:
        assert compare(sides(made, tree), exact=False) >= 1
        with pytest.raises(Difference):  # it is no mere caution of the ledger
            compare(sides(made, tree), exact=True)


RETURNING = {
    "repeat": node("Repeat", WELL, num_cycles=2),
    "retry": node("RetryUntilSuccessful", BADLY, num_attempts=3),
    "repeat for ever": node("Repeat", WELL, num_cycles=-1),
    "retry for ever": node("RetryUntilSuccessful", BADLY, num_attempts=-1),
    "keep running": node("KeepRunningUntilFailure", WELL),
    "async sequence": node("AsyncSequence", WELL, BADLY, A),
    "async fallback": node("AsyncFallback", BADLY, BADLY),
    "memory": node("SequenceWithMemory", WELL, WELL),
    "loop": node("LoopInt", WELL, queue="1;2"),
    "loop of one": node("LoopInt", WELL, queue="1", if_empty="FAILURE"),
    "loop of a leaf": node("LoopInt", A, queue="1;2", if_empty="FAILURE"),
    "turns": node("RoundRobin", node("Repeat", WELL, num_cycles=2), BADLY),
    "inverted": node("Inverter", node("Sequence", node("Repeat", WELL, num_cycles=2), BADLY)),
}
"""Nodes that return though no leaf runs, and answer at a later tick."""


@pytest.mark.parametrize("name", RETURNING)
@pytest.mark.parametrize(
    "around", ["ReactiveFallback", "ReactiveSequence", "WhileDoElse", "Parallel", "Inverter"]
)
def test_what_returns_though_no_leaf_runs(name: str, around: str, tmp_path: Path) -> None:
    """What is around it may halt it then; and one without a number of rounds never ends."""
    first = X if around == "WhileDoElse" else C
    ports = {"success_count": 1} if around == "Parallel" else {}
    children = [RETURNING[name]] if around == "Inverter" else [first, RETURNING[name]]
    made, ticked = imported(tmp_path, node(around, *children, **ports))
    assert made.ledger.kind in (Kind.EXACT, Kind.MORE)
    compare(sides(made, ticked), exact=made.ledger.kind is Kind.EXACT)


@pytest.mark.parametrize("last", [B, node("Repeat", X, num_cycles=2)])
def test_a_condition_that_runs_beside_what_it_chooses_is_left_out(last: str, tmp_path: Path) -> None:
    made, _ = imported(tmp_path, node("WhileDoElse", A, B, last))
    assert made.ledger.kind is Kind.LEFT_OUT


def test_a_queue_that_is_empty_says_how_its_loop_ends(tmp_path: Path) -> None:
    tree = node("Sequence", node("LoopInt", WELL, queue="1;2", if_empty="FAILURE"), A)
    made, ticked = imported(tmp_path, tree)
    assert made.ledger.kind is Kind.EXACT
    compare(sides(made, ticked), exact=True)


@pytest.mark.parametrize("first", [node("Fallback", Y, C), Y])
def test_a_stage_that_conditions_end_in_each_tick(first: str, tmp_path: Path) -> None:
    """Ticked again it has ended before its leaf runs on, so that in the tree that is not seen to run."""
    tree = node("PipelineSequence", node("Parallel", C, first, success_count=1, failure_count=2), A)
    made, ticked = imported(tmp_path, tree)
    assert made.ledger.kind is Kind.LEFT_OUT
    with pytest.raises(Difference, match="the tree"):
        compare(sides(made, ticked), exact=False)


LEAVES = st.sampled_from([A, B, C, D, X, Y, "<AlwaysSuccess/>", "<AlwaysFailure/>"])


@st.composite
def trees(
    draw: st.DrawFn,
    depth: int = 2,
    leaves: st.SearchStrategy[str] = LEAVES,
    without: frozenset[str] = frozenset(),
) -> str:
    """A tree of known nodes; none but conditions in places where a child that runs would be asked again.

    Args:
        draw: Draws.
        depth: How many levels there are above leaves.
        leaves: What these are drawn of.
        without: Nodes that it does not have.
    """
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        return draw(leaves)
    tag = draw(st.sampled_from(sorted(_ARITY.keys() - without)))
    least, most = _ARITY[tag]
    inside = trees(depth - 1, leaves, without)
    children = [draw(inside) for _ in range(draw(st.integers(least, most)))]
    ports = {name: draw(st.sampled_from(values)) for name, values in _PORTS.get(tag, {}).items()}
    if tag == "Parallel":
        ports |= {
            "success_count": draw(st.integers(0, len(children))),
            "failure_count": draw(st.integers(0, len(children))),
        }
    if tag == "WhileDoElse":
        children[0] = draw(st.sampled_from([X, node("Inverter", Y), node("Sequence", X, Y)]))
    return node(tag, *children, **ports)


_ARITY = {
    **dict.fromkeys(("Sequence", "Fallback", "ReactiveSequence", "ReactiveFallback"), (1, 3)),
    **dict.fromkeys(("SequenceWithMemory", "PipelineSequence", "RoundRobin", "ParallelAll"), (2, 3)),
    **dict.fromkeys(("AsyncSequence", "AsyncFallback"), (1, 3)),
    "LoopInt": (1, 1),
    **dict.fromkeys(("Parallel", "TryCatch", "IfThenElse", "WhileDoElse"), (2, 3)),
    "RecoveryNode": (2, 2),
    **dict.fromkeys(("Inverter", "ForceSuccess", "ForceFailure", "RetryUntilSuccessful", "Repeat"), (1, 1)),
    **dict.fromkeys(("Timeout", "Delay", "RateController"), (1, 1)),
}
_PORTS: dict[str, dict[str, list[object]]] = {
    "RetryUntilSuccessful": {"num_attempts": [1, 2, -1]},
    "Repeat": {"num_cycles": [1, 2]},
    "LoopInt": {"queue": ["1", "1;2"], "if_empty": ["SUCCESS", "FAILURE"]},
    "RecoveryNode": {"number_of_retries": [0, 1, 2]},
    "Timeout": {"msec": [0, 1000]},
    "Delay": {"delay_msec": [10]},
    "RateController": {"hz": [1]},
}


@given(tree=trees())
def test_drawn_trees(tree: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    """Each run of a tree is one of its mission; and the other way round where the ledger says exact."""
    made, ticked = imported(tmp_path_factory.mktemp("drawn"), tree)
    if made.ledger.kind is Kind.LEFT_OUT:
        returns_early("what the ledger says is left out")
        return
    exact = made.ledger.kind in (Kind.EXACT, Kind.TIME) and not hurries(ticked)
    try:
        compare(sides(made, ticked), exact=exact, most=40)
    except TooMuch:
        returns_early("too many states")


BESIDE = ("Parallel", "PipelineSequence", "Reactive", "WhileDoElse", "Timeout", "RateController")
"""Beginnings of nodes in which something else may happen while a leaf runs."""


def hurries(tree: Tree) -> bool:
    """Whether a condition answers in the very tick in which a child before it has, and it can be seen.

    A reactive node cannot wait for a condition behind its first child. In a mission, where ticks are
    forgotten, each leaf ends some time after it began, and what happens beside may come before.
    """
    around = [n for n in tree.forest.main.root.walk() if n.id.startswith(BESIDE)]
    inside = [inner for n in around for child in n.children for inner in child.walk()]
    for reactive in (n for n in inside if n.id.startswith("Reactive")):
        if any(map(tree.at_once, reactive.children[1:])):
            return True
    return False
