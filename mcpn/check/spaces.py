"""Who makes the space that a question is asked of: the one place where questions meet the engines.

Where nobody names an engine, static facts choose first, then who gives an answer. Stable states are listed
with their proof where they are few: that is quick, and its runs are shortest. More are held by sections;
where composition refuses a mission or hits a limit, diagrams hold the whole, as they hold all markings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, TypeAlias, TypeVar

from mcpn.errors import InputError, LimitError, PremiseError
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Space
from mcpn.space.diagrams.bounded import reach_markings
from mcpn.space.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.space.diagrams.symbolic import reach
from mcpn.space.markings.explicit import MAX_MARKINGS, Progress, explore
from mcpn.steps import Doing, step

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from mcpn.net.compose import MissionNet
    from mcpn.space.arrays import ArraySpace

# Each engine is loaded when it is asked.

On: TypeAlias = Literal["markings", "alternatives"]
Engine: TypeAlias = Literal["explicit", "symbolic", "local"]
"""Arrays, decision diagrams or composition."""
Asked: TypeAlias = Literal["auto", "explicit", "symbolic", "local"]
"""An engine by name, or ``auto``."""

FEW = 50_000
"""Stable states times sections up to which stable states are listed without being asked for.

What is asked of each section, as causes are, costs that product where states are listed.
"""

EXPECTED = 2
"""Stable states to expect at least for each section and set of hardware; most missions have 2 to 10."""

SMALL = 100_000
"""Markings listed beside few stable states, where their number is asked for or an event has two outcomes."""

MORTAL = 500_000
"""Stable states with hardware that may die that are listed beside few where it may not."""

Found = TypeVar("Found")


@dataclass(frozen=True, slots=True)
class Choice:
    """An engine that is asked, or that has answered.

    Args:
        engine: The engine.
        why: Why this one; ``None`` where it was named.
        max_states: Its limit on states that are listed; ``None`` for its own.
        allowed: The user's limit, of which the former is a part where states are few; ``None`` for none.
        brief: Whether it ends soon, whatever the mission is: it lists stable states, of which there are few.
    """

    engine: Engine
    why: str | None = None
    max_states: int | None = None
    allowed: int | None = None
    brief: bool = False

    def __str__(self) -> str:
        return f"engine {self.engine}" if self.why is None else f"engine {self.engine}: {self.why}"

    @property
    def limit(self) -> int:
        """The most states that it lists."""
        return MAX_MARKINGS if self.max_states is None else self.max_states

    def beside(self, most: int) -> int:
        """The most states of another graph that it lists: its limit, or another one where states are few."""
        if not self.brief:
            return self.limit
        return most if self.allowed is None else min(most, self.allowed)


@dataclass(frozen=True, slots=True)
class NoSpace:
    """An answer that needed no space.

    Args:
        why: How it was had.
        engine: What stands for an engine.
    """

    why: str
    engine: Literal["search"] = "search"

    def __str__(self) -> str:
        return f"engine {self.engine}: {self.why}"


def answered(
    ask: Callable[[Choice], Found],
    mission_net: MissionNet | None,
    *,
    engine: Asked,
    on: On,
    max_states: int | None = None,
) -> tuple[Found, Choice]:
    """The first answer to a question, and whose it is: of one engine after the other for ``auto``.

    Args:
        ask: Asks one engine.
        mission_net: The mission that is asked about; ``None`` for a net of no mission.
        engine: Who is asked.
        on: The graph that the question speaks of.
        max_states: The user's limit on states that are listed one by one.

    Raises:
        LimitError: No engine stays within its limits; the error is that of the last.
        PremiseError: The same, where only composition was asked.
    """
    choices = _choices(mission_net, engine, on, max_states)
    choice = next(choices)
    while True:
        try:
            return ask(choice), choice
        except (LimitError, PremiseError) as error:
            other = next(choices, None)
            if other is None:
                raise
            choice = replace(other, why=other.why or f"{choice.engine} gives no answer: {error}")


def _choices(
    mission_net: MissionNet | None, engine: Asked, on: On, max_states: int | None
) -> Iterator[Choice]:
    """The engines to ask, the one that promises most first."""
    if engine != "auto":
        yield Choice(engine, max_states=max_states)
        return
    if mission_net is None or on == "markings":
        yield Choice("symbolic", "a diagram holds all markings, however many they are", max_states)
        yield Choice("explicit", max_states=max_states)
        return
    sections = len(mission_net.graph.sections)
    limit = FEW // max(sections, 1)
    limit = limit if max_states is None else min(limit, max_states)
    many = _too_much_hardware(mission_net, limit) or _many_sections(mission_net, limit)
    if many is None:
        yield Choice("explicit", "the stable states are few", limit, max_states, brief=True)
        many = f"there are more than {limit} stable states"
    own = "the one section is" if sections == 1 else f"each type of the {sections} sections is"
    yield Choice("local", f"{many}, so {own} explored on its own", max_states)
    yield Choice("symbolic", max_states=max_states)


def expected_small(mission_net: MissionNet, max_states: int | None = None) -> bool:
    """Whether the stable states of a mission are listed before anything else is tried."""
    return next(_choices(mission_net, "auto", "alternatives", max_states)).brief


def _too_much_hardware(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission has more states than a limit, where its hardware alone says so.

    Before it begins any set of hardware may be out of service, each in a stable state of its own.
    """
    faulty = sum(h.faulty for h in mission_net.mission.hardware)
    return f"{faulty} hardware resources that may fail have 2^{faulty} states" if 2**faulty > limit else None


