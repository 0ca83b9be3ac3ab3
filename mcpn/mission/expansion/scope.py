"""What the blocks of one text take from around them, as they are written out: names, parameters, handlers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from mcpn.errors import LimitError, Problem, Source
from mcpn.mission.expansion.copies import BlockPosition
from mcpn.mission.expansion.routes import Interruption
from mcpn.mission.graph import TIMED_OUT
from mcpn.mission.model import ROUND, Block, Each, Protocol, Use
from mcpn.mission.robot import Parameter

MAX_NESTING = 128
MAX_OBJECTIVES = 20_000


@dataclass(frozen=True, slots=True)
class Scope:
    """What the blocks of a mission, or of one use of a protocol, inherit from the blocks that enclose them.

    Args:
        prefix: Stands before the names of blocks.
        suffixes: Stand after them; tell the copies of a block for each round or try, the outermost first.
        around: The innermost block that encloses them.
        depth: How many blocks enclose them.
        parameters: By name, the value that the innermost enclosing block (or use, or round) gives.
        defaults: By name, the default of the innermost enclosing protocol; used where no block gives a value.
        handlers: Handlers of enclosing blocks, up to the mission or the branch of a parallel block, innermost
            first.
        text: The name of the protocol; empty in the mission itself.
    """

    prefix: str = ""
    suffixes: tuple[str, ...] = ()
    around: BlockPosition | None = None
    depth: int = 0
    parameters: Mapping[str, Parameter] = field(default_factory=dict)
    defaults: Mapping[str, Parameter] = field(default_factory=dict)
    handlers: tuple[Interruption, ...] = ()
    text: str = ""

    def name(self, block: Block) -> str:
        """The qualified name of a block that stands here."""
        return f"{self.prefix}{'_'.join((block.name, *self.suffixes))}"

    def position(self, block: Block) -> BlockPosition:
        """Where a block stands here."""
        protocol = block.protocol if isinstance(block, Use) else ""
        return BlockPosition(self.prefix, block.name, self.suffixes, self.around, protocol, block.nominal)

    def written_at(self, block: str, event: str) -> str:
        """Where a handler is written in this text, whichever copy of its block happens to run."""
        return ".".join(filter(None, (self.text, block, event)))

    @property
    def interruptions(self) -> tuple[Interruption, ...]:
        """Handlers that can take effect here: of each event up to the first that may happen again."""
        closed: set[str] = set()
        found = []
        for handler in self.handlers:
            if handler.event not in closed:
                found.append(handler)
            if handler.once is None:
                closed.add(handler.event)
        return tuple(found)

    def in_force(self, own: tuple[Parameter, ...]) -> tuple[Parameter, ...]:
        """All parameters of an objective in this scope: its own, else those around it, else defaults."""
        return tuple({**self.defaults, **_overridden(self.parameters, own)}.values())

    def into(self, block: Block, parameters: tuple[Parameter, ...] = ()) -> Scope:
        """The scope of what a block holds in the same text; names inside a copy are qualified by its name."""
        prefix = f"{self.name(block)}." if self.suffixes else self.prefix
        return replace(
            self,
            prefix=prefix,
            suffixes=(),
            around=self.position(block),
            depth=self.deeper(block),
            parameters=_overridden(self.parameters, parameters),
        )

    def into_protocol(self, use: Use, protocol: Protocol) -> Scope:
        """The scope of a protocol's text as one use of it sees it."""
        return replace(
            self,
            prefix=f"{self.name(use)}.",
            suffixes=(),
            around=self.position(use),
            depth=self.deeper(use),
            parameters=_overridden(self.parameters, use.parameters),
            defaults=_overridden(self.defaults, protocol.parameters),
            text=protocol.name,
        )

    def copy(self, block: Block, suffix: str, value: Parameter | None = None) -> Scope:
        """The scope of one copy of a block, or of what stands in one round of it."""
        merged = _overridden(self.parameters, (value,) if value else ())
        return replace(self, suffixes=(*self.suffixes, suffix), depth=self.deeper(block), parameters=merged)

    def deeper(self, block: Block) -> int:
        """The depth inside a block."""
        if self.depth >= MAX_NESTING:
            raise limit_hit(f"blocks nested more than {MAX_NESTING} deep after expansion", block.source)
        return self.depth + 1


def _overridden(around: Mapping[str, Parameter], inner: tuple[Parameter, ...]) -> Mapping[str, Parameter]:
    """Parameters by name: those around, overridden by the inner ones."""
    return {**around, **{p.name: p for p in inner}} if inner else around


def limit_hit(what: str, source: Source | None) -> LimitError:
    """The error that a limit of the written-out mission was hit, with the line of the block that hit it."""
    return LimitError(str(Problem(source, f"{what}: the limit was hit")))


def unrouted(block: Block, **also: Any) -> Block:
    """A block without what leads from it, or to it: that stands on what is written out in its place.

    Args:
        block: The block.
        **also: What else is different.
    """
    return replace(block, success=None, failure=None, abort=None, guards=(), routes=(), handlers=(), **also)


def several(block: Block) -> bool:
    """Whether a block stands for several copies, one after the other."""
    each = isinstance(block, Each) and block.timeout is None
    return bool(block.recover or block.repeat is not None or block.retries) or each


def copies(block: Block, scope: Scope) -> Iterator[tuple[tuple[Block, ...], Scope]]:
    """The runs of a block that recovers, else its rounds, else its tries, else its values.

    Yields for each copy the blocks that run in it, without the routes of the whole, and their scope.
    """
    most = max(block.times + 1 if block.recover is not None else 0, block.repeat or 0, block.retries + 1)
    if max(most, len(block.values) if isinstance(block, Each) else 0) > MAX_OBJECTIVES:
        raise limit_hit(f"more than {MAX_OBJECTIVES} objectives after expansion", block.source)
    # A timeout leads out of all copies, not to the next.
    alone = partial(unrouted, block, timeout_goto=block.timeout_goto and TIMED_OUT)
    if block.recover is not None:
        run = alone(recover=None, times=1)
        for number in range(1, block.times + 2):
            yield (run,), scope.copy(block, f"run{number}")
    elif block.repeat is not None:
        round_ = alone(repeat=None)
        for number in range(1, block.repeat + 1):
            value = Parameter(name=ROUND, value=str(number), source=block.source)
            yield (round_,), scope.copy(block, str(number), value)
    elif block.retries:
        attempt = alone(retries=0)
        for number in range(1, block.retries + 2):
            yield (attempt,), scope.copy(block, f"try{number}")
    elif isinstance(block, Each):
        inside = scope.into(block)
        for text in block.values:
            value = Parameter(name=block.bound, value=text, source=block.source)
            yield block.blocks, inside.copy(block, text, value)
