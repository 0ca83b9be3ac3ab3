"""Where the success of a block leads by default is written out, before anything else is.

So no later pass has to know what stands behind a block, and copies can stand anywhere. Children of a parallel
block have no routes of success.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mcpn.mission.model import Block, Each, Holder, Mission, Recursive
from mcpn.mission.rewriting.siblings import following


def successors(mission: Mission) -> Mission:
    """Blocks say where their success leads: to the next that runs for no other (`success`)."""
    protocols = tuple(replace(each, blocks=_series(each.blocks)) for each in mission.protocols)
    return replace(mission, blocks=_series(mission.blocks), protocols=protocols)


def _series(siblings: tuple[Block, ...]) -> tuple[Block, ...]:
    after = following(siblings)
    return tuple([_led(block, after[block.name]) for block in siblings])


def _led(block: Block, after: str | None = None) -> Block:
    """A block with what stands behind it, if anything, and in it all with what stands behind them."""
    said: dict[str, Any] = {}
    if isinstance(block, Holder):
        series = isinstance(block, Recursive | Each)
        said["blocks"] = _series(block.blocks) if series else tuple(map(_led, block.blocks))
    if after is not None and not (block.success or block.resumes):
        said["success"] = after
    return replace(block, **said) if said else block
