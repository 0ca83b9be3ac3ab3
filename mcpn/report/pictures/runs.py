"""A run as a sequence diagram: who tells the controller what, and what it changes."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from itertools import chain
from typing import NamedTuple

from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.answers.verdicts.mission import MissionCheck, check, required_of
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import Event, What
from mcpn.report.pictures.drawing import Drawing, rendered
from mcpn.report.pictures.layout import text_width
from mcpn.report.words import in_words
from mcpn.spaces.run import Run

CONTROLLER = "controller"
_SENDERS = {What.START: "operator", What.DECLARED: "outside", What.TIMEOUT: "clock"}
"""Who reports an event that belongs to no element of the robot or the mission."""

MOST_LINES = 8
"""Objectives that have a lifeline each; more of them share one, so that the diagram fits a page."""

ROW, MARGIN = 24, 16


class Message(NamedTuple):
    """A line of the diagram.

    Args:
        sender: Whose line it begins at; the controller's own are what it changes.
        text: What is said.
        kind: ``success``, ``failure`` or ``event``, as pictures colour them.
    """

    sender: str
    text: str
    kind: str


class Sequence(NamedTuple):
    """A run in messages.

    Args:
        name: What it shows.
        messages: In their order.
    """

    name: str
    messages: tuple[Message, ...]

    @property
    def lifelines(self) -> tuple[str, ...]:
        """Those who say something, in the order of their first message, the controller first."""
        return tuple(dict.fromkeys(chain([CONTROLLER], (message.sender for message in self.messages))))


def shown_run(found: MissionCheck) -> tuple[str, Run]:
    """The run to show of a mission: the first counterexample of what is required, else one without failures.

    Raises:
        InputError: There is none.
    """
    for name in required_of(found.mission_net):
        if found.verdicts[name].holds is False and found.verdicts[name].runs_of_events:
            return f"{name} fails", found.verdicts[name].runs_of_events[0]
    for answer in found.requirements:
        if answer.required and answer.met is False and answer.witness is not None:
            return f"{answer.asked.name} is not met", answer.witness.run
    for name in ("nominal_success", "success_reachable"):
        if runs := found.verdicts[name].runs_of_events:
            return name, runs[0]
    raise InputError.at(None, "check shows no run of this mission: there is nothing to draw")


def sequence(mission_net: MissionNet, name: str, run: Run) -> Sequence:
    """The messages of a run."""
    return Sequence(f"{mission_net.mission.name}: {name}", tuple(_messages([*in_words(mission_net, run)])))


def _messages(steps: Collection[tuple[Event | str, str]]) -> Iterable[Message]:
    ends = {e.element for e, _ in steps if isinstance(e, Event) and e.what in (What.SUCCESS, What.FAILURE)}
    shared = dict.fromkeys(ends if len(ends) > MOST_LINES else (), "objectives")
    for event, words in steps:
        if not isinstance(event, Event):
            yield Message(CONTROLLER, words, "event")
            continue
        happens, _, changed = words.partition(": ")
        yield Message(
            shared.get(event.element, _SENDERS.get(event.what, event.element)), happens, _kind(event)
        )
        yield from (Message(CONTROLLER, change, "event") for change in changed.split(", ") if change)


def _kind(event: Event) -> str:
    if event.what in (What.FAILURE, What.OUT_OF_SERVICE, What.LOST):
        return "failure"
    return "success" if event.what in (What.SUCCESS, What.START, What.REPAIRED) else "event"


def mermaid(shown: Sequence) -> str:
    """The diagram as a text for Mermaid."""
    number = {name: f"p{place}" for place, name in enumerate(shown.lifelines)}
    lines = ["sequenceDiagram", f"  title {_plain(shown.name)}"]
    lines += [f"  participant {key} as {_plain(name)}" for name, key in number.items()]
    for message in shown.messages:
        arrow = "--x" if message.kind == "failure" else "->>"
        lines.append(f"  {number[message.sender]}{arrow}{number[CONTROLLER]}: {_plain(message.text)}")
    return "\n".join(lines) + "\n"


def _plain(text: str) -> str:
    """A text in which Mermaid reads no sign of its own: it ends statements at ; and # begins an entity."""
    return "".join(f"#{ord(c)};" if c in "#;<>&%{}" else c for c in text.replace("\n", " "))


def run_drawing(spaces: MissionSpaces) -> Drawing:
    """The run that :func:`shown_run` chooses, as a picture."""
    return Drawing(f"a run of {spaces.mission.mission.name}", lambda: _svg(run_of(spaces)))


def run_of(spaces: MissionSpaces) -> Sequence:
    """The run that :func:`shown_run` chooses, in messages."""
    return sequence(spaces.mission, *shown_run(check(spaces)))


def _svg(shown: Sequence) -> str:
    # What is said stands behind the controller's line, which comes first.
    said = max((text_width(message.text) for message in shown.messages), default=0)
    first, *others = shown.lifelines
    middle = {first: MARGIN + text_width(first, 14) / 2}
    right = middle[first] + max(said, text_width(first, 14) / 2) + 2 * MARGIN
    for name in others:
        width = text_width(name, 14) + 2 * MARGIN
        middle[name], right = right + width / 2, right + width
    rows = [
        {
            "begin": middle[message.sender],
            "end": middle[CONTROLLER],
            "y": 84 + ROW * number,
            "text": message.text,
            "kind": message.kind,
        }
        for number, message in enumerate(shown.messages)
    ]
    return rendered(
        "run.svg",
        name=shown.name,
        middle=middle,
        rows=rows,
        width=max(right, text_width(shown.name)) + MARGIN,
        height=84 + ROW * len(rows) + MARGIN,
    )
