"""Nothing in a file of trees is skipped because no code asks for it."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcpn.errors import InputError, Source
from mcpn.trees.importing import translate
from mcpn.trees.reading import read_forest

UNKNOWN = {
    "attribute of the root": (
        '<root odd="1"><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of a tree": (
        '<root><BehaviorTree ID="A" odd="1"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of an include": (
        '<root><include path="o.xml" odd="1"/><BehaviorTree ID="A"><a/></BehaviorTree></root>',
        "no attribute 'odd'",
    ),
    "attribute of a model": (
        '<root><BehaviorTree ID="A"><a/></BehaviorTree>'
        '<TreeNodesModel><Action ID="a" odd="1"/></TreeNodesModel></root>',
        "no attribute 'odd', expected ID, editable",
    ),
    "element in a model": (
        '<root><BehaviorTree ID="A"><a/></BehaviorTree>'
        '<TreeNodesModel><Action ID="a"><odd/></Action></TreeNodesModel></root>',
        "found <odd> in <Action>, expected <input_port>",
    ),
    "element beside trees": ('<root><odd/><BehaviorTree ID="A"><a/></BehaviorTree></root>', "found <odd>"),
    "include inside a tree": (
        '<root><BehaviorTree ID="A"><Sequence><include path="o.xml"/><a/></Sequence></BehaviorTree></root>',
        "found <include> inside a tree, expected a node",
    ),
    "model inside a tree": (
        '<root><BehaviorTree ID="A"><Sequence><TreeNodesModel/><a/></Sequence></BehaviorTree></root>',
        "found <TreeNodesModel> inside a tree, expected a node",
    ),
    "port inside a leaf": (
        '<root><BehaviorTree ID="A"><a><input_port name="x"/></a></BehaviorTree></root>',
        "found <input_port> inside a tree, expected a node",
    ),
    "ID where none belongs": (
        '<root><BehaviorTree ID="A"><a ID="b"/></BehaviorTree></root>',
        "no attribute 'ID'",
    ),
    "port of a node": (
        '<root><BehaviorTree ID="A"><Inverter odd="1"><a/></Inverter></BehaviorTree></root>',
        "no port",
    ),
}


@pytest.mark.parametrize("name", UNKNOWN)
def test_what_is_not_known_is_refused(name: str, tmp_path: Path) -> None:
    text, message = UNKNOWN[name]
    path = tmp_path / "tree.xml"
    path.write_text(text)
    with pytest.raises(InputError) as error:
        read_forest(path)
    assert any(message in problem.message for problem in error.value.problems)
    assert all(problem.source and problem.source.line == 1 for problem in error.value.problems)


def test_what_libraries_ignore_is_listed(tmp_path: Path) -> None:
    """Attributes that begin with ``_`` and text mean nothing: a warning says so, and what was meant."""
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><Sequence _odd="1" _description="x">\n'
        '<a _skipif="x"/>stray</Sequence></BehaviorTree></root>'
    )
    assert [problem.message for problem in read_forest(path).warnings] == [
        "<Sequence> holds text, which means nothing",
        "a: attribute _skipif means nothing, _skipIf does",
        "Sequence: attribute _odd means nothing",
    ]


def test_models_that_disagree_are_listed(tmp_path: Path) -> None:
    """A condition answers at once, an action may run: which one a node is changes the mission."""
    path, models = tmp_path / "tree.xml", tmp_path / "models.xml"
    path.write_text(
        '<root BTCPP_format="4"><BehaviorTree ID="A"><a/></BehaviorTree>\n'
        '<TreeNodesModel><Action ID="a"/><Condition ID="b"/></TreeNodesModel></root>'
    )
    models.write_text('<TreeNodesModel>\n<Condition ID="a"/><Condition ID="b"/></TreeNodesModel>')
    (warning,) = read_forest(path, models=[models]).warnings
    assert warning.message == "a is Action here and Condition in another model: Action counts"
    assert warning.source == Source(str(path), 2)


def test_names_in_other_letters(tmp_path: Path) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root><BehaviorTree ID="A"><Sequence><Go name="抓取"/><Go name="Größe prüfen"/><拿/></Sequence>'
        "</BehaviorTree></root>"
    )
    mission = translate(read_forest(path), "m", "tree.xml").mission
    assert [(block.name, block.description) for block in mission.blocks] == [
        ("Go", "抓取"),
        ("Grosse_prufen", "Größe prüfen"),
        ("node", "拿"),
    ]


def test_what_editors_and_version_3_write(tmp_path: Path) -> None:
    """Attributes of editors stand anywhere; version 3 writes the ports of a tree as elements."""
    path = tmp_path / "tree.xml"
    path.write_text(
        '<root main_tree_to_execute="A"><BehaviorTree ID="A" _description="x" _favorite="true">\n'
        '<SubTree ID="B"><remap internal="to" external="goal"/></SubTree></BehaviorTree>\n'
        '<BehaviorTree ID="B"><a to="{to}"/></BehaviorTree>\n'
        '<TreeNodesModel><SubTree ID="B"><MetadataFields><Metadata runnable="true"/></MetadataFields>'
        '<input_port name="to" default="x">Where to</input_port></SubTree></TreeNodesModel></root>'
    )
    forest = read_forest(path)
    assert forest.main.root.ports == {"to": "{goal}"}
    assert [each.message for each in forest.warnings] == ["<BehaviorTree>: attribute _favorite means nothing"]
