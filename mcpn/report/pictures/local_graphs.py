"""Local graphs for a report: one for each type of section, drawn by what runs; large ones by objectives."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, replace

from mcpn.answers.spaces import MissionSpaces
from mcpn.drawing.sections import SectionParts
from mcpn.errors import LimitError, SemanticsError
from mcpn.report.pictures.graph import Graph, Placed, lay_out_all
from mcpn.report.pictures.machines import states_picture, states_within

MOST_LOCAL_STATES, MOST_DRAWN, MOST_BOXES = 20_000, 24, 60
"""States of a section that are listed for its drawing, drawings of a report, and boxes of each."""

MOST_MODES = 20
"""Boxes up to which each way to run is one; of more nobody can follow the curves between them."""


@dataclass(frozen=True)
class LocalPicture:
    """The local graph of a type of section.

    Args:
        section: The section that it is drawn for.
        alike: Other sections of the same type, by other names.
        states: How many states it has.
        picture: What is drawn.
    """

    section: str
    alike: tuple[str, ...]
    states: int
    picture: Placed


def local_pictures(
    spaces: MissionSpaces, progress: Callable[[int, int], None] | None = None
) -> tuple[list[LocalPicture], list[str]]:
    """Local graphs as far as they can be drawn, and for each that cannot why.

    Args:
        spaces: The mission's spaces.
        progress: Called before each type of section with how many are done, and how many when the last is.
    """
    alike: dict[Hashable, list[str]] = {}
    mission_net = spaces.mission
    alone = SectionParts(mission_net.usage).alone
    for section in mission_net.graph.sections:
        alike.setdefault(alone(section).type, []).append(section.name)
    notes, sizes = list[str](), list[int]()
    graphs: list[Graph] = []
    members: list[list[str]] = []
    for number, names in enumerate(alike.values()):
        if progress:
            progress(number, number + min(len(alike) - number, MOST_DRAWN - len(graphs)))
        if len(graphs) == MOST_DRAWN:
            notes.append(
                f"No more than {MOST_DRAWN} local graphs are drawn, of {len(alike)} types of sections."
            )
            break
        try:
            local, graph = spaces.local(names[0], MOST_LOCAL_STATES)
        except (LimitError, SemanticsError) as error:
            notes.append(f"No local graph of {names[0]}: {error}")
            continue
        states, passages = states_within(local, graph)
        name = f"Local graph of the section {names[0]}"
        found = states_picture(name, states, passages, merged=True)
        if len(found.nodes) > MOST_MODES:
            found = states_picture(name, states, passages, by_objectives=True)
        if len(found.nodes) > MOST_BOXES:
            notes.append(f"No drawing of the local graph of {names[0]}: {len(found.nodes)} boxes.")
            continue
        graphs.append(replace(found, sideways=False))
        sizes.append(graph.states)
        members.append(names)
    try:
        placed = lay_out_all(graphs)
    except LimitError as error:
        return [], [*notes, f"No local graphs: {error}"]
    return [
        LocalPicture(names[0], tuple(names[1:]), size, picture)
        for names, size, picture in zip(members, sizes, placed, strict=True)
    ], notes
