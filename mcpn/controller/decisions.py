"""The reaction to an event as a list of parts, each of which decides some of what it does.

An event that concerns activities and branches which do not meet has a product of big steps. But what it does
to one bit, and whether it orders one action, is a question of its own, and most are short: they ask for the
state before the event and for what the parts before have decided. A part is a list of rules, of which the
first that fits is taken. Each is exact by construction: its rules are found by taking states apart that it
does something in and states that it does nothing in, until none is left.

So rules grow with the number of bits and actions, not with the product of what they may be.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import inf, log2

from mcpn._kernel import Zdd
from mcpn.controller.machine import PlannedAction
from mcpn.controller.reaction import EventReaction
from mcpn.controller.reduce import levels_of
from mcpn.errors import LimitError

BUDGETS = (1, 4, 512)
"""Rules of one part, in rounds: what is decided in one round, later ones may ask for."""
POOL = 64
"""Samples of states that may serve several parts."""
MOST_RULES = BUDGETS[-1]


Rows = Sequence[tuple[tuple[int, ...], bool]]
"""Literals, and whether a part does what it may where they are true: the first that fits says so."""
_Masks = Sequence[tuple[int, int, bool]]
"""The same, by masks of bits: those that a rule asks for, and those of them that it wants set."""


@dataclass
class EventPart:
    """What an event does or does not, whatever else it does; masks have a bit for each level.

    Args:
        on: The states in which it does it.
        changes: The levels that change.
        actions: In order.
        to: The outcome with which the section is left.
        rules: Literals, and whether it is done where they are true: the first that fits says so.
            A literal beyond twice the number of levels is one on the state after the parts before.
    """

    on: Zdd
    changes: int = 0
    actions: tuple[PlannedAction, ...] = ()
    to: str | None = None
    rules: Rows = ()


class EventParts:
    """The parts of an event.

    Args:
        reaction: What it does.
        planned: The actions that it may order, in order, with the states in which it does.
        exits: By outcome with which the section may be left, the states in which it is.
        preferred: Levels that are read anyway, so that literals on them cost nothing.
        carried: Those of them that are read after the section, too.

    Attributes:
        always: What it does in all states; it comes first.
    """

    def __init__(
        self,
        reaction: EventReaction,
        planned: Sequence[tuple[PlannedAction, Zdd]],
        exits: Mapping[str, Zdd],
        preferred: Collection[int],
        carried: Collection[int],
    ) -> None:
        self.reaction = reaction
        self.always = EventPart(reaction.states, rules=[((), True)])
        self.levels = len(reaction.remembering.level)
        self._known: set[int] = set()
        self._decided = list[tuple[int, _Masks]]()
        """Levels whose changes are decided, with the rules that do."""
        self._preferred = preferred
        self._level = {at: level for level, at in enumerate(reaction.remembering.level)}
        self._literal: dict[Zdd, int] = {}
        """By the states in which a literal is true, the literal."""
        for level in preferred:
            self._know(level, reaction.states.subset([reaction.remembering.level[level]]))
        self._number: dict[tuple[int, ...], int] = {}
        """Of the states that have been looked at."""
        self._pool = reaction.nothing
        """The last ones of them."""
        self._samples = list[int]()
        """By number of such a state its marked levels, then those after the event, as far as decided."""
        self._marking = [0] * (2 * self.levels)
        """By bit of a sample, the samples that have it."""
        self.always.to = next((to for to, states in exits.items() if states == reaction.states), None)
        self._read = None if self.always.to is None else carried
        self._bits = list[EventPart]()
        self.decide(preferred)
        self._ordering = [
            EventPart(states, to=to, rules=self._rules(states, MOST_RULES))
            for to, states in exits.items()
            if states and self.always.to is None
        ]
        begun: EventPart | None = None
        for action, states in planned:
            if begun is not None and states == begun.on:
                begun.actions += (action,)
            else:
                begun = EventPart(states, actions=(action,))
                begun.rules = self._rules(states, MOST_RULES)
                self._ordering.append(begun)

    @property
    def all(self) -> list[EventPart]:
        """All parts that come then, in order."""
        return [*self._bits, *self._ordering]

    @property
    def asked(self) -> set[int]:
        """The levels that their rules ask for."""
        rules = (literals for part in self.all for literals, _ in part.rules)
        return {(literal >> 1) % self.levels for literals in rules for literal in literals}

    def decide(self, levels: Iterable[int]) -> None:
        """Adds parts for the changes of some levels; where the section is always left, of those carried."""
        flips: dict[Zdd, list[int]] = {}
        for level in sorted(levels):
            if level not in self._known and (self._read is None or level in self._read):
                self._known.add(level)
                flips.setdefault(self.reaction.flipping(self.reaction.remembering.level[level]), []).append(
                    level
                )
        begun = {part.on: part for part in (self.always, *self._bits)}
        open_ = []
        for on, those in flips.items():
            mask = sum(1 << level for level in those)
            if on in begun:
                begun[on].changes |= mask
                self._decide(mask, begun[on].rules)
            elif on:
                open_.append(EventPart(on, mask))
        for most in BUDGETS:
            left = []
            for part in open_:
                if rules := self._rules(part.on, most):
                    part.rules = rules
                    self._bits.append(part)
                    self._decide(part.changes, rules)
                else:
                    left.append(part)
            open_ = left

    def _decide(self, changes: int, rules: Rows) -> None:
        """Notes that the changes of some levels are decided by some rules."""
        masks = _masks(rules)
        self._decided.append((changes, masks))
        for level in levels_of(changes):
            self._know(self.levels + level, self.reaction.leading(self.reaction.remembering.level[level]))
        for number, sample in enumerate(self._samples):
            after = self._after(sample, changes, masks)
            self._samples[number] |= after
            for bit in levels_of(after):
                self._marking[bit] |= 1 << number

    def _know(self, bit: int, states: Zdd) -> None:
        """Notes in which states a bit is set."""
        self._literal.setdefault(states, 2 * bit + 1)
        self._literal.setdefault(self.reaction.states - states, 2 * bit)

    def _after(self, sample: int, changes: int, rules: _Masks) -> int:
        """What some levels, which rules decide, are after the event in a sample."""
        for asked, set_, does in rules:
            if sample & asked == set_:
                return ((sample ^ changes if does else sample) & changes) << self.levels
        return (sample & changes) << self.levels

    def _rules(self, on: Zdd, most: int) -> list[tuple[tuple[int, ...], bool]]:
        """The rules of a part that does something in some states; none where they are more than allowed.

        Those that fit where it does something are sought, and those that fit where it does nothing, in turn:
        whichever are all there first.
        """
        if on in self._literal:
            return [((self._literal[on],), True)]
        off = self.reaction.states - on
        sides = [(True, self._cover(on, off), list[tuple[int, ...]]()), (False, self._cover(off, on), [])]
        for _ in range(most):
            for does, covering, found in sides:
                literals = next(covering, None)
                if literals is None:
                    needed = self._needed(on if does else off, found)
                    rules = [(each, does) for each in needed]
                    return rules if does else [*rules, ((), True)]
                found.append(literals)
        if most == BUDGETS[-1]:
            raise LimitError(f"a part of an event has more than {most:,} rules")
        return []

    def _cover(self, on: Zdd, off: Zdd) -> Iterator[tuple[int, ...]]:
        """Conjunctions of literals that together fit all of some states and none of others."""
        ours, others = (self._looked_at(each) for each in (on, off))
        while on:
            literals, others = self._fitting(on, off, ours, others)
            yield literals
            on -= self._where(on, literals)

    def _needed(self, on: Zdd, found: list[tuple[int, ...]]) -> list[tuple[int, ...]]:
        """Those of some conjunctions that together fit all of some states."""
        needed = found
        for literals in found[:-1]:
            rest, left = [other for other in needed if other != literals], self._where(on, literals)
            for other in rest:
                left -= self._where(left, other)
            if not left:
                needed = rest
        return needed

    def _looked_at(self, states: Zdd) -> int:
        """The samples of the pool that are among some states."""
        return sum(1 << self._number[tuple(levels)] for levels in self._pool & states)

    def _fitting(self, on: Zdd, off: Zdd, ours: int, others: int) -> tuple[tuple[int, ...], int]:
        """Literals that are true in one of some states, and not all in any of others.

        A literal is added for each of the others that is found still to fit: the one with the best gain
        (Quinlan 1990), which keeps many samples of the ones and few of the others.

        Args:
            on: The states.
            off: The others.
            ours: The samples among the states.
            others: Those among the others.

        Returns:
            The literals, and the samples among the others.
        """
        number = self._sample(on)
        state, chosen, fits = self._samples[number], list[int](), others
        ours |= 1 << number
        while True:
            if not fits:  # of those looked at; are there more?
                if not (left := self._where(off, chosen)):
                    break
                fits = 1 << self._sample(left)
                others |= fits
            other = fits.bit_length() - 1
            base = log2(ours.bit_count() / (ours | fits).bit_count())
            best, most = -1, (-inf, False)
            for bit in levels_of(state ^ self._samples[other]):
                literal = 2 * bit | state >> bit & 1
                holding = self._holding(literal)
                kept = (ours & holding).bit_count()
                gain = kept * (log2(kept / (kept + (fits & holding).bit_count())) - base)
                if (score := (gain, self._free(bit))) > most:
                    best, most = literal, score
            chosen.append(best)
            ours &= self._holding(best)
            fits &= self._holding(best)
        for literal in chosen[:-1]:
            fewer = [other for other in chosen if other != literal]
            if not self._where(off, fewer):
                chosen = fewer
        return tuple(chosen), others

    def _sample(self, states: Zdd) -> int:
        """The number of one of some states, which are not none."""
        levels = states.pick()
        assert levels is not None, "there are some"
        number = self._number.setdefault(tuple(levels), len(self._number))
        if number == len(self._samples):
            sample = sum(1 << self._level[at] for at in levels if at in self._level)
            for changes, rules in self._decided:
                sample |= self._after(sample, changes, rules)
            for bit in levels_of(sample):
                self._marking[bit] |= 1 << number
            self._samples.append(sample)
            if number % POOL == 0:
                self._pool = self.reaction.nothing
            self._pool |= self.reaction.remembering.encoding.store.singleton(levels)
        return number

    def _holding(self, literal: int) -> int:
        """The samples in which a literal is true."""
        marking = self._marking[literal >> 1]
        return marking if literal & 1 else ~marking

    def _free(self, bit: int) -> bool:
        """Whether a literal on a bit costs nothing."""
        return bit % self.levels in self._preferred

    def _where(self, states: Zdd, literals: Iterable[int]) -> Zdd:
        """Those of some states in which all of some literals are true."""
        marked, unmarked = list[int](), list[int]()
        for literal in literals:
            level = literal >> 1
            if level < self.levels:
                (marked if literal & 1 else unmarked).append(self.reaction.remembering.level[level])
            else:
                after = self.reaction.leading(self.reaction.remembering.level[level - self.levels])
                states = states & after if literal & 1 else states - after
        return states.subset(sorted(marked), sorted(unmarked))


def _masks(rules: Rows) -> _Masks:
    """Rules by masks."""
    return [
        (sum(1 << (x >> 1) for x in literals), sum(1 << (x >> 1) for x in literals if x & 1), does)
        for literals, does in rules
    ]
