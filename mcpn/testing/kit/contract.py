"""The written contract of templates: which places they meet at, and who may mark what.

Templates meet at places of agreed parts. Each part has an *owner*, the template that draws it, and others may
touch it only as :data:`PARTS` says: who *takes* its token, *puts* one, or *reads* it. All other places are
private. So a template can be replaced by another one that keeps the contract, and a proof of one side needs
to know nothing of the other but this.

Sides: the ``resource`` itself; its ``consumer``, an activity; its ``producer``, an activity; ``control``, the
objectives graph; a ``product`` of an activity; the ``loss`` of hardware that an activity detects, or of what
stands for its crash; a ``reader``, an activity with an alternative that requires the fact,
or needs a supplier that does.

What templates call otherwise is known by the role that they declare (:data:`BY_ROLE`), as are facts.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import ClassVar, TypeAlias

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import Role, TemplateSet
from mcpn.drawing.templates.canvas import RoleName
from mcpn.drawing.templates.names import names_of
from mcpn.mission.model import Mission
from mcpn.mission.static.usage import Usage
from mcpn.mission.world.conditions import word
from mcpn.nets.events import Event
from mcpn.nets.petri import Provenance, Transition
from mcpn.testing.kit.subject import Subject, Violation

Allowed: TypeAlias = Mapping[str, str]
"""By side, what it may do to a place: letters of ``take``, ``put`` and ``read``, as ``tpr``."""

Entry: TypeAlias = tuple[str, Allowed]
"""What a token says, and who may do what."""

Contract: TypeAlias = Mapping[str, Mapping[str, Entry]]

PARTS: Contract = {
    "hardware": {
        "available": ("nobody uses it, or asks for it", {"owner": "tp", "consumer": "t"}),
        "take": ("it is asked for", {"owner": "t", "consumer": "p"}),
        "answer": ("it is held, and works", {"owner": "tp", "consumer": "tpr"}),
        "error": ("it is held, and has failed", {"owner": "p", "consumer": "tr"}),
        "release": ("it is given back", {"owner": "t", "consumer": "p"}),
        "OOS": ("it is out of service", {"owner": "tp", "consumer": "r"}),
        "free": ("it is in service (exclusive: and not in use)", {"owner": "tpr", "consumer": "r"}),
        "service": ("it is in service, for who may return", {"owner": "tp", "consumer": "r", "watcher": "r"}),
        "fine": ("detected late: it is not in use though it is gone", {"owner": "tpr", "control": "r"}),
        "doubted": ("detected late: an objective has failed that may use it", {"owner": "t", "control": "p"}),
        "undoubted": ("detected late: there is no such doubt", {"owner": "pr", "control": "t"}),
    },
    "software": {
        "available": ("the consumer neither holds it nor asks", {"owner": "p", "consumer": "tp"}),
        "take": ("it is asked for", {"owner": "t", "consumer": "p"}),
        "answer": ("it is held, and produced", {"owner": "tp", "consumer": "tpr"}),
        "error": ("it is refused, or is no longer produced", {"owner": "p", "consumer": "tr"}),
        "release": ("it is given back", {"owner": "t", "consumer": "p"}),
        "waiting": ("its producer is to answer", {"owner": "tp", "consumer": "t", "producer": "r"}),
        "free": ("its producer may stop", {"owner": "tp", "consumer": "p", "producer": "r"}),
        "unused": ("no request is open", {"owner": "tp", "consumer": "p", "producer": "r"}),
        "activation": ("its producer runs now", {"owner": "t", "producer": "p"}),
        "deactivation": ("its producer has stopped, or refuses", {"owner": "tp", "producer": "p"}),
    },
    "activity": {
        "Start": ("it is started, or evaluates again", {"owner": "tp", "control": "p"}),
        "Stop": ("an objective stops it", {"owner": "t", "control": "p"}),
        "StartByRes": ("a request starts it, or it evaluates again", {"owner": "tp", "product": "p"}),
        "error": ("no alternative is possible", {"owner": "tp"}),
        "refusing": ("the same of a producer that serves", {"owner": "tp", "product": "r"}),
        "running": ("some alternative runs", {"owner": "tp", "control": "r", "product": "r"}),
        "active1": (
            "its first alternative runs",
            {"owner": "tp", "control": "r", "product": "r", "loss": "r"},
        ),
        "active": ("another alternative runs", {"owner": "tp", "loss": "r"}),
        "idle": ("it is not started, nor stopping", {"owner": "tp", "control": "t"}),
    },
    "fact": {
        "value": (
            "the fact has this value",
            {"owner": "tpr", "control": "tpr", "reader": "r", "event": "tpr"},
        )
    },
    "mission": {
        "resting": ("an objective has ended in this reaction", {"control": "tp", "activity": "r"}),
    },
}
"""By kind of element and part of it: what a token says, and who may do what."""

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

CONTROL = frozenset({"objective", "parallel", "mission", "once"})
WORDS = {"t": "takes from", "p": "puts into", "r": "reads"}


def states_of(templates: TemplateSet | None) -> Mapping[str, tuple[str, ...]]:
    """By state of hardware, the parts by which some templates say it."""
    found: Mapping[str, tuple[str, ...]] = getattr(templates, "hardware_states", STATES)
    return found


def contract_of_arcs(of: Subject, parts: Contract = PARTS) -> None:
    """Each transition touches the places of other templates only as the contract allows.

    Args:
        of: What has been composed.
        parts: The contract.

    Raises:
        Violation: One does more.
    """
    names, found = names_of(of.mission_net.usage), of.mission_net
    for transition in of.net.transitions:
        by = transition.provenance
        assert by is not None, "composition notes who drew a transition"
        arcs = {"t": dict(transition.consume), "p": dict(transition.produce), "r": dict(transition.read)}
        for place in sorted({p for places in arcs.values() for p in places}):
            name = of.net.places[place].name
            meaning = names.meaning(name)
            if meaning is None:
                continue  # a place that the templates have named themselves
            kind, element, *part = meaning
            known = _known(parts, kind, part[0] if part else "", found.roles.get(place))
            side, allowed = _sides(found, by, (kind, element), known)
            for letter in WORDS:
                if place in arcs[letter] and letter not in allowed:
                    message = f"{transition.name}, of {by}, {WORDS[letter]} {name}"
                    raise Violation(f"{message}, which the {side} of {kind} {element} may not")


BY_ROLE: Mapping[RoleName, tuple[str, str]] = {
    "fact": ("fact", "value"),
    "oos": ("hardware", "OOS"),
    "active": ("activity", "active"),
    "refused": ("activity", "refusing"),
}
"""By role the row for places that templates have called otherwise: they are known by what they say."""


def _known(parts: Contract, kind: str, part: str, role: Role | None) -> Entry | None:
    """The row of a part: by its name, for numbered alternatives without the number, else by its role.

    With a place of a name of its own the owner does what it likes; values of facts have no other name.
    """
    rows = parts.get(kind, {})
    named = rows.get(part) or rows.get(part.rstrip("0123456789"))
    if named is None and role is not None and role[0] in BY_ROLE:
        of, row = BY_ROLE[role[0]]
        said = rows.get(row) if of == kind else None
        return said if of == "fact" else said and (said[0], {**said[1], "owner": "tpr"})
    return named


def _sides(
    found: MissionNet, by: Provenance, touched: tuple[str, str], place: Entry | None
) -> tuple[str, str]:
    """As whom an element touches a place of another, and what it may do there."""
    kind, element = touched
    drawer_kind, name = drawer(by)
    own = touched == (drawer_kind, name) or (kind in CONTROL and by.kind in CONTROL)
    if place is None:
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
    return side, place[1].get(side, "")


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
        self.of = Alone(self.mission, self.templates, *self.element)

    def at(self, part: str, owner: str | None = None, element: tuple[str, str] | None = None) -> str:
        """The name of a place."""
        kind, name = element or self.element
        return self.of.place(kind, name, part, owner)

    def has(self, part: str, owner: str | None = None, element: tuple[str, str] | None = None) -> bool:
        """Whether a place is marked."""
        return self.of.tokens[self.at(part, owner, element)] > 0

    @property
    def at_rest(self) -> bool:
        """Whether nothing internal of the template may fire, and nobody owes it anything."""
        return not self.of.internal and not self.owed()

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return False

    @precondition(lambda self: self.of.internal)
    @rule(choice=CHOICE)
    def fires(self, choice: int) -> None:
        """An internal transition of the template fires, any of those that may."""
        enabled = self.of.internal
        self.of.fire(enabled[choice % len(enabled)])

    @precondition(lambda self: self.at_rest and self.of.events)
    @rule(choice=CHOICE)
    def happens(self, choice: int) -> None:
        """An event of the template happens."""
        events = list(self.of.events.values())
        self.of.fire(events[choice % len(events)])
