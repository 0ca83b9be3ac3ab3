"""What places and transitions are called, by their element and their part of it.

A name is the paper's: the element's, with a prefix for objectives (``OBJ_``) and parallel blocks (``PAR_``),
and the part (``GPS_sensor_take``). Elements have names that are unique in their kind only, so that these may
coincide. Where they could, one of the two is written with its kind instead: ``activity:camera:error``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import copy
from typing import Self
from weakref import WeakKeyDictionary

from mcpn.mission.core.objectives_graph import ParallelSection
from mcpn.mission.static.resource_use import Usage

_PREFIXES = {"objective": "OBJ_", "parallel": "PAR_", "once": "ONCE_", "fact": "FACT_"}


class NetNames:
    """Names for all elements of a mission, the same in its net and in the nets of its parts.

    Args:
        elements: Kind and name of each element; where two of them are called alike in nets, the first has
            the paper's names.
    """

    def __init__(self, elements: Iterable[tuple[str, str]]) -> None:
        self._owners: dict[str, tuple[str, str]] = {}
        self._begun: set[str] = set()  # proper prefixes of stems, cut where a word ends
        self._resources: set[str] = set()
        self._given: dict[tuple[str, ...], str] = {}
        self._meant: dict[str, tuple[str, ...]] = {}
        self._noted_later: list[Callable[[], Mapping[tuple[str, ...], str]]] = []
        for kind, name in elements:
            stem = _stem(kind, name)
            self._owners.setdefault(stem, (kind, name))
            self._begun.update(stem[:end] for end in _boundaries(stem) if end < len(stem))
            if kind in ("hardware", "software"):
                self._resources.add(name)

    def of(self, kind: str, element: str, *part: str) -> str:
        """The name of a part of an element, different from that of any other part of any element.

        Args:
            kind: The element's kind.
            element: Its name.
            *part: A word, and names of resources where one word would not distinguish parts; nothing for the
                element's own place.

        Returns:
            ``stem_part``, unless the stem is another element's, or text of this form may be another
            element's name with a part, or other resources would give the same text.
        """
        whole = kind, element, *part
        if whole not in self._given:
            self._given[whole] = self._name(kind, element, *part)
        return self._given[whole]

    def stem(self, kind: str, element: str) -> str | None:
        """What parts of an element begin with that are one word; ``None`` where that depends on the part."""
        stem = _stem(kind, element)
        mine = self._owners.get(stem, (kind, element)) == (kind, element)
        return stem if mine and stem not in self._begun else None

    def noted_anew(self) -> Self:
        """The same names, of which only those are noted that are given from now on."""
        other = copy(self)
        other._given, other._meant, other._noted_later = {}, {}, []
        return other

    def note_later(self, given: Callable[[], Mapping[tuple[str, ...], str]]) -> None:
        """Has names that were given without :meth:`of` noted when somebody asks what names mean."""
        self._noted_later.append(given)

    def meaning(self, name: str) -> tuple[str, ...] | None:
        """The kind, the element and the part that a name was given to; ``None`` if it was given to none."""
        while self._noted_later:
            self._given |= self._noted_later.pop()()
        if len(self._meant) < len(self._given):
            self._meant = {given: whole for whole, given in self._given.items()}
        return self._meant.get(name)

    def _name(self, kind: str, element: str, *part: str) -> str:
        stem = _stem(kind, element)
        plain = "_".join((stem, *part))
        longer = _boundaries(plain, len(stem) + 1) if part and stem in self._begun else ()
        if (
            self._owners.get(stem, (kind, element)) != (kind, element)
            or any(plain[:end] in self._owners for end in longer)
            or (len(part) > 1 and self._ways_to_read(part[1:]) > 1)
        ):
            return ":".join((kind, element, *part))
        return plain

    def _ways_to_read(self, names: tuple[str, ...]) -> int:
        """In how many ways a text is a series of names."""
        text, known = "_".join(names), self._resources.union(names)
        ways = {0: 1}  # by where the next name begins
        for end in _boundaries(text):
            ways[end + 1] = sum(n for start, n in ways.items() if text[start:end] in known)
        return ways[len(text) + 1]


def _stem(kind: str, element: str) -> str:
    return "MISSION" if kind == "mission" else f"{_PREFIXES.get(kind, '')}{element}"


def _boundaries(text: str, begin: int = 0) -> Iterator[int]:
    """Where words of a text end, from a letter on."""
    end = text.find("_", begin)
    while end >= 0:
        yield end
        end = text.find("_", end + 1)
    yield len(text)


_KNOWN: WeakKeyDictionary[Usage, NetNames] = WeakKeyDictionary()


def names_of(usage: Usage) -> NetNames:
    """The names of a mission, made once."""
    if usage not in _KNOWN:
        _KNOWN[usage] = NetNames(_elements(usage))
    return _KNOWN[usage]


def _elements(usage: Usage) -> Iterator[tuple[str, str]]:
    mission = usage.core
    yield "mission", mission.name
    crashes = [crash.name for crash in mission.crashes]
    yield from (("hardware", h.name) for h in mission.hardware if h.name not in crashes)
    yield from (("software", s.name) for s in mission.software)
    yield from (("activity", a.name) for a in mission.activities)
    yield from (("hardware", name) for name in crashes)
    yield from (("once", handler) for handler in usage.graph.once())
    yield from (("fact", fact) for fact in usage.world.facts)
    for graph in usage.graphs():
        for section in graph.sections:
            if isinstance(section, ParallelSection):
                yield "parallel", section.name
                yield from (("objective", branch.name) for branch in section.branches)
            else:
                yield "objective", section.name
