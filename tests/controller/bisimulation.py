"""Whether classes of the states of a machine are a bisimulation, by the definition."""

from __future__ import annotations

from collections.abc import Sequence

from mcpn.controller.hierarchy import SectionMachine
from mcpn.controller.moves import Move
from mcpn.drawing.forgetful import Guard


def is_bisimulation(machine: SectionMachine, classes: Sequence[int]) -> bool:
    """Whether states of one class show the same and do the same on every event, up to classes.

    It compares each state with the first of its class, one move at a time, and shares no code with the
    partition that minimises.

    Args:
        machine: The machine.
        classes: The number of its class by state.
    """
    first: dict[int, int] = {}
    by_source: dict[int, dict[tuple[int, Guard], Move]] = {n: {} for n in range(len(machine.states))}
    for move in machine.moves:
        by_source[move.source][move.event, move.guard] = move
    for number, class_ in enumerate(classes):
        other = first.setdefault(class_, number)
        if machine.states[number] != machine.states[other]:
            return False
        mine, theirs = by_source[number], by_source[other]
        if mine.keys() != theirs.keys():
            return False
        for event, move in mine.items():
            same = theirs[event]
            if (move.gained, move.lost) != (same.gained, same.lost):
                return False
            if move.actions != same.actions or type(move.target) is not type(same.target):
                return False
            if isinstance(move.target, int) and isinstance(same.target, int):
                if classes[move.target] != classes[same.target]:
                    return False
            elif move.target != same.target:
                return False
    return True
