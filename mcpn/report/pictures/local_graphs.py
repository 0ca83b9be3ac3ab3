"""Local graphs for a report: one for each type of section, drawn by what runs; large ones by objectives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from mcpn.errors import LimitError
from mcpn.findings import LocalGraph
from mcpn.report.pictures.graph import Graph, Placed, lay_out_all
from mcpn.report.pictures.machines import MOST_BOXES, MOST_MODES, states_picture, states_within
from mcpn.steps import Doing, step


@dataclass(frozen=True)
class LocalPicture:
    """The picture of the local graph of a type of section.

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


LocalPictures = tuple[list[LocalPicture], list[str]]
"""Pictures of local graphs, and why others are not drawn."""


def local_pictures(found: Sequence[LocalGraph]) -> LocalPictures:
    """Draws local graphs, as far as somebody can read them."""
    notes, drawn = list[str](), list[tuple[LocalGraph, Graph]]()
    for number, each in enumerate(found, 1):
        step(Doing.DRAWING, section=each.section, number=number, total=len(found))
        states, passages = states_within(each.net, each.graph)
        name = f"Local graph of the section {each.section}"
        picture = states_picture(name, states, passages, merged=True)
        if len(picture.nodes) > MOST_MODES:
            picture = states_picture(name, states, passages, by_objectives=True)
        if len(picture.nodes) > MOST_BOXES:
            notes.append(f"No drawing of the local graph of {each.section}: {len(picture.nodes)} boxes.")
            continue
        drawn.append((each, replace(picture, sideways=False)))
    try:
        placed = lay_out_all([picture for _, picture in drawn])
    except LimitError as error:
        return [], [*notes, f"No local graphs: {error}"]
    return [
        LocalPicture(each.section, each.alike, each.graph.states, picture)
        for (each, _), picture in zip(drawn, placed, strict=True)
    ], notes
