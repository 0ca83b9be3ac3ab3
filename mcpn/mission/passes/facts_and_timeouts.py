"""Blocks that facts (``<on when>``) or a timeout end as a whole become parallel blocks with one branch.

That branch is all of them. An objective that has no copies, and a parallel block, are such sections
already. The net asks for what facts have become by internal transitions, after all that ends and before
anything begins (:mod:`mcpn.drawing.templates.facts`). So what is entered in the same reaction is not left by
it.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.errors import Problem, Source
from mcpn.mission.model import WHOLE, Block, Mission, Objective, Parallel
from mcpn.mission.rewriting.blocks import alone, common, rewritten


def becoming(mission: Mission) -> Mission:
    """Blocks that facts end are stopped as a whole (`<on when>`)."""
    return rewritten(mission, _left_by_facts)


def timeouts(mission: Mission) -> Mission:
    """Blocks that hold others and have a time are stopped as a whole (`timeout`)."""
    return rewritten(mission, _timed)


def _left_by_facts(block: Block) -> Block:
    if not block.left_by_facts:
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


def becoming_problems(block: Block) -> Iterator[Problem]:
    """What else a block cannot have that is left when facts become so."""
    handler = next((handler for handler in block.handlers if handler.when), None)
    if handler is None:
        return
    if block.recover is not None:
        yield _alone(block, handler.source, f"recovers by {block.recover}")
    if block.timeout_goto is not None and (block.retries or block.repeat):
        yield _alone(block, handler.source, "has copies, each with a timeout_goto")


def _alone(block: Block, source: Source | None, though: str) -> Problem:
    message = f"{block.name} is left when facts become so (on when), though it {though}"
    return Problem(source, f"{message}: put it into an objective of its own, and <on when> there")


def of_missions(mission: Mission) -> Iterator[Problem]:
    """Facts by which a whole mission would be left."""
    for handler in mission.handlers:
        if handler.when:
            message = f"{mission.name} is left when facts become so (on when), though it is the mission"
            yield Problem(handler.source, f"{message}: put its blocks into an objective, and <on when> there")
