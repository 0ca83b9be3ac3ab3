"""Rounds for values are written out one after the other, each with its value as a parameter."""

from __future__ import annotations

from mcpn.mission.model import SUCCEED, Block, Each, Mission, Recursive
from mcpn.mission.passes.parameters import with_parameter
from mcpn.mission.rewriting.blocks import common, rewritten
from mcpn.mission.rewriting.copying import copied, led
from mcpn.mission.robot import Parameter


def each(mission: Mission) -> Mission:
    """Rounds for values are written out, the end of each leading to the next (`<each>`)."""
    return rewritten(mission, _written_out)


def _written_out(block: Block) -> Block:
    if not isinstance(block, Each):
        return block
    made = list[Block]()
    for value, next_ in zip(block.values, (*block.values[1:], None), strict=True):
        said = Parameter(name=block.bound, value=value, source=block.source)
        names = {child.name: f"{child.own}_{value}" for child in block.blocks}
        if next_ is not None:
            names[SUCCEED] = f"{block.blocks[0].own}_{next_}"
        made += (copied(with_parameter(child, said), value, **led(child, names)) for child in block.blocks)
    return Recursive(**common(block), parameters=block.parameters, blocks=tuple(made))
