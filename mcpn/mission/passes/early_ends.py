"""Early ends (``success_when``, ``failure_when``, ``impossible``) of parallel blocks become numbers."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import Block, Mission, Parallel
from mcpn.mission.rewriting.blocks import rewritten


def early_ends(mission: Mission) -> Mission:
    """What ends parallel blocks early is counted (`success_when`, `failure_when`, `impossible`)."""
    return rewritten(mission, _counted)


def _counted(block: Block) -> Block:
    return counted(block) if isinstance(block, Parallel) else block


def counted(block: Parallel) -> Parallel:
    """A parallel block that says how many children decide it, in the words of core missions alone."""
    said = (block.success_when, block.failure_when, block.impossible)
    if said == ("all", "all", "waits"):
        return block
    needed, hasty, doomed = said[0].replace("any", "1"), said[1] == "any", said[2] == "fails"
    limits = [int(number) for number in (said[1], str(block.failing)) if number.isdecimal()]
    if doomed and needed != "all":
        limits.append(len(block.blocks) - int(needed) + 1)
    return replace(
        block,
        success_when=needed,
        failure_when="any" if hasty or (doomed and needed == "all") else "all",
        impossible="waits",
        failing=min(limits, default=None),
    )
