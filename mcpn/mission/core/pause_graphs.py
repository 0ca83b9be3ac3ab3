"""Parallel blocks that pause: what runs meanwhile, and leaves their branches where they are, stands in them.

Which copy of a sibling runs for what is said by :mod:`mcpn.mission.passes.pauses`.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from itertools import chain

from mcpn.mission.core.objectives_graph import ObjectivesGraph, ParallelSection, PauseGraph, rerouted
from mcpn.mission.core.routes import GO_ON, Interruption

PAUSE = "pause "
"""Begins, before the sibling's name, what stands for the target of a pause until what is stopped is known."""


def end_of_pause(section: str) -> str:
    """What the copy that runs while a block pauses leads to, until it is put into the block.

    The block may itself stand in what runs while another one pauses, and be left for the end of that:
    each has a name of its own, which no block has.
    """
    return f"{GO_ON} {section}"


def with_pause_graph(section: ParallelSection, pause_graph: PauseGraph, mark: str) -> ParallelSection:
    """A parallel block that pauses, with one more copy of a sibling that runs meanwhile.

    Args:
        section: The block.
        pause_graph: The copy; it leads to :func:`end_of_pause`, and out of the block by the names of sections
            and exits there.
        mark: The target that stands for the copy, of handlers of the block and of what runs in other pauses.
    """
    end = end_of_pause(section.name)
    inside = {end: GO_ON, **{inner.name: inner.name for inner in pause_graph.graph.sections}}
    led = (route for inner in pause_graph.graph.sections for route in inner.routes)
    left = (route for i in pause_graph.interruptions for route in i.routes if not route.startswith(PAUSE))
    pause_exits = {target: exit_ for exit_, target in section.pause_exits}
    for target in chain(led, left):
        if target not in inside:
            pause_exits.setdefault(target, f"away {len(pause_exits) + 1}")

    def out(target: str) -> str:
        return inside.get(target) or pause_exits.get(target, target)

    def pausing(interruptions: tuple[Interruption, ...]) -> tuple[Interruption, ...]:
        paused = partial(replace, target=GO_ON, pauses=len(section.pause_graphs))
        return tuple(paused(i) if i.target == mark else i for i in interruptions)

    graph = pause_graph.graph
    inner = ObjectivesGraph(tuple(rerouted(s, out) for s in graph.sections), graph.entry, graph.unreached)
    here = PauseGraph(inner, tuple(i.led(out) for i in pause_graph.interruptions))
    pause_graphs = (replace(s, interruptions=pausing(s.interruptions)) for s in section.pause_graphs)
    return replace(
        section,
        interruptions=pausing(section.interruptions),
        pause_graphs=(*pause_graphs, here),
        pause_exits=tuple((exit_, target) for target, exit_ in pause_exits.items()),
    )
