"""The contract of templates: each touches places of others only as these declare.

Templates meet at places that they declare (:mod:`mcpn.drawing.templates.interface`): who *takes* a token of
them, *puts* one, or *reads* it. All other places are private to the element that draws them, also those that
a set of templates has named itself. So a template can be replaced by another one that keeps the contract, and
a proof of one side needs to know nothing of the other but this.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from mcpn.drawing.compose import MissionNet
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.interface import CONTROL, HAPPENING, MEETINGS, SAYING, Meeting
from mcpn.drawing.templates.net_names import names_of
from mcpn.mission.fact_conditions import word
from mcpn.mission.static.resource_use import Usage
from mcpn.nets.provenance import Provenance
from mcpn.testing.kit.subject import Subject, Violation

STATES: Mapping[str, tuple[str, ...]] = {
    "available": ("free",),
    "used": ("busy",),
    "between": ("failing",),
    "out of service": ("OOS",),
}
"""By state of hardware, the parts that say so; it is *between* two others on its way alone, never at rest.

These are the parts of the paper's templates. A set whose hardware has other places maps them by an attribute
``hardware_states``; what it does not map may be marked on the way between two states.
"""

WORDS = {"t": "takes from", "p": "puts into", "r": "reads"}


def states_of(templates: TemplateSet | None) -> Mapping[str, tuple[str, ...]]:
    """By state of hardware, the parts by which some templates say it."""
    found: Mapping[str, tuple[str, ...]] = getattr(templates, "hardware_states", STATES)
    return found


class Touch(NamedTuple):
    """An arc of a transition that one template draws, at a place that another may have drawn.

    Args:
        transition: The transition.
        by: Whose template draws it.
        letter: What it does there, one of :data:`WORDS`.
        place: The place.
        kind: The kind of the element that the place is of.
        element: The element.
        row: Kind and part under which the place is declared; ``None`` where it is private, or this set's own.
        side: As whom the transition's template touches it.
        allowed: What that side may do.
    """

    transition: str
    by: Provenance
    letter: str
    place: str
    kind: str
    element: str
    row: tuple[str, str] | None
    side: str
    allowed: str


def touches(subject: Subject) -> Iterator[Touch]:
    """Every arc of a mission's net, with what the declarations say of it."""
    names, found = names_of(subject.mission_net.usage), subject.mission_net
    for transition in subject.net.transitions:
        by = transition.provenance
        assert by is not None, "composition notes who drew a transition"
        for letter, arcs in zip(
            WORDS, (transition.consume, transition.produce, transition.read), strict=True
        ):
            for index, _ in arcs:
                place = subject.net.places[index]
                drawn = None if place.provenance is None else drawer(place.provenance)
                meaning = names.meaning(place.name) or drawn
                if meaning is None:
                    continue  # nobody's
                kind, element, *part = meaning
                row, meeting = _declared(found, index, kind, part[0] if part else "")
                side, allowed = _sides(found, by, (kind, element), meeting)
                yield Touch(
                    transition=transition.name,
                    by=by,
                    letter=letter,
                    place=place.name,
                    kind=kind,
                    element=element,
                    row=row,
                    side=side,
                    allowed=allowed,
                )


def contract_of_arcs(subject: Subject) -> None:
    """Each transition touches the places of other templates only as these declare, and has events of its own.

    Args:
        subject: What has been composed.

    Raises:
        Violation: One does more.
    """
    for t in touches(subject):
        if t.letter not in t.allowed:
            message = f"{t.transition}, of {t.by}, {WORDS[t.letter]} {t.place}"
            raise Violation(f"{message}, which the {t.side} of {t.kind} {t.element} may not")
    for transition in subject.net.transitions:
        event, by = transition.event, transition.provenance
        kinds = HAPPENING.get(event.what) if event is not None else None
        if event is None or by is None or kinds is None:
            continue
        kind, name = drawer(by)
        if kind not in kinds or (kind == "hardware" and name != event.element):
            raise Violation(f"{transition.name}, of {by}, fires with {event}, an event of another element")


