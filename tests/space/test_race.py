"""The race: who wins whatever the machine, what budgets are given, what is let go."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import BudgetExceeded, Cancelled, MemoryLimit
from mcpn.errors import LimitError, UnsafeError
from mcpn.net.petri import NetBuilder, PetriNet
from mcpn.space.diagrams.order import cuthill_mckee
from mcpn.space.diagrams.race import Race
from mcpn.space.diagrams.symbolic import reach
from tests.net.nets import nets


@dataclass
class Worker:
    """Needs so many steps in all; goes on where it was unless it forgot."""

    name: int
    needs: int
    held: int = 0
    memory: int = 1 << 60
    done: int = 0
    budgets: list[int] = field(default_factory=list)
    cancelled: threading.Event = field(default_factory=threading.Event)
    patient: bool = False  # goes on until it is cancelled
    begun: threading.Event = field(default_factory=threading.Event)
    after: Worker | None = None  # goes on when that one has begun to be patient

    @property
    def bytes(self) -> int:
        return self.held

    def run(self, steps: int) -> int:
        self.budgets.append(steps)
        if self.patient and steps >= 500_000:
            self.begun.set()
            assert self.cancelled.wait(30)
            raise Cancelled
        if self.after is not None and steps >= 1_000_000:
            assert self.after.begun.wait(30)
        self.done += steps
        if self.done >= self.memory:
            raise MemoryLimit
        if self.done < self.needs:
            raise BudgetExceeded
        return self.name

    def forget(self) -> None:
        self.done = self.held = 0

    def cancel(self) -> None:
        self.cancelled.set()


def winner(needs: list[int]) -> int:
    """The first of those that end in the earliest round, by hand."""
    budget, done = 50_000, [0] * len(needs)
    while True:
        done = [
            had + budget // (rank + 1 if rank < 4 else int((rank + 1) ** 1.5))
            for rank, had in enumerate(done)
        ]
        ended = [rank for rank, (had, need) in enumerate(zip(done, needs, strict=True)) if had >= need]
        if ended:
            return ended[0]
        budget *= 2


@given(st.lists(st.integers(1, 3_000_000), min_size=1, max_size=9), st.integers(1, 4))
def test_the_winner_does_not_depend_on_the_machine(needs: list[int], workers: int) -> None:
    runners = [Worker(rank, need) for rank, need in enumerate(needs)]
    assert Race(iter(runners), 1 << 60, workers).run() == winner(needs)


def test_later_orders_are_not_made_where_the_first_wins() -> None:
    def drawn() -> Iterator[Worker]:
        yield Worker(0, 10)
        raise AssertionError("asked for more")

    assert Race(drawn(), 1 << 60, 2).run() == 0


def test_who_can_no_longer_win_is_stopped() -> None:
    endless = Worker(1, 1 << 60, patient=True)
    assert Race(iter([Worker(0, 2_000_000, after=endless), endless]), 1 << 60, 2).run() == 0
    assert endless.cancelled.is_set()


def test_memory_is_let_go_from_the_last_on_and_who_has_none_is_out() -> None:
    first, greedy, last = (
        Worker(0, 400_000, held=60),
        Worker(1, 10**9, memory=60_000),
        Worker(2, 10**9, held=60),
    )
    race = Race(iter([first, greedy, last]), 100, 1)
    assert race.run() == 0
    assert last.done < sum(last.budgets)  # it began anew
    assert first.done == sum(first.budgets)
    assert len(greedy.budgets) == 2
    assert Race(iter([Worker(0, 10**9, memory=5)]), 100, 1).run() is None


def scattered(size: int) -> PetriNet:
    """Places marked in no pattern by each of few markings: a counter whose states mark random places."""
    from random import Random

    draw = Random(5)
    builder = NetBuilder("scattered")
    patterns = [[draw.random() < 0.5 for _ in range(120)] for _ in range(size)]
    for place in range(120):
        builder.place(f"p{place}", initial=int(patterns[0][place]))
    for i in range(size):
        builder.place(f"at{i}", initial=int(i == 0))
    for i, (here, there) in enumerate(pairwise(patterns)):
        gone = [f"p{p}" for p in range(120) if here[p] and not there[p]]
        come = [f"p{p}" for p in range(120) if there[p] and not here[p]]
        builder.transition(f"t{i}", consume=[f"at{i}", *gone], produce=[f"at{i + 1}", *come])
    return builder.build()


def test_few_markings_without_a_small_diagram_are_explored_one_by_one() -> None:
    space = reach(scattered(100))
    assert space.states == 100
    assert space.edges == 99
    assert space.dead_states == 1


def test_an_unsafe_firing_is_found_without_the_whole_space() -> None:
    builder = NetBuilder("unsafe")
    for i in range(12):  # 13! / ... markings in no order that a diagram likes
        for j in range(12):
            builder.place(f"cell{i}x{j}")
            builder.transition(f"fill{i}x{j}", consume=[f"row{i}", f"column{j}"], produce=[f"cell{i}x{j}"])
        builder.place(f"row{i}", initial=1)
        builder.place(f"column{i}", initial=1)
    builder.transition("twice", consume=["row0"], produce=["column0"])
    with pytest.raises(UnsafeError) as caught:
        reach(builder.build())
    assert caught.value.transition == "twice"
    assert caught.value.run == ()


def test_too_little_memory_is_said() -> None:
    with pytest.raises(LimitError, match="no order of places stays within memory"):
        reach(scattered(4), memory_limit=1000)


@given(nets(max_places=8, max_transitions=8))
def test_cuthill_mckee_holds_every_place_once(net: PetriNet) -> None:
    order = cuthill_mckee(net)
    assert sorted(order) == list(range(len(net.places)))


def test_cuthill_mckee_walks_along_a_chain() -> None:
    builder = NetBuilder("chain")
    names = [f"p{i * 7 % 30}" for i in range(30)]
    for name in sorted(names):
        builder.place(name, initial=1)
    for here, there in pairwise(names):
        builder.transition(f"{here}-{there}", consume=[here], produce=[there])
    net = builder.build()
    told = [net.places[p].name for p in cuthill_mckee(net)]
    assert told in (names, names[::-1])


def test_the_winner_s_order_is_told(mcc: Path) -> None:
    from mcpn.net.formats import read_net

    space = reach(read_net(mcc / "Dekker-PT-020" / "model.pnml"))
    assert (space.order, space.states) == ("units", 11534336)
    again = reach(space.encoding.net, order=space.places)
    assert again.states == space.states
