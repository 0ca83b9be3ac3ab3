"""What is wrong with pauses: siblings that are none, that pause themselves, and names that their copies have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from mcpn.errors import Problem
from mcpn.mission.expansion.helpers import pausing
from mcpn.mission.model import Block, Handler, walk


def pause_problems(siblings: Sequence[Block], text: Sequence[Block]) -> Iterator[Problem]:
    """What is wrong with the pauses of sibling blocks.

    Args:
        siblings: The siblings.
        text: The blocks of their text.
    """
    named = {block.name: block for block in siblings}
    for block in siblings:
        for handler in block.handlers:
            if handler.pause is not None and handler.event is not None:
                yield from _pause(block, handler, named)
    for by, blocks in pausing(siblings).items():
        for other in walk(tuple(text)):
            if other.name.startswith(f"{by}_") and "_at_" in other.name:
                message = f"{other.name} could be the name of a copy of {by}, which is run while"
                yield Problem(other.source, f"{message} {blocks[0].name} pauses: rename it")


def no_siblings(owner: str, handlers: Sequence[Handler], remedy: str) -> Iterator[Problem]:
    """Pauses of what has no siblings."""
    for handler in handlers:
        if handler.pause is not None and handler.event is not None:
            message = f"{owner} pauses on the event {handler.event}, though it has no siblings"
            yield Problem(handler.source, f"{message}: {remedy}")


def _pause(block: Block, handler: Handler, named: Mapping[str, Block]) -> Iterator[Problem]:
    what = f"pause of {block.name} on the event {handler.event}"
    by = named.get(handler.pause or "")
    if by is None or by is block:
        others = ", ".join(name for name in named if name != block.name)
        expected = f"expected one of {others}" if others else "expected a sibling, of which there is none"
        yield Problem(handler.source, f"{what} names {handler.pause}; {expected}")
    elif by.recover is not None or any(other.pause is not None for other in by.handlers):
        does = "recovers by a sibling" if by.recover is not None else "pauses, too"
        yield Problem(handler.source, f"{what} runs {by.name}, which itself {does}: only one of them can")
