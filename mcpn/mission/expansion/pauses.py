"""Blocks that pause: an event stops what runs in one, a sibling is run, and then it goes on where it was.

It is written out: for each objective of the block there is a copy of the sibling, which the event leads to
while the objective runs, and whose success enters the objective again. So the copy that runs says where the
block was, and nothing else has to remember it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from mcpn.errors import Problem
from mcpn.mission.expansion.recovery import pausing
from mcpn.mission.expansion.scope import Scope
from mcpn.mission.model import Block, Handler, Holder, Parallel, Protocol, Use, walk


def suffix_at(objective: str, scope: Scope) -> str:
    """What tells copies of a sibling apart: the objective that is stopped, named as in their scope."""
    return f"at_{objective.removeprefix(scope.prefix).replace('.', '_')}"


def pause_problems(
    siblings: Sequence[Block], text: Sequence[Block], protocols: Mapping[str, Protocol]
) -> Iterator[Problem]:
    """What is wrong with the pauses of sibling blocks.

    Args:
        siblings: The siblings.
        text: The blocks of their text.
        protocols: All protocols, by name.
    """
    named = {block.name: block for block in siblings}
    for block in siblings:
        for handler in block.handlers:
            if handler.pause is not None:
                yield from _pause(block, handler, named, protocols)
    for by, blocks in pausing(siblings).items():
        for other in walk(tuple(text)):
            if other.name.startswith(f"{by}_") and "_at_" in other.name:
                message = f"{other.name} could be the name of a copy of {by}, which is run while"
                yield Problem(other.source, f"{message} {blocks[0].name} pauses: rename it")


def no_siblings(owner: str, handlers: Sequence[Handler], remedy: str) -> Iterator[Problem]:
    """Pauses of what has no siblings."""
    for handler in handlers:
        if handler.pause is not None:
            message = f"{owner} pauses on the event {handler.event}, though it has no siblings"
            yield Problem(handler.source, f"{message}: {remedy}")


def _pause(
    block: Block, handler: Handler, named: Mapping[str, Block], protocols: Mapping[str, Protocol]
) -> Iterator[Problem]:
    what = f"pause of {block.name} on the event {handler.event}"
    by = named.get(handler.pause or "")
    if by is None or by is block:
        others = ", ".join(name for name in named if name != block.name)
        expected = f"expected one of {others}" if others else "expected a sibling, of which there is none"
        yield Problem(handler.source, f"{what} names {handler.pause}; {expected}")
    elif by.recover is not None or any(other.pause is not None for other in by.handlers):
        does = "recovers by a sibling" if by.recover is not None else "pauses, too"
        yield Problem(handler.source, f"{what} runs {by.name}, which itself {does}: only one of them can")
    if inner := _parallel(block, protocols):
        message = f"{block.name} pauses, and the parallel block {inner} is in it"
        remedy = "let each of its branches pause: put what pauses into an objective there"
        yield Problem(handler.source, f"{message}: {remedy}")


def _parallel(block: Block, protocols: Mapping[str, Protocol]) -> str | None:
    """The name of a parallel block that a block is or holds, uses of protocols expanded."""
    stack, seen = [block], set[str]()
    while stack:
        at = stack.pop()
        if isinstance(at, Parallel):
            return at.name
        if isinstance(at, Holder):
            stack.extend(at.blocks)
        elif isinstance(at, Use) and at.protocol in protocols and at.protocol not in seen:
            seen.add(at.protocol)
            stack.extend(protocols[at.protocol].blocks)
    return None
