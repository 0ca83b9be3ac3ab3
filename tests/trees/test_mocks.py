"""Tests of a tree that a mission writes: what the tree returns when it is played, and what is left out."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from mcpn.study import open_study
from mcpn.tree_tests import document, mocks
from mcpn.trees.importing import translate
from mcpn.trees.ledger import Kind
from mcpn.trees.nodes.forest import Forest, tree_of
from mcpn.trees.nodes.node import TreeNode
from mcpn.trees.reading import read_forest
from tests.commands import mcpn
from tests.shares import returns_early
from tests.trees.test_import import EXACT, TIME, A, B, X, node, trees
from tests.trees.ticking import FAILURE, IDLE, RUNNING, SUCCESS, Tree

SUBTREES = """<root BTCPP_format="4" main_tree_to_execute="M">
  <BehaviorTree ID="M"><Sequence>
    <SubTree ID="S" name="one"/>
    <RetryUntilSuccessful num_attempts="2"><SubTree ID="S"/></RetryUntilSuccessful>
    <ReactiveSequence><IsX/><SubTree ID="T"/></ReactiveSequence>
    <Parallel><SubTree ID="S"/><SubTree ID="T" name="two"/></Parallel>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="S"><Fallback><a/><b name="bee"/></Fallback></BehaviorTree>
  <BehaviorTree ID="T"><Sequence><c name="bee"/><Sleep msec="100000"/><d/></Sequence></BehaviorTree>
