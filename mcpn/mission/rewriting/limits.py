"""How large a mission may be when its copies are written out: measured before any copy is made."""

from __future__ import annotations

from collections.abc import Iterable
from math import prod

from mcpn.errors import LimitError, Problem, Source
from mcpn.mission.model import Block, Each, Mission, Objective, Protocol, Use
from mcpn.mission.rewriting.siblings import recovering

MAX_NESTING = 128
MAX_OBJECTIVES = 100_000
MAX_PARAMETERS = 1_000_000


def limit_hit(what: str, source: Source | None) -> LimitError:
    """The error that a limit of the written-out mission was hit, with the line of the block that hit it."""
    return LimitError(str(Problem(source, f"{what}: the limit was hit")))


class Counted:
    """Counts the objectives that are written out, and their parameters."""

    def __init__(self) -> None:
        self.objectives = 0
        self.parameters = 0

    def add(self, parameters: int, source: Source | None) -> None:
        """Counts one objective.

        Raises:
            LimitError: It is one too many.
        """
        self.objectives += 1
        self.parameters += parameters
        if self.objectives > MAX_OBJECTIVES:
            raise limit_hit(f"more than {MAX_OBJECTIVES} objectives after expansion", source)
        if self.parameters > MAX_PARAMETERS:
            raise limit_hit(f"more than {MAX_PARAMETERS} parameters of objectives after expansion", source)


def measure(mission: Mission) -> None:
    """Refuses a mission that would be too deep or too large; copies for pauses come on top.

    Raises:
        LimitError: It would be, with the line of a block that is too deep or one too many.
    """
    measuring = _Measuring(mission)
    measuring.depth(mission.blocks, 0)
    if measuring.series(mission.blocks) > MAX_OBJECTIVES:
        measuring.refuse(mission.blocks)


class _Measuring:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.depths: dict[str, int] = {}
        """By protocol how deep it is."""
        self.sizes: dict[str, int] = {}
        """By protocol how many objectives one use of it is."""
        self.helping: dict[int, int] = {}
        """By identity of a block of how many recoveries of its siblings it runs in."""

    def inside(self, block: Block) -> tuple[Block, ...]:
        """What a block holds, or uses."""
        if isinstance(block, Use):
            return self.protocols[block.protocol].blocks
        return () if isinstance(block, Objective) else block.blocks

    def depth(self, blocks: Iterable[Block], around: int) -> int:
        """How many blocks and copies of them stand around the innermost one, those around these included."""
        return max((self.deepest(block, around) for block in blocks), default=around)

    def deepest(self, block: Block, around: int) -> int:
        depth = around + sum(number > 0 for number in _kinds(block))
        depth += not isinstance(block, Objective)
        if depth > MAX_NESTING:
            raise limit_hit(f"blocks nested more than {MAX_NESTING} deep after expansion", block.source)
        if isinstance(block, Use) and depth + self.depths.get(block.protocol, MAX_NESTING) <= MAX_NESTING:
            return depth + self.depths[block.protocol]
        found = self.depth(self.inside(block), depth)
        if isinstance(block, Use):
            self.depths[block.protocol] = found - depth
        return found

    def series(self, blocks: Iterable[Block]) -> int:
        """How many objectives some siblings are."""
        for by, recovered in recovering(siblings := tuple(blocks)).items():
            recoveries = sum(block.times for block in recovered)
            self.helping |= {id(block): recoveries for block in siblings if block.name == by}
        return sum(self.size(block) for block in siblings)

    def size(self, block: Block) -> int:
        return self.copies(block) * self.of_copy(block)

    def copies(self, block: Block) -> int:
        """How many copies a block has, the one counted that it is without any."""
        return prod(number or 1 for number in _kinds(block)) * max(1, self.helping.get(id(block), 0))

    def of_copy(self, block: Block) -> int:
        """How many objectives one copy of a block is."""
        if isinstance(block, Objective):
            return 1
        if not isinstance(block, Use):
            return self.series(block.blocks)
        if block.protocol not in self.sizes:
            self.sizes[block.protocol] = self.series(self.inside(block))
        return self.sizes[block.protocol]

    def refuse(self, blocks: tuple[Block, ...]) -> None:
        """Finds the objective that is one too many, or the block that has too many copies.

        Raises:
            LimitError: With its line.
        """
        left = MAX_OBJECTIVES  # so many may still come
        while True:
            for block in blocks:
                if max(self.copies(block), *_kinds(block)) > MAX_OBJECTIVES or self.size(block) > left:
                    break
                left -= self.size(block)
            if max(_kinds(block)) > MAX_OBJECTIVES or isinstance(block, Objective):
                raise limit_hit(f"more than {MAX_OBJECTIVES} objectives after expansion", block.source)
            blocks, left = self.inside(block), left % self.of_copy(block)


def _kinds(block: Block) -> tuple[int, int, int, int]:
    """Of each kind of copies how many a block has; 0 where it has none of the kind."""
    runs = block.times + 1 if block.recover is not None else 0
    tries = block.retries + 1 if block.retries else 0
    return runs, block.repeat or 0, tries, len(block.values) if isinstance(block, Each) else 0
