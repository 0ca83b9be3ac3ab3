"""What passes have in common: every block is rewritten in its place, and stands on another in its place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any

from mcpn.mission.model import Block, BlockElement, Handler, Holder, Mission, Objective, Recursive

_EVERY = tuple(field.name for field in fields(BlockElement))


def rewritten(mission: Mission, rewrite: Callable[[Block], Block]) -> Mission:
    """A mission in which each block, at any depth, is rewritten, those inside first; the same where none is.

    Args:
        mission: The mission.
        rewrite: Gives what stands in the place of a block, perhaps the block.
    """
    blocks = everywhere(mission.blocks, rewrite)
    return mission if blocks is mission.blocks else replace(mission, blocks=blocks)


def everywhere(blocks: tuple[Block, ...], rewrite: Callable[[Block], Block]) -> tuple[Block, ...]:
    """Blocks of one text, each rewritten, at any depth; see :func:`rewritten`."""
    made = tuple([_rewritten(block, rewrite) for block in blocks])
    return blocks if all(new is old for new, old in zip(made, blocks, strict=True)) else made


def _rewritten(block: Block, rewrite: Callable[[Block], Block]) -> Block:
    if not isinstance(block, Objective) and isinstance(block, Holder):
        inside = everywhere(block.blocks, rewrite)
        block = block if inside is block.blocks else replace(block, blocks=inside)
    return rewrite(block)


def in_series(
    mission: Mission, rewrite: Callable[[tuple[Block, ...], tuple[Handler, ...]], tuple[Block, ...]]
) -> Mission:
    """A mission in which all series of siblings are rewritten, those inside first; the same where none is.

    Args:
        mission: The mission, without blocks for values.
        rewrite: Gives what stands in the place of siblings under the handlers of the mission, or of none.
    """

    def inside(block: Block) -> Block:
        if not isinstance(block, Recursive):
            return block
        made = rewrite(block.blocks, ())
        return block if made is block.blocks else replace(block, blocks=made)

    mission = rewritten(mission, inside)
    blocks = rewrite(mission.blocks, mission.handlers)
    return mission if blocks is mission.blocks else replace(mission, blocks=blocks)


def common(block: Block, **also: Any) -> dict[str, Any]:
    """What a block says that blocks of all kinds may say.

    Args:
        block: The block.
        **also: What is different.
    """
    return {name: getattr(block, name) for name in _EVERY} | also


def alone(block: Block, **also: Any) -> Any:
    """A block without what leads from it, or to it: that stays on what holds it.

    Args:
        block: The block.
        **also: What else is different.
    """
    nothing: dict[str, Any] = {"success": None, "failure": None, "abort": None, "recover": None, "times": 1}
    nothing |= {"guards": (), "routes": (), "handlers": (), "mandatory": True}
    return replace(block, **(nothing | also))
