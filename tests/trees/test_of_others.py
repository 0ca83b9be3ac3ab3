"""Trees that others wrote, where their folder is given: translated, or refused with a line."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from lxml import etree

from mcpn.errors import InputError
from mcpn.study import open_study
from mcpn.trees.importing import translate
from mcpn.trees.ledger import Kind
from mcpn.trees.reading import read_forest


def test_trees_of_others_are_translated_or_refused_with_a_line(trees: Path) -> None:
    large, unplaced = list[Kind](), list[Path]()
    for path in sorted(trees.rglob("*.xml")):
        try:
            forest = read_forest(path, library=["nav2=1.5"])
            made = translate(forest, "others", path.name)
        except InputError as error:
            unplaced += [path for problem in error.problems if not problem.source or not problem.source.line]
            continue
        if len(made.ledger.entries) >= 10:
            large.append(made.ledger.kind)
        # Every node of the trees that are used is in the ledger, once.
        assert len({id(entry.node) for entry in made.ledger.entries}) == len(made.ledger.entries)
    assert unplaced == []
    assert 3 * sum(kind in (Kind.EXACT, Kind.TIME) for kind in large) >= 2 * len(large) > 0


REFUSED = {
    "misspelled_ports_parallel.xml": "has no port 'success_treshold'",
    "misspelled_ports_parallelall.xml": "has no port 'max_failure'",
    "misspelled_ports_recovery.xml": "has no port 'num_retries'",
}
READ = {
    "v3_retry.xml": (Kind.EXACT, "BehaviorTree.CPP 3.0 to 3.8"),
    "parallel_threshold_v3.xml": (Kind.EXACT, "BehaviorTree.CPP 3.0 to 3.5"),
    "roundrobin_wrap.xml": (Kind.EXACT, "Nav2 1.5"),
    "distance_controller.xml": (Kind.TIME, "Nav2 1.3 to 1.5"),
    "raw_ampersand.xml": (Kind.MORE, "BehaviorTree.CPP 4.0 to 4.10"),
    "raw_less_than.xml": (Kind.MORE, "BehaviorTree.CPP 4.0 to 4.10"),
    "names_not_ascii.xml": (Kind.EXACT, "BehaviorTree.CPP 4.0 to 4.10"),
    "keep_running.xml": (Kind.MORE, "BehaviorTree.CPP 4.0 to 4.10"),
    "raw_amp.xml": (Kind.MORE, "BehaviorTree.CPP 4.0 to 4.10"),
    "round_robin.xml": (Kind.MORE, "Nav2 1.3 to 1.5"),
}


def fault(faults: Path, name: str) -> Path:
    found = sorted(faults.rglob(name))
    if not found:
        pytest.skip(f"needs a folder with {name}: --faults")
    return found[0]


@pytest.mark.parametrize("name", REFUSED)
def test_files_that_libraries_refuse(name: str, faults: Path) -> None:
    with pytest.raises(InputError, match=REFUSED[name]):
        read_forest(fault(faults, name))


@pytest.mark.parametrize("name", READ)
def test_files_that_were_read_wrongly(name: str, faults: Path) -> None:
    kind, read_as = READ[name]
    made = translate(read_forest(fault(faults, name)), "m", name)
    assert made.ledger.kind is kind
    assert read_as in made.ledger.read_as
    failing = open_study(made.mission).verdicts().verdicts["failure_reachable"]
    assert failing.holds
    names = {block.name for block in made.mission.blocks}
    assert not names & {"n", "n2"}


WHOLE = (
    '<root BTCPP_format="4"><include path="o.xml"/><BehaviorTree ID="A"><Sequence name="s"><a/>'
    '<Decorator ID="D"><b/></Decorator><SubTree ID="O"/></Sequence></BehaviorTree><TreeNodesModel>'
    '<Action ID="a"><input_port name="x" type="int" default="1"/></Action></TreeNodesModel></root>'
)


@given(place=st.integers(0, 10), element=st.booleans(), name=st.sampled_from(["odd", "_odd", "Odd", "guard"]))
def test_what_is_added_anywhere_is_refused_or_named(
    place: int, element: bool, name: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    """An attribute or an element more: a node or a port that the mission has, a problem, or a warning."""
    folder = tmp_path_factory.mktemp("drawn")
    (folder / "o.xml").write_text('<root BTCPP_format="4"><BehaviorTree ID="O"><c/></BehaviorTree></root>')
    root = etree.fromstring(WHOLE)
    every = [each for each in root.iter() if isinstance(each.tag, str)]
    at = every[place % len(every)]
    if element:
        etree.SubElement(at, name)
    else:
        at.set(name, "1")
    path = folder / "tree.xml"
    path.write_bytes(etree.tostring(root))
    refused: InputError | None = None
    try:
        forest = read_forest(path)
    except InputError as error:
        refused = error
    if refused is not None:
        assert all(problem.source and problem.source.line for problem in refused.problems)
        return
    named = [w for w in forest.warnings if name in w.message]
    nodes = [each for tree in forest.trees.values() for each in tree.root.walk()]
    read = any(name == each.id or name in each.ports for each in nodes)
    assert named or read, etree.tostring(root)
