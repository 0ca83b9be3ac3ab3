"""How large a state space is, by whichever engine counts it."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, TypeAlias

from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.spaces.engines import SMALL, Choice, On, answered
from mcpn.spaces.kept import Subject, spaces_of
from mcpn.spaces.summary import SpaceSummary, summary_of, summary_of_counts, summary_of_own

if TYPE_CHECKING:
    from mcpn.spaces.markings.explicit import Progress

Counting: TypeAlias = Literal["auto", "explicit", "symbolic", "local", "pyeda"]
"""Who counts: an engine by name, ``pyeda`` being the small reference, or ``auto``."""


def summarise(
    of: Subject, engine: str, *, max_states: int | None = None, progress: Progress | None = None
) -> SpaceSummary:
    """Explores a net and says its sizes.

    Args:
        of: The net, or its spaces.
        engine: One of :data:`mcpn.spaces.summary.ENGINES`, or one of the caller's own by its name; see
            :func:`mcpn.spaces.own.engine_named`.
        max_states: Limit for the explicit engine.
        progress: Called now and then by the explicit engine.

    Returns:
        The sizes.

    Raises:
        InputError: There is no such engine.
        UnsafeError: The net is not 1-safe, and has priorities or the engine is pyeda or of the caller's own.
        UnboundedError: The net is unbounded.
        LimitError: A limit was hit, or the engine is not installed.
    """
    started, spaces = time.perf_counter(), spaces_of(of)
    if engine == "symbolic":
        return summary_of(spaces.symbolic(), started)
    if engine == "explicit":
        return summary_of_counts(spaces.net, spaces.counted(max_states, progress), engine, started)
    if engine == "pyeda":
        return summary_of_counts(spaces.net, spaces.reference(), engine, started)
    from mcpn.spaces.own import OwnSpace, engine_named

    return summary_of_own(OwnSpace(spaces.net, engine_named(engine)), engine, started)


def sizes(
    of: Subject,
    *,
    engine: Counting = "auto",
    on: On | None = None,
    max_states: int | None = None,
    progress: Progress | None = None,
) -> tuple[SpaceSummary, Choice | None]:
    """Counts the states of a net, or of a mission.

    Args:
        of: The spaces of a net or of a mission, or what they are to be built of.
        engine: Who counts.
        on: Whether all markings are counted, or the stable states alone, which leaves all else ``None``. By
            default all markings, but for a mission that is asked of sections: by ``local``, or by ``auto``
            where there are many markings.
        max_states: Limit on states that are listed one by one.
        progress: Called now and then with states and edges, or with sections done and to do.

    Returns:
        The sizes, and the engine that was chosen; ``None`` for ``pyeda``, which is only asked by name.

    Raises:
        InputError: The net has no stable states to count.
        SemanticsError: The net is unbounded, or not 1-safe though it has priorities; of stable states, an
            event has several outcomes or none.
        LimitError: A limit was hit.
    """
    spaces = spaces_of(of)
    net = spaces.net
    if engine == "pyeda":
        return summarise(spaces, engine), None

    def markings(choice: Choice) -> SpaceSummary:
        if choice.engine == "local":  # counts stable states only: a diagram of the net counts the rest
            whole = summarise(spaces, "symbolic")
            return replace(whole, stable_states=stable(choice).stable_states, engine="local")
        return summarise(spaces, choice.engine, max_states=choice.limit, progress=progress)

    def stable(choice: Choice) -> SpaceSummary:
        started = time.perf_counter()
        count = spaces.space(choice, "alternatives", progress=progress).everything.count()
        seconds = time.perf_counter() - started
        net_size = len(net.places), len(net.transitions)
        return SpaceSummary(*net_size, None, None, count, None, None, None, None, choice.engine, seconds)

    def markings_if_few(choice: Choice) -> SpaceSummary:
        """Counts all markings where they are few, else the stable states alone."""
        if choice.engine == "symbolic":
            return markings(choice)
        try:
            if choice.brief:
                with suppress(LimitError):  # few stable states, but many markings
                    return markings(replace(choice, max_states=choice.beside(SMALL)))
            return stable(choice)
        except (
            ConfluenceError,
            DivergenceError,
        ) as error:  # the markings graph exists nevertheless: ask the next engine
            raise LimitError(str(error)) from error

    if on is None:
        if engine == "auto" and spaces.asked_on == "alternatives":
            return answered(markings_if_few, spaces.choices("auto", "alternatives", max_states))
        on = "alternatives" if engine == "local" else "markings"
    count = markings if on == "markings" else stable
    return answered(count, spaces.choices(engine, on, max_states))
