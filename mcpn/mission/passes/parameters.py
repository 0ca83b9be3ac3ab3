"""Parameters stand on the objectives in which they are in force."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from operator import is_
from typing import Any

from mcpn.mission.model import Block, Mission, Objective, Parallel, Recursive
from mcpn.mission.rewriting.limits import Counted
from mcpn.mission.robot import Parameter


def parameters(mission: Mission) -> Mission:
    """Parameters stand on the objectives in which they are in force (`<parameter>`)."""
    in_force = _InForce()
    blocks = tuple(in_force.block(block, ()) for block in mission.blocks)
    return replace(mission, blocks=blocks) if in_force.changed else mission


class _InForce:
    def __init__(self) -> None:
        self.changed = False
        self.counted = Counted()

    def block(self, block: Block, around: tuple[Parameter, ...], declared: tuple[str, ...] = ()) -> Block:
        """A block, inside blocks that give some parameters, and uses of protocols that declare some."""
        if isinstance(block, Objective):
            return self.objective(block, around, declared)
        said: dict[str, Any] = {}
        if isinstance(block, Recursive) and (block.parameters or block.declares):
            around, declared = overridden(around, block.parameters), (*declared, *block.declares)
            said, self.changed = {"parameters": (), "declares": ()}, True
        assert isinstance(block, Recursive | Parallel), "copies are written out"
        inside = tuple([self.block(child, around, declared) for child in block.blocks])
        if not said and all(map(is_, inside, block.blocks)):
            return block  # what nothing is said in or around stays the same object
        return replace(block, blocks=inside, **said)

    def objective(
        self, block: Objective, around: tuple[Parameter, ...], declared: tuple[str, ...]
    ) -> Objective:
        """An objective with what is in force; what protocols declare comes first."""
        found = overridden(around, block.parameters) if around else block.parameters
        self.counted.add(len(found), block.source)
        if not around:
            return block
        named = {parameter.name: parameter for parameter in found}
        first = {name: named.pop(name) for name in dict.fromkeys(declared)}
        return replace(block, parameters=(*first.values(), *named.values()))


def with_parameter(block: Block, outer: Parameter) -> Block:
    """A block around which something says a parameter; what it says itself counts more."""
    if isinstance(block, Parallel):
        return replace(block, blocks=tuple([with_parameter(child, outer) for child in block.blocks]))
    return replace(block, parameters=overridden((outer,), block.parameters))


def overridden(around: Iterable[Parameter], inner: Iterable[Parameter]) -> tuple[Parameter, ...]:
    """Parameters by name: those around, overridden by the inner ones."""
    return tuple({parameter.name: parameter for parameter in (*around, *inner)}.values())
