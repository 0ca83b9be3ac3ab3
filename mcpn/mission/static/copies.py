"""Which blocks are copies of one that is written once: its rounds, tries, runs and values, and its uses.

Names of copies are those of their block with a number or a value (``visit_3``, ``visit_try2``); what is said
of all copies alike is said once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cached_property
from typing import TypeAlias, TypeVar

from mcpn.mission.expansion.recovery import pausing, recovering
from mcpn.mission.model import Block, Each, Holder, Mission, Use, walk
from mcpn.sentences import shortened

Written: TypeAlias = tuple[str, str]
"""The text that holds a block (a protocol by name; empty for the mission itself), and its name there."""

T = TypeVar("T")
K = TypeVar("K")


class Copies:
    """Tells the copies of the blocks of a mission apart from what is written.

    Args:
        mission: A valid mission.
    """

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self._texts: dict[str, dict[str, Block]] = {}

    def __bool__(self) -> bool:
        """Whether a block has rounds, tries, runs or values, or is run for another."""
        return self._numbers is not None

    def plain(self, name: str) -> str:
        """A name without the numbers and values of copies; uses of protocols still qualify it.

        Args:
            name: Of an objective, a block or a branch, or of an event of an objective.
        """
        if self._numbers is None:
            return name
        return self._numbers.sub(lambda found: next(filter(None, found.groups())), name)

    def written(self, name: str) -> Written:
        """Where the block of this name is written.

        Args:
            name: Of an objective, a block or a branch.
        """
        *around, last = self.plain(name).split(".")
        text = ""
        for block in (self._text(text).get(part) for part in around):
            text = block.protocol if isinstance(block, Use) else text
        return text, last

    def told(self, names: Iterable[str], every: Iterable[str]) -> list[str]:
        """Names in a sentence; where all copies of one are among them, they are one.

        Args:
            names: What is spoken of.
            every: All names of their sort.
        """
        here, found = grouped(dict.fromkeys(names), self.plain), list[str]()
        whole = grouped(every, self.plain) if any(len(of) > 1 for of in here.values()) else {}
        for plain, of in here.items():
            together = len(of) > 1 and set(of) == {name for name in whole.get(plain, ()) if name != plain}
            found += [f"{plain} (all {len(of)})"] if together else of
        return found

    def subject(self, kind: str, names: Collection[str], every: Iterable[str]) -> tuple[str, bool]:
        """What a sentence speaks of ("objectives north.fly, south.fly"), and whether that is plural.

        Args:
            kind: "objective", "block", and so on.
            names: The names of those of that kind.
            every: All names of their sort.
        """
        told = self.told(names, every)
        return f"{kind if len(told) == 1 else f'{kind}s'} {shortened(told)}", len(told) > 1

    def _text(self, protocol: str) -> Mapping[str, Block]:
        """The blocks of a text by name."""
        if protocol not in self._texts:
            blocks = next(
                (p.blocks for p in self.mission.protocols if p.name == protocol), self.mission.blocks
            )
            self._texts[protocol] = {block.name: block for block in walk(blocks)}
        return self._texts[protocol]

    @cached_property
    def _numbers(self) -> re.Pattern[str] | None:
        """Matches block names with the numbers of rounds and tries; ``None`` where no block has any."""
        several = list[str]()
        texts = (self.mission.blocks, *(protocol.blocks for protocol in self.mission.protocols))
        inside = (block for blocks in texts for block in walk(blocks) if isinstance(block, Holder))
        families = [*((None, blocks) for blocks in texts), *((block, block.blocks) for block in inside)]
        for around, blocks in families:
            value = f"_(?:{'|'.join(around.values)})" if isinstance(around, Each) else ""
            aside, shelters = recovering(blocks), pausing(blocks)
            for block in blocks:
                said = value + ("_run[0-9]+" if block.recover else "")
                if recovers := aside.get(block.name):
                    said += f"(?:_(?:{'|'.join(b.name for b in recovers)})[0-9]+)?"
                said += "(?:_at_[A-Za-z0-9_]+?)?" if block.name in shelters else ""
                said += "_[0-9]+" if block.repeat is not None else ""
                said += "_try[0-9]+" if block.retries else ""
                if said:
                    several.append(f"({block.name}){said}")
        return re.compile(rf"(?:(?<=[.])|^)(?:{'|'.join(several)})(?=[.]|$|_EV_)") if several else None


def grouped(these: Iterable[T], by: Callable[[T], K]) -> dict[K, list[T]]:
    """Things by what they have in common, in the order in which they come."""
    found: dict[K, list[T]] = {}
    for each in these:
        found.setdefault(by(each), []).append(each)
    return found