</root>"""
ONCE_NAMED = '<Sequence><a name="bee"/><Fallback><b/><c/></Fallback></Sequence>'


def scenarios(folder: Path, tree: str) -> tuple[Forest, dict[str, Any], Kind]:
    """What is written of a tree whose leaves may crash."""
    path = folder / "tree.xml"
    root = f'<root BTCPP_format="4"><BehaviorTree ID="M">{tree}</BehaviorTree></root>'
    path.write_text(tree if "<root" in tree else root)
    forest = read_forest(path, library=("nav2=1.4",))
    made = translate(forest, "m", path.name, faulty=True)
    study = open_study(made.mission)
    found = mocks(made, study.mission_net, study.verdicts(), study.causes())
    return forest, document(found, "m", path.name), made.ledger.kind


class Mocked(Tree):
    """A tree whose leaves answer as substitution rules say."""

    def __init__(self, forest: Forest, rules: dict[str, Any]) -> None:
        super().__init__(forest, frozenset())
        self.rules, self.step = rules, 0
        self.waited: set[str] = set()
        self.paths: dict[str, tuple[str, str | None, str]] = {}
        self.made = 0
        self.number(forest.main.root, "", "")
        self.choose = lambda options: next(o for o in ("in time", "over", *options) if o in options)

    def number(self, of: TreeNode, at: str, prefix: str) -> None:
        """Numbers nodes in the order in which the library makes them."""
        self.made += 1
        own = of.name or f"{of.id}::{self.made}"
        if (tree := tree_of(self.forest, of)) is not None:
            self.number(tree.root, f"{at}/", f"{prefix}{own}/")
        self.paths[at] = (prefix + own, of.name, of.id)
        for place, child in enumerate(of.children):
            self.number(child, f"{at}.{place}", prefix)

    def config(self, at: str) -> dict[str, Any]:
        """What the one rule says that fits."""
        path, name, id_ = self.paths[at]
        fits = {
            rule
            for pattern, rule in self.rules["SubstitutionRules"].items()
            if pattern in (name, id_) or re.fullmatch(re.escape(pattern).replace(r"\?", "."), path)
        }
        (rule,) = fits
        config: dict[str, Any] = self.rules["TestNodeConfigs"][rule]
        return config

    def leaf(self, _: TreeNode, at: str, again: bool) -> str:
        config = self.config(at)
        if self.get(at, "status", IDLE) == RUNNING and "async_delay" not in config:
            return RUNNING
        if self.get(at, "status", IDLE) != RUNNING and "async_delay" in config:
            return RUNNING
        said = config.get("return_status") or self.said(config["return_status_script"])
        if said == "RUNNING":
            return RUNNING
        counted = re.findall(r"== (\d+)", config.get("success_script", "").partition("?")[0])
        self.step += str(self.step) in counted
        return SUCCESS if said == "SUCCESS" else FAILURE

    def said(self, script: str) -> str:
        while parts := re.fullmatch(r"@mcpn_step (==|>=) (\d+) \? (\w+) : \((.*)\)", script):
            turn, number, status, script = parts.groups()
            if self.step == int(number) or (turn == ">=" and self.step > int(number)):
                return status
        return script

    def returned(self) -> str:
        for _ in range(200):
            status = self.tick(self.forest.main.root, "", False)
            if status != RUNNING:
                break
        return status.upper()


def judged(written: dict[str, Any], returned: dict[str, str]) -> int:
    """How many tests there were; each has done what it says."""
    for scenario in written["scenarios"]:
        assert scenario["returns"] in (None, returned[scenario["name"]]), scenario["name"]
        assert scenario["never"] != returned[scenario["name"]], scenario["name"]
    return len(written["scenarios"])


def test_what_is_written(tmp_path: Path) -> None:
    tree = node("ReactiveSequence", X, node("Fallback", A, B))
    _, written, _ = scenarios(tmp_path, tree)
    each = {one["name"]: one for one in written["scenarios"]}
    sets = ("IsX", "a and b")
    runs = [f"failure by {names}" for names in sets]
    assert [*each] == ["nothing fails", "shortest failure", *runs, *(f"without {names}" for names in sets)]
    answers = [(answer["leaf"], answer["answer"]) for answer in each["failure by a and b"]["answers"]]
    assert answers == [("IsX::2", "SUCCESS"), ("a::4", "FAILURE"), ("b::5", "FAILURE")]
    always = each["without a and b"]["rules"]["SubstitutionRules"]
    assert always == {"IsX::2": "succeeds", "a::4": "fails", "b::5": "fails"}
    assert written["left_out"] == []


@pytest.mark.parametrize(
    ("tree", "left_out"),
    [
        (node("RetryUntilSuccessful", A, num_attempts=-1), "only cannot succeed any more"),
        (node("WhileDoElse", X, A, B), "changes its answer"),
        (node("Strange", A), "has runs that the tree has not"),
        (
            node("ReactiveFallback", node("RetryUntilSuccessful", A, num_attempts=2), B),
            "returns between its rounds",
        ),
        (node("ReactiveFallback", node("AsyncFallback", A, B), A), "returns between its rounds"),
        (node("Parallel", '<a name="x"/>', '<a name="x"/>'), "no path of its own"),
    ],
)
def test_what_is_left_out(tree: str, left_out: str, tmp_path: Path) -> None:
    _, written, _ = scenarios(tmp_path, tree)
    assert any(left_out in each["why"] for each in written["left_out"])


def test_what_is_wrong(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, leaf in (("one", "a"), ("other", "b")):
        text = f'<root BTCPP_format="4"><BehaviorTree ID="M"><{leaf}/></BehaviorTree></root>'
        Path(f"{name}.xml").write_text(text)
    mcpn("init", "made", "--from", "one.xml")
    wrong = ["made/mission.xml", "--btcpp", "m.json", "--tree", "other.xml"]
    assert "no objective of other.xml is in this mission" in refused(*wrong)
    assert "need each other" in refused(*wrong[:3])
    assert "either -o or --btcpp" in refused("made/mission.xml")
    assert "no tree 'N'" in refused(*wrong, "--main", "N")
    assert not Path("m.json").exists()


def refused(*arguments: str) -> str:
    found = mcpn("tests", *arguments)
    assert found.returncode == 2
    return found.stderr


def by_ticks(forest: Forest, written: dict[str, Any]) -> int:
    each = written["scenarios"]
    return judged(written, {one["name"]: Mocked(forest, one["rules"]).returned() for one in each})


TWICE_NAMED = {
    "one name, two nodes": node("Sequence", '<a name="x"/>', node("Fallback", '<b name="x"/>', "<c/>")),
    "one name, one node": node("Sequence", '<a name="x"/>', node("Fallback", '<a name="x"/>', B)),
    "one name, again": node("Repeat", node("Sequence", '<a name="x"/>', '<a name="x"/>'), num_cycles=2),
    "one name, beside each other": node("Parallel", '<a name="x"/>', '<b name="x"/>'),
}
TREES = EXACT | TIME | {"subtrees": SUBTREES, "named": ONCE_NAMED} | TWICE_NAMED


@pytest.mark.parametrize("name", TREES)
def test_tests_of_each_kind_of_node(name: str, tmp_path: Path) -> None:
    forest, written, _ = scenarios(tmp_path, TREES[name])
    assert by_ticks(forest, written) >= 1 or name == "nothing"


@given(tree=trees())
def test_tests_of_drawn_trees(tree: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    forest, written, kind = scenarios(tmp_path_factory.mktemp("drawn"), tree)
    if not by_ticks(forest, written):
        returns_early(f"no test of a tree that is {kind.value}")
