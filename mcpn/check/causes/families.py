"""Families of sets on zero-suppressed diagrams, as the minimal solutions of monotone functions.

A monotone function of some elements (here: which hardware is out of service) is determined by its minimal
solutions, an antichain of sets. The diagram holds that antichain; disjunction and conjunction keep it minimal
as they go, so that functions with millions of minimal solutions stay small where these share their parts.

Source: Minato, *Zero-suppressed BDDs for set manipulation* (DAC 1993); Rauzy, *New algorithms for fault trees
analysis* (Reliability Engineering and System Safety 40, 1993); Knuth, TAOCP 7.1.4, exercises 203 to 207.

>>> families = Families(3)
>>> function = families.either(families.single(2), families.both(families.single(0), families.single(1)))
>>> families.members(function)
[(2,), (0, 1)]
>>> families.members(families.dual(function))
[(0, 2), (1, 2)]
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NewType

from mcpn.errors import LimitError

Family = NewType("Family", int)
"""A family of sets in one :class:`Families`; equal families are equal numbers."""

NEVER = Family(0)
"""The family without a set: the function that is never true."""
ALWAYS = Family(1)
"""The family of the empty set alone: the function that is always true."""

MAX_ELEMENTS = 500
MAX_LISTED = 1_000_000


class Families:
    """Minimal families over a fixed number of elements.

    Every family that the operations take and give is minimal: none of its sets holds another.

    Args:
        elements: How many elements there are; sets hold numbers below it.

    Raises:
        LimitError: More than :data:`MAX_ELEMENTS` elements.
    """

    def __init__(self, elements: int) -> None:
        if elements > MAX_ELEMENTS:
            raise LimitError(f"{elements} hardware resources: the limit on elements is {MAX_ELEMENTS}")
        self.elements = elements
        self._top: list[int] = [elements, elements]
        self._low: list[Family] = [NEVER, ALWAYS]
        self._high: list[Family] = [NEVER, ALWAYS]
        self._unique: dict[tuple[int, Family, Family], Family] = {}
        self._either: dict[tuple[Family, Family], Family] = {}
        self._both: dict[tuple[Family, Family], Family] = {}
        self._beyond: dict[tuple[Family, Family], Family] = {}
        self._dual: dict[Family, Family] = {}

    def _node(self, element: int, low: Family, high: Family) -> Family:
        if high == NEVER:
            return low
        key = element, low, high
        if key not in self._unique:
            self._unique[key] = Family(len(self._top))
            self._top.append(element)
            self._low.append(low)
            self._high.append(high)
        return self._unique[key]

    def _parts(self, family: Family, element: int) -> tuple[Family, Family]:
        """The sets without the element, and those with it (the element taken out)."""
        if self._top[family] == element:
            return self._low[family], self._high[family]
        return family, NEVER

    def single(self, element: int) -> Family:
        """The function that is true where the element is there."""
        return self._node(element, NEVER, ALWAYS)

    def any_of(self, elements: Iterable[int]) -> Family:
        """The function that is true where one of the elements is there."""
        family = NEVER
        for element in sorted(elements, reverse=True):
            family = self._node(element, family, ALWAYS)
        return family

    def all_of(self, elements: Iterable[int]) -> Family:
        """The function that is true where all of the elements are there."""
        family = ALWAYS
        for element in sorted(elements, reverse=True):
            family = self._node(element, NEVER, family)
        return family

    def either(self, first: Family, second: Family) -> Family:
        """Minimal solutions of the disjunction."""
        if first == second or second == NEVER:
            return first
        if first == NEVER:
            return second
        if ALWAYS in (first, second):
            return ALWAYS
        key = (first, second) if first < second else (second, first)
        if key not in self._either:
            element = min(self._top[first], self._top[second])
            low1, high1 = self._parts(first, element)
            low2, high2 = self._parts(second, element)
            low = self.either(low1, low2)
            high = self._without_supersets(self.either(high1, high2), low)
            self._either[key] = self._node(element, low, high)
        return self._either[key]

    def both(self, first: Family, second: Family) -> Family:
        """Minimal solutions of the conjunction."""
        if first == second or second == ALWAYS:
            return first
        if first == ALWAYS:
            return second
        if NEVER in (first, second):
            return NEVER
        key = (first, second) if first < second else (second, first)
        if key not in self._both:
            element = min(self._top[first], self._top[second])
            low1, high1 = self._parts(first, element)
            low2, high2 = self._parts(second, element)
            low = self.both(low1, low2)
            mixed = self.either(self.both(low1, high2), self.both(high1, low2))
            high = self._without_supersets(self.either(mixed, self.both(high1, high2)), low)
            self._both[key] = self._node(element, low, high)
        return self._both[key]

    def _without_supersets(self, family: Family, of: Family) -> Family:
        """Those sets of a family that hold no set of another family."""
        if of == NEVER or family == NEVER:
            return family
        if of == ALWAYS or family == of:
            return NEVER
        if family == ALWAYS:
            # A minimal family holds the empty set only where it is ALWAYS.
            return ALWAYS
        key = family, of
        if key not in self._beyond:
            element = self._top[family]
            low, high = self._parts(family, element)
            if self._top[of] < element:
                self._beyond[key] = self._without_supersets(family, self._low[of])
            else:
                of_low, of_high = self._parts(of, element)
                without = self._without_supersets(high, of_low)
                self._beyond[key] = self._node(
                    element,
                    self._without_supersets(low, of_low),
                    self._without_supersets(without, of_high),
                )
        return self._beyond[key]

    def dual(self, family: Family) -> Family:
        """The minimal sets that meet every set of the family: cut sets of path sets, and the reverse."""
        if family in (NEVER, ALWAYS):
            return ALWAYS if family == NEVER else NEVER
        if family not in self._dual:
            low, high = self.dual(self._low[family]), self.dual(self._high[family])
            without = self.both(low, high)
            self._dual[family] = self._node(self._top[family], without, self._without_supersets(low, without))
        return self._dual[family]

    def assuming(self, family: Family, given: frozenset[int]) -> Family:
        """The function where some elements are there: minimal solutions in the others."""
        memo: dict[Family, Family] = {NEVER: NEVER, ALWAYS: ALWAYS}

        def visit(node: Family) -> Family:
            if node not in memo:
                element, low, high = self._top[node], visit(self._low[node]), visit(self._high[node])
                if element in given:
                    memo[node] = self.either(low, high)
                else:
                    memo[node] = self._node(element, low, self._without_supersets(high, low))
            return memo[node]

        return visit(family)

    def inside(self, family: Family, allowed: frozenset[int]) -> Family:
        """Those sets of the family that hold allowed elements only."""
        memo: dict[Family, Family] = {NEVER: NEVER, ALWAYS: ALWAYS}

        def visit(node: Family) -> Family:
            if node not in memo:
                low = visit(self._low[node])
                element = self._top[node]
                memo[node] = low
                if element in allowed:
                    memo[node] = self._node(element, low, visit(self._high[node]))
            return memo[node]

        return visit(family)

    def support(self, family: Family) -> list[int]:
        """The elements that the function depends on."""
        seen, stack = {family}, [family]
        while stack:
            node = stack.pop()
            if node not in (NEVER, ALWAYS):
                below = {self._low[node], self._high[node]} - seen
                seen |= below
                stack += below
        return sorted({self._top[node] for node in seen - {NEVER, ALWAYS}})

    def holds(self, family: Family, elements: frozenset[int]) -> bool:
        """Whether the function is true where exactly these elements are there."""
        return self.inside(family, elements) != NEVER

    def count(self, family: Family) -> int:
        """How many minimal solutions there are."""
        memo: dict[Family, int] = {NEVER: 0, ALWAYS: 1}

        def visit(node: Family) -> int:
            if node not in memo:
                memo[node] = visit(self._low[node]) + visit(self._high[node])
            return memo[node]

        return visit(family)

    def models(self, family: Family, among: frozenset[int]) -> int:
        """How many subsets of some elements the function is true of; it must depend on no others."""
        order = sorted(among)
        place = {element: i for i, element in enumerate(order)} | {self.elements: len(order)}
        memo: dict[Family, int] = {NEVER: 0, ALWAYS: 1}

        def visit(node: Family) -> int:
            """Models over the elements from the node's own on."""
            if node not in memo:
                here = place[self._top[node]]
                low, with_it = self._low[node], self.either(self._low[node], self._high[node])
                memo[node] = sum(visit(n) << (place[self._top[n]] - here - 1) for n in (low, with_it))
            return memo[node]

        return visit(family) << place[self._top[family]]

    def least(self, family: Family) -> int | None:
        """The size of the smallest solution, or ``None`` where there is none."""
        memo: dict[Family, int | None] = {NEVER: None, ALWAYS: 0}

        def visit(node: Family) -> int | None:
            if node not in memo:
                low, high = visit(self._low[node]), visit(self._high[node])
                sizes = [size for size in (low, None if high is None else high + 1) if size is not None]
                memo[node] = min(sizes, default=None)
            return memo[node]

        return visit(family)

    def members(self, family: Family) -> list[tuple[int, ...]]:
        """The minimal solutions, smaller ones first, then by their elements.

        Raises:
            LimitError: More than :data:`MAX_LISTED` of them.
        """
        number = self.count(family)
        if number > MAX_LISTED:
            raise LimitError(f"{number} minimal sets: more than {MAX_LISTED}, the limit on listed sets")
        found: list[tuple[int, ...]] = []
        stack: list[tuple[Family, tuple[int, ...]]] = [(family, ())]
        while stack:
            node, taken = stack.pop()
            if node == ALWAYS:
                found.append(taken)
            elif node != NEVER:
                stack.append((self._low[node], taken))
                stack.append((self._high[node], (*taken, self._top[node])))
        return sorted(found, key=lambda members: (len(members), members))
