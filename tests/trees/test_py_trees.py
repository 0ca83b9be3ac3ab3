"""py_trees itself judges what is read of its XML: each of its runs is one of the imported mission.

The library is PyPI's ``py_trees`` 2.6, which parses the same file (:mod:`tests.trees.py_trees_library`).
"""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import InputError
from mcpn.trees.nodes.table import TABLE
from mcpn.trees.nodes.versions import PY_TREES
from tests.shares import returns_early
from tests.trees.languages import TooMuch
from tests.trees.py_trees_library import library, played, throws
from tests.trees.test_import import A, B, C, X, Y, imported, node
from tests.trees.test_judged import agree

EACH = {
    "Sequence": node("Sequence", A, X, B),
    "Selector": node("Selector", A, X, B),
    "Fallback": node("Fallback", A, X, B),
    "Sequence, reactive": node("Sequence", X, A, B, memory="false"),
    "Selector, reactive": node("Selector", X, A, B, memory="1"),
    "Parallel": node("Parallel", A, node("Sequence", B, C)),
    "Parallel, all": node("Parallel", A, B, C, policy="success_on_all"),
    "Inverter": node("Inverter", A),
    "FailureIsSuccess": node("FailureIsSuccess", A),
    "SuccessIsFailure": node("SuccessIsFailure", A),
    "Retry": node("Retry", A, num_failures=3),
    "Retry, never again": node("Retry", A, num_failures=-1),
    "Repeat": node("Repeat", A, num_success=3),
    "Repeat, for ever": node("Repeat", A, num_success=0),
    "SuccessIsRunning": node("SuccessIsRunning", A),
    "Timeout": node("Timeout", A, duration="1e9"),
    "PassThrough": node("PassThrough", A),
    "Count": node("Count", A),
    "StatusToBlackboard": node("StatusToBlackboard", A, variable_name="told"),
    "OneShot": node("OneShot", A, policy="ON_COMPLETION"),
    "RunningIsFailure": node("RunningIsFailure", A),
    "RunningIsSuccess": node("RunningIsSuccess", A),
    "FailureIsRunning": node("FailureIsRunning", A),
}
OF_PYTHON = {"EternalGuard", "ForEach"}
"""Nodes that want what no attribute can say: a function, an entry that is there already."""


def whole(tree: str) -> str:
    return f'<root main_tree_to_execute="M"><BehaviorTree ID="M">{tree}</BehaviorTree></root>'


def held(folder: Path, tree: str, runs: int) -> None:
    try:
        if not agree(folder, whole(tree), range(runs), PY_TREES, played):
            returns_early("what the ledger says is left out")
    except TooMuch:
        returns_early("too many states")


def test_each_node_of_the_table_is_played() -> None:
    names = {row.node for row in TABLE if row.library == PY_TREES}
    assert names - {name.partition(",")[0] for name in EACH} == OF_PYTHON


@pytest.mark.parametrize("name", EACH)
def test_each_node(name: str, tmp_path: Path) -> None:
    library()
    assert agree(tmp_path, whole(EACH[name]), range(20), PY_TREES, played) == 20


@pytest.mark.parametrize("name", EACH)
def test_each_node_inside_of_others(name: str, tmp_path: Path) -> None:
    library()
    for around in ("Retry", "SuccessIsRunning"):
        ports = {"num_failures": 2} if around == "Retry" else {}
        held(tmp_path, node(around, EACH[name], **ports), 10)
    held(tmp_path, node("Parallel", EACH[name], C), 10)
    held(tmp_path, node("Selector", Y, EACH[name], memory="false"), 10)


LEAVES = st.sampled_from([A, B, C, X, Y])
_SERIES, _POLICY = ["true", "false"], ["success_on_all", "success_on_one"]
_COUNTS = [-1, 0, 1, 2]


@st.composite
def trees(draw: st.DrawFn, depth: int = 2) -> str:
    """A tree of py_trees' own nodes."""
    if depth == 0 or draw(st.integers(0, 5)) == 0:
        return draw(LEAVES)
    tag = draw(st.sampled_from(sorted({name.partition(",")[0] for name in EACH})))
    several = tag in ("Sequence", "Selector", "Fallback", "Parallel")
    inside = draw(st.lists(trees(depth - 1), min_size=1, max_size=3 if several else 1))
    ports: dict[str, list[str] | list[int]] = {
        "Parallel": {"policy": _POLICY},
        "Retry": {"num_failures": _COUNTS},
        "Repeat": {"num_success": _COUNTS},
        "Timeout": {"duration": ["1e9"]},
        "StatusToBlackboard": {"variable_name": ["told"]},
        "OneShot": {"policy": ["ON_COMPLETION"]},
    }.get(tag, {"memory": _SERIES} if several else {})  # type: ignore[assignment]
    return node(tag, *inside, **{port: draw(st.sampled_from(values)) for port, values in ports.items()})


@given(tree=trees())
def test_drawn_trees(tree: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    library()
    held(tmp_path_factory.mktemp("drawn"), tree, 4)


@pytest.mark.parametrize(
    "tree",
    [
        node("Retry", A, num_failures="many"),
        node("Retry", A),
        node("Timeout", A, msec=5),
        node("OneShot", A),
        node("EternalGuard", A, condition="x"),
        node("RetryUntilSuccessful", A, num_attempts=2),
        node("Inverter", A, B),
        node("Parallel", A, policy="success_on_selected"),
    ],
)
def test_what_the_library_refuses_is_refused(tree: str, tmp_path: Path) -> None:
    library()
    path = tmp_path / "tree.xml"
    path.write_text(whole(tree))
    assert throws(path)
    with pytest.raises(InputError):
        imported(tmp_path, whole(tree), (PY_TREES,))
