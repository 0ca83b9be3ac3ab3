"""What each node of a tree became in the mission, and which answers survive that."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

from mcpn.errors import Problem
from mcpn.mission.model import Translated
from mcpn.trees.nodes.node import TreeNode


class Kind(Enum):
    """How faithful the translation of a node is; later ones are weaker.

    Ticks are forgotten throughout: leaves end one at a time, some time after they began. What leaves answer,
    conditions among them, is free, as it is in a tree without its robot.
    """

    EXACT = "exact"
    TIME = "time"
    MORE = "more"
    LEFT_OUT = "left_out"


WORDS = {
    Kind.EXACT: "exact",
    Kind.TIME: "exact but for time",
    Kind.MORE: "more runs",
    Kind.LEFT_OUT: "left out",
}
"""Each kind, as people read it."""


@dataclass(frozen=True, slots=True)
class LedgerEntry:
    """A line of the ledger.

    Args:
        node: The node of the tree.
        became: What it is in the mission: the name of a block, or words.
        kind: How faithful that is.
        why: What differs, in a sentence; empty where nothing does.
    """

    node: TreeNode
    became: str
    kind: Kind
    why: str = ""


@dataclass(frozen=True, slots=True)
class Ledger:
    """The ledger of one import.

    Args:
        file: The file of the tree, as it is called.
        entries: One for each node, in the order of the trees.
        read_as: The libraries and versions as which it was read.
        warnings: What was read though a library or XML would not have it so.
    """

    file: str
    entries: tuple[LedgerEntry, ...]
    read_as: str = ""
    warnings: tuple[Problem, ...] = ()

    @property
    def counts(self) -> dict[Kind, int]:
        """How many nodes of each kind."""
        found = Counter(entry.kind for entry in self.entries)
        return {kind: found[kind] for kind in Kind}

    @property
    def inexact(self) -> tuple[LedgerEntry, ...]:
        """The nodes of which the mission says something else, or less."""
        return tuple(entry for entry in self.entries if entry.kind is not Kind.EXACT)

    @property
    def kind(self) -> Kind:
        """The weakest kind of all nodes."""
        return max((entry.kind for entry in self.entries), key=list(Kind).index, default=Kind.EXACT)


SURVIVES = {
    Kind.EXACT: "Every answer of check holds of the tree, whatever its leaves answer, with ticks forgotten.",
    Kind.TIME: "Every answer holds of the tree where nothing is said about time: a period, a delay or a "
    "timeout may be over at any moment.",
    Kind.MORE: "The mission has all runs of the tree, and more. What it can never do the tree can never do: "
    "failure that is unreachable, LTL and AG formulas that hold, freedom from being stuck. Cut sets "
    "that are found are real, though the tree may need less. That success is reachable, or that the end "
    "always is, does not carry over.",
    Kind.LEFT_OUT: "Parts of the tree are left out of the mission: no answer carries over without a look at "
    "them.",
}
"""Which answers about the mission hold of the tree."""


def of_translated(translated: Translated) -> tuple[str, str]:
    """What a mission says of the tree that it was made of: how much is exact, and what survives that."""
    found = Counter(Kind(each.kind) for each in translated.approximations)
    found[Kind.EXACT] = translated.exact
    counted = ", ".join(f"{WORDS[kind]} {found[kind]}" for kind in Kind if found[kind])
    weakest = max(found, key=list(Kind).index)
    read_as = f". Read as {translated.library}" if translated.library else ""
    return f"made of {translated.tree}, {found.total()} nodes: {counted}{read_as}", SURVIVES[weakest]


def in_words(ledger: Ledger) -> str:
    """The ledger as a text: counts, what survives, then a line for each node."""
    counted = ", ".join(f"{WORDS[kind]}: {count}" for kind, count in ledger.counts.items() if count)
    lines = [
        f"{ledger.file}: {len(ledger.entries)} nodes. {counted}.",
        *([f"Read as {ledger.read_as}."] if ledger.read_as else []),
        SURVIVES[ledger.kind],
        *(f"warning: {placed(each, ledger.file)}" for each in ledger.warnings),
        "",
    ]
    width = max((len(entry.node.title) for entry in ledger.entries), default=0)
    lines += [_line(entry, width) for entry in ledger.entries]
    return "\n".join(lines) + "\n"


def placed(problem: Problem, file: str) -> str:
    """A warning with its file, by its name alone, and its line; of ``file`` where it has none of its own."""
    at = f"{Path(problem.source.file).name}:{problem.source.line}" if problem.source else file
    return f"{at}: {problem.message}"


def _line(entry: LedgerEntry, width: int) -> str:
    at = entry.node.source.line
    why = f" ({entry.why})" if entry.why else ""
    return f"line {at:>4}  {entry.node.title:{width}}  {WORDS[entry.kind]}: {entry.became}{why}"


def in_order(entries: Iterable[LedgerEntry]) -> tuple[LedgerEntry, ...]:
    """Entries in the order of files and lines; of a node that was translated twice the weakest one."""
    order = list(Kind)
    found: dict[int, LedgerEntry] = {}
    for entry in entries:
        before = found.get(id(entry.node))
        if before is None or order.index(entry.kind) > order.index(before.kind):
            found[id(entry.node)] = entry
    places = {key: place for place, key in enumerate(found)}
    return tuple(
        sorted(
            found.values(), key=lambda e: (e.node.source.file, e.node.source.line or 0, places[id(e.node)])
        )
    )
