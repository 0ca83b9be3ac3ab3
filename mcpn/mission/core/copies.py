"""What names stand for: one home for which blocks are copies of one that is written once.

A block is written once and stands in the mission many times: its rounds, tries, runs and values, its copies
that are run while others pause or recover, and all of these in each use of its protocol. Flattening notes
where every objective stands (:class:`BlockPosition`), and :class:`Copies` answers from that alone which of
them a name means, and by which name all copies of one are named together.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from functools import cached_property
from itertools import accumulate
from typing import TypeAlias, TypeVar

from mcpn.records import record
from mcpn.sentences import shortened

Written: TypeAlias = tuple[str, str]
"""The text that holds a block (a protocol by name; empty for the mission itself), and its name there."""
Path: TypeAlias = tuple[str, ...]
"""A block in one use of its text: the blocks that use protocols around it, then the block, as written."""

MOST_LEFT_OUT = 3
"""Copies, or rounds of copies, that a sentence names to say of which ones it does not speak."""

T = TypeVar("T")
K = TypeVar("K")


@record(frozen=True, slots=True, eq=False)
class BlockPosition:
    """A block in its place, or one copy of it.

    Args:
        prefix: Qualifies its name.
        block: Its name as written.
        suffixes: Tell the copy from others, the outermost first.
        around: The block that it stands in; ``None`` for a block of the mission itself.
        protocol: What it uses; empty for a block of another kind.
        nominal: What its author says of it for runs on which nothing fails.
    """

    prefix: str
    block: str
    suffixes: tuple[str, ...] = ()
    around: BlockPosition | None = None
    protocol: str = ""
    nominal: str = "entered"

    @property
    def names(self) -> Iterator[str]:
        """Its unqualified name as written, then with one suffix more at a time; the last is its own."""
        return accumulate(self.suffixes, "{}_{}".format, initial=self.block)

    @property
    def chain(self) -> Iterator[BlockPosition]:
        """Itself, then the blocks around it."""
        here: BlockPosition | None = self
        while here is not None:
            yield here
            here = here.around

    @property
    def path(self) -> Path:
        """The block, whatever copy of it or of the blocks around this is."""
        _, *around = self.chain
        return *(each.block for each in reversed(around) if each.protocol), self.block

    @property
    def written(self) -> Written:
        """Where the block is written."""
        here, *around = self.chain
        return next((each.protocol for each in around if each.protocol), ""), here.block

    def says(self, parts: list[str], within: str = "") -> int | None:
        """Whether a name says it: its own name, which the blocks around it may qualify, suffixes left out.

        Args:
            parts: The name, taken apart.
            within: What stands before all names of the use of a protocol that the name is written in.

        Returns:
            How many uses of protocols the name leaves out, the outermost; ``None`` if it says something else.
        """
        left, omitted = list(parts), 0
        for each in self.chain:
            if within and each.protocol and f"{each.prefix}{[*each.names][-1]}." == within:
                return None if left else omitted
            if left and left[-1] in each.names:
                left.pop()
            elif each is self or (left and each.protocol):
                return None
            elif each.protocol:
                omitted += 1
        return None if left or within else omitted


class Copies:
    """Tells the copies of the blocks of a mission apart from what is written.

    Attributes:
        objectives: By name where each elementary objective stands, those that no route reaches too.
    """

    def __init__(self) -> None:
        self.objectives: dict[str, BlockPosition] = {}

    def meant(self, name: str, within: str = "") -> list[str]:
        """The objectives that a name means: all copies of one that is written.

        Args:
            name: As written, or of some of the copies (``visit_3``, all tries of it); the blocks around it
                qualify it, as they are written or as copies of them are called. Uses of protocols may be
                left out where one objective is written so: then it is meant in all of them.
            within: What stands before all names of the use of a protocol in which the name is written; there
                it is looked for first.

        Returns:
            Their names; none where the name says no objective, or several.
        """
        return [self._leaves[id(each)] for each in self._said(name, within, self._leaves)]

    def blocks(self, name: str, within: str = "") -> list[str]:
        """The blocks that a name means, each copy of them; arguments as of :meth:`meant`."""
        return [f"{each.prefix}{[*each.names][-1]}" for each in self._said(name, within)]

    def inside(self, name: str, within: str = "") -> list[str]:
        """The objectives in a block that a name means, in all copies of it; arguments as of :meth:`meant`."""
        blocks = {id(each) for each in self._said(name, within)}
        return [
            leaf for leaf, copy in self.objectives.items() if any(id(each) in blocks for each in copy.chain)
        ]

    def _said(self, name: str, within: str, among: Collection[int] | None = None) -> list[BlockPosition]:
        """What a name says, in the use of a protocol that it is written in, else in the whole mission."""
        parts = name.split(".")
        for text in dict.fromkeys((within, "")):
            full, loose = dict[Path, list[BlockPosition]](), dict[Path, list[BlockPosition]]()
            for each in self._by_last.get(parts[-1], ()):
                omitted = None if among is not None and id(each) not in among else each.says(parts, text)
                if omitted is not None:
                    (loose if omitted else full).setdefault(each.path, []).append(each)
            for found in (full, loose):
                exact = {path: these for path, these in found.items() if path[-1] == parts[-1]} or found
                if len({these[0].written for these in exact.values()}) == 1:
                    return [each for these in exact.values() for each in these]
        return []

    def plain(self, name: str) -> str:
        """The one name that means all copies of a block; uses of protocols still qualify it.

        Args:
            name: Of an objective, a block or a branch; or of something else in a text, whose last part is
                kept as it is.
        """
        if (known := self._plain_names.get(name)) is not None:
            return known
        around, dot, last = name.rpartition(".")
        return f"{self.plain(around)}.{last}" if dot else name

    def written(self, name: str) -> Written:
        """Where the block of this name is written.

        Args:
            name: Of an objective, a block or a branch.
        """
        return self._blocks[name].written

    def around(self, objective: str) -> frozenset[Written]:
        """An objective and the blocks that it stands in, as they are written."""
        found, text = list[Written](), ""
        for each in reversed([*self.objectives[objective].chain]):
            found.append((text, each.block))
            text = each.protocol or text
        return frozenset(found)

    @cached_property
    def held(self) -> dict[str, tuple[str, ...]]:
        """By name of a block the objectives that it holds, at any depth, in document order.

        An objective holds itself. A block with copies stands beside them, and holds what they hold.
        """
        found: dict[str, list[str]] = {}
        for objective, position in self.objectives.items():
            for each in position.chain:
                for name in each.names:
                    found.setdefault(f"{each.prefix}{name}", []).append(objective)
        return {name: tuple(objectives) for name, objectives in found.items()}

    def meant_as(self, nominal: str) -> set[str]:
        """The objectives in blocks of which their author says something for runs on which nothing fails.

        Args:
            nominal: What is said, as the attribute of this name says it.
        """
        return set(self._meant.get(nominal, ()))

    @cached_property
    def _meant(self) -> dict[str, set[str]]:
        """By what authors say of blocks the objectives in these blocks."""
        found: dict[str, set[str]] = {}
        for name, position in self.objectives.items():
            for each in position.chain:
                found.setdefault(each.nominal, set()).add(name)
        return found

    def told(self, names: Iterable[str], every: Iterable[str]) -> list[str]:
        """Names in a sentence; all copies of one, most of them, or all of one round are said together.

        Args:
            names: What is spoken of.
            every: All names of their sort.
        """
        here, found = grouped(dict.fromkeys(names), self.plain), list[str]()
        whole = grouped(every, self.plain) if any(len(named) > 1 for named in here.values()) else {}
        for plain, named in here.items():
            copies = [name for name in dict.fromkeys(whole.get(plain, ())) if name not in self.wholes]
            spoken = {name for name in named if name not in self.wholes}
            together = self._together(named, copies)
            left = self._together([name for name in copies if name not in spoken], copies)
            if len(named) > 1 and {*copies} == spoken:
                found.append(f"{plain} (all {len(copies)})")
            elif 0 < len(left) <= MOST_LEFT_OUT and 2 * len(left) < len(together) and spoken < {*copies}:
                found.append(f"{plain} (all {len(copies)} but {', '.join(left)})")
            else:
                found += (
                    f"{name} (all {len(members)})" if len(members) > 1 else name
                    for name, members in together.items()
                )
        return found

    def _together(self, names: Collection[str], copies: Collection[str]) -> dict[str, list[str]]:
        """Copies of one block by the name that means no other copy of it, nor fewer of these."""
        meant: dict[str, set[str]] = {}
        for copy in copies:
            for name in self._shorter(copy):
                meant.setdefault(name, set()).add(copy)
        found: dict[str, list[str]] = {}
        for copy in names:
            among = (name for name in self._shorter(copy) if meant.get(name, {""}) <= {*names})
            name = next(among, copy)
            found.setdefault(name, []).append(copy)
        return {(members[0] if len(members) == 1 else name): members for name, members in found.items()}

    def _shorter(self, name: str) -> Iterator[str]:
        """The names of a copy without some or all of its own suffixes, the shortest first."""
        position = self._blocks.get(name)
        return iter(()) if position is None else (f"{position.prefix}{own}" for own in position.names)

    def subject(self, kind: str, names: Collection[str], every: Iterable[str]) -> tuple[str, bool]:
        """What a sentence speaks of ("objectives north.fly, south.fly"), and whether that is plural.

        Args:
            kind: "objective", "block", and so on.
            names: The names of those of that kind.
            every: All names of their sort.
        """
        told = self.told(names, every)
        return f"{kind if len(told) == 1 else f'{kind}s'} {shortened(told)}", len(told) > 1

    @cached_property
    def _leaves(self) -> dict[int, str]:
        """The objectives, by the identity of their position."""
        return {id(position): name for name, position in self.objectives.items()}

    @cached_property
    def _by_last(self) -> dict[str, list[BlockPosition]]:
        """By each unqualified name, with some or all suffixes, what it may say."""
        found: dict[str, list[BlockPosition]] = {}
        for position in self._positions:
            for name in position.names:
                found.setdefault(name, []).append(position)
        return found

    @cached_property
    def _blocks(self) -> dict[str, BlockPosition]:
        """By name every block and copy of one, those that stand for several copies too."""
        found: dict[str, BlockPosition] = {}
        for position in self._positions:
            for name in position.names:
                found.setdefault(f"{position.prefix}{name}", position)
        return found

    @cached_property
    def _positions(self) -> list[BlockPosition]:
        found: dict[int, BlockPosition] = {}
        for objective in self.objectives.values():
            for each in objective.chain:
                if id(each) in found:
                    break
                found[id(each)] = each
        return [*found.values()]

    @cached_property
    def wholes(self) -> set[str]:
        """Names of blocks that stand for several copies, and of no copy by itself."""
        copies = {f"{each.prefix}{[*each.names][-1]}" for each in self._positions}
        return self._blocks.keys() - copies

    @cached_property
    def _plain_names(self) -> dict[str, str]:
        """By name of a block the one that means all its copies: what qualifies each of them qualifies it."""
        shown: dict[Path, list[str]] = {}
        paths: dict[int, Path] = {}
        for position in self._positions:
            _, *around = position.chain
            own = [each.block for each in reversed(around) if each.protocol or each.suffixes]
            path = paths[id(position)] = position.path
            shown[path] = [name for name in shown[path] if name in own] if path in shown else own
        plain = {path: ".".join((*around, path[-1])) for path, around in shown.items()}
        return {name: plain[paths[id(position)]] for name, position in self._blocks.items()}


def grouped(these: Iterable[T], by: Callable[[T], K]) -> dict[K, list[T]]:
    """Things by what they have in common, in the order in which they come."""
    found: dict[K, list[T]] = {}
    for each in these:
        found.setdefault(by(each), []).append(each)
    return found
