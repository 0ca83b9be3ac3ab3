"""What a node means in which version of its library: what is chosen, what is refused, what depends on it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcpn.cli.line import run
from mcpn.errors import InputError
from mcpn.trees.importing import Imported, translate
from mcpn.trees.ledger import Kind, in_words
from mcpn.trees.nodes.forest import Forest
from mcpn.trees.nodes.table import TABLE
from mcpn.trees.nodes.versions import VERSIONS
from mcpn.trees.reading import read_forest
from tests.trees.languages import compare, sides
from tests.trees.test_import import A, B, C, imported, node
from tests.trees.ticking import Tree


def forest(folder: Path, tree: str, *library: str, form: str = "") -> Forest:
    """The forest of one tree, whose file may say its format."""
    path = folder / "tree.xml"
    said = f' BTCPP_format="{form}"' if form else ""
    path.write_text(f'<root{said}><BehaviorTree ID="M">{tree}</BehaviorTree></root>')
    return read_forest(path, library=library)


def made(folder: Path, tree: str, *library: str, form: str = "") -> Imported:
    return translate(forest(folder, tree, *library, form=form), "m", "tree.xml")


def why_refused(folder: Path, tree: str, *library: str, form: str = "") -> str:
    with pytest.raises(InputError) as error:
        made(folder, tree, *library, form=form)
    problem = error.value.problems[0]
    assert problem.source is None or problem.source.line == 1
    return problem.message


@pytest.mark.parametrize(
    ("tree", "form", "read_as"),
    [
        (A, "4", "BehaviorTree.CPP 4.0 to 4.10 (BTCPP_format 4)"),
        (A, "", "BehaviorTree.CPP 3.0 to 4.10"),
        (node("ParallelAll", A, B), "", "BehaviorTree.CPP 4.3 to 4.10 (ParallelAll, line 1)"),
        (node("TryCatch", A, B), "4", "BehaviorTree.CPP 4.9 to 4.10 (BTCPP_format 4, TryCatch, line 1)"),
        (node("RetryUntilSuccesful", A, num_attempts=3), "", "3.0 to 3.8 (RetryUntilSuccesful, line 1)"),
        (node("Parallel", A, B, threshold=1), "", "3.0 to 3.5 (threshold of Parallel, line 1)"),
        ('<a _skipIf="x"/>', "", "BehaviorTree.CPP 4.0 to 4.10 (_skipIf)"),
        (node("RoundRobin", A, B, wrap_around="true"), "4", "Nav2 1.5 (wrap_around of RoundRobin, line 1)"),
        (node("Selector", A, B), "", "py_trees 2.6"),
        (node("Sequence", A, B, memory="false"), "", "py_trees 2.6"),
    ],
)
def test_what_a_tree_is_read_as(tree: str, form: str, read_as: str, tmp_path: Path) -> None:
    found = made(tmp_path, tree, form=form)
    assert read_as in found.ledger.read_as
    assert f"Read as {found.ledger.read_as}." in in_words(found.ledger)
    assert found.mission.translated[0].library == found.ledger.read_as


@pytest.mark.parametrize(
    ("tree", "library", "form", "said"),
    [
        (
            node("Parallel", A, B, success_treshold=1),
            (),
            "4",
            "has no port 'success_treshold', expected fail",
        ),
        (
            node("ParallelAll", A, B, max_failure=2),
            (),
            "",
            "has no port 'max_failure', expected max_failures",
        ),
        (
            node("Parallel", A, B, threshold=1),
            (),
            "4",
            "threshold of Parallel is a port of BehaviorTree.CPP 3.0",
        ),
        (node("Parallel", A, B, success_count=1), ("btcpp=3.8",), "", "is a port of BehaviorTree.CPP 4.0 to"),
        (node("Parallel", A, B, threshold=1, success_count=1), (), "", "has ports of different versions"),
        (node("Sequence", A, memory="false"), (), "4", "it is one of py_trees 2.6: --library py_trees"),
        (node("RoundRobin", A, B, wrap_around="true"), ("nav2=1.4",), "", "is a port of Nav2 1.5"),
        (node("TryCatch", A, B), ("btcpp=4.8.2",), "", "TryCatch is a node of BehaviorTree.CPP 4.9 to 4.10"),
        (
            node("RetryUntilSuccessful", A),
            (),
            "4",
            "lacks num_attempts, which BehaviorTree.CPP 3.6 to 4.10 req",
        ),
        (node("Repeat", A, num_cycles="many"), (), "4", "num_cycles is 'many', expected a whole number"),
        (node("Timeout", A, msec="-1"), (), "4", "msec is '-1', expected a whole number, not below 0"),
        (node("RunOnce", A, then_skip="maybe"), (), "4", "then_skip is 'maybe', expected true or false"),
        (node("Parallel", A, B, success_count=3), (), "4", "more successes or failures than children"),
        (
            node("Parallel", A, B, threshold=0),
            (),
            "",
            "a threshold of 0 is never met in BehaviorTree.CPP 3.0",
        ),
        (node("ParallelAll", A, max_failures=2), (), "4", "more failures than children"),
        (
            '<a _while="x"/>',
            (),
            "3",
            "has _while of BehaviorTree.CPP 4, the tree is for BehaviorTree.CPP 3.0",
        ),
        (
            node("RecoveryNode", A, B, number_of_retries=-1),
            (),
            "4",
            "number_of_retries is '-1', expected a wh",
        ),
        (A, ("nav3=1",), "", "no library 'nav3', expected one like btcpp=4.10"),
        (A, ("nav2=0.4",), "", "no version '0.4' of Nav2, expected one of 1.1, 1.2"),
    ],
)
def test_what_no_version_has_is_refused(
    tree: str, library: tuple[str, ...], form: str, said: str, tmp_path: Path
) -> None:
    assert said in why_refused(tmp_path, tree, *library, form=form)


def test_thresholds_of_version_3(tmp_path: Path) -> None:
    """One of three children must succeed; that three must fail follows from it."""
    (block,) = made(tmp_path, node("Parallel", A, B, C, threshold=1)).mission.blocks
    assert (block.success_when, block.failure_when) == ("any", "all")  # type: ignore[union-attr]
    two = node("Parallel", A, B, success_threshold=2, failure_threshold=2)
    (block,) = made(tmp_path, two).mission.blocks
    assert (block.success_when, block.failure_when) == ("all", "any")  # type: ignore[union-attr]


@pytest.mark.parametrize("count", [-2, -7, 0])
def test_rounds_that_the_library_never_makes(count: int, tmp_path: Path) -> None:
    """Below -1 there is no round: RetryUntilSuccessful fails at once, Repeat succeeds."""
    tried = node("RetryUntilSuccessful", A, num_attempts=count)
    (entry,) = (e for e in made(tmp_path, tried).ledger.entries if e.node.id != "a")
    assert (entry.became, entry.kind) == ("fails at once", Kind.EXACT)
    repeated = node("Repeat", A, num_cycles=count)
    (entry,) = (e for e in made(tmp_path, repeated).ledger.entries if e.node.id != "a")
    assert entry.became == "succeeds at once"


TURNS = {
    "once": node("RoundRobin", A, B, C),
    "again": node("KeepRunningUntilFailure", node("RoundRobin", A, node("Sequence", B, C))),
    "a recovery": node("RecoveryNode", A, node("RoundRobin", B, C), number_of_retries=2),
    "one child": node("RetryUntilSuccessful", node("RoundRobin", A), num_attempts=2),
    "halted": node("KeepRunningUntilFailure", node("ReactiveFallback", "<IsX/>", node("RoundRobin", A, B))),
}


@pytest.mark.parametrize("name", TURNS)
@pytest.mark.parametrize("version", ["1.4", "1.5"])
def test_turns_by_version(name: str, version: str, tmp_path: Path) -> None:
    """Each version has its meaning, and without one the mission has the runs of both."""
    found, ticked = imported(tmp_path, TURNS[name], (f"nav2={version}",))
    assert found.ledger.kind is Kind.EXACT
    assert compare(sides(found, ticked), exact=True) >= 1
    either, _ = imported(tmp_path, TURNS[name], ())
    (entry,) = (e for e in either.ledger.entries if e.node.id == "RoundRobin")
    assert entry.kind is Kind.MORE
    assert entry.why.startswith(
        "depends on the version: in Nav2 1.3 to 1.4: the next child in turn, up to the"
    )
    assert "; in Nav2 1.5: the next child in turn; without wrap_around it fails once" in entry.why
    assert compare(sides(either, ticked), exact=False) >= 1


def test_a_tree_that_wraps_around(tmp_path: Path) -> None:
    """Since 1.5 the port brings the old meaning back."""
    tree = node("KeepRunningUntilFailure", node("RoundRobin", A, B, wrap_around="true"))
    found, _ = imported(tmp_path, tree, ())
    assert found.ledger.kind is Kind.EXACT
    old = forest(tmp_path, node("KeepRunningUntilFailure", node("RoundRobin", A, B)), "nav2=1.4", form="4")
    assert compare(sides(found, Tree(old, frozenset())), exact=True) >= 1


def test_a_sequence_that_halts_reset_until_3_6(tmp_path: Path) -> None:
    tree = node("RetryUntilSuccesful", node("SequenceStar", A, B), num_attempts=2)
    entries = made(tmp_path, tree).ledger.entries
    (entry,) = (e for e in entries if e.node.id == "SequenceStar")
    assert entry.kind is Kind.MORE
    assert entry.why.startswith("depends on the version: in BehaviorTree.CPP 3.0 to 3.5: ")
    assert made(tmp_path, tree, "btcpp=3.8").ledger.kind is Kind.EXACT


def test_py_trees(tmp_path: Path) -> None:
    reactive = made(tmp_path, node("Selector", "<IsX/>", A, memory="False"), "py_trees")
    assert [event.name for event in reactive.mission.events] == ["IsX_succeeds"]
    assert not made(tmp_path, node("selector", "<IsX/>", A, memory="true")).mission.events
    (every,) = made(tmp_path, node("Parallel", A, B, policy="success_on_all")).mission.blocks
    assert (every.success_when, every.failure_when) == ("all", "any")  # type: ignore[union-attr]
    one = made(tmp_path, node("Parallel", A, B), "py_trees")
    assert (one.mission.blocks[0].success_when, one.ledger.kind) == ("any", Kind.MORE)  # type: ignore[union-attr]
    assert "no port 'success_count'" in why_refused(
        tmp_path, node("Parallel", A, success_count=1), "py_trees"
    )
    (tried,) = made(tmp_path, node("Retry", A, num_failures=3), "py_trees").mission.blocks
    assert tried.retries == 2
    (timed,) = made(tmp_path, node("Timeout", A, duration="2.5"), "py_trees").mission.blocks
    assert timed.timeout == 2.5


def test_the_version_is_asked_for_on_the_command_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="M"><RoundRobin><a/><b/></RoundRobin></BehaviorTree></root>'
    )
    command = ["init", str(tmp_path / "m"), "--from", str(path), "--library", "nav2=1.5", "--json"]
    assert run(command) == 0
    told = json.loads(capsys.readouterr().out)["ledger"]
    assert told["read_as"].endswith("Nav2 1.5 (asked for)")
    assert run(["check", str(tmp_path / "m" / "mission.xml")]) == 0
    assert "Read as" in " ".join(capsys.readouterr().out.split())


def test_the_table_is_without_contradictions() -> None:
    """Of one name, rows of one library do not overlap where their ports are the same, and are in order."""
    seen: dict[tuple[str, str], list[frozenset[str]]] = {}
    for row in TABLE:
        before = seen.setdefault((row.library, row.node), [])
        known = VERSIONS[row.library]
        assert row.versions
        assert row.versions <= set(known)
        assert all(
            known.index(min(row.versions, key=known.index)) > known.index(min(b, key=known.index))
            for b in before
        )
        before.append(row.versions)
    assert {row.role for row in TABLE} == {"Control", "Decorator", "Action", "Condition"}
