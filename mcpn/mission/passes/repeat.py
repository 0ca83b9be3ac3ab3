"""Rounds that are counted are written out: the success of each leads to the next."""

from __future__ import annotations

from mcpn.mission.model import ROUND, SUCCEED, Block, Mission
from mcpn.mission.passes.parameters import with_parameter
from mcpn.mission.rewriting.blocks import rewritten
from mcpn.mission.rewriting.copying import copied, holding, one_copy
from mcpn.mission.robot import Parameter


def repeat(mission: Mission) -> Mission:
    """Counted rounds are written out, the success of each leading to the next (`repeat`)."""
    return rewritten(mission, _written_out)


def _written_out(block: Block) -> Block:
    if block.repeat is None:
        return block
    alone, rounds = one_copy(block, repeat=None), list[Block]()
    for number in range(1, block.repeat + 1):
        success = f"{block.own}_{number + 1}" if number < block.repeat else SUCCEED
        said = Parameter(name=ROUND, value=str(number), source=block.source)
        rounds.append(copied(with_parameter(alone, said), str(number), success=success))
    return holding(block, rounds)
