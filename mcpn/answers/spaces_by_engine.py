"""The state spaces of one mission, and which engine a question is asked of, also where that is ``auto``.

Where the user names no engine (``auto``), static analysis orders the engines, and the first that answers is
taken. Stable states are listed, with the proof of confluence, where few are expected: that is quick, and the
runs are shortest. Where many are expected, composition holds them section by section; where composition
refuses a mission or hits a limit, decision diagrams hold the whole mission, as they hold all markings.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf
from typing import TYPE_CHECKING, Any, TypeAlias, Unpack

from mcpn.composite.clash_sentences import in_mission_words
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.local_nets import local_net, part_of
from mcpn.drawing.permanent_loss import mortal
from mcpn.drawing.sections import refuse_wide
from mcpn.errors import InputError, LimitError
from mcpn.spaces.algebra import Space
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, SYMBOLIC, Asking, Engine, On
from mcpn.spaces.engines import Choice, choices_of_net, refuse_unknown
from mcpn.spaces.registry import Spaces, kept
from mcpn.spaces.stable.run_to_completion import MAX_STABLE_STATES

if TYPE_CHECKING:
    from mcpn.answers.mission_names import MissionNames
    from mcpn.composite.composite import CompositeSpace
    from mcpn.drawing.templates import TemplateSet
    from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
    from mcpn.spaces.search.goal import Formula
    from mcpn.spaces.stable.alternatives import AlternativesGraph

# Composition and names are loaded when they are asked.

FEW = 50_000
"""Limit on stable states times sections up to which ``auto`` lists stable states.

A question that is asked for each section, such as failure causes, costs that product on listed states.
"""

EXPECTED = 2
"""Stable states expected for each section and set of hardware out of service; most missions have 2 to 10."""

MORTAL = 500_000
"""Limit on stable states of the mission whose hardware may die, where the mission itself has few."""

MissionSubject: TypeAlias = "Spaces | MissionNet"
"""What questions about missions are asked of: spaces that may be there already, or the mission's net."""


