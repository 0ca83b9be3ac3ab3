"""What templates draw on: the net under construction, the static analysis, the roles of places."""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Hashable, Iterable, Mapping, MutableMapping
from copy import copy
from functools import cached_property, partial
from typing import Literal, Self, TypeAlias

from mcpn.drawing.templates.interface import Meeting
from mcpn.drawing.templates.net_names import names_of
from mcpn.drawing.templates.ranks import Ranks
from mcpn.errors import Source
from mcpn.events import ENDING, Event, What
from mcpn.mission.core.objectives_graph import Section
from mcpn.mission.robot import Activity, Alternative, Fact
from mcpn.mission.static.resource_use import Usage
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.provenance import Provenance

RoleName: TypeAlias = Literal[
    "active",
    "wait",
    "want",
    "refused",
    "oos",
    "known",
    "fine",
    "objective",
    "pending",
    "done",
    "success",
    "failure",
    "abort",
    "exit",
    "alive",
    "dead",
    "open",
    "happened",
    "fact",
    "ready",
    "presumed",
]
"""A kind of statement that a marked place may make."""

Role: TypeAlias = tuple[RoleName, str]
"""What a marked place says, and of which element.

``("active", "localisation.gps_localisation")``: this alternative of this activity runs;
``("wait", …)``: it is selected and waits for answers;
``("want", …)``: it would be selected but for another activity, which has a resource that it needs: it waits
for the release, and holds nothing (:meth:`~mcpn.mission.static.resource_use.Usage.waits_for_release`);
``("refused", "diving")``: no alternative of the activity is possible;
``("oos", "GPS_sensor")``: the hardware resource is out of service;
``("known", "camera")``: it is detected late, and known to be out of service;
``("fine", "camera")``: it is detected late, and nobody uses it while it is lost;
``("presumed", "camera")``: it is detected late, free, and taken to be in service (some places of it);
``("objective", "diving")``: the objective runs;
``("pending", "diving")``: the objective is about to be entered, an activity of it is not idle yet;
``("done", "filming")``: the branch of a parallel block has ended (two places, ok and fail);
``("success", mission)``, ``("failure", mission)``, ``("abort", mission)``: the mission has ended so;
``("exit", "on leak")``: a part of the mission has been left so (never in the net of the whole);
``("open", "go_home.leak")``, ``("happened", "go_home.leak")``: a handler that happens once (see
:attr:`mcpn.mission.core.objectives_graph.Interruption.once`) may happen yet, or has happened;
``("fact", "door=open")``: the fact has the value;
``("ready", "localise.by_scan")``: it has not crashed, and does not run (some places of what may crash);
``("alive", "GPS_sensor")``, ``("dead", "GPS_sensor")``: it may be repaired, or is lost for good (only in
:mod:`mcpn.drawing.permanent_loss`).
"""

Alike: TypeAlias = Callable[[Section], Hashable]
"""Equal for sections that are drawn alike, but for names and for what they lead to."""

Finish: TypeAlias = Callable[[], tuple[PetriNet, Mapping[str, int], Mapping[int, Role]]]
"""Gives a net, the numbers of places by name, and what some other places say."""


