"""Siblings that run for others, in pauses or as these recover, and where success leads from the others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

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
    routes = routes_among(siblings)
    led = (target for handler in around for target in handler.targets)
    return {siblings[0].name, *led}.union(*routes.values())


def routes_among(siblings: Sequence[Block]) -> dict[str, list[str]]:
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
