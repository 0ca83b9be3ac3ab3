"""Blocks that facts (``<on when>``) or a timeout end as a whole become parallel blocks with one branch.

That branch is all of them. An objective that has no copies, and a parallel block, are such sections
already.
"""

from __future__ import annotations

from mcpn.mission.left_by_facts import left_by_facts
from mcpn.mission.model import WHOLE, Block, Mission, Objective, Parallel
from mcpn.mission.passes.rewriting import alone, common, rewritten


def becoming(mission: Mission) -> Mission:
    """Blocks that facts end are stopped as a whole (`<on when>`)."""
    return rewritten(mission, _left_by_facts)


def timeouts(mission: Mission) -> Mission:
    """Blocks that hold others and have a time are stopped as a whole (`timeout`)."""
    return rewritten(mission, _timed)


def _left_by_facts(block: Block) -> Block:
    if not left_by_facts(block):
        return block
    if block.repeat is not None or block.retries:  # each copy has a time of its own
        branch = alone(block, name=f"{block.own}{WHOLE}")
        return Parallel(**common(block, repeat=None, retries=0, timeout=None), blocks=(branch,))
    return block if isinstance(block, Objective | Parallel) else _whole(block)


def _timed(block: Block) -> Block:
    return block if block.timeout is None or isinstance(block, Objective | Parallel) else _whole(block)


def _whole(block: Block) -> Parallel:
    branch = alone(block, name=f"{block.own}{WHOLE}", timeout=None, timeout_goto=None)
    return Parallel(**common(block), blocks=(branch,))
