"""Local confluence: whether two internal transitions in conflict lead to the same marking again.

Where every two enabled internal transitions either commute or lead to a common marking again, and internal
evolution ends, every transient marking has one stable end (Newman's lemma, 1942). Conflicts are judged only
in markings that enable nothing but transitions in conflict (:func:`calm`).

In such a marking, one run is followed from each of the two transitions until both runs are in the same
marking. If they never are, the event has two outcomes. If they are, firings that both runs make and neither
needs are left out. The tokens that the rest consumes or reads are a sufficient condition: in every marking
that has them the same two runs lead to a common marking. So one pair of runs decides a set of markings, and
no interleavings are listed.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain

from mcpn._kernel import Zdd
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.diagrams.encoding import Encoding, distinct
from mcpn.spaces.markings.firing import MaskedNet, mask_of
from mcpn.spaces.stable.commutation import open_pairs

DECIDING_WAYS = 3_000
"""Markings behind a parting from which every order is tried before it is taken for one that decides."""


@dataclass(frozen=True, slots=True)
class Join:
    """Two transitions in conflict that lead to the same marking again.

    Args:
        needed: Places, a bit for each, whose tokens do for both ways.
    """

    needed: int


@dataclass(frozen=True, slots=True)
class Parting:
    """Two runs from one marking to two stable markings.

    Args:
        first: Transitions of one run.
        second: Those of the other; the first ones are in conflict.
    """

    first: tuple[int, ...]
    second: tuple[int, ...]


class EndlessRun(Exception):
    """An internal run comes back to a marking that it has passed.

    Args:
        run: Its transitions.
    """

    def __init__(self, run: Sequence[int]) -> None:
        super().__init__("an internal run need not end")
        self.run = tuple(run)


class Joining:
    """Joins transitions of one net; what it finds for one marking it knows for all that are alike.

    Args:
        net: A 1-safe net with priorities.

    Attributes:
        firings: How many firings it has looked at.
    """

    def __init__(self, net: PetriNet) -> None:
        self.masked = MaskedNet(net)
        self._known: dict[tuple[int, int], list[Join]] = {}
        self._rivals = [0] * len(net.transitions)
        for t, u in open_pairs(net):
            self._rivals[t] |= 1 << u
            self._rivals[u] |= 1 << t
        self.firings = 0
        self._contended = sum(1 << t for t, rivals in enumerate(self._rivals) if rivals)

    def run(self, marking: int, first: int) -> tuple[list[int], int]:
        """A run that begins with a transition and goes on to a stable marking, and that marking.

        Raises:
            EndlessRun: It comes back to a marking that it has passed.
        """
        masked = self.masked
        run, at = [first], masked.fire(marking, first)[0]
        covered, seen = masked.covered(at), {marking}
        while internal := covered & masked.internal:
            if at in seen:
                raise EndlessRun(run)
            seen.add(at)
            t = (internal & -internal).bit_length() - 1
            run.append(t)
            at = masked.fire(at, t)[0]
            covered = masked.covered_after(covered, at, t)
        self.firings += len(run)
        return run, at

    def outcome(self, marking: int, first: int, second: int) -> Join | Parting:
        """Whether two transitions, both enabled, lead to the same marking again.

        Raises:
            EndlessRun: An internal run behind them need not end.
        """
        known = self._known.setdefault((first, second), [])
        for join in known:
            if marking & join.needed == join.needed:
                return join
        one, other, joined = self._chase(marking, first, second)
        if not joined:
            return Parting(tuple(one), tuple(other))
        self._shorten(marking, one, other)
        needed = self._needed(one) | self._needed(other)
        known.append(Join(needed))
        return known[-1]

    def _chase(self, marking: int, first: int, second: int) -> tuple[list[int], list[int], bool]:
        """Extends two runs until they meet in a marking, or both end; returns both, and whether they meet.

        A transition that only one of the two markings enables fires first: it consumes tokens in which they
        differ, so that the runs usually meet after few firings. Transitions that both enable fire last.
        """
        masked = self.masked
        sides = [self._Side(masked, marking, first), self._Side(masked, marking, second)]
        while sides[0].marking != sides[1].marking:
            behind, ahead = sorted(sides, key=lambda side: len(side.run))
            internal = behind.covered & masked.internal, ahead.covered & masked.internal
            if alone := internal[0] & ~internal[1]:
                behind.fire(alone)
            elif alone := internal[1] & ~internal[0]:
                ahead.fire(alone)
            elif internal[0]:
                behind.fire(internal[0])
            else:
                break
        one, other = (side.run for side in sides)
        self.firings += len(one) + len(other)
        return one, other, sides[0].marking == sides[1].marking

    class _Side:
        """A run that is being made, and where it is."""

        def __init__(self, masked: MaskedNet, marking: int, first: int) -> None:
            self.masked = masked
            self.run = [first]
            self.marking = masked.fire(marking, first)[0]
            self.covered = masked.covered(self.marking)
            self.seen = {marking, self.marking}

        def fire(self, transitions: int) -> None:
            """Fires the first of some enabled transitions.

            Raises:
                EndlessRun: It comes back to a marking that it has passed.
            """
            t = (transitions & -transitions).bit_length() - 1
            self.run.append(t)
            self.marking = self.masked.fire(self.marking, t)[0]
            if self.marking in self.seen:
                raise EndlessRun(self.run)
            self.seen.add(self.marking)
            self.covered = self.masked.covered_after(self.covered, self.marking, t)

    def _shorten(self, marking: int, one: list[int], other: list[int]) -> None:
        """Leaves out of two runs to the same marking what both do and neither needs."""
        for at in range(len(one) - 1, 0, -1):
            if one[at] not in other[1:]:
                continue
            beside = len(other) - 1 - other[::-1].index(one[at])
            shorter = one[:at] + one[at + 1 :], other[:beside] + other[beside + 1 :]
            ends = [self._fired(marking, run) for run in shorter]
            if ends[0] is not None and ends[0] == ends[1]:
                one[:], other[:] = shorter

    def _fired(self, marking: int, run: Iterable[int]) -> int | None:
        masked = self.masked
        for t in run:
            if marking & masked.need[t] != masked.need[t]:
                return None
            marking = masked.fire(marking, t)[0]
        return marking

    def _needed(self, run: Iterable[int]) -> int:
        """The tokens with which a run can fire, where it can."""
        masked = self.masked
        needed = made = 0
        for t in run:
            needed |= masked.need[t] & ~made
            made |= masked.put[t]  # what is taken again is asked for no more, since the run can fire
        return needed

    def parting_behind(self, marking: int, most: int) -> tuple[list[int], int, Parting | None]:
        """Looks behind a marking for conflicts that decide the end.

        A transition that is in conflict with no other is fired at once: it commutes with all of them. Where
        none is left, every order is tried (*persistent sets*: Godefroid, LNCS 1032, 1996).

        Args:
            marking: Where it begins.
            most: How many markings may be left in several ways.

        Returns:
            A run to a stable marking, or to where it parts; the marking there; how it parts, if it does. The
            two transitions at which it parts decide the end: behind neither was another parting found.

        Raises:
            EndlessRun: An internal run need not end.
        """
        run, at, parting = self._some_parting(marking, most)
        return (run, at, None) if parting is None else self.deciding(run, at, parting)

    def deciding(
        self, run: list[int], marking: int, parting: Parting, most: int = DECIDING_WAYS
    ) -> tuple[list[int], int, Parting]:
        """Goes on from where two runs part to the decisive conflict, where they part for good.

        After a parting that is not decisive, one run may still come to the other's end by a later parting.

        Args:
            run: A run to the marking.
            marking: Where they part.
            parting: How.
            most: How many markings may be left in several ways, behind each transition.

        Returns:
            A run to where they part for good; the marking there; how they part.

        Raises:
            EndlessRun: An internal run need not end.
        """
        for first in (parting.first[0], parting.second[0]):
            on_way = [*run, first]
            try:
                more, at, later = self._some_parting(self.masked.fire(marking, first)[0], most)
            except EndlessRun as endless:
                raise EndlessRun([*on_way, *endless.run]) from endless
            if later is not None:
                return self.deciding([*on_way, *more], at, later, most)
        return run, marking, parting

    def _some_parting(self, marking: int, most: int) -> tuple[list[int], int, Parting | None]:
        """As :meth:`parting_behind`, but the parting need not be the decisive one."""
        masked = self.masked
        stack: list[tuple[list[int], int]] = [([], marking)]
        ended: tuple[list[int], int] | None = None
        seen = set[int]()
        while stack and (ended is None or most > 0):
            run, at = stack.pop()
            covered = masked.covered(at)
            on_way = {at}
            while (internal := covered & masked.internal) and (free := internal & ~self._contended):
                t = (free & -free).bit_length() - 1
                at = masked.fire(at, t)[0]
                run.append(t)
                if at in on_way:
                    raise EndlessRun(run)
                on_way.add(at)
                covered = masked.covered_after(covered, at, t)
            self.firings += len(on_way)
            if at in seen:
                continue
            seen.add(at)
            if not internal:
                ended = ended or (run, at)
                continue
            most -= 1
            ways = list(masked.allowed(internal))
            for t in ways:
                for u in masked.allowed(self._rivals[t] & internal & -(1 << t)):
                    try:
                        parting = self.outcome(at, t, u)
                    except EndlessRun as endless:
                        raise EndlessRun([*run, *endless.run]) from endless
                    if isinstance(parting, Parting):
                        return run, at, parting
            stack += [([*run, t], masked.fire(at, t)[0]) for t in reversed(ways)]
        if ended is None:  # no run ends: any of them shows it
            self.run(marking, next(masked.allowed(masked.covered(marking) & masked.internal)))
        assert ended is not None, "some run ends"
        return *ended, None


def calm(encoding: Encoding, begun: Zdd, conflicts: Iterable[tuple[int, int]]) -> Zdd:
    """The markings in which conflicts are judged: those in which nothing else is left to fire.

    A transition that no reachable marking enables together with one that it is in conflict with commutes with
    all that may fire before it, so that no stable marking is lost where it is always fired first (a
    persistent set of one transition: Godefroid, LNCS 1032, 1996). What is left are few of the interleavings:
    those of transitions in conflict.

    Args:
        encoding: The net on the levels of a store.
        begun: Markings just after an event, from each of which some internal run ends.
        conflicts: The pairs of internal transitions in conflict that some reachable marking enables both.

    Returns:
        Markings that are reached where transitions without conflict are fired first, and that enable none.

    Raises:
        EndlessRun: An internal run need not end.
    """
    contended = distinct(encoding.events[t] for pair in conflicts for t in pair)
    assert len(encoding.internal_ranks) <= 1, "ranks are another matter: see mcpn.spaces.stable.commutation"
    internal = chain.from_iterable(encoding.internal_ranks)
    free = dict.fromkeys(event for event in internal if event not in contended)
    conditions = [c for t, c in encoding.enabling.items() if c is not None and encoding.events.get(t) in free]
    known, front, seen = encoding.store.empty(), begun, set[Zdd]()
    # The front holds what as many firings of contended transitions lead to. It is empty once all runs ended.
    while front:
        front = front.saturate(list(free)).without(conditions)
        if front in seen:
            raise EndlessRun(())
        seen.add(front)
        known |= front
        front = front.images(contended)
    return known


def parting_among(
    encoding: Encoding, begun: Zdd, pairs: Sequence[tuple[int, int]]
) -> tuple[Marking, Parting] | None:
    """Follows the conflicts behind some markings until each rejoins, or one is found that does not.

    Args:
        encoding: The net on the levels of a store.
        begun: As of :func:`calm`.
        pairs: The same.

    Returns:
        A marking and how runs part there; ``None`` where all rejoin.

    Raises:
        EndlessRun: An internal run need not end.
    """
    safe, markings, joining = (
        encoding.net.safe_transitions,
        calm(encoding, begun, pairs),
        Joining(encoding.net),
    )
    for t, u in pairs:
        needed = (*safe[t].consume, *safe[t].read, *safe[u].consume, *safe[u].read)
        left = encoding.restricted(markings, needed)
        while (levels := left.pick()) is not None:
            marking = encoding.marking(levels)
            outcome = joining.outcome(mask_of(marking), t, u)
            if isinstance(outcome, Parting):
                return marking, outcome
            places = [p for p in range(len(marking)) if outcome.needed >> p & 1]
            left -= encoding.restricted(left, places)
    return None
