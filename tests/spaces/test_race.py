"""The race: who wins whatever the machine, what budgets are given, what is let go."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from math import ceil, inf
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn._kernel import BudgetExceeded, Cancelled, MemoryLimit
from mcpn.errors import LimitError, UnsafeError
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.order import cuthill_mckee
from mcpn.spaces.diagrams.race import FIRST_BUDGET, LEAST_BUDGET, SIDE_BY_SIDE, SLICE, Race, Resting
from mcpn.spaces.diagrams.race_entrants import ByOrder, OneByOne
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.symbolic import reach, reaching
from tests.nets.nets import nets


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
    outlook: float = inf
    patient: bool = False  # goes on until it is cancelled
    begun: threading.Event = field(default_factory=threading.Event)
    after: Worker | None = None  # goes on when that one has begun to be patient

    @property
    def bytes(self) -> int:
        return self.held

    def run(self, steps: int) -> int:
        self.budgets.append(steps)
        if self.patient and beside_others():
            self.begun.set()
            assert self.cancelled.wait(30)
            raise Cancelled
        if self.after is not None and beside_others():
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


def beside_others() -> bool:
    """Whether runners work in parallel."""
    return threading.current_thread() is not threading.main_thread()


def winner(needs: list[int]) -> int:
    """The first of those that end in the earliest slice of the earliest round, by hand."""
    budget, done = 50_000, [0] * len(needs)
    while True:
        given = [budget // (rank + 1 if rank < 3 else int((rank + 1) ** 1.5)) for rank in range(len(needs))]
        slices = ceil(budget / SLICE)
        for _ in range(slices):
            done = [
                had + part // slices if part >= LEAST_BUDGET else 0
                for had, part in zip(done, given, strict=True)
            ]
            ended = [rank for rank, (had, need) in enumerate(zip(done, needs, strict=True)) if had >= need]
            if ended:
                return ended[0]
        budget *= 2


@given(st.lists(st.integers(1, 3 * SIDE_BY_SIDE), min_size=1, max_size=9), st.integers(1, 4))
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
    needs = sum(FIRST_BUDGET << doubled for doubled in range(8)) + 1  # ends in the first slice side by side
    assert Race(iter([Worker(0, needs, after=endless), endless]), 1 << 60, 2).run() == 0
    assert endless.cancelled.is_set()


def test_one_near_its_end_comes_first_and_the_others_are_given_little() -> None:
    others = [Worker(rank, 1 << 60) for rank in range(3)]
    near = Worker(3, 300_000, outlook=1.5)
    assert Race(iter([*others, near]), 1 << 60, 1).run() == 3
    assert near.budgets == [100_000 // 8, 200_000, 400_000]  # the first round had too little for it
    assert [worker.budgets[2] for worker in others] == [200_000 // 8, 200_000 // 8, 200_000 // 8]
    assert [len(worker.budgets) for worker in others] == [3, 3, 3]


def test_one_near_its_end_works_alone() -> None:
    beside = Worker(1, 1 << 60)
    first = Worker(0, 2 * SIDE_BY_SIDE, outlook=1.5)
    assert Race(iter([first, beside]), 1 << 60, 2).run() == 0
    assert len(first.budgets) == len(beside.budgets) + 1


def test_a_race_rests_inside_a_round_and_ends_as_one_that_does_not() -> None:
    def drawn() -> list[Worker]:
        return [Worker(0, 1 << 60), Worker(1, 5 * SLICE)]

    resting, rests, most = Resting(Race(iter(drawn()), 1 << 60, 1).rounds()), list[int](), FIRST_BUDGET
    while not resting.ended:
        rests.append(sum(1 for _ in resting.going_on(most)))
        most *= 2
    assert resting.made == Race(iter(drawn()), 1 << 60, 1).run() == 1
    assert max(rests) > 4
    race = Race(iter(workers := drawn()), 1 << 60, 1, 8 * SLICE, resumable=False)
    assert race.run() == 1
    assert workers[0].budgets == [8 * SLICE, 16 * SLICE]


def test_an_error_in_one_ends_the_others() -> None:
    endless = Worker(1, 1 << 60, patient=True)
    failing = Worker(0, 1 << 60)

    def run(steps: int) -> int:
        if beside_others():
            assert endless.begun.wait(30)
            raise ZeroDivisionError
        raise BudgetExceeded

    failing.run = run  # type: ignore[method-assign]
    with pytest.raises(ZeroDivisionError):
        Race(iter([failing, endless]), 1 << 60, 2).run()
    assert endless.cancelled.is_set()


@pytest.mark.parametrize("begun", [False, True])
def test_a_runner_that_was_cancelled_works_no_more(begun: bool) -> None:
    net = scattered(40)
    order = tuple(range(len(net.places)))
    closing = ByOrder(net, Encoding, "file", order, 1 << 30)
    exploring = OneByOne(net, "file", order, 1 << 30)
    for runner in (closing, exploring):
        if begun:
            with pytest.raises(BudgetExceeded):
                runner.run(2)
        runner.cancel()
        with pytest.raises(Cancelled):
            runner.run(1 << 40)
    assert closing._encoding is not None
    assert closing._encoding.store.steps <= 2
    assert exploring._explorer is not None
    assert exploring._explorer.explored < 40


def test_closures_and_explorations_say_when_they_are_near_their_end() -> None:
    builder = NetBuilder("cells")  # the queue of 2^10 markings runs dry at its end
    for i in range(10):
        builder.place(f"p{i}", initial=1)
        builder.place(f"q{i}")
        builder.transition(f"t{i}", consume=[f"p{i}"], produce=[f"q{i}"])
    net = builder.build()
    exploring = OneByOne(net, "file", tuple(range(20)), 1 << 40)
    seen = []
    while True:
        try:
            exploring.run(100)
        except BudgetExceeded:
            seen.append(exploring.outlook)
        else:
            break
    assert seen[0] == inf
    assert seen[-1] < 1


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


def test_listed_markings_become_a_diagram_when_it_is_asked_for() -> None:
    net = scattered(30)
    order = tuple(range(len(net.places)))
    space = OneByOne(net, "file", order, 1 << 30).run(1000)
    assert isinstance(space, SymbolicSpace)
    assert (space.states, space.edges, space.nodes) == (30, 29, None)
    assert space.reachable.count() == 30
    assert space.nodes == space.reachable.nodes()
    assert (space.encoding.initial() | space.reachable) == space.reachable


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
    from mcpn.nets.formats import read_net

    space = reach(read_net(mcc / "Dekker-PT-020" / "model.pnml"))
    assert (space.order, space.states) == ("closing", 11534336)
    again = reach(space.encoding.net, order=space.places)
    assert again.states == space.states


def test_a_race_that_rests_ends_as_one_that_does_not(mcc: Path) -> None:
    from mcpn.nets.formats import read_net

    net = read_net(mcc / "Dekker-PT-010" / "model.pnml")
    rests = [0]
    resting = Resting(reaching(net))
    while not resting.go_on(FIRST_BUDGET * 2 ** len(rests)):
        rests.append(1)
    assert resting.made.states == reach(net).states


def test_a_race_rests_between_rounds_and_keeps_its_error() -> None:
    builder = NetBuilder("ring")
    for place in range(9):
        builder.place(f"p{place}", initial=int(place == 0))
    for place in range(9):
        builder.transition(f"t{place}", consume=[f"p{place}"], produce=[f"p{(place + 1) % 9}"])
    resting = Resting(reaching(builder.build()))
    assert not resting.go_on(FIRST_BUDGET - 1)
    assert resting.go_on(FIRST_BUDGET)
    assert resting.made.states == 9
    builder = NetBuilder("unsafe")
    builder.place("p", initial=1)
    builder.place("q")
    builder.transition("t", consume=[], read=["p"], produce=["q"])
    unsafe = Resting(reaching(builder.build()))
    for _ in range(2):
        assert unsafe.go_on(FIRST_BUDGET), "ended, by an error"
        with pytest.raises(UnsafeError):
            _ = unsafe.made
