"""Siblings that run for others, in pauses or as these recover: which they are, and what is wrong with them.

A block that recovers is written out (:mod:`mcpn.mission.passes.recovery`): its runs, and between them copies
of the sibling. So the copies count the recoveries since the block was entered. No route
may lead back to the block, so it is entered at most once in a run of the block around it: the same number is
the count that ``times`` limits.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence

from mcpn.errors import Problem
from mcpn.mission.model import SUCCEED, Block, Handler


def recovering(siblings: Sequence[Block]) -> dict[str, list[Block]]:
    """By name of a sibling that ``recover`` of some block names, the blocks that name it."""
    found: dict[str, list[Block]] = {}
    for block in siblings:
        if block.recover is not None:
            found.setdefault(block.recover, []).append(block)
    return found


def suffixes(recovered: Sequence[Block]) -> Iterator[str]:
    """Suffixes of the names of a recovering sibling's copies: one for each block and each recovery of it."""
    for block in recovered:
        yield from (f"{block.name}{number}" for number in range(1, block.times + 1))


def pausing(siblings: Sequence[Block]) -> dict[str, list[Block]]:
    """By name of a sibling that is run while a block pauses, the blocks that pause for it."""
    found: dict[str, list[Block]] = {}
    for block in siblings:
        for by in {handler.pause: None for handler in block.handlers if handler.pause is not None}:
            found.setdefault(by, []).append(block)
    return found


def helping(siblings: Sequence[Block]) -> set[str]:
    """The siblings by which others recover, or that are run while others pause."""
    return {*recovering(siblings), *pausing(siblings)}


def following(siblings: Sequence[Block]) -> dict[str, str]:
    """Where success leads by default, by name: to the next sibling that does not help others."""
    aside, after, found = helping(siblings), SUCCEED, dict[str, str]()
    aside |= {block.name for block in siblings if block.resumes is not None}
    for block in reversed(siblings):
        found[block.name] = after
        after = after if block.name in aside else block.name
    return found


def entered(siblings: Sequence[Block], around: Sequence[Handler]) -> set[str]:
    """The siblings that are the first, or that a route of one of them, or of a handler around, names."""
    routes = _routes(siblings)
    led = (target for handler in around for target in handler.targets)
    return {siblings[0].name, *led}.union(*routes.values())


def problems(siblings: Sequence[Block], around: Sequence[Handler]) -> Iterator[Problem]:
    """What is wrong with the recoveries among siblings that stand under some handlers."""
    named = {block.name: block for block in siblings}
    pausing_at_last = _pausing_at_last(siblings)
    for number, block in enumerate(siblings):
        yield from _last_runs(block, number, pausing_at_last)
        if block.recover is None:
            if block.times != 1:
                yield Problem(block.source, f"{block.name} has times, though it has no recover")
            continue
        by = named.get(block.recover)
        if by is None or by is block:
            others = ", ".join(name for name in named if name != block.name)
            expected = f"expected one of {others}" if others else "expected a sibling, of which there is none"
            yield Problem(block.source, f"recover of {block.name} names {block.recover}; {expected}")
        elif by.recover is not None:
            message = f"{block.name} recovers by {by.name}, which itself recovers by {by.recover}"
            yield Problem(block.source, f"{message}: only one of them can")
        elif any(handler.pause is not None for handler in by.handlers):
            message = f"{block.name} recovers by {by.name}, which itself pauses"
            yield Problem(block.source, f"{message}: only one of them can")
        elif block.name in _behind(block.name, _routes(siblings), around):
            message = f"{block.name} recovers by {by.name}, and a route leads back to {block.name}"
            remedy = "put it into an objective of its own, whose runs are counted one by one"
            yield Problem(block.source, f"{message}: {remedy}")


def _pausing_at_last(siblings: Sequence[Block]) -> dict[tuple[str, str], int]:
    """By stem and name, the positions of runs whose pauses do not fail as a further run of the same."""
    return {
        (block.stem, block.name): number
        for number, block in enumerate(siblings)
        if any(h.pause and not h.fails_as for h in block.handlers)
    }


def _last_runs(
    block: Block, number: int, pausing_at_last: Mapping[tuple[str, str], int]
) -> Iterator[Problem]:
    """Pauses of a run, as core missions say them, that fail as a block which is no last run of the same."""
    for handler in block.handlers:
        if handler.fails_as is None:
            continue
        last = pausing_at_last.get((block.stem, handler.fails_as), number)
        if handler.pause is None or last <= number:
            expected = "expected, with pause, a later run of the block that pauses and has none"
            yield Problem(handler.source, f"fails_as of {block.name} names {handler.fails_as}; {expected}")


def _behind(name: str, routes: Mapping[str, Sequence[str]], around: Sequence[Handler]) -> Collection[str]:
    """The siblings that routes lead to from the sibling of this name, directly or not, its recovery aside."""
    stack = [*routes[name], *(target for handler in around for target in handler.targets)]
    seen = set[str]()
    while stack:
        if (at := stack.pop()) in routes and at not in seen:
            seen.add(at)
            stack.extend(routes[at])
    return seen


def _routes(siblings: Sequence[Block]) -> dict[str, list[str]]:
    """By name of a sibling, where it leads, and where the sibling that helps it may lead instead of back."""
    after, own = following(siblings), {block.name: _elsewhere(block) for block in siblings}
    found = {}
    for block in siblings:
        routes = [block.success or after[block.name], block.failure, *own[block.name]]
        routes += [route.goto for route in block.routes]
        routes += [guard.otherwise for guard in block.guards]
        if block.recover is not None:
            routes += own.get(block.recover, [])
        for handler in block.handlers:
            routes += own.get(handler.pause or "", [])
        found[block.name] = [route for route in routes if route is not None]
    return found


def _elsewhere(block: Block) -> list[str | None]:
    """Where a block leads otherwise than by success and failure."""
    late = block.timeout_goto
    return [block.abort, late, *(target for handler in block.handlers for target in handler.targets)]
