"""Where a failure for a reason leads is said by each block that it leaves, if somebody has a route for it.

A failure finds its route by its reason through all blocks that it leaves. Written out, a block has routes for
the reason of which the last always counts, and ``fail no_path`` is an exit: the block around fails for that
reason, too. A copy leaves all copies where the whole block has a route for the reason; else it fails as ever.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

from mcpn.mission.model import (
    FAIL,
    Block,
    FactRoute,
    Mission,
    Objective,
    Parallel,
    Recursive,
    failing_for,
    walk,
)
from mcpn.mission.reasons import reason


def named_failures(mission: Mission) -> Mission:
    """Blocks say where each failure for a reason leads, also where it fails what is around (`reason`)."""
    if not any(route.reason for block in walk(mission.blocks) for route in block.routes):
        return mission
    return replace(mission, blocks=_series(mission.blocks, _AskedAround()))


class _AskedAround(NamedTuple):
    """What stands around some blocks.

    Args:
        stem: The stem of the block around: those of the same are copies of it.
        asked: The reasons for which somebody around may have a route.
        own: Of these, the routes of the block around as its author wrote them, of a copy those of the whole.
    """

    stem: str = ""
    asked: Collection[str] = ()
    own: Mapping[str, tuple[FactRoute, ...]] = {}


def _series(blocks: tuple[Block, ...], around: _AskedAround) -> tuple[Block, ...]:
    return tuple([_block(block, around) for block in blocks])


def _block(block: Block, around: _AskedAround) -> Block:
    if isinstance(block, Parallel):
        return replace(
            block, blocks=_series(block.blocks, _AskedAround())
        )  # it fails as a whole, for no reason
    own = dict[str, tuple[FactRoute, ...]]()
    for route in block.routes:
        if route.reason is not None:
            own[route.reason] = (*own.get(route.reason, ()), route)
    asked = [name for name in _reasons(block) if name in around.asked or name in own]
    if not asked:
        routes = block.routes
    else:
        routes = tuple(route for route in block.routes if route.reason is None)
        routes += tuple(route for name in asked for route in _led(block, name, own.get(name, ()), around))
    if isinstance(block, Recursive):
        whole = own or (around.own if block.stem == around.stem else {})
        return replace(
            block, routes=routes, blocks=_series(block.blocks, _AskedAround(block.stem, asked, whole))
        )
    return replace(block, routes=routes)


def _reasons(block: Block) -> dict[str, None]:
    """The reasons for which a block may fail."""
    if isinstance(block, Objective):
        return {reason(text).name: None for text in block.failures}
    inside = block.blocks if isinstance(block, Recursive) else ()
    return {name: None for each in inside for name in _reasons(each)}


def _led(block: Block, name: str, own: tuple[FactRoute, ...], around: _AskedAround) -> Iterator[FactRoute]:
    """The routes of a block for a reason, up to the first that always counts."""
    fail = failing_for(name) if name in around.asked else FAIL
    routes = [replace(route, goto=fail if route.goto == FAIL else route.goto) for route in own]
    failure = block.failure or FAIL
    if not own and block.stem == around.stem and failure != FAIL:  # a copy, before others
        routes += (replace(route, goto=fail) for route in around.own.get(name, ()))
    else:  # of copies nothing but this is said
        unnamed = (route for route in block.routes if route.on == "failure" and route.reason is None)
        routes += (replace(r, reason=name, goto=fail if r.goto == FAIL else r.goto) for r in unnamed)
    always = FactRoute(
        on="failure", reason=name, goto=fail if failure == FAIL else failure, source=block.source
    )
    for route in (*routes, always):
        yield route
        if not route.when:
            return
