"""What a notebook shows: missions, nets, graphs and controllers as pictures, checks and causes as tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mcpn.check.causes.find import Causes
from mcpn.check.verdicts.mission import MissionCheck
from mcpn.controller.hierarchy import TableController
from mcpn.errors import McpnError
from mcpn.mission.graph import ObjectivesGraph
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.net.petri import PetriNet
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import drawing
from mcpn.report.pictures.machines import controller_drawing, graph_drawing
from mcpn.report.pictures.mission import mission_drawing
from mcpn.report.pictures.nets import net_drawing, units_drawing
from mcpn.report.pictures.objectives import objectives_picture
from mcpn.report.templates import environment
from mcpn.report.text import SENTENCES
from mcpn.sentences import enumeration
from mcpn.space.stable.alternatives import AlternativesGraph

_TABLE = (
    "<table><caption>{{ caption }}</caption>"
    "<thead><tr>{% for head in heads %}<th>{{ head }}</th>{% endfor %}</tr></thead>"
    "<tbody>{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}"
    "</tbody></table>"
)


def show(what: object, kind: str) -> str | None:
    """An object as ``svg`` or ``html``, or ``None`` where it has no such form, or is too large for it."""
    if kind == "html":
        if isinstance(what, MissionCheck):
            return _check(what)
        return _causes(what) if isinstance(what, Causes) else None
    try:
        found = _drawing(what)
        return None if found is None else found.svg
    except McpnError:  # too large, or the extra is missing: a notebook then shows the repr
        return None


def _drawing(what: object) -> Drawing | None:
    match what:
        case Mission():
            return mission_drawing(compose(what))
        case MissionNet():
            return units_drawing(what)
        case PetriNet():
            return net_drawing(what)
        case ObjectivesGraph():
            return drawing(objectives_picture(what, "Objectives graph"))
        case AlternativesGraph():
            return graph_drawing(what)
        case TableController():
            return controller_drawing(what)
    return None


def _table(caption: str, heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of texts, each escaped."""
    return environment().from_string(_TABLE).render(caption=caption, heads=heads, rows=rows)


def _check(check: MissionCheck) -> str:
    rows = []
    for name, verdict in check.verdicts.items():
        number = {True: 0, False: 1, None: 2}[verdict.holds]
        sentences = SENTENCES.get(name, (verdict.explanation,) * 3)
        mark = ("✓", "✗", "?")[number] if verdict.required else "i"
        rows.append((mark, sentences[number], name))
    return _table(f"Verdicts of the mission {check.mission_net.mission.name}", ("", "says", "verdict"), rows)


def _causes(causes: Causes) -> str:
    goals = [causes.mission, *causes.objectives.values()]
    rows = [
        (
            goal.name,
            "; ".join(enumeration(lost) or "nothing" for lost in goal.cut_sets) or "never by hardware",
        )
        for goal in goals
    ]
    name = causes.mission_net.mission.name
    return _table(f"What makes the mission {name} fail", ("fails", "if these are lost"), rows)
