"""One template alone: what it draws, cut out of a composed net, and driven by hand at its places.

The places at which it meets others stay; what others do there is the *environment*, which a machine plays
(:mod:`mcpn.testing.kit.units`) as generally as the contract allows.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from typing import ClassVar

from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from mcpn.drawing.compose import compose
from mcpn.drawing.templates import TemplateSet
from mcpn.drawing.templates.canvas import RoleName
from mcpn.drawing.templates.net_names import names_of
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.mission.static.resource_use import Usage
from mcpn.nets.petri import Transition
from mcpn.testing.kit.contract import drawn_by
from mcpn.testing.kit.subject import Violation


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
        self._own = [t for t in drawn if t.provenance is not None and drawn_by(t.provenance, kind, name)]
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
