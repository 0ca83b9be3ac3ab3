"""The sizes of a state space, from whichever engine counts them."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, PYEDA, SYMBOLIC, Counting, On
from mcpn.spaces.engines import SMALL, Choice, answered
from mcpn.spaces.kept import Subject, spaces_of
from mcpn.spaces.markings.explicit import Counts

if TYPE_CHECKING:
    from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
    from mcpn.spaces.own import OwnSpace
    from mcpn.spaces.pyeda_reference import ReferenceCounts

ENGINES = (EXPLICIT, SYMBOLIC, PYEDA)
"""The engines that count: marking by marking, by decision diagrams, and the independent reference."""


@dataclass(frozen=True)
class SpaceSummary:
    """Sizes of a state space, exact integers of any size; ``None`` for what was not counted.

    Args:
        places: Of the net.
        transitions: Of the net.
        states: Reachable markings.
        edges: Firings, priorities respected.
        stable_states: Markings that enable no internal transition; ``None`` for nets without priorities.
        dead_states: Markings that enable no transition.
        max_tokens: Most tokens in a marking.
        max_tokens_in_place: Most tokens in a place.
        nodes: Of the final decision diagram; ``None`` where there is none.
        engine: One of :data:`ENGINES`, ``local``, or the name of an engine of the caller's own.
        seconds: Wall-clock time of the engine.
        order: Name of the diagram's order of places; ``None`` where there is none.
        peak_nodes: Most nodes at once while the diagram was made; ``None`` where there is none.
    """

    places: int
    transitions: int
    states: int | None
    edges: int | None
    stable_states: int | None
    dead_states: int | None
    max_tokens: int | None
    max_tokens_in_place: int | None
    nodes: int | None
    engine: str
    seconds: float
    order: str | None = None
    peak_nodes: int | None = None


def summary_of(space: SymbolicSpace, started: float) -> SpaceSummary:
    """The sizes of markings reached as a diagram.

    Args:
        space: The reachable markings.
        started: When reaching them began, by :func:`time.perf_counter`.
    """
    net = space.encoding.net
    stable = None if space.stable is None else space.stable.count()
    return SpaceSummary(
        len(net.places),
        len(net.transitions),
        space.states,
        space.edges,
        stable,
        space.dead_states,
        space.max_tokens,
        space.max_tokens_in_place,
        space.nodes,
        SYMBOLIC,
        time.perf_counter() - started,
        space.order,
        None if space.nodes is None else space.peak_nodes,
    )


def summary_of_counts(
    net: PetriNet, counts: Counts | ReferenceCounts, engine: str, started: float
) -> SpaceSummary:
    """The sizes of a markings graph whose markings were counted, not kept.

    Args:
        net: The net.
        counts: The counts.
        engine: Who has counted.
        started: When counting began, by :func:`time.perf_counter`.
    """
    nodes = peak_nodes = None
    if isinstance(counts, Counts):
        stable, dead = counts.stable if net.priorities else None, counts.dead
    else:
        stable, dead = counts.stable_states, counts.dead_states
        nodes, peak_nodes = counts.nodes, counts.peak_nodes
    bounds: tuple[int, ...] = getattr(counts, "bounds", (min(counts.max_tokens, 1),))
    return SpaceSummary(
        *(len(net.places), len(net.transitions)),
        *(counts.states, counts.edges, stable, dead, counts.max_tokens, max(bounds, default=0)),
        nodes,
        engine,
        time.perf_counter() - started,
        None if nodes is None else "clustered",
        peak_nodes,
    )


def summary_of_own(space: OwnSpace, engine: str, started: float) -> SpaceSummary:
    """The sizes of a space over an engine of the caller's own.

    Args:
        space: The markings graph.
        engine: The engine's name.
        started: When the space was asked for, by :func:`time.perf_counter`.
    """
    net, reached = space.net, space.everything
    nodes = getattr(space.sets, "nodes", None)
    return SpaceSummary(
        *(len(net.places), len(net.transitions)),
        *(reached.count(), sum(space.firings(reached).values())),
        space.stable.count() if net.priorities else None,
        space.dead.count(),
        *(None, None),
        None if nodes is None else nodes(reached.raw),
        engine,
        time.perf_counter() - started,
        getattr(space.sets, "order", None),
    )


# --- How large a state space is, by whichever engine counts it --------------------------------------------


def summarise(
    subject: Subject,
    engine: str,
    *,
    max_states: int | None = None,
    seconds: float | None = None,
) -> SpaceSummary:
    """Explores a net and says its sizes.

    Args:
        subject: The net, or its spaces.
        engine: One of :data:`mcpn.spaces.sizes.ENGINES`, or one of the caller's own by its name; see
            :func:`mcpn.spaces.own.engine_named`.
        max_states: Limit for the explicit engine.
        seconds: How much CPU time pyeda may take; an hour by default.

    Returns:
        The sizes.

    Raises:
        InputError: There is no such engine.
        UnsafeError: The net is not 1-safe, and has priorities or the engine is pyeda or of the caller's own.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit, or the engine is not installed.
    """
    started, spaces = time.perf_counter(), spaces_of(subject)
    if engine == SYMBOLIC:
        return summary_of(spaces.symbolic(), started)
    if engine == EXPLICIT:
        return summary_of_counts(spaces.net, spaces.counted(max_states), engine, started)
    if engine == PYEDA:
        return summary_of_counts(spaces.net, spaces.reference(seconds), engine, started)
    from mcpn.spaces.own import OwnSpace, engine_named

    return summary_of_own(OwnSpace(spaces.net, engine_named(engine)), engine, started)


def sizes(
    subject: Subject,
    *,
    engine: Counting = "auto",
    on: On | None = None,
    max_states: int | None = None,
) -> tuple[SpaceSummary, Choice | None]:
    """Counts the states of a net, or of a mission.

    Args:
        subject: The spaces of a net or of a mission, or what they are to be built of.
        engine: Who counts.
        on: Whether all markings are counted, or the stable states alone, which leaves all else ``None``. By
            default all markings, but for a mission that is asked of sections: by ``local``, or by ``auto``
            where there are many markings.
        max_states: Limit on states that are listed one by one.

    Returns:
        The sizes, and the engine that was chosen; ``None`` for ``pyeda``, which is only asked by name.

    Raises:
        InputError: The net has no stable states to count.
        SemanticsError: The net is unbounded, or not 1-safe though it has priorities; of stable states, an
            event has several outcomes or none.
        LimitError: A limit was hit.
    """
    spaces = spaces_of(subject)
    net = spaces.net
    if engine == PYEDA:
        return summarise(spaces, engine), None

    def markings(choice: Choice) -> SpaceSummary:
        if choice.engine == LOCAL:  # counts stable states only: a diagram of the net counts the rest
            whole = summarise(spaces, SYMBOLIC)
            return replace(whole, stable_states=stable(choice).stable_states, engine=LOCAL)
        return summarise(spaces, choice.engine, max_states=choice.limit)

    def stable(choice: Choice) -> SpaceSummary:
        started = time.perf_counter()
        count = spaces.space(choice, "alternatives").everything.count()
        seconds = time.perf_counter() - started
        net_size = len(net.places), len(net.transitions)
        return SpaceSummary(*net_size, None, None, count, None, None, None, None, choice.engine, seconds)

    def markings_if_few(choice: Choice) -> SpaceSummary:
        """Counts all markings where they are few, else the stable states alone."""
        if choice.engine == SYMBOLIC:
            return markings(choice)
        try:
            if choice.brief:
                with suppress(LimitError):  # few stable states, but many markings
                    return markings(choice._replace(max_states=choice.second_limit(SMALL)))
            return stable(choice)
        except (
            ConfluenceError,
            DivergenceError,
        ) as error:  # the markings graph exists nevertheless: ask the next engine
            raise LimitError(str(error)) from error

    if on is None:
        if engine == "auto" and spaces.asked_on == "alternatives":
            return answered(markings_if_few, spaces.choices("auto", "alternatives", max_states))
        on = "alternatives" if engine == LOCAL else "markings"
    count = markings if on == "markings" else stable
    return answered(count, spaces.choices(engine, on, max_states))