class MissionSpaces(Spaces):
    """The state spaces of one mission, each built when it is first asked for, and then kept.

    Args:
        mission: The mission's net; an attribute, too.
        templates: Those that the mission was composed with, for composition; the paper's by default.
    """

    asked_on: On = "alternatives"

    def __init__(self, mission: MissionNet, *, templates: TemplateSet | None = None) -> None:
        super().__init__(mission.net)
        self.mission = mission
        self.templates = templates

    @property
    def one_outcome(self) -> bool:  # type: ignore[override]
        """Whether each event is known to have one outcome: nothing contends."""
        return not self.mission.usage.contentions

    def names(self, within: str = "") -> MissionNames:
        """Looks up what names and words in formulas stand for."""
        from mcpn.answers.mission_names import MissionNames

        return MissionNames(self.mission, within)

    def progress(self) -> Sequence[tuple[Formula, tuple[int, ...]]]:
        """The mission goes on: it starts, and running objectives end."""
        from mcpn.answers.mission_names import progress

        return [(constraint.states, constraint.transitions) for constraint in progress(self.mission)]

    def choices(self, on: On) -> Iterator[Choice]:
        """The engines to ask, the one that promises most first."""
        refuse_unknown(on=on)
        max_states = self.max_states
        if self.engine != "auto" or on == "markings":
            yield from choices_of_net(self.engine, max_states)
            return
        sections = len(self.mission.graph.sections)
        limit = FEW // max(sections, 1)
        limit = limit if max_states is None else min(limit, max_states)
        many = too_much_hardware(self.mission, limit) or _many_sections(self.mission, limit)
        if many is None:
            yield Choice(EXPLICIT, "the stable states are few", limit, max_states, brief=True)
            many = f"there are more than {limit} stable states, or much happens between them"
        own = "the one section is" if sections == 1 else f"each type of the {sections} sections is"
        yield Choice(LOCAL, f"{many}, so {own} explored on its own", max_states)
        yield Choice(SYMBOLIC, max_states=max_states)

    def few(self) -> bool:
        """Whether the stable states are listed before anything else is tried."""
        return next(self.bound(engine="auto").choices("alternatives")).brief

    def space(
        self,
        by: Choice | Engine,
        on: On = "markings",
        *,
        tokens: bool = True,
        may_die: bool = False,
    ) -> Space[Any]:
        """The space on one of the graphs, by an engine; see :meth:`mcpn.spaces.registry.Spaces.space`.

        Args:
            by: The engine; ``local`` composes the alternatives graph.
            on: The graph.
            tokens: As there; the net of a mission must be 1-safe.
            may_die: Whether the hardware of the mission may die
                (:mod:`mcpn.drawing.permanent_loss`). Internal evolution is then known to be confluent, for
                dying changes nothing but what may be repaired;
                where something may crash, which then does so at any moment, it is proved again.

        Raises:
            InputError: There is no such graph by this engine.
            SemanticsError: The net is not 1-safe, or internal evolution is not confluent or divergent.
            LimitError: A limit was hit.
        """
        by = Choice(by) if isinstance(by, str) else by
        if on == "markings" or not self.net.priorities:
            return super().space(by, on, tokens=tokens)
        with in_mission_words(self._mortal.mission if may_die and by.engine != LOCAL else self.mission):
            if by.engine == LOCAL:
                return self.composite(may_die=may_die)
            return self._dying(by) if may_die else super().space(by, on)

    def _dying(self, by: Choice) -> Space[Any]:
        """The alternatives graph of the mission where its hardware may die, states listed or on diagrams."""
        proof = bool(self.mission.core.crashes)
        if by.engine == SYMBOLIC:
            return self._mortal.reduced(by, proof=proof)[0]
        limit = by.second_limit(MORTAL)
        return self._mortal._listed((limit, inf)).space if proof else self._mortal.unproved(limit)

    @property
    @kept()
    def _mortal(self) -> MissionSpaces:
        """The spaces of the same mission where hardware may die."""
        return MissionSpaces(mortal(self.mission))

    def within(self, by: Choice) -> tuple[int, float]:
        """How many stable states may be listed, unless hardware alone means more."""
        if reason := too_much_hardware(self.mission, by.limit):
            raise LimitError(f"{reason}, the limit on states is {by.limit}: use --engine local")
        return super().within(by)

    def symbolic(self, *, tokens: bool = True, edges: bool = False) -> SymbolicSpace:
        """All markings as a diagram; a mission whose net alone would be too large is refused."""
        refuse_wide(map(self.mission.section_parts.alone, self.mission.graph.sections))
        return super().symbolic(tokens=tokens, edges=edges)

    @kept()
    def composite(self, *, may_die: bool = False) -> CompositeSpace:
        """The alternatives graph of the mission by composition; see :meth:`space`.

        Raises:
            PremiseError: A section hands on more than the state of its hardware.
        """
        from mcpn.composite.composing import composite_space

        return composite_space(self.mission, templates=self.templates, may_die=may_die)

    @kept()
    def section(self, name: str) -> MissionSpaces:
        """The spaces of one section on its own net, which begins where the section does.

        Raises:
            InputError: There is no such section.
        """
        return MissionSpaces(local_net(part_of(self.mission, name), self.templates))

    def local(self, name: str, max_states: int | None = None) -> tuple[MissionNet, AlternativesGraph]:
        """The local graph of a section, with its net; see :func:`mcpn.composite.composing.local_graph`."""
        return self._local(name, MAX_STABLE_STATES if max_states is None else max_states)

    @kept("max_states")
    def _local(self, name: str, max_states: int) -> tuple[MissionNet, AlternativesGraph]:
        from mcpn.composite.composing import local_graph

        return local_graph(self.mission, name, max_states, self.templates)


def spaces_of(subject: MissionSubject, **asked: Unpack[Asking]) -> MissionSpaces:
    """The spaces of a mission's net, bound to who is asked; those that are given, if they are.

    Raises:
        InputError: These are the spaces of a net of no mission.
    """
    if isinstance(subject, MissionSpaces):
        return subject.bound(**asked)
    if isinstance(subject, Spaces):
        raise InputError.at(None, f"{subject.net.name} is a net of no mission: expected a mission")
    return MissionSpaces(subject).bound(**asked)


def too_much_hardware(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission has more states than a limit, where its hardware alone says so.

    Before it begins any set of hardware may be out of service, each in a stable state of its own. What stands
    for software that crashes is not: it fails only while it runs.
    """
    mission = mission_net.core
    faulty = sum(h.faulty for h in mission.hardware) - sum(c.faulty for c in mission.crashes)
    return f"{faulty} hardware resources that may fail have 2^{faulty} states" if 2**faulty > limit else None


def _many_sections(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission is expected to have more stable states than a limit, where listing need not find it out.

    In each section that is entered any set of hardware may be out of service, in stable states of their own,
    and what has run may have crashed.
    """
    mission, started = mission_net.core, mission_net.usage.started
    never = sum(c.faulty for c in mission.crashes if c.activity not in started)
    faulty = sum(h.faulty for h in mission.hardware) - never
    sections = len(mission_net.graph.sections)
    if 2**faulty * sections * EXPECTED <= limit:
        return None
    many = f"{faulty} hardware resources that may fail in {sections} sections are expected to have many"
    return f"{many} stable states"
