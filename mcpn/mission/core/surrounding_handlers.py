"""What the blocks of one text take from around them as their sections are made: handlers, and their place."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.core.copies import BlockPosition
from mcpn.mission.core.routes import Interruption
from mcpn.mission.model import Block, Recursive
from mcpn.mission.rewriting.handlers_in_effect import in_effect
from mcpn.records import record


@record(frozen=True, slots=True)
class Scope:
    """What blocks inherit from the blocks that enclose them.

    Args:
        around: The innermost block that encloses them.
        handlers: Handlers of enclosing blocks, up to the mission or the branch of a parallel block, innermost
            first.
        text: The name of the protocol that they are written in; empty in the mission itself.
    """

    around: BlockPosition | None = None
    handlers: tuple[Interruption, ...] = ()
    text: str = ""

    def position(self, block: Block) -> BlockPosition:
        """Where a block stands here; what holds all of its copies, or stops it as a whole, is the block."""
        prefix, written, around = block.prefix, block.written, self.around
        if around is not None and (around.prefix, around.block) == (prefix, written):
            around = around.around
        protocol = (isinstance(block, Recursive) and block.protocol) or ""
        return BlockPosition(prefix, written, block.copy, around, protocol, block.nominal)

    def written_at(self, block: str, event: str) -> str:
        """Where a handler is written in this text, whichever copy of its block happens to run."""
        return ".".join(filter(None, (self.text, block, event)))

    @property
    def interruptions(self) -> tuple[Interruption, ...]:
        """Handlers that can take effect here: of each event up to the first that may happen again."""
        if not self.handlers:  # as in most missions
            return ()
        return tuple(in_effect(self.handlers, lambda one: one.event, lambda one: one.once is not None))

    def into(self, block: Block) -> Scope:
        """The scope of what a block holds."""
        protocol = block.protocol if isinstance(block, Recursive) else None
        return replace(self, around=self.position(block), text=protocol or self.text)
