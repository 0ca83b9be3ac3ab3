"""Tests of a tree, as BehaviorTree.CPP itself plays them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from mcpn.trees.nodes.forest import Forest, tree_of
from tests.natives import program_of
from tests.shares import returns_early
from tests.trees.test_btcpp import NAV2
from tests.trees.test_import import trees
from tests.trees.test_mocks import TREES, judged, scenarios


@pytest.fixture(scope="session")
def mocked(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program that plays them in BehaviorTree.CPP."""
    return program_of("mocked.cpp", request.config, tmp_path_factory)


def in_library(mocked: Path, folder: Path, forest: Forest, written: dict[str, Any]) -> int:
    (folder / "mocks.json").write_text(json.dumps(written))
    leaves: dict[str, set[str]] = {}
    for tree in forest.trees.values():
        for each in tree.root.walk():
            if not each.children and tree_of(forest, each) is None and each.id not in BUILT_IN:
                leaves.setdefault(each.id, set()).update(each.ports)
    said = [":".join((leaf, *sorted(ports))) for leaf, ports in leaves.items()]
    command = [str(mocked), str(folder / "tree.xml"), str(folder / "mocks.json"), forest.main.id, *said]
    ran = subprocess.run(command, check=True, capture_output=True, text=True)
    returned = dict(line.rsplit(";", 1) for line in ran.stdout.splitlines())
    return judged(written, returned)


BUILT_IN = ("AlwaysSuccess", "AlwaysFailure", "Script", "SetBlackboard", "Sleep")


@pytest.mark.parametrize("name", TREES)
def test_the_library_plays_them(name: str, mocked: Path, tmp_path: Path) -> None:
    if any(f"<{each}" in TREES[name] for each in NAV2):
        pytest.skip("not of BehaviorTree.CPP")
    forest, written, _ = scenarios(tmp_path, TREES[name])
    in_library(mocked, tmp_path, forest, written)


@given(tree=trees().filter(lambda tree: not any(f"<{n}" in tree for n in NAV2)))
def test_the_library_plays_those_of_drawn_trees(
    tree: str, mocked: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("drawn")
    forest, written, kind = scenarios(folder, tree)
    if not in_library(mocked, folder, forest, written):
        returns_early(f"no test of a tree that is {kind.value}")
