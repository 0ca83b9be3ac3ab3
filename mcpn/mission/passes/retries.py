"""Tries are written out: the failure of each leads to the next."""

from __future__ import annotations

from mcpn.mission.model import SUCCEED, Block, Mission
from mcpn.mission.rewriting.blocks import rewritten
from mcpn.mission.rewriting.copying import copied, holding, one_copy


def retries(mission: Mission) -> Mission:
    """Tries are written out, the failure of each leading to the next (`retries`)."""
    return rewritten(mission, _written_out)


def _written_out(block: Block) -> Block:
    if not block.retries:
        return block
    alone, tries = one_copy(block, retries=0), list[Block]()
    for number in range(1, block.retries + 2):
        failure = f"{block.own}_try{number + 1}" if number <= block.retries else None
        tries.append(copied(alone, f"try{number}", success=SUCCEED, failure=failure))
    return holding(block, tries)
