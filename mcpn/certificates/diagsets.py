"""Sets of sets of levels as zero-suppressed decision diagrams, as diagcheck needs them."""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Any

try:
    from mcpn.certificates import certcheck
except ImportError:  # alone, beside the other file
    import certcheck  # type: ignore[import-not-found, no-redef]

Literal = tuple[int, bool]
"""A level, and whether it is marked."""
Word = list[tuple[int, bool, bool]]
"""What a firing needs and leaves: levels, ascending, whether marked before, and after."""
Memo = dict[Any, Any]


class Families:
    """Zero-suppressed decision diagrams: sets of sets of levels. Node 0 holds none, node 1 the empty one."""

    def __init__(self, levels: int, most: int, until: float) -> None:
        self.levels, self.most, self.until, self.steps = levels, most, until, 0
        self.level, self.low, self.high = [levels, levels], [0, 0], [0, 0]
        self.known = dict[tuple[int, int, int], int]()

    def step(self) -> None:
        """Gives up where a limit is hit."""
        self.steps += 1
        if not self.steps % 4096:
            certcheck.need(time.monotonic() <= self.until, "the time is over (--seconds)", certcheck.Limit)

    def node(self, level: int, low: int, high: int) -> int:
        """The sets of ``low``, and with the level those of ``high``."""
        if not high:
            return low
        found = self.known.get((level, low, high))
        if found is None:
            found = self.known[level, low, high] = len(self.level)
            why = f"more than {self.most} nodes (--max-nodes)"
            certcheck.need(found < self.most, why, certcheck.Limit)
            self.level.append(level)
            self.low.append(low)
            self.high.append(high)
        return found

    def read(self, rows: list[list[int]], where: str) -> list[int]:
        """The nodes that rows describe, each of children before it."""
        found = [0, 1]
        for row in rows:
            self.step()
            fine = len(row) == 3 and all(0 <= child < len(found) for child in row[1:])
            certcheck.need(fine, f"{where}: {row} is no node", certcheck.Malformed)
            level, low, high = row[0], found[row[1]], found[row[2]]
            ordered = 0 <= level < min(self.level[low], self.level[high]) and high > 0
            certcheck.need(ordered, f"{where}: {row} is out of order", certcheck.Malformed)
            found.append(self.node(level, low, high))
        return found

    def sides(self, a: int, level: int) -> tuple[int, int]:
        """The sets without a level that is not below the first, and those with it."""
        return (self.low[a], self.high[a]) if self.level[a] == level else (a, 0)

    def union(self, a: int, b: int, memo: Memo) -> int:
        """What is in one of two."""
        if not a or not b or a == b:
            return a or b
        key = (a, b) if a < b else (b, a)
        if key not in memo:
            self.step()
            level = min(self.level[a], self.level[b])
            (a0, a1), (b0, b1) = self.sides(a, level), self.sides(b, level)
            memo[key] = self.node(level, self.union(a0, b0, memo), self.union(a1, b1, memo))
        return int(memo[key])

    def without(self, a: int, cube: list[Literal]) -> int:
        """What does not satisfy all of some literals, in the order of their levels."""
        memo, last, node, step = dict[tuple[int, int], int](), len(cube), self.node, self.step
        level, low, high = self.level, self.low, self.high

        def at(a: int, i: int) -> int:
            if not a or i == last:
                return 0
            found = memo.get((a, i))
            if found is None:
                step()
                here, (asked, marked) = level[a], cube[i]
                if here < asked:
                    found = node(here, at(low[a], i), at(high[a], i))
                elif here > asked:
                    found = a if marked else at(a, i + 1)
                elif marked:
                    found = node(here, low[a], at(high[a], i + 1))
                else:
                    found = node(here, at(low[a], i + 1), high[a])
                memo[a, i] = found
            return found

        return at(a, 0)

    def some(self, a: int, cube: list[Literal]) -> bool:
        """Whether something satisfies all of some literals."""
        return self.without(a, cube) != a

    def escaping(self, a: int, b: int, word: Word) -> int:
        """What cannot fire a word, or is not in ``b`` after it."""
        memo = Memo()

        def at(a: int, b: int, i: int) -> int:
            if not a or not b:
                return a
            if (a, b, i) not in memo:
                self.step()
                asked, before, after = word[i] if i < len(word) else (self.levels, False, False)
                level = min(self.level[a], self.level[b], asked)
                if level == self.levels:
                    return 0
                (a0, a1), (b0, b1) = self.sides(a, level), self.sides(b, level)
                if level < asked:
                    found = self.node(level, at(a0, b0, i), at(a1, b1, i))
                elif before:
                    found = self.node(level, a0, at(a1, b1 if after else b0, i + 1))
                else:
                    found = self.node(level, at(a0, b1 if after else b0, i + 1), a1)
                memo[a, b, i] = found
            return int(memo[a, b, i])

        return at(a, b, 0)

    def leads(self, a: int, b: int, word: Word) -> bool:
        """Whether all that can fire a word is in ``b`` after it."""
        memo, last, levels = Memo(), len(word), self.levels
        level, low, high, step = self.level, self.low, self.high, self.step

        def at(a: int, b: int, i: int) -> bool:
            if not a or (i == last and a == b):
                return True
            found: bool | None = memo.get((a, b, i))
            if found is None:
                step()
                asked, before, after = word[i] if i < last else (levels, False, False)
                here, there = level[a], level[b]
                top = here if here < there else there
                if asked > top:
                    a0, a1 = (low[a], high[a]) if here == top else (a, 0)
                    b0, b1 = (low[b], high[b]) if there == top else (b, 0)
                    found = at(a0, b0, i) and at(a1, b1, i)
                elif asked == levels:
                    found = bool(b)
                else:
                    a_on = (high[a] if before else low[a]) if here == asked else 0 if before else a
                    b_on = (high[b] if after else low[b]) if there == asked else 0 if after else b
                    found = at(a_on, b_on, i + 1)
                memo[a, b, i] = found
            return found

        return at(a, b, 0)

    def within(self, a: int, b: int) -> bool:
        """Whether all of ``a`` is in ``b``."""
        return self.leads(a, b, [])

    def has(self, a: int, marked: Iterable[int]) -> bool:
        """Whether one set of levels is there."""
        for level in sorted(marked):
            while self.level[a] < level:
                a = self.low[a]
            if self.level[a] != level:
                return False
            a = self.high[a]
        while a > 1:
            a = self.low[a]
        return a == 1

    def minus(self, a: int, b: int) -> int:
        """What is in ``a`` alone."""
        return self.escaping(a, b, [])

    def image(self, a: int, word: Word) -> int:
        """What some sets become by firing a word, those that can."""
        memo, ends = dict[tuple[int, int], int](), len(word)

        def at(a: int, i: int) -> int:
            if not a or i == ends:
                return a
            if (a, i) not in memo:
                self.step()
                here, (asked, before, after) = self.level[a], word[i]
                if here < asked:
                    memo[a, i] = self.node(here, at(self.low[a], i), at(self.high[a], i))
                else:
                    found = at(self.sides(a, asked)[before], i + 1)
                    memo[a, i] = self.node(asked, 0, found) if after else found
            return memo[a, i]

        return at(a, 0)

    def onto(
        self, a: int, literals: list[Literal], into: Families, memo: Memo, unions: Memo, i: int = 0
    ) -> int:
        """Of each set which literals, in the order of their levels, it satisfies: their positions."""
        if not a or i == len(literals):
            return bool(a)
        if (a, i) not in memo:
            self.step()
            here, (asked, marked) = self.level[a], literals[i]
            if here < asked:
                low, high = (
                    self.onto(child, literals, into, memo, unions, i) for child in (self.low[a], self.high[a])
                )
                memo[a, i] = into.union(low, high, unions)
            else:
                others, these = self.sides(a, asked)[:: 1 if marked else -1]
                low, high = (
                    self.onto(child, literals, into, memo, unions, i + 1) for child in (others, these)
                )
                memo[a, i] = into.node(i, low, high)
        return int(memo[a, i])

    def parts(self, a: int, memo: Memo, unions: Memo) -> int:
        """What is part of a set."""
        if a < 2:
            return a
        if a not in memo:
            self.step()
            low, high = (self.parts(child, memo, unions) for child in (self.low[a], self.high[a]))
            memo[a] = self.node(self.level[a], self.union(low, high, unions), high)
        return int(memo[a])

    def holding(self, a: int, memo: Memo, unions: Memo, level: int = 0) -> int:
        """What holds a set, of levels from one on."""
        if not a or level == self.levels:
            return a
        if (a, level) not in memo:
            self.step()
            low, high = (self.holding(child, memo, unions, level + 1) for child in self.sides(a, level))
            memo[a, level] = self.node(level, low, self.union(low, high, unions))
        return int(memo[a, level])

    def count(self, a: int, memo: Memo) -> int:
        """How many sets there are."""
        if a < 2:
            return a
        if a not in memo:
            memo[a] = self.count(self.low[a], memo) + self.count(self.high[a], memo)
        return int(memo[a])

    def equals(self, a: int, memo: Memo) -> bool:
        """Whether all are pairs of equals: level 2 l marked where 2 l + 1 is."""
        if a < 2:
            return True
        if a not in memo:
            self.step()
            level, low, high = self.level[a], self.low[a], self.high[a]
            memo[a] = (
                level % 2 == 0
                and self.level[high] == level + 1
                and not self.low[high]
                and self.equals(low, memo)
                and self.equals(self.high[high], memo)
            )
        return bool(memo[a])

    def firsts(self, a: int, into: Families, memo: Memo, unions: Memo) -> int:
        """Of pairs the first ones, as sets of half as many levels."""
        if a < 2:
            return a
        if a not in memo:
            self.step()
            low, high = (self.firsts(child, into, memo, unions) for child in (self.low[a], self.high[a]))
            level = self.level[a]
            memo[a] = into.union(low, high, unions) if level % 2 else into.node(level // 2, low, high)
        return int(memo[a])


def unknown(families: Families, survived: int, cuts: Iterable[Iterable[int]]) -> int:
    """How many sets neither hold a cut nor are among those that are survived."""
    listed = 0
    for cut in cuts:
        one = 1
        for number in sorted(cut, reverse=True):
            one = families.node(number, 0, one)
        listed = families.union(listed, one, {})
    lost = families.holding(listed, {}, {})
    return int(2**families.levels) - families.count(lost, {}) - families.count(survived, {})