def _many_sections(mission_net: MissionNet, limit: int) -> str | None:
    """Why a mission is expected to have more stable states than a limit, where listing need not find it out.

    In each section that is entered any set of hardware may be out of service, in stable states of their own.
    """
    faulty, sections = sum(h.faulty for h in mission_net.mission.hardware), len(mission_net.graph.sections)
    if 2**faulty * sections * EXPECTED <= limit:
        return None
    many = f"{faulty} hardware resources that may fail in {sections} sections are expected to have many"
    return f"{many} stable states"


def space_of(
    of: PetriNet | MissionNet,
    by: Choice | Engine,
    on: On = "markings",
    *,
    progress: Progress | None = None,
    tokens: bool = True,
    may_die: bool = False,
    executor: Executor | None = None,
) -> Space[Any]:
    """The space of a net or of a mission, on one of its graphs, by one of the engines.

    Args:
        of: The net, or the mission's.
        by: The engine.
        on: The graph; the alternatives graph is of nets with priorities.
        progress: Called now and then with states and edges, or with local spaces done and to do.
        tokens: Whether the places of a net without priorities may hold several tokens.
        may_die: Whether the hardware of the mission may die (:mod:`mcpn.net.mortal`). Internal evolution is
            then known to be confluent, for dying changes nothing but what may be repaired.
        executor: Where composition explores sections; this process by default.

    Raises:
        InputError: The net has no such graph, or composition is asked of a net of no mission.
        SemanticsError: The net is unbounded, or not 1-safe though it has priorities or may hold no more than
            one token in a place; of the alternatives graph, internal evolution is not confluent or divergent.
        LimitError: A limit was hit.
    """
    net, mission_net = (of, None) if isinstance(of, PetriNet) else (of.net, of)
    by = Choice(by) if isinstance(by, str) else by
    if on == "alternatives" and not net.priorities:
        raise InputError.at(None, "the alternatives graph is of missions: this net has no priorities")
    if by.engine == "local" and (mission_net is None or on == "markings"):
        message = "composition makes the alternatives graph of a mission: sections hand on stable states only"
        raise InputError.at(None, message)
    if on == "markings":
        return markings_by(net, by, progress, tokens=tokens)
    from mcpn.space.stable.clash_words import in_mission_words

    with in_mission_words(mission_net):
        if by.engine == "local":
            assert mission_net is not None, "asked of a mission"
            from mcpn.space.local.composing import composite_space

            return composite_space(mission_net, progress=progress, may_die=may_die, executor=executor)
        if by.engine == "explicit" and not may_die:
            return stable_states(of, by, progress)[0]
        if may_die:
            assert mission_net is not None, "asked of a mission"
            from mcpn.net.mortal import mortal

            net = mortal(mission_net).net
        if by.engine == "symbolic":
            return alternatives_by(markings_by(net, by, progress), by.limit, proof=not may_die)[0]
        from mcpn.space.arrays import ArraySpace
        from mcpn.space.stable.alternatives import direct

        return ArraySpace(direct(net, proof=False, max_states=by.beside(MORTAL), progress=progress))


def stable_states(
    of: PetriNet | MissionNet, by: Choice, progress: Progress | None = None
) -> tuple[ArraySpace, str]:
    """The alternatives graph by listing, and the proof of confluence used; see :func:`space_of`."""
    net, mission_net = (of, None) if isinstance(of, PetriNet) else (of.net, of)
    if mission_net is not None and (found := _too_much_hardware(mission_net, by.limit)):
        raise LimitError(f"{found}, the limit on states is {by.limit}: use --engine local")
    step(Doing.LISTING)  # before arrays are loaded, which takes its time
    from mcpn.space.arrays import ArraySpace
    from mcpn.space.stable.alternatives import direct_with_proof

    graph = direct_with_proof(net, max_states=by.limit, progress=progress)
    return ArraySpace(graph), graph.proof or ""


def markings_by(
    net: PetriNet, by: Choice, progress: Progress | None = None, *, tokens: bool = True
) -> ArraySpace | DiagramMarkings:
    """The markings graph of a net; see :func:`space_of`."""
    step(Doing.LISTING_MARKINGS if by.engine == "explicit" else Doing.MAKING_DIAGRAM)
    if by.engine == "explicit":
        from mcpn.space.arrays import ArraySpace

        if not tokens or net.priorities:  # the net must be 1-safe
            return ArraySpace(explore(net, max_states=by.limit, progress=progress))
        from mcpn.space.markings.counted import explore_markings

        return ArraySpace(explore_markings(net, max_states=by.limit, progress=progress))
    edges = by.why is not None and not net.priorities  # no diagram was asked for by name
    space = reach_markings(net, edges=edges) if tokens else reach(net, edges=edges)
    if space.listed is not None:
        from mcpn.space.arrays import ArraySpace

        return ArraySpace(space.listed)
    return DiagramMarkings(space)


def alternatives_by(
    markings: ArraySpace | DiagramMarkings, max_states: int, *, proof: bool = True
) -> tuple[Space[Any], str]:
    """The alternatives graph of a net whose markings graph is there, and the proof of confluence used."""
    step(Doing.PROVING)
    if not isinstance(markings, DiagramMarkings):
        from mcpn.space.stable.alternatives import by_reduction

        graph = by_reduction(markings.graph)
        return type(markings)(graph), graph.proof or ""
    from mcpn.space.stable.confluence import prove_confluent

    net, space = markings.net, markings.space
    proved = prove_confluent(net, max_states=max_states, space=space) if proof else ""
    return DiagramAlternatives(space), proved
