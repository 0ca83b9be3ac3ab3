"""Trees played by BehaviorTree.CPP itself, with leaves in Python: PyPI's ``behaviortreepy``.

Leaves answer by chance: at once, some ticks later, or not at all, where they are halted or skipped.
"""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pytest

Player = Callable[[Path, int], "list[Tick]"]


class Tick(NamedTuple):
    """What a tick did.

    Args:
        status: What the root returned.
        seen: The leaves that have answered, with what they did, in order.
        running: The leaves that run then, sorted.
        beside: Places of answers that the mission need not have: what was asked is not seen to run there.
    """

    status: str
    seen: tuple[tuple[str, str], ...]
    running: tuple[str, ...]
    beside: frozenset[int] = frozenset()


LEAVES, CONDITIONS = ("a", "b", "c", "d"), ("IsX", "IsY")
TICKS = 30


def library() -> Any:
    """The library; without it the test is skipped."""
    return pytest.importorskip("behaviortreepy", reason="needs the extra trees: behaviortreepy")


class _Played:
    """One run of a tree."""

    def __init__(self, text: str, seed: int) -> None:
        self.bt = library()
        self.chance = random.Random(seed)
        self.running: dict[int, str] = {}
        self.seen: list[tuple[str, str]] = []
        self.beside: set[int] = set()
        self.ending: int | None = None
        self.reactive = "<Reactive" in text
        self.factory = factory = self.bt.BehaviorTreeFactory()  # which must live as long as the tree
        for name in LEAVES:
            factory.register_simple_stateful_action(name, self.begun, self.asked, self.halted)
        for name in CONDITIONS:
            factory.register_simple_condition(name, lambda node: self.either()[0])
        self.tree = factory.create_tree_from_text(text)
        self.entries = sorted(set(re.findall(r"\bs\d\b", text)))

    def either(self) -> tuple[Any, str]:
        good = self.chance.random() < 0.5
        return (self.bt.NodeStatus.SUCCESS, "success") if good else (self.bt.NodeStatus.FAILURE, "failure")

    def answer(self, node: Any) -> Any:
        status, what = self.either()
        self.seen.append((node.name(), what))
        return status

    def begun(self, node: Any) -> Any:
        if self.chance.randrange(3):
            self.running[node.uid()] = node.name()
            return self.bt.NodeStatus.RUNNING
        # Asked again by a reactive node, a leaf that answers at once is not seen to run in the mission.
        self.beside |= {len(self.seen)} if self.running and self.reactive else set()
        return self.answer(node)

    def asked(self, node: Any) -> Any:
        if node.uid() != self.ending:
            return self.bt.NodeStatus.RUNNING
        self.running.pop(node.uid(), None)
        return self.answer(node)

    def halted(self, node: Any) -> None:
        self.running.pop(node.uid(), None)

    def ticks(self) -> Iterator[Tick]:
        for _ in range(TICKS):
            for entry in self.entries:  # which scripts read
                self.tree.root_blackboard().set_bool(entry, self.chance.random() < 0.3)
            self.seen, self.beside = [], set()
            self.ending = self.chance.choice([*self.running, None])
            status = str(self.tree.tick_exactly_once()).rpartition(".")[2].lower()
            running = tuple(sorted(self.running.values()))
            yield Tick(status, tuple(self.seen), running, frozenset(self.beside))
            if status != "running":
                return


def played(tree: Path, seed: int) -> list[Tick]:
    """What each tick of a tree did, up to its end or for thirty ticks."""
    run = _Played(tree.read_text(), seed)
    found = list(run.ticks())
    run.tree.halt_tree()
    return found


def throws(text: str) -> str | None:
    """What the library says of a tree that it refuses, as it is made or in its first ticks; else ``None``."""
    try:
        for _ in _Played(text, 0).ticks():
            pass
    except RuntimeError as error:
        return str(error)
    return None
