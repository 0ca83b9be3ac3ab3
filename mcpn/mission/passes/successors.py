"""Where the success of a block leads by default is written out, before anything else is.

So no later pass has to know what stands behind a block, and copies can stand anywhere. Children of a parallel
block have no routes of success.
"""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import Block, Each, Holder, Mission, Recursive
from mcpn.mission.rewriting.siblings import following


def successors(mission: Mission) -> Mission:
    """Blocks say where their success leads: to the next that runs for no other (`success`)."""
    protocols = tuple(replace(each, blocks=_series(each.blocks)) for each in mission.protocols)
    return replace(mission, blocks=_series(mission.blocks), protocols=protocols)


def _series(siblings: tuple[Block, ...]) -> tuple[Block, ...]:
    after = following(siblings)
    return tuple([_led(_inside(block), after[block.name]) for block in siblings])


def _led(block: Block, after: str) -> Block:
    return block if block.success or block.resumes else replace(block, success=after)


def _inside(block: Block) -> Block:
    if isinstance(block, Recursive | Each):
        return replace(block, blocks=_series(block.blocks))
    return replace(block, blocks=tuple(map(_inside, block.blocks))) if isinstance(block, Holder) else block
