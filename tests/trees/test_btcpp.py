"""BehaviorTree.CPP itself against the interpreter of trees, and against the missions that are made of them.

``--btcpp`` names a folder with its sources (:func:`tests.natives.library_of`), for the version of these;
without them it is the one of PyPI's ``behaviortreepy``.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.trees.ledger import Kind
from tests.natives import program_of
from tests.shares import returns_early
from tests.trees.languages import Element, Side, TooMuch, sides
from tests.trees.library import Player, Tick, library, played
from tests.trees.test_import import EXACT, MORE, TIME, imported, trees
from tests.trees.ticking import IDLE, RUNNING, State, Tree, Visible, ticks

NAV2 = {"RecoveryNode", "PipelineSequence", "RoundRobin", "RateController"}
"""Nodes that BehaviorTree.CPP has not."""


@pytest.fixture(scope="session")
def player(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Player:
    """What plays trees in BehaviorTree.CPP."""
    if not request.config.getoption("--btcpp"):
        library()
        return played
    program = program_of("played.cpp", request.config, tmp_path_factory)
    return lambda tree, seed: by_program(program, tree, seed)


def by_program(program: Path, tree: Path, seed: int) -> list[Tick]:
    """What each tick of a tree did."""
    ran = subprocess.run([program, tree, str(seed), "30"], check=True, capture_output=True, text=True)
    found = []
    for line in ran.stdout.splitlines():
        status, seen, running = line.split(";")
        answers = tuple((leaf, how) for leaf, _, how in (each.partition(":") for each in seen.split()))
        found.append(Tick(status.lower(), answers, tuple(running.split())))
    return found


def agree(player: Player, folder: Path, tree: str, seeds: Iterable[int]) -> None:
    """Each run of the library is one of the interpreter, and of the mission if its ledger promises that."""
    made, ticked = imported(folder, tree)
    both = sides(made, ticked)
    promised = made.ledger.kind is not Kind.LEFT_OUT
    for seed in seeds:
        mission = Side(both.mission_moves, both.mission_rest)
        begun: tuple[State, str] = ((), IDLE)
        states = {(begun, mission.closed([((), both.mission.initial)]))}
        for status, seen, running, _ in player(folder / "tree.xml", seed):
            states = {
                ((after, now), _behind(mission, there, shown))
                for (state, _), there in states
                for after, now, shown, answers in ticks(both.tree, state)
                if (now, answers) == (status, seen) and names(both.tree, after) == running
            }
            assert states, (seed, status, seen, running)
            assert not promised or all(there for _, there in states), (seed, seen)
            assert (
                status == RUNNING
                or not promised
                or all((status,) in mission.rests(there) for _, there in states)
            )


def too_new(tree: str, player: Player) -> bool:
    """Whether a tree has a node that PyPI's version has not."""
    return player is played and "<TryCatch" in tree


def _behind(mission: Side, there: frozenset[Element], shown: Iterable[Visible]) -> frozenset[Element]:
    for answer in shown:
        there = mission.behind(there).get(answer, frozenset())
    return there


def names(tree: Tree, state: State) -> tuple[str, ...]:
    """The leaves that run in a state, conditions apart."""
    at = [key.removesuffix(":status") for key, value in state if key.endswith(":status") and value == RUNNING]
    leaves = [tree.leaves[place].id for place in at if place in tree.leaves]
    return tuple(sorted(leaf for leaf in leaves if leaf not in tree.quick))


@pytest.mark.parametrize("name", [*EXACT, *TIME, *MORE])
def test_each_kind_of_node(name: str, player: Player, tmp_path: Path) -> None:
    tree = (EXACT | TIME | MORE)[name]
    if any(f"<{node}" in tree for node in (*NAV2, "Timeout", "Delay", "Strange")) or too_new(tree, player):
        pytest.skip("not of BehaviorTree.CPP, or its time is not free there")
    agree(player, tmp_path, tree, range(10))


@given(tree=trees().filter(lambda tree: not any(f"<{n}" in tree for n in (*NAV2, "Timeout", "Delay"))))
def test_drawn_trees_in_the_library(
    tree: str, player: Player, tmp_path_factory: pytest.TempPathFactory
) -> None:
    if too_new(tree, player):
        returns_early("not of this version")
        return
    try:
        agree(player, tmp_path_factory.mktemp("drawn"), tree, range(5))
    except TooMuch:
        returns_early("too many states")
