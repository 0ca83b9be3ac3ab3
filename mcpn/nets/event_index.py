"""Which transitions of a net carry which event; each net has one such index (:attr:`PetriNet.events`)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from itertools import chain

from mcpn.events import Event, What


class EventIndex:
    """The transitions of a net by their event; events come in the order of the first transition with each.

    Args:
        carried: By transition, its event, or ``None`` for an internal one.

    Examples:
        >>> index = EventIndex([None, Event.parse("a_EV_OOS"), Event.parse("b_EV_OOS")])
        >>> index.of(Event.parse("b_EV_OOS")), index.carrying(What.OUT_OF_SERVICE), index.internal
        ((2,), (1, 2), (0,))
    """

    def __init__(self, carried: Iterable[Event | None]) -> None:
        by_event: dict[Event, tuple[int, ...] | list[int]] = {}
        internal = list[int]()
        for number, event in enumerate(carried):
            if event is None:
                internal.append(number)
            elif isinstance(known := by_event.setdefault(event, alone := (number,)), list):
                known.append(number)
            elif known is not alone:
                by_event[event] = [*known, number]
        self.internal = tuple(internal)
        self._by_event = by_event

    def __iter__(self) -> Iterator[Event]:
        return iter(self._by_event)

    def __contains__(self, event: Event) -> bool:
        return event in self._by_event

    def of(self, *events: Event) -> tuple[int, ...]:
        """The transitions that carry some events, event by event."""
        known = self._by_event
        return tuple(chain.from_iterable(known.get(event, ()) for event in events))

    def carrying(self, *whats: What) -> tuple[int, ...]:
        """The transitions whose events say that something of this kind happens."""
        return self.of(*chain.from_iterable(self._by_what.get(what, ()) for what in whats))

    def of_element(self, what: What, element: str) -> tuple[int, ...]:
        """The transitions by which something happens to an element, for whatever reason."""
        if what is What.FAILURE and (reasons := self._reasons.get(element)):
            return self.of(Event(what, element), *reasons)
        return tuple(self._by_event.get(Event(what, element), ()))

    @property
    def pairs(self) -> Sequence[tuple[int, Event]]:
        """Each transition that carries an event, with it, in the net's order."""
        every = ((number, event) for event, numbers in self._by_event.items() for number in numbers)
        return sorted(every, key=lambda pair: pair[0])

    @cached_property
    def carried(self) -> Mapping[int, Event]:
        """By transition the event that it carries; internal transitions are missing."""
        return {number: event for event, numbers in self._by_event.items() for number in numbers}

    @cached_property
    def _by_what(self) -> Mapping[What, Sequence[Event]]:
        found: dict[What, list[Event]] = {}
        for event in self._by_event:
            found.setdefault(event.what, []).append(event)
        return found

    @cached_property
    def _reasons(self) -> Mapping[str, Sequence[Event]]:
        """By element the failures of which it is said why: no other event has more than its element."""
        found: dict[str, list[Event]] = {}
        for event in self._by_event:
            if event.reason:
                found.setdefault(event.element, []).append(event)
        return found
