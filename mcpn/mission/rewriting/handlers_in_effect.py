"""Which handlers are in effect in a place: those of all blocks around it, as far as inner ones leave them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

T = TypeVar("T")


def in_effect(handlers: Iterable[T], event: Callable[[T], str | None], once: Callable[[T], bool]) -> list[T]:
    """Of handlers, the innermost first, those of each event up to the first that may happen again.

    Args:
        handlers: Those of a block, then of the blocks around it.
        event: What each is for.
        once: Whether it happens once only.

    Examples:
        >>> inner_first = [("leak", True), ("stop", False), ("leak", False), ("leak", False), ("stop", True)]
        >>> in_effect(inner_first, lambda one: one[0], lambda one: one[1])
        [('leak', True), ('stop', False), ('leak', False)]
    """
    closed, found = set[str | None](), list[T]()
    for handler in handlers:
        if event(handler) not in closed:
            found.append(handler)
        if not once(handler):
            closed.add(event(handler))
    return found
