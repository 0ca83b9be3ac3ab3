"""Pieces of a mission that translations of nodes put together: blocks with what their ends mean.

A node of a tree returns success or failure. Where a decorator turns that round, the block stays as it is and
the piece remembers what each of its ends means: :func:`placed` gives it its routes. A node that is skipped
leaves by the exit abort, which passes through everything around it until somebody leads it elsewhere, as
SKIPPED does.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

from mcpn.errors import Source
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    Block,
    Handler,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.passes.early_ends import counted
from mcpn.mission.robot import FactChange


@dataclass(frozen=True, slots=True)
class Part:
    """A block, and what its ends mean for the node that it stands for.

    Args:
        block: The block, without routes.
        good: Whether its success means success.
        bad: Whether its failure means success.
        skips: Whether it may leave by abort, because it is skipped.
    """

    block: Block
    good: bool = True
    bad: bool = False
    skips: bool = False

    @property
    def plain(self) -> bool:
        """Whether its ends mean what they are called."""
        return self.good and not self.bad


Result = Part | bool
"""What a node becomes: a piece, or what it always returns at once."""


def sourced(block: Block, source: Source) -> Block:
    """A block that a node became: what of it has no place in the file yet has that of the node."""
    if block.source is not None:
        return block
    if isinstance(block, Recursive | Parallel):
        block = replace(block, blocks=tuple(sourced(inner, source) for inner in block.blocks))
    return replace(block, source=source)


def placed(piece: Part, good: str, bad: str, skip: str = ABORT) -> Block:
    """The block of a piece in a series, with its routes.

    Args:
        piece: The piece.
        good: Where its success leads.
        bad: Where its failure leads.
        skip: Where it leads that it is skipped.
    """
    block = piece.block
    success, failure = (good if piece.good else bad), (good if piece.bad else bad)
    return replace(
        block,
        success=success,
        failure=None if failure == FAIL else failure,
        abort=None if not piece.skips or skip == ABORT else skip,
    )


def tidied(blocks: Sequence[Block], apart: Sequence[str] = ()) -> tuple[Block, ...]:
    """Blocks of a series without the routes that they have by default.

    Args:
        blocks: The blocks with their routes.
        apart: TreeNames of those to which success does not lead by default: they recover others.
    """
    found = []
    for place, block in enumerate(blocks):
        last = place + 1 == len(blocks)
        default = SUCCEED if last else blocks[place + 1].name
        usual = block.success == default and default not in apart
        found.append(replace(block, success=None) if usual else block)
    return tuple(found)


def handled(block: Block, handlers: Sequence[Handler], instants: Collection[str] = ()) -> Block:
    """A block with further handlers, which count before those that it has.

    Args:
        block: The block.
        handlers: The handlers.
        instants: Objectives in it that stand for no time in the tree: where one of them runs, what
            it leads to has happened already, whatever the handlers say.
    """
    block = _immune(block, handlers, instants, None) if instants else block
    return replace(block, handlers=(*handlers, *block.handlers)) if handlers else block


def _immune(
    block: Block, handlers: Sequence[Handler], instants: Collection[str], following: str | None
) -> Block:
    if isinstance(block, Objective) and block.name in instants:
        # Where facts say what follows, it is entered again.
        if (goto := block.name if block.routes else block.success or following) is None:
            return block
        going_on = tuple(Handler(event=handler.event, goto=goto) for handler in handlers)
        return replace(block, handlers=(*going_on, *block.handlers))
    if isinstance(block, Recursive):
        behind = [*(inner.name for inner in block.blocks[1:]), SUCCEED]
        inside = zip(block.blocks, behind, strict=True)
        return replace(block, blocks=tuple(_immune(i, handlers, instants, then) for i, then in inside))
    if isinstance(block, Parallel):
        return replace(block, blocks=tuple(_immune(i, handlers, instants, None) for i in block.blocks))
    return block


def bare(piece: Part) -> bool:
    """Whether a block may be given retries, rounds or a place in a parallel block as it is."""
    block = piece.block
    return (
        piece.plain
        and not isinstance(block, Parallel)
        and block.retries == 0
        and block.repeat is None
        and block.recover is None
        and not block.handlers
        and not block.routes
    )


def wrapped(piece: Part, name: str) -> Part:
    """A piece that is bare: itself, or an objective around it."""
    if bare(piece):
        return piece
    inner = placed(piece, SUCCEED, FAIL)
    return Part(Recursive(name=name, blocks=tidied([inner])), skips=piece.skips)


def marked(piece: Part, change: FactChange) -> Part | None:
    """A piece whose success sets a fact, or ``None`` where no objective of it always ends it so."""
    block = piece.block
    if isinstance(block, Objective) and piece.plain and block.repeat is None:
        return replace(piece, block=replace(block, sets=(*block.sets, change)))
    if not isinstance(block, Recursive) or not piece.plain or block.repeat is not None or piece.skips:
        return None
    *before, last = block.blocks
    ends = [
        (b.success, b.failure, b.abort, *(h.goto for h in b.handlers), *(r.goto for r in b.routes))
        for b in before
    ]
    behind = (last.failure, last.abort, *(h.goto for h in last.handlers), *(r.goto for r in last.routes))
    if last.success is not None or SUCCEED in behind or any(SUCCEED in routes for routes in ends):
        return None
    inner = marked(Part(last), change)
    return None if inner is None else replace(piece, block=replace(block, blocks=(*before, inner.block)))


def answers(piece: Part, protocols: Mapping[str, Protocol]) -> frozenset[bool]:
    """What a piece may return, by where its blocks lead: a fallback whose last child succeeds never fails.

    Args:
        piece: The piece.
        protocols: Those that blocks of it use, by name.
    """
    ends = _ends(piece.block, protocols)
    return frozenset(good for end, good in ((SUCCEED, piece.good), (FAIL, piece.bad)) if end in ends)


def _ends(block: Block, protocols: Mapping[str, Protocol]) -> frozenset[str]:
    """The ends that a block may come to, of success and failure."""
    if isinstance(block, Recursive):
        return _ends_of_series(block.blocks, protocols)
    if isinstance(block, Use):
        return _ends_of_series(protocols[block.protocol].blocks, protocols)
    if not isinstance(block, Parallel):
        return frozenset((SUCCEED, FAIL))
    inside = [_targets(branch, SUCCEED, protocols) for branch in block.blocks]
    succeeding, failing = (sum(end in ends for ends in inside) for end in (SUCCEED, FAIL))
    decided = counted(block)
    wanted = len(inside) if decided.success_when == "all" else int(decided.success_when)
    allowed = 1 if decided.failure_when == "any" else decided.failing or len(inside)
    losing = min(len(inside) - wanted + 1, allowed)
    return frozenset(end for end, may in ((SUCCEED, succeeding >= wanted), (FAIL, failing >= losing)) if may)


def _ends_of_series(blocks: Sequence[Block], protocols: Mapping[str, Protocol]) -> frozenset[str]:
    following = [*(block.name for block in blocks[1:]), SUCCEED]
    routes = {block.name: (block, behind) for block, behind in zip(blocks, following, strict=True)}
    found, todo = set[str](), [blocks[0].name]
    while todo:
        if (name := todo.pop()) not in found:
            found.add(name)
            todo += _targets(*routes[name], protocols) if name in routes else ()
    return frozenset((SUCCEED, FAIL)) & found


def _targets(block: Block, following: str, protocols: Mapping[str, Protocol]) -> set[str]:
    """Where a block of a series may lead."""
    ends = _ends(block, protocols) | ({FAIL} if block.timeout is not None else set())
    found = {block.success or following} if SUCCEED in ends else set[str]()
    if FAIL in ends:
        found |= {block.failure or FAIL, *([block.recover] if block.recover else [])}
    aside = {handler.goto or FAIL for handler in block.handlers} | {route.goto for route in block.routes}
    return found | aside | ({block.abort} if block.abort else set())
