"""What templates draw on: the net under construction, the mission's static facts and the roles of places."""

from __future__ import annotations

from typing import Literal, TypeAlias

from mcpn.errors import Source
from mcpn.mission.usage import Usage
from mcpn.net.events import Event
from mcpn.net.petri import NetBuilder, Provenance

Role: TypeAlias = tuple[
    Literal["active", "wait", "refused", "oos", "objective", "pending", "done", "success", "failure"], str
]
"""What a marked place says, and of which element.

``("active", "localisation.gps_localisation")``: this alternative of this activity runs;
``("wait", …)``: it is selected and waits for answers;
``("refused", "diving")``: no alternative of the activity is possible;
``("oos", "GPS_sensor")``: the hardware resource is out of service;
``("objective", "diving")``: the objective runs;
``("pending", "diving")``: the objective is about to be entered, an activity of it is not idle yet;
``("done", "filming")``: the branch of a parallel block has ended (two places, ok and fail);
``("success", mission)``, ``("failure", mission)``: the mission has ended so.
"""


def interface(resource: str, owner: str | None) -> str:
    """What the places of an interface are called, before ``_take`` and the like."""
    return resource if owner is None else f"{resource}_for_{owner}"


class Canvas(NetBuilder):
    """A net builder that knows the mission and notes the roles of places.

    Args:
        name: The net's name.
        usage: Static facts of the mission.
        left_out: Activities and software resources, each as kind and name, that are not drawn: they are idle
            all the time.
    """

    def __init__(self, name: str, usage: Usage, left_out: frozenset[tuple[str, str]] = frozenset()) -> None:
        super().__init__(name, priorities=True)
        self.usage = usage
        self.left_out = left_out
        self.roles: dict[str, Role] = {}

    def interfaces(self, resource: str) -> list[tuple[str, str | None]]:
        """The interfaces of a resource that are drawn: what their places are called, and whose they are."""
        owners = self.usage.sharing.owners(resource)
        drawn = [o for o in owners if o is None or ("activity", o) not in self.left_out]
        return [(interface(resource, owner), owner) for owner in drawn]

    def role(self, place: str, role: Role) -> str:
        """Notes what the place says when it is marked, and returns the place."""
        self.roles[place] = role
        return place

    def of(self, kind: str, name: str, source: Source | None) -> Pen:
        """A pen that draws for one element of the mission."""
        return Pen(self, Provenance(kind, name, source))


class Pen:
    """Draws places and transitions that all come from one element of the mission.

    Args:
        canvas: Where to draw.
        provenance: The element.
    """

    def __init__(self, canvas: Canvas, provenance: Provenance) -> None:
        self.canvas = canvas
        self.provenance = provenance

    def place(self, name: str, *, initial: int = 0) -> str:
        """Draws a place and returns its name."""
        return self.canvas.place(name, initial=initial, provenance=self.provenance)

    def transition(
        self,
        name: str,
        consume: list[str],
        produce: list[str],
        *,
        read: list[str] | None = None,
        event: Event | None = None,
    ) -> None:
        """Draws a transition, internal unless an event is given."""
        self.canvas.transition(
            name,
            consume=consume,
            produce=produce,
            read=read or [],
            event=event,
            provenance=self.provenance,
        )
