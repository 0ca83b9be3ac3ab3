"""The contract of templates: each touches places of others only as these declare.

Templates meet at places that they declare (:mod:`mcpn.drawing.templates.interface`): who *takes* a token of
them, *puts* one, or *reads* it. All other places are private to the element that draws them, also those that
a set of templates has named itself. So a template can be replaced by another one that keeps the contract, and
a proof of one side needs to know nothing of the other but this.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from typing import ClassVar, NamedTuple

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.canvas import RoleName
from mcpn.drawing.templates.interface import CONTROL, HAPPENING, MEETINGS, SAYING, Meeting
from mcpn.drawing.templates.names import names_of
from mcpn.mission.conditions import word
from mcpn.mission.model import Mission
from mcpn.mission.static.usage import Usage
from mcpn.nets.events import Event
from mcpn.nets.petri import Provenance, Transition
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
                yield Touch(transition.name, by, letter, place.name, kind, element, row, side, allowed)


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
    crashes = {crash.name: crash.activity for crash in usage.mission.crashes}
    return hardware in usage.activities[activity].detects or crashes.get(hardware) == activity


def drawer(by: Provenance) -> tuple[str, str]:
    """The element whose template drew something; alternatives belong to their activity."""
    return ("activity", by.name.split(".", 1)[0]) if by.kind == "alternative" else (by.kind, by.name)


def _drawn_by(by: Provenance, kind: str, name: str) -> bool:
    """Whether a template draws something: ``control`` is one template, of whatever kinds it draws."""
    return by.kind in CONTROL if kind == "control" else drawer(by) == (kind, name)


# --- One template alone: what it draws, cut out of a composed net, and driven by hand at its places -------
#
# The places at which it meets others stay; what others do there is the *environment*, which a machine plays
# (:mod:`mcpn.testing.kit.units`) as generally as the contract allows.


class Alone:
    """What one template draws of one element.

    Args:
        mission: A mission with the element.
        templates: The templates.
        kind: The element's kind.
        name: Its name.

    Attributes:
        usage: The static analysis of the mission.
        tokens: By name of a place, its tokens now.
        run: What has happened: transitions that fired, and in brackets what the environment did.
    """

    def __init__(self, mission: Mission, templates: TemplateSet | None, kind: str, name: str) -> None:
        found = compose(mission, templates)
        self.usage: Usage = found.usage
        self.graph = found.graph
        self._roles = found.by_role
        self._said = {place for places in self._roles.values() for place in places}
        self._names = names_of(found.usage)
        net = found.net
        self._places = [place.name for place in net.places]
        self._initial = {place.name: place.initial for place in net.places}
        drawn = (t for t in net.transitions if t.provenance is not None)
        self._own = [t for t in drawn if t.provenance is not None and _drawn_by(t.provenance, kind, name)]
        self.begin()

    def begin(self) -> None:
        """Before anything has happened."""
        self.tokens: Counter[str] = Counter(self._initial)
        self.run: list[str] = []

    def changed(self, *but: str) -> list[str]:
        """Places that say nothing of the mission and are not as at the beginning, but for some."""
        silent = (name for number, name in enumerate(self._places) if number not in self._said)
        return [name for name in silent if name not in but and self.tokens[name] != self._initial[name]]

    def place(self, kind: str, element: str, part: str, owner: str | None = None) -> str:
        """The name of a place, drawn or not."""
        return self._names.of(kind, element, part, *([owner] if owner else []))

    def says(self, role: RoleName, name: str) -> bool:
        """Whether a place with a role is marked."""
        return any(self.tokens[self._places[place]] for place in self._roles.get((role, name), ()))

    @property
    def internal(self) -> list[Transition]:
        """Internal transitions of the template that may fire: of the lowest rank."""
        enabled = [t for t in self._own if t.internal and self._enabled(t)]
        lowest = min((t.rank for t in enabled), default=0)
        return [t for t in enabled if t.rank == lowest]

    @property
    def events(self) -> dict[Event, Transition]:
        """Events that are possible where nothing internal is."""
        return {t.event: t for t in self._own if t.event is not None and self._enabled(t)}

    def _enabled(self, transition: Transition) -> bool:
        needed = (*transition.consume, *transition.read)
        return all(self.tokens[self._places[place]] >= weight for place, weight in needed)

    def fire(self, transition: Transition) -> None:
        """Fires a transition of the template."""
        self.run.append(transition.name)
        for place, weight in transition.consume:
            self.tokens[self._places[place]] -= weight
        for place, weight in transition.produce:
            self._put(self._places[place], weight)

    def move(self, said: str, taken: tuple[str, ...], put: tuple[str, ...]) -> None:
        """The environment takes tokens and puts others.

        Raises:
            Violation: A place has two then.
        """
        self.run.append(f"[{said}]")
        for place in taken:
            self.tokens[place] -= 1
        for place in put:
            self._put(place, 1)

    def _put(self, place: str, weight: int) -> None:
        self.tokens[place] += weight
        self.require(self.tokens[place] <= 1, f"a second token in {place}")

    def require(self, holds: bool, message: str) -> None:
        """Sees that something holds now.

        Raises:
            Violation: It does not.
        """
        if not holds:
            raise Violation(f"{message}, after {' '.join(self.run) or 'nothing'}")


def told(names: Iterable[str]) -> str:
    """Some names, for a message."""
    return ", ".join(sorted(names)) or "none"


CHOICE = st.integers(0, 5)
"""Which of several is taken: counted round."""


class TemplateMachine(RuleBasedStateMachine):
    """Plays what surrounds one template."""

    templates: ClassVar[TemplateSet | None] = None
    mission: ClassVar[Mission]
    element: ClassVar[tuple[str, str]]

    def __init__(self) -> None:
        super().__init__()
        self.alone = Alone(self.mission, self.templates, *self.element)

    def at(self, part: str, owner: str | None = None, element: tuple[str, str] | None = None) -> str:
        """The name of a place."""
        kind, name = element or self.element
        return self.alone.place(kind, name, part, owner)

    def has(self, part: str, owner: str | None = None, element: tuple[str, str] | None = None) -> bool:
        """Whether a place is marked."""
        return self.alone.tokens[self.at(part, owner, element)] > 0

    @property
    def at_rest(self) -> bool:
        """Whether nothing internal of the template may fire, and nobody owes it anything."""
        return not self.alone.internal and not self.owed()

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return False

    @precondition(lambda self: self.alone.internal)
    @rule(choice=CHOICE)
    def fires(self, choice: int) -> None:
        """An internal transition of the template fires, any of those that may."""
        enabled = self.alone.internal
        self.alone.fire(enabled[choice % len(enabled)])

    @precondition(lambda self: self.at_rest and self.alone.events)
    @rule(choice=CHOICE)
    def happens(self, choice: int) -> None:
        """An event of the template happens."""
        events = list(self.alone.events.values())
        self.alone.fire(events[choice % len(events)])
