"""Scripts of behaviour trees: what BehaviorTree.CPP refuses is refused, where it breaks the grammar."""

from __future__ import annotations

from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcpn.cli.line import run
from mcpn.errors import InputError
from mcpn.trees.nodes.script_grammar import misread
from mcpn.trees.reading import read_forest
from tests.trees.library import library

TAKEN_BY_ALL = (
    "x := 1",
    "@x:='a b'; y = -x ? 0x1F : (z := 2.5e-3)",
    "a & b == ~c || !(d + 1 > 2) && true",
    "x += -1;\n y := 'a' .. b",
)
BROKEN_FOR_ALL = {
    "x :=": 5,
    "x = = 1": 5,
    "x := (1 + 2": 12,
    "x ? 1": 6,
    "{x} := 1": 1,
    "x := 1.": 6,
    "x := 0x": 6,
    "y := 3foo": 6,
    "x := 'open": 6,
    "x)": 2,
    "a => b": 4,
    "x %2": 3,
    "; x": 1,
    "x := 1e999": 6,
    "  ": 1,
}
"""With the column of the first thing that cannot stand there."""
BROKEN_UNTIL = {
    "a b": 3,
    "x := 1;": 8,
    "a := b := c": 8,
    "a & b + c": 7,
    "!a && b > -1": 11,
    "- !a": 3,
    "truex := 1": 5,
    "x := 9223372036854775808": 6,
    "x := 'é'": 6,
    "a ? b : c ? d : e": 11,
    "1..2": 1,
}
BROKEN_SINCE = {'x := "a"': 6, "é := 1": 1, "x := +5": 6}

SIGNS = "+ - * / & | ^ ~ ! && || == != < > <= >= ? : := = += .. ( ) ; # . ,"
OPERANDS = """a b1 true false truex 1 0x1F 2.5 1e3 1. 0x "s" 's' é @k ' 9223372036854775808 x:=1 !c a?b:c"""
PARTS = st.sampled_from([*SIGNS.split(), *OPERANDS.split()])


def tree(node: str) -> str:
    return f'<root BTCPP_format="4">\n<BehaviorTree ID="M">\n{node}\n</BehaviorTree></root>'


@pytest.mark.parametrize("later", [False, True])
def test_scripts_that_all_versions_take(later: bool) -> None:
    assert [misread(script, later=later) for script in TAKEN_BY_ALL] == [None] * len(TAKEN_BY_ALL)


@pytest.mark.parametrize(
    ("later", "broken", "taken"),
    [
        (False, BROKEN_FOR_ALL | BROKEN_UNTIL, BROKEN_SINCE),
        (True, BROKEN_FOR_ALL | BROKEN_SINCE, BROKEN_UNTIL),
    ],
    ids=["4.9", "4.10"],
)
def test_where_scripts_break_the_grammar(later: bool, broken: dict[str, int], taken: dict[str, int]) -> None:
    found = {script: misread(script, later=later) for script in broken | taken}
    assert {script: each and each.column for script, each in found.items()} == broken | dict.fromkeys(taken)


@settings(max_examples=150)
@given(st.lists(st.tuples(PARTS, st.sampled_from(("", " "))), min_size=1, max_size=8))
def test_the_library_refuses_the_same(parts: list[tuple[str, str]]) -> None:
    script = "".join(part + space for part, space in parts)
    factory = library().BehaviorTreeFactory()
    try:
        factory.create_tree_from_text(tree(f"<Script code={quoteattr(script)}/>"))
    except RuntimeError:
        taken = False
    else:
        taken = True
    assert (misread(script, later=False) is None) == taken


@pytest.mark.parametrize(
    ("node", "said"),
    [
        ("<Script code='x :='/>", "Script: code is 'x :=', in column 5 expected an operand, found the end"),
        ("<a _skipIf='x =='/>", "a: _skipIf is 'x ==', in column 5 expected an operand, found the end"),
        ("<a _onSuccess='x y)'/>", "a: _onSuccess is 'x y)', in column 4 expected an operand, found ')'"),
        ("<a _post=' '/>", "a: _post is empty, expected a script"),
        ("<ScriptCondition code=''/>", "ScriptCondition: code is empty, expected a script"),
        (
            "<Precondition if='(x' else='SKIPPED'><a/></Precondition>",
            "Precondition: if is '(x', in column 3 expected ')', found the end",
        ),
        (
            '<SubTree ID="N" _while="x ? y"/>\n</BehaviorTree><BehaviorTree ID="N">\n<a/>',
            "N: _while is 'x ? y', in column 6 expected ':', found the end",
        ),
        (f"<Script code='{'(' * 500}'/>", "in column 101 expected at most 100 levels, found '('"),
    ],
)
def test_what_all_versions_refuse_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], node: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("tree.xml").write_text(tree(node))
    assert run(["check", "tree.xml", "--main", "M"]) == 2
    told = capsys.readouterr().err
    assert "tree.xml:3: " in told
    assert said in told


def test_what_some_versions_refuse_is_said(tmp_path: Path) -> None:
    path = tmp_path / "tree.xml"
    path.write_text(
        tree("<Sequence><Script code='a b'/><Script code='{later}'/><Script code=''/></Sequence>")
    )
    warnings = [each.message for each in read_forest(path).warnings]
    assert warnings == [
        "Script: code is 'a b', in column 3 expected ';', found 'b': BehaviorTree.CPP up to 4.9 refuses that",
        "Script: code is a script on the blackboard, {later}, which is not read",
    ]
    assert len(read_forest(path, library=["btcpp=4.10"]).warnings) == 1
    with pytest.raises(InputError, match="in column 3 expected ';'"):
        read_forest(path, library=["btcpp=4.6"])
