"""The race of orders: closures under growing budgets of steps, side by side on the cores that there are.

No order of places is good for every net, and none tells beforehand how good it is. So all of them work, in
rounds: each order is given steps (:attr:`mcpn._kernel.Store.steps`), the fewer the later it stands among the
candidates, and twice as many in each round. An order that its budget ended goes on in the next round from
what its store remembers. One explorer of markings one by one runs beside them: state spaces that are small
but have no small diagram are its own.

The race is repeatable whatever the machine: the winner is the first, in the order of the candidates, of those
that end in the earliest round in which any does.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from math import isqrt
from typing import TYPE_CHECKING, Generic, Protocol, TypeVar

from mcpn._kernel import BudgetExceeded, Cancelled, MemoryLimit

if TYPE_CHECKING:
    from concurrent.futures import Future

FIRST_BUDGET = 50_000
GROWTH = 2
SIDE_BY_SIDE = 1_000_000
"""Budgets from which on runners work side by side; before, one that wins spares the others their turns."""

FAVOURED = 4
"""Runners of which each gets half, a third, a quarter of the first one's budget; later ones get less."""

Result = TypeVar("Result", covariant=True)


class Runner(Protocol[Result]):
    """One way to a result, that can be stopped and go on."""

    @property
    def bytes(self) -> int:
        """What it holds to go on from."""

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


@dataclass
class Race(Generic[Result]):
    """Runners under budgets.

    Args:
        runners: Drawn as they are needed, the most promising first.
        memory: Bytes that all of them may hold from round to round.
        workers: How many work at a time.
        first_budget: Steps of the first runner in the first round.
    """

    runners: Iterator[Runner[Result]]
    memory: int
    workers: int
    first_budget: int = FIRST_BUDGET
    limit: MemoryLimit | None = None
    _drawn: list[Runner[Result]] = field(default_factory=list)
    _out: set[int] = field(default_factory=set)

    def run(self) -> Result | None:
        """The result of the winner, or ``None`` where none stays within memory."""
        budget = self.first_budget
        while True:
            found = self._side_by_side(budget) if self._spread(budget) else self._in_turn(budget)
            if found is not None:
                return found
            if len(self._out) == len(self._drawn):
                return None
            self._make_room()
            budget *= GROWTH

    def _spread(self, budget: int) -> bool:
        return self.workers > 1 and budget >= SIDE_BY_SIDE and len(self._drawn) - len(self._out) > 1

    def _attempt(self, rank: int, budget: int) -> Result | None:
        try:
            return self._drawn[rank].run(max(budget // share(rank), 1))
        except MemoryLimit as error:
            self.limit = error
            self._out.add(rank)
            self._drawn[rank].forget()
        except (BudgetExceeded, Cancelled):
            pass
        return None

    def _in_turn(self, budget: int) -> Result | None:
        rank = 0
        while True:
            if rank == len(self._drawn):
                runner = next(self.runners, None)
                if runner is None:
                    return None
                self._drawn.append(runner)
            if rank not in self._out and (found := self._attempt(rank, budget)) is not None:
                return found
            rank += 1

    def _side_by_side(self, budget: int) -> Result | None:
        from concurrent.futures import ThreadPoolExecutor, as_completed

        ranks = [rank for rank in range(len(self._drawn)) if rank not in self._out]
        with ThreadPoolExecutor(self.workers) as pool:
            working: dict[Future[Result | None], int] = {
                pool.submit(self._attempt, rank, budget): rank for rank in ranks
            }
            best: tuple[int, Result] | None = None
            try:
                for future in as_completed(working):
                    if future.cancelled() or (found := future.result()) is None:
                        continue
                    rank = working[future]
                    if best is None or rank < best[0]:
                        best = rank, found
                        self._stop(working, rank)
            except BaseException:
                self._stop(working, -1)
                raise
        return None if best is None else best[1]

    def _stop(self, working: dict[Future[Result | None], int], beyond: int) -> None:
        """Ends those that stand after a rank: they can no longer win."""
        for future, rank in working.items():
            if rank > beyond and not future.cancel() and not future.done():
                self._drawn[rank].cancel()

    def _make_room(self) -> None:
        """Lets the last of the runners forget what is too much to hold."""
        held = 0
        for rank, runner in enumerate(self._drawn):
            held += runner.bytes
            if held > self.memory and rank not in self._out:
                held -= runner.bytes
                runner.forget()


def share(rank: int) -> int:
    """By what the first runner's budget is divided for another: the late ones seldom win."""
    return rank + 1 if rank < FAVOURED else isqrt((rank + 1) ** 3)


def cores() -> int:
    """How many processors this process may use."""
    counted: Callable[[int], set[int]] | None = getattr(os, "sched_getaffinity", None)
    return len(counted(0)) if counted is not None else os.cpu_count() or 1