def _declared(
    found: MissionNet, place: int, kind: str, part: str
) -> tuple[tuple[str, str] | None, Meeting | None]:
    """What is declared of a place, and where: by its set, by its part's name, or by what it says.

    With a place of a name of its own the owner does what it likes; values of facts have no other name.
    """
    if place in found.meetings:
        own = found.meetings[place]
        return None, Meeting(own.says, {"owner": "tpr", **own.allowed})
    rows, role = MEETINGS.get(kind, {}), found.roles.get(place)
    for name in (part, part.rstrip("0123456789")):
        if name in rows:
            return (kind, name), rows[name]
    if role is not None and role[0] in SAYING:
        owner, name = SAYING[role[0]]
        said = MEETINGS.get(owner, {}).get(name)
        if owner == kind and said is not None:
            own = said if owner == "fact" else Meeting(said.says, {**said.allowed, "owner": "tpr"})
            return (owner, name), own
    return None, None


def _sides(
    found: MissionNet, by: Provenance, touched: tuple[str, str], meeting: Meeting | None
) -> tuple[str, str]:
    """As whom an element touches a place of another, and what it may do there."""
    kind, element = touched
    drawer_kind, name = drawer(by)
    own = touched == (drawer_kind, name) or (kind in CONTROL and by.kind in CONTROL)
    if meeting is None:
        return ("owner", "tpr") if own else ("other side", "")
    side, usage = "other side", found.usage
    if own and kind != "mission":
        side = "owner"
    elif by.kind in CONTROL:
        side = "control"
    elif kind == "fact" and drawer_kind == "activity" and element in _required(usage, name):
        side = "reader"
    elif kind == "fact" and drawer_kind == "fact" and _changed_together(usage, element, name):
        side = "event"
    elif kind == "mission" and drawer_kind == "activity":
        side = "activity"
    elif kind == "activity" and drawer_kind == "hardware" and _loses(usage, name, element):
        side = "loss"
    elif kind == "activity" and drawer_kind == "software" and found.usage.producer[name] == element:
        side = "product"
    elif drawer_kind == "activity" and kind == "software" and found.usage.producer[element] == name:
        side = "producer"
    elif drawer_kind == "activity" and kind != "activity" and element in found.usage.resources_of({name}):
        side = "consumer"
    elif drawer_kind == "activity" and kind == "hardware":
        side = "watcher"  # a supplier needs it for an alternative that the activity may return to
    return side, meeting.allowed.get(side, "")


def _required(usage: Usage, name: str) -> set[str]:
    """The facts that alternatives of an activity require; ``done(x)`` is one.

    With them those that a supplier requires for an alternative that the activity may return to.
    """
    activity = usage.activities[name]
    texts = (*activity.requires, *(text for way in activity.alternatives for text in way.requires))
    ways = (way for i in range(len(activity.alternatives)) for way in usage.switching.better(name, i))
    return {word(text).fact for text in texts} | {what.partition("=")[0] for way in ways for what in way}


def _changed_together(usage: Usage, one: str, other: str) -> bool:
    """Whether an event changes two facts at once; the transitions that do stand with one of the two."""
    return any({one, other} <= changes.keys() for changes in usage.world.changing.values())


def _loses(usage: Usage, hardware: str, activity: str) -> bool:
    """Whether an activity finds out that some hardware is lost, or that hardware stands for its crash."""
    crashes = {crash.name: crash.activity for crash in usage.core.crashes}
    return hardware in usage.activities[activity].detects or crashes.get(hardware) == activity


def drawer(by: Provenance) -> tuple[str, str]:
    """The element whose template drew something; alternatives belong to their activity."""
    return ("activity", by.name.split(".", 1)[0]) if by.kind == "alternative" else (by.kind, by.name)


def drawn_by(by: Provenance, kind: str, name: str) -> bool:
    """Whether a template draws something: ``control`` is one template, of whatever kinds it draws."""
    return by.kind in CONTROL if kind == "control" else drawer(by) == (kind, name)
