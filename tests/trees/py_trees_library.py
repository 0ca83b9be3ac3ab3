"""Trees played by py_trees itself, of PyPI, which makes them of the same XML.

Leaves answer by chance: at once, some ticks later, or not at all, where they are interrupted.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any, ClassVar

import pytest

from tests.trees.library import CONDITIONS, LEAVES, TICKS, Tick


def library() -> Any:
    """The library; without it the test is skipped."""
    pytest.importorskip("py_trees.parsers", reason="needs the extra trees: py_trees 2.6")
    return pytest.importorskip("py_trees")


class _Played:
    """One run of a tree."""

    made_now: ClassVar[_Played]
    """The run whose tree is made, for its leaves."""

    def __init__(self, tree: Path, seed: int) -> None:
        self.chance = random.Random(seed)
        self.running: dict[int, str] = {}
        self.seen: list[tuple[str, str]] = []
        self.answers = 0
        self.ending: int | None = None
        _Played.made_now = self
        text = tree.read_text()
        # Without memory children are asked again, and a parallel node asks all that run, whatever ends it.
        self.unseen = "<Parallel" in text or 'memory="false"' in text
        self.root = library().parsers.behaviour_tree_xml.parse_behaviour_tree_xml(
            str(tree), node_registry=_leaves()
        )

    def asked(self, leaf: int, name: str, *, begins: bool) -> str:
        """What a leaf returns."""
        quick = name in CONDITIONS
        if not quick and (self.chance.randrange(3) > 0 if begins else leaf != self.ending):
            self.running[leaf] = name
            return "RUNNING"
        self.running.pop(leaf, None)
        answer = self.chance.choice(("success", "failure"))
        self.answers += 1
        if not quick:
            self.seen.append((name, answer))
        return answer.upper()

    def ticks(self) -> Iterator[Tick]:
        for _ in range(TICKS):
            self.seen, self.answers = [], 0
            self.ending = self.chance.choice([*self.running, None])
            self.root.tick_once()
            status = self.root.status.name.lower()
            unseen = frozenset(range(len(self.seen)) if self.unseen and self.answers > 1 else ())
            yield Tick(status, tuple(self.seen), tuple(sorted(self.running.values())), unseen)
            if status != "running":
                return


@cache
def _leaves() -> dict[str, type]:
    """A class of leaves for each name, as the parser wants them: with ports, though they have none.

    py_trees keeps each class by its name and warns of another of the same name: these are for all runs.
    """
    py_trees: Any = library()

    class Leaf(py_trees.ports.PortsMixin, py_trees.behaviour.Behaviour):  # type: ignore[misc]
        INPUT_PORTS: dict[str, object] = {}  # noqa: RUF012
        OUTPUT_PORTS: dict[str, object] = {}  # noqa: RUF012
        KIND = ""

        def __init__(self, name: str, **_: object) -> None:
            super().__init__(name=name)
            self.run = _Played.made_now

        def update(self) -> Any:
            begins = self.status != py_trees.common.Status.RUNNING
            return py_trees.common.Status[self.run.asked(id(self), self.KIND, begins=begins)]

        def terminate(self, new_status: Any) -> None:
            if new_status == py_trees.common.Status.INVALID:
                self.run.running.pop(id(self), None)

    return {kind: type(f"Leaf_{kind}", (Leaf,), {"KIND": kind}) for kind in (*LEAVES, *CONDITIONS)}


def played(tree: Path, seed: int) -> list[Tick]:
    """What each tick of a tree did, up to its end or for thirty ticks."""
    return list(_Played(tree, seed).ticks())


def throws(tree: Path) -> str | None:
    """What the library says of a tree that it refuses, as it is made or in its first ticks; else ``None``."""
    try:
        played(tree, 0)
    except Exception as error:
        return str(error) or type(error).__name__
    return None
