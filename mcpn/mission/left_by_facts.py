"""Blocks that are left when facts become so: which they are, and where that is refused.

A block that is left when facts become so is one section, an objective or a block with branches, of which it
may have one alone. The net asks for what facts have become by internal transitions, after all that ends and
before anything begins (:mod:`mcpn.drawing.templates.facts`). So what is entered in the same reaction is not
left by it.
"""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.errors import Problem, Source
from mcpn.mission.model import Block, Mission


def left_by_facts(block: Block) -> bool:
    """Whether a block is left when facts become so."""
    return any(handler.when for handler in block.handlers)


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