class Canvas(NetBuilder):
    """A net builder that knows the mission and notes the roles of places.

    Args:
        name: The net's name.
        usage: The static analysis of the mission.
        left_out: Activities and software resources, each as kind and name, that are not drawn: they are idle
            all the time.
        facts: Facts that are drawn.
        part: Whether the net is of a part of the mission, which begins with all hardware in service.
        alike: Which sections are drawn alike, where that is known.

    Attributes:
        most_combined: Branches up to which a block has a transition for each combination of their ends, where
            a set of templates says it.
        finish: What makes the net where some of it is copied.
    """

    def __init__(
        self,
        name: str,
        usage: Usage,
        left_out: frozenset[tuple[str, str]] = frozenset(),
        facts: tuple[Fact, ...] = (),
        *,
        part: bool = False,
        alike: Alike | None = None,
    ) -> None:
        super().__init__(name, priorities=True)
        self.alike = alike
        self.facts = facts
        self.usage = usage
        self.left_out = left_out
        self.part = part
        self.names = names_of(usage)
        self.ranks = Ranks(usage)
        self.roles: MutableMapping[str, Role] = {}
        self.meetings: dict[str, Meeting] = {}
        self.most_combined: int | None = None
        self.finish: Finish | None = None
        late = {h.name for h in usage.core.late}
        sections = usage.graph.walk() if late else ()
        self._late = {section.name: self._may_use(section.activities, late) for section in sections}

    def _may_use(self, activities: Iterable[str], late: set[str]) -> list[str]:
        """Hardware detected late that some activities, or those that may produce for them, consume."""
        reached = frozenset[str]().union(*(self.usage.closure(name) for name in activities))
        used = self.usage.resources_of(reached)
        return [h.name for h in self.usage.core.late if h.name in used & late]

    def transition(
        self,
        name: str,
        *,
        consume: Iterable[str] | Mapping[str, int] = (),
        produce: Iterable[str] | Mapping[str, int] = (),
        read: Iterable[str] | Mapping[str, int] = (),
        event: Event | None = None,
        rank: int = 0,
        provenance: Provenance | None = None,
    ) -> None:
        """Declares a transition; one that ends an objective touches hardware whose loss is detected late.

        The objective succeeds only while none of the hardware that it may use is *misused*: gone and in use.
        Where it fails, each is *doubted*, and then suspected where it is misused
        (:func:`mcpn.drawing.templates.resources.draw_hardware`).
        """
        if event is not None and event.what in ENDING and (late := self._late.get(event.element)):
            part = partial(self.place_of, "hardware")
            if event.what is What.SUCCESS:
                read = [*read, *(part(hardware, "fine") for hardware in late)]
            else:
                consume = [*consume, *(part(hardware, "undoubted") for hardware in late)]
                produce = [*produce, *(part(hardware, "doubted") for hardware in late)]
        super().transition(
            name,
            consume=consume,
            produce=produce,
            read=read,
            event=event,
            rank=rank,
            provenance=provenance,
        )

    def finished(self) -> tuple[PetriNet, dict[int, Role], dict[int, Meeting]]:
        """The net, by place in ascending order what it says, and where templates meet besides.

        Raises:
            InputError: A transition names a place that nobody declared.
        """
        if self.finish is None:
            net = self.build()
            index, said = net.place_index, dict[int, Role]()
        else:
            net, index, more = self.finish()
            said = dict(more)
        said |= {index[place]: role for place, role in self.roles.items()}
        meetings = {index[place]: meeting for place, meeting in self.meetings.items()}
        return net, dict(sorted(said.items())), meetings

    def blank(self) -> Self:
        """A canvas for the same mission with nothing on it, on which names are noted anew."""
        other = copy(self)
        NetBuilder.__init__(other, self.name, priorities=True)
        other.names, other.meetings = self.names.noted_anew(), {}
        other.roles = ChainMap({}, self.roles)
        return other

    def owners(self, resource: str) -> list[str | None]:
        """Whose interfaces of a resource are drawn (``None``: it has one for all)."""
        owners = self.usage.sharing.owners(resource)
        return [o for o in owners if o is None or ("activity", o) not in self.left_out]

    @cached_property
    def asking(self) -> str:
        """The place that says that facts are asked, after all that the event itself ends has ended."""
        return self.place_of("mission", self.usage.core.name, "asking")

    @cached_property
    def resting(self) -> list[str]:
        """Where some producer is kept, the place that says that an objective has ended in this reaction.

        It is marked until what stops has stopped, before any activity handles an error.
        """
        usage = self.usage
        drawn = (a for a in usage.started if ("activity", a) not in self.left_out)
        name = self.place_of("mission", usage.core.name, "resting")
        return [name] if any(map(usage.sharing.kept, drawn)) else []

    def role(self, place: str, role: Role) -> str:
        """Notes what the place says when it is marked, and returns the place."""
        self.roles[place] = role
        return place

    def meet(self, place: str, says: str, **allowed: str) -> str:
        """Declares that templates meet at a place of this set's own, and returns the place.

        Args:
            place: The place.
            says: What a token in it says.
            **allowed: By side, what it may do (:class:`mcpn.drawing.templates.interface.Meeting`).
        """
        self.meetings[place] = Meeting(says, allowed)
        return place

    def place_of(self, kind: str, element: str, *part: str) -> str:
        """The name of a place of an element, drawn already or not."""
        return self.names.of(kind, element, *part)

    def fact(self, name: str, value: str) -> str:
        """The place that says that a fact has a value."""
        return self.names.of("fact", name, value)

    def became(self, name: str, value: str) -> str:
        """The place that says that a fact has taken a value in this reaction."""
        return self.names.of("fact", name, f"became:{value}")

    def others(self, name: str, value: str) -> list[tuple[str, str]]:
        """The other values of a fact, each with the place that says it."""
        values = self.usage.world.facts[name].values
        return [(other, self.fact(name, other)) for other in values if other != value]

    def resource(self, name: str, part: str, owner: str | None = None) -> str:
        """The name of a place of a resource, hardware or software, or of one owner's interface of it."""
        kind = "hardware" if name in self.usage.hardware else "software"
        return self.names.of(kind, name, part, *([] if owner is None else [owner]))

    def of(self, kind: str, name: str, source: Source | None) -> Pen:
        """A pen that draws for one element of the mission."""
        return Pen(self, Provenance(kind, name, source), (kind, name))

    def answer(self, resource: str, owner: str | None) -> str:
        """The place that says that an interface is held."""
        return self.resource(resource, "answer", owner)

    def of_interface(self, kind: str, name: str, source: Source | None, owner: str | None) -> Pen:
        """A pen that draws one owner's interface of a resource."""
        return Pen(self, Provenance(kind, name, source), (kind, name), () if owner is None else (owner,))

    def of_alternative(self, activity: Activity, alternative: Alternative) -> Pen:
        """A pen that draws for one alternative; what it draws is called after the activity."""
        provenance = Provenance("alternative", f"{activity.name}.{alternative.name}", alternative.source)
        return Pen(self, provenance, ("activity", activity.name))


