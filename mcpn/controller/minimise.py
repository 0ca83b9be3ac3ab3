"""Merges states of machines that no run of events can tell apart (partition refinement, Moore 1956).

Two states may be merged where they show the same (objectives, mode, what waits, what was refused, branches
that have ended, hardware out of service, noticed or not), allow the same events under the same guards, order
the same actions on each, and lead to states that may be merged. The coarsest such partition is a
bisimulation.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import replace

from mcpn.controller.hierarchy import SectionMachine, TableController
from mcpn.controller.moves import Move, Moves


def minimise(controller: TableController) -> TableController:
    """Minimises the machines of a controller.

    Args:
        controller: Any controller.

    Returns:
        One that does the same on every run of events; compare :attr:`TableController.states` of the two.
    """
    types = tuple(quotient(machine, partition(machine)) for machine in controller.types)
    return replace(controller, types=types, minimised=True)


def partition(machine: SectionMachine) -> list[int]:
    """The coarsest bisimulation: the number of its class by state, in the order of their first states."""
    moves = _moves(machine)
    classes = _numbered([_shown(machine, number) for number in range(len(machine.states))])
    while True:
        keys: list[Hashable] = [
            (
                classes[number],
                tuple(
                    (
                        m.event,
                        m.guard,
                        m.gained,
                        m.lost,
                        m.actions,
                        classes[m.target] if isinstance(m.target, int) else m.target,
                    )
                    for m in moves[number]
                ),
            )
            for number in range(len(classes))
        ]
        finer = _numbered(keys)
        if finer == classes:
            return classes
        classes = finer


def quotient(machine: SectionMachine, classes: Sequence[int]) -> SectionMachine:
    """The machine with one state for each class, which stands for its first state."""
    first: dict[int, int] = {}
    for number, class_ in enumerate(classes):
        first.setdefault(class_, number)
    kept = set(first.values())
    return replace(
        machine,
        states=tuple(machine.states[number] for number in first.values()),
        entries=tuple(e and replace(e, target=classes[e.target]) for e in machine.entries),
        moves=Moves.of(
            replace(
                m,
                source=classes[m.source],
                target=classes[m.target] if isinstance(m.target, int) else m.target,
            )
            for m in machine.moves
            if m.source in kept
        ),
    )


def _shown(machine: SectionMachine, number: int) -> Hashable:
    state = machine.states[number]
    return (
        state.objectives,
        state.pending,
        state.done,
        tuple(state.mode.items()),
        tuple(state.waiting.items()),
        state.refused,
        state.out_of_service,
        state.unnoticed,
        tuple(state.facts.items()),
    )


def _moves(machine: SectionMachine) -> list[list[Move]]:
    found: list[list[Move]] = [[] for _ in machine.states]
    for move in machine.moves:
        found[move.source].append(move)
    return found


def _numbered(keys: Sequence[Hashable]) -> list[int]:
    known: dict[Hashable, int] = {}
    return [known.setdefault(key, len(known)) for key in keys]
