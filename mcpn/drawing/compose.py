"""From a mission to its Petri net: templates drawn for every element, each place knowing its element.

Source: the paper, sections 6 and 7.1 (models "integrated and linked together").
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import cached_property

from mcpn.drawing.sections import Parts, SectionParts
from mcpn.drawing.status import Element, Flag, Status, statuses
from mcpn.drawing.templates import Canvas, PaperTemplates, Role, TemplateSet
from mcpn.drawing.templates.interface import Meeting
from mcpn.drawing.templates.named import looks_at_no_names
from mcpn.errors import Problem
from mcpn.events import START, What
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.model import Mission
from mcpn.mission.robot import Activity, Software
from mcpn.mission.static.resource_use import Usage
from mcpn.mission.static.warnings import static_warnings
from mcpn.nets.petri import Marking, PetriNet
from mcpn.notebook import Drawn
from mcpn.records import record


@record(frozen=True)
class MissionNet(Drawn):
    """The net of a mission, with what its places mean.

    Args:
        mission: The mission.
        graph: Its objectives graph.
        usage: Its static analysis.
        net: Its Petri net.
        roles: By place index, in ascending order, what the place says when it is marked.
        section_parts: What makes parts of its sections.
        meetings: By place index, where templates meet besides the places that all sets agree on.
    """

    mission: Mission
    graph: ObjectivesGraph
    usage: Usage
    net: PetriNet
    roles: Mapping[int, Role]
    section_parts: SectionParts = field(compare=False, repr=False)
    meetings: Mapping[int, Meeting] = field(default_factory=dict)

    def __repr__(self) -> str:
        sizes = f"{len(self.net.places)} places, {len(self.net.transitions)} transitions"
        return f"<net of the mission {self.mission.name}: {sizes}>"

    @property
    def core(self) -> Mission:
        """The core mission: what its hardware and its activities are, common causes written out."""
        return self.usage.core

    @cached_property
    def warnings(self) -> tuple[Problem, ...]:
        """What is suspicious in the mission by its text."""
        return tuple(static_warnings(self.usage))

    @cached_property
    def by_role(self) -> Mapping[Role, tuple[int, ...]]:
        """Places by what they say."""
        by_role: dict[Role, list[int]] = {}
        for place, role in self.roles.items():
            by_role.setdefault(role, []).append(place)
        return {role: tuple(places) for role, places in by_role.items()}

    @property
    def success(self) -> int:
        """The place that says that the mission has succeeded."""
        return self.by_role["success", self.mission.name][0]

    @property
    def failure(self) -> int:
        """The place that says that the mission has failed."""
        return self.by_role["failure", self.mission.name][0]

    @property
    def abort(self) -> int | None:
        """The place that says that the mission has been aborted; ``None`` where it cannot be."""
        return next(iter(self.by_role.get(("abort", self.mission.name), ())), None)

    @cached_property
    def exits(self) -> Mapping[str, int]:
        """Exit places by name: the mission's ends and, in the net of a part, each other exit of the part."""
        named = {name: place for place, name in self.saying("exit").items()}
        return {**self.ends, **named}

    @property
    def ends(self) -> dict[str, int]:
        """The places that say how the mission has ended, by ``success``, ``failure`` and ``abort``."""
        ends = {"success": self.success, "failure": self.failure}
        return ends if self.abort is None else {**ends, "abort": self.abort}

    @cached_property
    def start(self) -> int:
        """The transition with which the mission begins."""
        (start,) = self.net.events.of(START)
        return start

    @cached_property
    def beginning(self) -> int:
        """The place that says that the mission has not begun: the one that its start consumes."""
        ((place, _),) = self.net.transitions[self.start].consume
        return place

    @cached_property
    def in_service(self) -> Marking:
        """The initial marking, with hardware repaired that is out of service at the start."""
        net, out = self.net, {h.name for h in self.core.hardware if h.initial == "oos"}
        marking = net.initial
        for t in sorted(net.events.carrying(What.REPAIRED)) if out else ():
            event = net.transitions[t].event
            if event is not None and event.element in out:
                marking = net.fire(marking, t) if t in net.enabled(marking) else marking
        return marking

    def saying(self, kind: str) -> Mapping[int, str]:
        """Names of elements by the place that says ``kind`` of them (see :data:`Role`)."""
        return self._said.get(kind, {})

    @cached_property
    def _said(self) -> Mapping[str, dict[int, str]]:
        said: dict[str, dict[int, str]] = {}
        for place, (kind, name) in self.roles.items():
            said.setdefault(kind, {})[place] = name
        return said

    @cached_property
    def statuses(self) -> tuple[Status, ...]:
        """The status of all that the places of the net give one, in the order in which it is drawn."""
        usage = self.usage
        hardware, once, facts = (
            dict.fromkeys(self.saying(role).values()) for role in ("oos", "open", "fact")
        )
        named = dict.fromkeys(fact.partition("=")[0] for fact in facts)
        values = (usage.world.facts[name] for name in named)
        return tuple(statuses((usage.hardware[name] for name in hardware), once, values))

    def flag_places(self, flag: Flag) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """The places that are marked where a flag is true, and those that are marked where it is false."""
        known = self.by_role
        so = () if flag.so is None else known.get(flag.so, ())
        return so, () if flag.otherwise is None else known.get(flag.otherwise, ())

    def flag_bit(self, flag: Flag) -> tuple[int, bool]:
        """A place that says whether a flag is true, and whether a token there means *false*."""
        so, otherwise = self.flag_places(flag)
        return (so[0], False) if so else (otherwise[0], True)

    @cached_property
    def flag_bits(self) -> Mapping[Element, tuple[int, bool]]:
        """By flag that some place tells, its :meth:`flag_bit`."""
        every = (flag for status in self.statuses for flag in status.flags)
        return {flag.element: self.flag_bit(flag) for flag in every if any(self.flag_places(flag))}

    def not_idle(self, marking: Sequence[int]) -> list[str]:
        """Names of places that differ from the initial marking, but for status places and the mission's own.

        Status places (of hardware, handlers that happen once and facts) hold what sections hand on. Between
        two sections, and when the mission has ended, no other place should differ (the premise of
        composition). Of hardware, only places that say that it is out of service, or lost, may be marked then
        that are not marked while it is in service.
        """
        excepted, found = {"mission", "once", "fact"}, list[str]()
        out = {place for place, (said, _) in self.roles.items() if said in ("oos", "known", "dead")}
        every = zip(self.net.places, self.in_service, marking, strict=True)
        for number, (place, before, tokens) in enumerate(every):
            kind = place.provenance.kind if place.provenance else None
            if kind == "hardware":
                differs = tokens > before and number not in out
            else:
                differs = tokens != before and kind not in excepted
            if differs:
                found.append(place.name)
        return found


