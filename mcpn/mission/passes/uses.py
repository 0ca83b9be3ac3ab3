"""Uses of protocols become objectives that hold what the protocol does, its names qualified by the use.

Parameters that a protocol declares, and nobody around gives, stand on the use.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from mcpn.mission.model import ROUND, Block, Each, Mission, Objective, Protocol, Recursive, Use, walk
from mcpn.mission.passes.parameters import overridden
from mcpn.mission.rewriting.blocks import common
from mcpn.mission.rewriting.copying import led


def uses(mission: Mission) -> Mission:
    """Uses of protocols are written out, with their parameters (`<use>`)."""
    if not mission.protocols:
        return mission
    writing = _Uses(mission)
    blocks = writing.blocks(mission.blocks, "", frozenset())
    return replace(mission, blocks=blocks, protocols=writing.unused())


class _Uses:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.used = set[str]()

    def unused(self) -> tuple[Protocol, ...]:
        """The protocols that nothing in the mission uses, and those that they use: what they say stays."""
        found = dict[str, None]()
        left = [name for name in self.protocols if name not in self.used]
        while left:
            if (name := left.pop()) not in found:
                found[name] = None
                left += (b.protocol for b in walk(self.protocols[name].blocks) if isinstance(b, Use))
        return tuple(protocol for name, protocol in self.protocols.items() if name in found)

    def blocks(self, blocks: tuple[Block, ...], prefix: str, given: frozenset[str]) -> tuple[Block, ...]:
        """Blocks of one text, which a use qualifies, where blocks around give some parameters."""
        names = {block.name: f"{prefix}{block.name}" for block in blocks} if prefix else {}
        return tuple(
            [self.block(block, prefix, given, led(block, names) if prefix else {}) for block in blocks]
        )

    def block(self, block: Block, prefix: str, given: frozenset[str], other: dict[str, Any]) -> Block:
        """A block, other in where it leads."""
        name = f"{prefix}{block.name}"
        given |= {ROUND} if block.repeat is not None else frozenset()
        if isinstance(block, Objective):
            return replace(block, name=name, **other) if prefix else block
        if isinstance(block, Use):
            return self.use(block, name, given, other)
        own: tuple[str, ...] = (block.bound,) if isinstance(block, Each) else ()
        if isinstance(block, Recursive):
            own = tuple(parameter.name for parameter in block.parameters)
        inside = self.blocks(block.blocks, prefix, given.union(own) if own else given)
        return replace(block, name=name, blocks=inside, **other)

    def use(self, block: Use, name: str, given: frozenset[str], other: dict[str, Any]) -> Recursive:
        """What a use stands for."""
        protocol = self.protocols[block.protocol]
        self.used.add(protocol.name)
        given = given.union(parameter.name for parameter in block.parameters)
        declared = (parameter for parameter in protocol.parameters if parameter.name not in given)
        return Recursive(
            **common(block, name=name, **other),
            protocol=protocol.name,
            declares=tuple(parameter.name for parameter in protocol.parameters),
            requirements=protocol.requirements,
            parameters=overridden(declared, block.parameters),
            blocks=self.blocks(protocol.blocks, f"{name}.", given),
        )
