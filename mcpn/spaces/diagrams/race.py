"""The race of orders, which is how one is chosen: closures under growing budgets, side by side on the cores.

No order of places is good for every net, and none tells beforehand how good it is. So all of them work, in
rounds: each order is given steps (:attr:`mcpn._kernel.Store.steps`), the fewer the later it stands, and twice
as many in each round. An order that its budget ended goes on in the next round from what its store remembers;
so large budgets are given out in slices, between which the race may rest.
One explorer of markings one by one runs beside them: state spaces that are small but have no small diagram
are its own.

At first they stand as the candidates do. From the second round on, those whose progress says that they are
near their end stand before the others (:attr:`Runner.outlook`).

The race is repeatable whatever the machine: budgets and progress are counts, and the winner is the first, as
they stand in that round, of those that end in the earliest slice in which any does.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Iterator
from dataclasses import field
from math import isqrt
from typing import TYPE_CHECKING, Generic, Protocol, TypeAlias, TypeVar, cast

from mcpn._kernel import BudgetExceeded, Cancelled, MemoryLimit
from mcpn.errors import McpnError
from mcpn.records import record
from mcpn.turns import Pausing, finished

if TYPE_CHECKING:
    from concurrent.futures import Future

FIRST_BUDGET = 50_000
BUDGET_FACTOR = 2
SIDE_BY_SIDE = 8_000_000
"""Budgets from which on runners work in parallel; below they take turns, so that a winner saves work."""

SLICE = 500_000
"""Steps of the first runner in a slice of a round, about a quarter of a second."""

FAVOURED = 3
"""Of this many runners, number *i* gets a budget divided by *i*; later ones, by ``i ** 1.5``."""

LEAST_BUDGET = 10_000
"""The least budget with which a runner begins, since that takes time; else it waits for a later round."""

NEAR = 2.0
"""A runner with an outlook (:attr:`Racer.outlook`) of at most this works before the others, which get small
budgets meanwhile."""

Result = TypeVar("Result", covariant=True)
Made = TypeVar("Made")
Work: TypeAlias = Generator[int, None, Made]
"""Work in rounds. It says how many steps its round is of where it may rest: before the round, and inside."""


class Resting(Generic[Made]):
    """Work that is gone on with now and then, while something else is done in between.

    Args:
        work: The work.
    """

    def __init__(self, work: Work[Made]) -> None:
        self._work = work
        self._next = 0
        self.ended = False

    def go_on(self, most: int) -> bool:
        """What :meth:`going_on` returns, without pauses."""
        return finished(self.going_on(most))

    def going_on(self, most: int) -> Pausing[bool]:
        """Takes rounds of at most so many steps; whether the work has ended, be it by an error."""
        try:
            while not self.ended and self._next <= most:
                self._next = next(self._work)
                yield
        except StopIteration as end:
            self.ended, self._made = True, cast(Made, end.value)
        except McpnError as error:
            self.ended, self._error = True, error
        return self.ended

    @property
    def made(self) -> Made:
        """What comes of it; raises the error that it has ended with."""
        while not self.ended:
            self.go_on(self._next)
        if hasattr(self, "_error"):
            raise self._error
        return self._made


class Racer(Protocol[Result]):
    """A computation that can be interrupted and resumed; several race for the same result."""

    @property
    def bytes(self) -> int:
        """What it holds to go on from."""

    @property
    def outlook(self) -> float:
        """How often its work so far must double until it ends, by its progress; infinite where none shows."""

    def run(self, steps: int) -> Result:
        """Works for so many steps at most.

        Raises:
            BudgetExceeded: They do not do.
            MemoryLimit: Memory does not do.
            Cancelled: It was told to give up.
        """

    def forget(self) -> None:
        """Frees what it holds; it then begins anew."""

    def cancel(self) -> None:
        """Ends what it does now, from another thread."""


@record()
class Race(Generic[Result]):
    """Runners under budgets.

    Args:
        runners: Drawn as they are needed, the most promising first.
        memory: Bytes that all of them may hold from round to round.
        workers: How many work at a time.
        first_budget: Steps of the first runner in the first round.
        resumable: Whether runners go on where a slice has ended; else each round is one.
    """

    runners: Iterator[Racer[Result]]
    memory: int
    workers: int
    first_budget: int = FIRST_BUDGET
    resumable: bool = True
    limit: MemoryLimit | None = None
    _drawn: list[Racer[Result]] = field(default_factory=list)
    _out: set[int] = field(default_factory=set)

    def rounds(self) -> Work[Result | None]:
        """Round after round, each with its budget; returns as :meth:`run` does."""
        budget = self.first_budget
        while True:
            result = yield from self._round(budget)
            if result is not None:
                return result
            if len(self._out) == len(self._drawn):
                return None
            self._make_room()
            budget *= BUDGET_FACTOR

    def run(self) -> Result | None:
        """The result of the winner, or ``None`` where none stays within memory."""
        return finished(self.rounds())

    def _round(self, budget: int) -> Work[Result | None]:
        """One round, slice by slice."""
        slices = -(-budget // SLICE) if self.resumable else 1
        spread, given = self._spread(budget), list[tuple[int, int]]()
        for number in range(slices):
            standing = self._given(budget, slices, given) if number == 0 else given
            working = ((rank, steps) for rank, steps in standing if rank not in self._out)
            if spread:
                yield budget
                result = self._side_by_side(list(working))
            else:
                result = yield from self._in_turn(working, budget)
            if result is not None:
                return result
        return None

    def _given(self, budget: int, slices: int, given: list[tuple[int, int]]) -> Iterator[tuple[int, int]]:
        """Those that work in a round and what each has in a slice of it, which is kept for later slices."""
        for rank, steps in self._budgets(budget):
            given.append((rank, max(steps // slices, 1)))
            yield given[-1]

    def _spread(self, budget: int) -> bool:
        if self.workers == 1 or budget < SIDE_BY_SIDE or len(self._drawn) - len(self._out) < 2:
            return False
        return self._drawn[self._standing()[0]].outlook > NEAR

    def _standing(self) -> list[int]:
        """Ranks of those that still work, the nearest to their end first."""
        working = (rank for rank in range(len(self._drawn)) if rank not in self._out)
        return sorted(working, key=lambda rank: self._drawn[rank].outlook)

    def _budgets(self, budget: int) -> Iterator[tuple[int, int]]:
        """Those that work in a round, and what each is given: little beside one that is near its end."""
        near = False
        for place, rank in enumerate(self._standing()):
            behind = near and self._drawn[rank].outlook > NEAR
            yield rank, part(budget, max(place, FAVOURED) if behind else place)
            near = near or self._drawn[rank].outlook <= NEAR
        while part(budget, place := len(self._drawn)) >= LEAST_BUDGET or not place:
            if (runner := next(self.runners, None)) is None:
                break
            self._drawn.append(runner)
            yield place, part(budget, place)

    def _attempt(self, rank: int, budget: int) -> Result | None:
        try:
            return self._drawn[rank].run(budget)
        except MemoryLimit as error:
            self.limit = self.limit or error
            self._out.add(rank)
            self._drawn[rank].forget()
        except (BudgetExceeded, Cancelled):
            pass
        return None

    def _in_turn(self, given: Iterable[tuple[int, int]], budget: int) -> Work[Result | None]:
        for rank, steps in given:
            yield budget
            if (result := self._attempt(rank, steps)) is not None:
                return result
        return None

    def _side_by_side(self, given: list[tuple[int, int]]) -> Result | None:
        from concurrent.futures import ThreadPoolExecutor, as_completed

        with ThreadPoolExecutor(self.workers) as pool:
            working: dict[Future[Result | None], int] = {
                pool.submit(self._attempt, rank, steps): place for place, (rank, steps) in enumerate(given)
            }
            best: tuple[int, Result] | None = None
            try:
                for future in as_completed(working):
                    if future.cancelled() or (result := future.result()) is None:
                        continue
                    place = working[future]
                    if best is None or place < best[0]:
                        best = place, result
                        self._stop([*working], given, place)
            except BaseException:
                self._stop([*working], given, -1)
                raise
        return None if best is None else best[1]

    def _stop(self, working: list[Future[Result | None]], given: list[tuple[int, int]], beyond: int) -> None:
        """Ends those that stand after a place: they can no longer win."""
        for future, (rank, _) in list(zip(working, given, strict=True))[beyond + 1 :]:
            if not future.cancel() and not future.done():
                self._drawn[rank].cancel()

    def _make_room(self) -> None:
        """Lets the last of the runners forget what is too much to hold."""
        held = 0
        for rank in self._standing():
            runner = self._drawn[rank]
            held += runner.bytes
            if held > self.memory:
                held -= runner.bytes
                runner.forget()


def part(budget: int, place: int) -> int:
    """The share of the first runner's budget that the one at a position gets: late ones seldom win."""
    return max(budget // (place + 1 if place < FAVOURED else isqrt((place + 1) ** 3)), 1)


def cores() -> int:
    """How many processors this process may use."""
    counted: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)
    return len(counted(0)) if counted is not None else os.cpu_count() or 1
