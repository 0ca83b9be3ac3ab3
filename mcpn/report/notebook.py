"""What a notebook shows: missions, nets, graphs and controllers as pictures, checks and causes as tables."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mcpn.answers.causes.find import Causes, GoalCauses
from mcpn.answers.claims import claims_of_causes
from mcpn.answers.claims.of_check import of_verdict
from mcpn.answers.mission_names import MissionNames
from mcpn.answers.verdicts.mission import MissionCheck, Verdict
from mcpn.controller.hierarchy import TableController
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import McpnError
from mcpn.logic.session import Answer
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.model import Mission
from mcpn.nets.petri import PetriNet
from mcpn.report.assets import environment
from mcpn.report.failures.sentences import conditions, headlines, of_objectives
from mcpn.report.pictures.drawing import Drawing
from mcpn.report.pictures.graph import drawing
from mcpn.report.pictures.machines import controller_drawing, graph_drawing
from mcpn.report.pictures.nets import net_drawing, units_drawing
from mcpn.report.pictures.objectives import mission_drawing
from mcpn.report.pictures.objectives_graph import objectives_picture
from mcpn.report.words import in_words
from mcpn.sentences import enumeration
from mcpn.spaces.stable.alternatives import AlternativesGraph

_TABLE = (
    "<table><caption>{{ caption }}</caption>"
    "<thead><tr>{% for head in heads %}<th>{{ head }}</th>{% endfor %}</tr></thead>"
    "<tbody>{% for row in rows %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}"
    "</tbody></table>"
)


def show(what: object, kind: str) -> str | None:
    """An object as ``svg`` or ``html``, or ``None`` where it has no such form, or is too large for it."""
    if kind == "html":
        return _as_table(what)
    try:
        picture = _drawing(what)
        return None if picture is None else picture.svg
    except McpnError:  # too large, or the extra is missing: a notebook then shows the repr
        return None


def _as_table(what: object) -> str | None:
    match what:
        case MissionCheck():
            return _check(what)
        case Verdict():
            return _verdict(what)
        case Answer():
            return _answer(what)
        case Causes():
            return _causes(what)
        case GoalCauses():
            return _goal(what)
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
        mark = ("✓", "✗", "?")[number] if verdict.required else "i"
        rows.append((mark, of_verdict(verdict).sentence, name))
    return _table(f"Verdicts of the mission {check.mission_net.mission.name}", ("", "says", "verdict"), rows)


def _causes(causes: Causes) -> str:
    said = [*headlines(causes, claims_of_causes(causes)), *of_objectives(causes)]
    return _table(f"What the mission {causes.mission.name} loses", ("says",), [(each,) for each in said])


def _verdict(verdict: Verdict) -> str:
    """A verdict with the events of its runs."""
    rows = [
        (str(number), str(step), text)
        for number, run in enumerate(verdict.runs_of_events, 1)
        for step, text in enumerate([*map(str, run.events), *run.tail], 1)
    ]
    caption = f"{of_verdict(verdict).sentence} {verdict.explanation}".strip()
    return _table(caption, ("run", "step", "what happens"), rows)


def _answer(answer: Answer) -> str:
    """An answer with the run that shows it, in mission words where it is of a mission."""
    witness = answer.witness
    if isinstance(witness.names, MissionNames):
        mission_net = witness.names.mission_net
        steps = [(words, str(event)) for event, words in in_words(mission_net, witness.run)]
    else:
        steps = [(witness.names.net.transitions[t].name, "") for t in witness.firings]
    rows = [(str(number), *step) for number, step in enumerate(steps, 1)]
    rows += [("", note, "") for note in witness.notes]
    caption = f"{answer.formula} {'holds' if answer.holds else 'fails'}"
    return _table(caption, ("", "what shows it", "event"), rows)


def _goal(goal: GoalCauses) -> str:
    """What losses cost a goal, with a shortest run by each."""
    rows = []
    for lost in goal.cut_sets:
        run = goal.runs[lost]
        events = "" if run is None else " ".join(map(str, run.events))
        rows.append((enumeration(lost) or "nothing", events))
    return _table(" ".join(conditions(goal, goal.name)), ("lost", "a run that shows it"), rows)