class Pen:
    """Draws places and transitions that all come from one element of the mission.

    Args:
        canvas: Where to draw.
        provenance: The element.
        called: Kind and name of the element after which places and transitions are called.
        owner: What is added to the part: whose interface it is.
    """

    def __init__(
        self, canvas: Canvas, provenance: Provenance, called: tuple[str, str], owner: tuple[str, ...] = ()
    ) -> None:
        self.canvas = canvas
        self.provenance = provenance
        self.called = called
        self.owner = owner

    def place(self, *part: str, initial: int = 0, element: tuple[str, str] | None = None) -> str:
        """Draws a place and returns its name.

        Args:
            *part: Which place of its element; nothing for the element's own.
            initial: Tokens of the initial marking.
            element: Kind and name of the element, where it is another than the pen's.
        """
        name = self.canvas.place_of(*(element or self.called), *part, *self.owner)
        return self.canvas.place(name, initial=initial, provenance=self.provenance)

    def own(self, name: str) -> str:
        """Draws a place whose name is known, and returns the name."""
        return self.canvas.place(name, provenance=self.provenance)

    def transition(
        self,
        part: str | tuple[str, ...],
        consume: list[str],
        produce: list[str],
        *,
        read: list[str] | None = None,
        event: Event | None = None,
        rank: int = 0,
    ) -> None:
        """Draws a transition, internal unless an event is given; its part is a word, or one with names."""
        self.canvas.transition(
            self.canvas.names.of(*self.called, *((part,) if isinstance(part, str) else part), *self.owner),
            consume=consume,
            produce=produce,
            read=read or [],
            event=event,
            rank=rank + self.canvas.ranks.below,
            provenance=self.provenance,
        )
