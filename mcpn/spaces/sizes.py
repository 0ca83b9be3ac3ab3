"""Counts a state space: which engine is asked, and what it is asked for."""

from __future__ import annotations

import time
from contextlib import suppress
from dataclasses import replace
from typing import Unpack

from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.spaces.engine_names import EXPLICIT, LOCAL, PYEDA, SYMBOLIC, Counting, Limited, On
from mcpn.spaces.engines import SMALL, Choice, answered
from mcpn.spaces.registry import Subject, spaces_of
from mcpn.spaces.summary import SpaceSummary, summary_of, summary_of_counts, summary_of_own


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
        engine: One of :data:`mcpn.spaces.summary.ENGINES`, or one of the caller's own by its name; see
            :func:`mcpn.spaces.custom_engine.engine_named`.
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
    from mcpn.spaces.custom_engine import OwnSpace, engine_named

    return summary_of_own(OwnSpace(spaces.net, engine_named(engine)), engine, started)


def sizes(
    subject: Subject,
    *,
    engine: Counting | None = None,
    on: On | None = None,
    **within: Unpack[Limited],
) -> tuple[SpaceSummary, Choice | None]:
    """Counts the states of a net, or of a mission.

    Args:
        subject: The spaces of a net or of a mission, or what they are to be built of.
        engine: Who counts; by default whom the spaces are bound to.
        on: Whether all markings are counted, or the stable states alone, which leaves all else ``None``. By
            default all markings, but for a mission that is asked of sections: by ``local``, or by ``auto``
            where there are many markings.
        **within: Limit on states that are listed one by one.

    Returns:
        The sizes, and the engine that was chosen; ``None`` for ``pyeda``, which is only asked by name.

    Raises:
        InputError: The net has no stable states to count.
        SemanticsError: The net is unbounded, or not 1-safe though it has priorities; of stable states, an
            event has several outcomes or none.
        LimitError: A limit was hit.
    """
    if engine == PYEDA:
        return summarise(subject, engine), None
    spaces = spaces_of(subject, **within)
    spaces = spaces if engine is None else spaces.bound(engine=engine)
    net = spaces.net

    def markings(choice: Choice) -> SpaceSummary:
        if choice.engine == LOCAL:  # counts stable states only: a diagram of the net counts the rest
            whole = summarise(spaces, SYMBOLIC)
            return replace(whole, stable_states=stable(choice).stable_states, engine=LOCAL)
        return summarise(spaces, choice.engine, max_states=choice.limit)

    def stable(choice: Choice) -> SpaceSummary:
        started = time.perf_counter()
        count = spaces.space(choice, "alternatives").everything.count()
        seconds = time.perf_counter() - started
        return SpaceSummary(
            places=len(net.places),
            transitions=len(net.transitions),
            states=None,
            edges=None,
            stable_states=count,
            dead_states=None,
            max_tokens=None,
            max_tokens_in_place=None,
            nodes=None,
            engine=choice.engine,
            seconds=seconds,
        )

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
        if spaces.engine == "auto" and spaces.asked_on == "alternatives":
            return answered(markings_if_few, spaces.choices("alternatives"))
        on = "alternatives" if spaces.engine == LOCAL else "markings"
    count = markings if on == "markings" else stable
    return answered(count, spaces.choices(on))
