"""Copies of blocks: their names, those of what they hold, and the routes among these."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from mcpn.mission.model import TIMED_OUT, WHOLE, Block, Each, FactRoute, Handler, Parallel, Recursive
from mcpn.mission.rewriting.blocks import alone, common


def copied(block: Block, suffix: str, **also: Any) -> Block:
    """One copy of a block: its name ends in what tells it from others, and qualifies those in it.

    Args:
        block: The block, or a copy of it.
        suffix: What tells the copy from others.
        **also: What else is different.
    """
    old, new = block.own, f"{block.own}_{suffix}"
    if isinstance(block, Recursive | Parallel | Each):
        copying = _Copying(old, new, block.prefix, block.stem, len(block.copy), suffix)
        also["blocks"] = copying.inside(block)
    return replace(block, name=new, copy=(*block.copy, suffix), **also)


class _Copying(NamedTuple):
    """One copy that is made.

    Args:
        old: The name of the block that is copied.
        new: The name of the copy.
        prefix: What qualifies the old name.
        stem: The old name, whichever copy it is of.
        place: Which of its suffixes is new.
        suffix: The new one.
    """

    old: str
    new: str
    prefix: str
    stem: str
    place: int
    suffix: str

    def inside(self, holder: Recursive | Parallel | Each) -> tuple[Block, ...]:
        """What a block holds, in the copy."""
        names = {child.name: self.moved(child) for child in holder.blocks}
        return tuple([self.child(child, names) for child in holder.blocks])

    def child(self, child: Block, names: Mapping[str, str]) -> Block:
        """A block in the copy, whose siblings have other names there."""
        changes, within = led(child, names), self
        if child.stem == self.stem:  # a copy of what is copied, or all of it
            changes["copy"] = (*child.copy[: self.place], self.suffix, *child.copy[self.place :])
            within = self._replace(old=child.own, new=names[child.name].removesuffix(WHOLE))
        if isinstance(child, Recursive | Parallel | Each):
            changes["blocks"] = within.inside(child)
        return replace(child, name=names[child.name], **changes)

    def moved(self, child: Block) -> str:
        """The name of something that the copy holds: its own name begins, or qualifies it."""
        if child.stem == self.stem or child.name.startswith(f"{self.old}."):
            return f"{self.new}{child.name[len(self.old) :]}"
        return f"{self.new}.{child.name[len(self.prefix) :]}"


def led(block: Block, names: Mapping[str, str]) -> dict[str, Any]:
    """What is different in a block whose targets are called otherwise.

    Args:
        block: The block.
        names: By target its other name.
    """
    changes: dict[str, Any] = {}
    for route in ("success", "failure", "abort", "timeout_goto", "recover"):
        target = getattr(block, route)
        if target is not None and target in names:
            changes[route] = names[target]
    if block.guards:
        changes["guards"] = tuple(
            replace(guard, otherwise=names.get(guard.otherwise, guard.otherwise)) for guard in block.guards
        )
    if block.routes:
        changes["routes"] = _routed(block.routes, names)
    if block.handlers:
        changes["handlers"] = handled(block.handlers, names)
    return changes


def handled(handlers: Iterable[Handler], names: Mapping[str, str]) -> tuple[Handler, ...]:
    """Handlers whose targets are called otherwise.

    Args:
        handlers: The handlers.
        names: By target its other name.
    """
    return tuple(
        replace(
            handler,
            goto=handler.goto and names.get(handler.goto, handler.goto),
            pause=handler.pause and names.get(handler.pause, handler.pause),
            fails_as=handler.fails_as and names.get(handler.fails_as, handler.fails_as),
            routes=_routed(handler.routes, names),
        )
        for handler in handlers
    )


def _routed(routes: Iterable[FactRoute], names: Mapping[str, str]) -> tuple[FactRoute, ...]:
    return tuple(replace(each, goto=names.get(each.goto, each.goto)) for each in routes)


def one_copy(block: Block, **without: Any) -> Block:
    """What of a block each of its copies is; where its time is over, all of them are left.

    Args:
        block: The block.
        **without: What makes it stand for several copies, by which it would not.
    """
    found: Block = alone(block, timeout_goto=block.timeout_goto and TIMED_OUT, **without)
    return found


def holding(block: Block, copies: Iterable[Block]) -> Recursive:
    """A block that stands for several copies, as a series of them."""
    said = common(block, repeat=None, retries=0, timeout=None)
    return Recursive(blocks=tuple(copies), **said)
