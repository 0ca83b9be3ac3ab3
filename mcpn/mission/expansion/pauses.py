"""Blocks that pause: an event stops what runs in one, a sibling is run, and then it goes on where it was.

It is written out: for each objective of the block there is a copy of the sibling, which the event leads to
while the objective runs, and whose success enters the objective again. So the copy that runs says where the
block was, and nothing else has to remember it. A parallel block in it may be at many places: it has one copy,
which runs in the section of the parallel block and leaves its branches where they are.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial
from itertools import chain

from mcpn.mission.expansion.routes import GO_ON, Interruption
from mcpn.mission.graph import ObjectivesGraph, ParallelSection, PauseGraph, rerouted

PAUSE = "pause "
"""Begins what stands for the target of a pause until its copies are made."""


def suffix_at(objective: str, prefix: str) -> str:
    """What distinguishes copies of a sibling: the objective that is stopped, named as among the siblings."""
    return f"at_{objective.removeprefix(prefix).replace('.', '_')}"


def end_of_pause(section: str) -> str:
    """What the copy that runs while a block pauses leads to, until it is put into the block.

    The block may itself stand in what runs while another one pauses, and be left for the end of that:
    each has a name of its own, which no block has.
    """
    return f"{GO_ON} {section}"


def with_pause_graph(
    section: ParallelSection, pause_graph: PauseGraph, marks: Collection[str]
) -> ParallelSection:
    """A parallel block that pauses, with one more copy of a sibling that runs meanwhile.

    Args:
        section: The block.
        pause_graph: The copy; it leads to :func:`end_of_pause`, and out of the block by the names of sections
            and exits there.
        marks: Targets that stand for the copy, of handlers of the block and of what runs in other pauses.
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
        return tuple(paused(i) if i.target in marks else i for i in interruptions)

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