def compose(mission: Mission, templates: TemplateSet | None = None) -> MissionNet:
    """Composes the Petri net of a mission.

    Activities and software resources that no objective reaches are left out; hardware never is, since its
    failures come whether it is used or not.

    Args:
        mission: A mission, read or built in Python; it is checked once.
        templates: The set of templates; the paper's by default.

    Returns:
        The net with the meaning of its places. For the mission of the paper: 133 places, 150 transitions.

    Raises:
        LimitError: An element is too wide for its template.
        InputError: The mission is not valid, with every problem; or templates of the caller's name a place
            that none of them draws.
    """
    return compose_usage(Usage(mission, flatten(mission)), templates)


def compose_usage(usage: Usage, templates: TemplateSet | None = None) -> MissionNet:
    """Composes the Petri net of a mission whose objectives graph is there; see :func:`compose`."""
    mission = usage.core
    activities = [a for a in mission.activities if a.name in set(usage.started)]
    produced = {s for a in activities for s in a.produces}
    software = [s for s in mission.software if s.name in produced]
    facts = tuple(usage.world.facts.values())
    parts = Parts(usage.graph, mission.hardware, tuple(software), tuple(activities), facts)
    return compose_parts(usage, parts, templates, by_type=True)


def compose_parts(
    usage: Usage, parts: Parts, templates: TemplateSet | None = None, *, by_type: bool = False
) -> MissionNet:
    """Composes a net of some parts of a mission, each drawn as it is in the net of the whole.

    Args:
        usage: The static analysis of the whole mission.
        parts: What to draw.
        templates: The set of templates; the paper's by default.
        by_type: Whether sections that are alike are drawn once, where the templates look at no names.

    Returns:
        The net with the meaning of its places; parts of one shape give nets that differ in names only.

    Raises:
        LimitError: An element is too wide for its template.
        InputError: A template names a place that none of the parts draws.
    """
    templates = templates or PaperTemplates()
    known = _named(usage.core.software, usage.core.activities)
    left_out = known - _named(parts.software, parts.activities)
    section_parts = SectionParts(usage)
    alike = section_parts.alike if by_type and looks_at_no_names(templates) else None
    canvas = Canvas(
        usage.core.name, usage, left_out, parts.facts, part=parts.graph is not usage.graph, alike=alike
    )
    for hardware in parts.hardware:
        templates.hardware(canvas, hardware)
    for software in parts.software:
        templates.software(canvas, software)
    for activity in parts.activities:
        templates.activity(canvas, activity)
    templates.control(canvas, parts.graph)
    net, roles, meetings = canvas.finished()
    return MissionNet(usage.mission, parts.graph, usage, net, roles, section_parts, meetings)


def _named(software: tuple[Software, ...], activities: tuple[Activity, ...]) -> frozenset[tuple[str, str]]:
    """Elements as kind and name: names are unique in their kind only."""
    return frozenset((*(("software", s.name) for s in software), *(("activity", a.name) for a in activities)))
