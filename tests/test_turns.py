"""Work that pauses: each kind of it gets as much CPU time as every other, however coarse its pauses are."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import pytest

from mcpn.turns import Pausing, finished, in_turns


class Clock:
    """CPU time that passes as work says."""

    def __init__(self) -> None:
        self.now = 0.0
        self.spent: dict[str, float] = {}

    def work(self, name: str, seconds: float, steps: int) -> Iterator[str | None]:
        """So many steps of so many seconds each."""
        for _ in range(steps):
            self.now += seconds
            self.spent[name] = self.spent.get(name, 0.0) + seconds
            yield None
        yield name


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    made = Clock()
    monkeypatch.setattr("mcpn.turns.time.process_time", lambda: made.now)
    return made


def test_each_way_has_as_much_time_as_every_other(clock: Clock) -> None:
    ways = [clock.work("fine", 0.01, 10_000), clock.work("coarse", 3.0, 100), clock.work("short", 0.05, 20)]
    for told in in_turns(ways, lambda: clock.now > 60):
        if told is not None:
            assert told == "short"  # the only one that ends, and soon
            assert clock.now < 20
    assert clock.spent["short"] == pytest.approx(1)
    assert clock.spent["fine"] == pytest.approx(clock.spent["coarse"], rel=0.5)


def test_what_answers_all_at_its_end_has_as_much_time_as_all_others_together(clock: Clock) -> None:
    ways = [clock.work(name, 0.01, 100_000) for name in "abcd"]
    for _ in in_turns(ways, lambda: clock.now > 60, whole=ways[1]):
        pass
    others = [clock.spent[name] for name in "acd"]
    assert sum(others) / 2 <= clock.spent["b"] <= 2 * sum(others)
    assert max(others) <= 2.1 * min(others)


def test_what_has_all_that_it_needs_has_three_times_as_much(clock: Clock) -> None:
    ways = [clock.work(name, 0.01, 100_000) for name in "abc"]
    for _ in in_turns(ways, lambda: clock.now > 60, whole=ways[1], near=lambda: clock.now > 20):
        if clock.now <= 20:
            begun = dict(clock.spent)
    since = {name: clock.spent[name] - begun[name] for name in "abc"}
    assert begun["b"] <= 2 * (begun["a"] + begun["c"])
    assert since["b"] >= 2.5 * (since["a"] + since["c"])


def test_who_has_told_something_long_ago_waits_as_others_do(clock: Clock) -> None:
    """Ten answers at the beginning do not pay for a minute of silence."""

    def telling() -> Iterator[str | None]:
        for told in (*"abcdefghij", *[None] * 100_000):
            clock.now += 0.01
            clock.spent["told"] = clock.spent.get("told", 0.0) + 0.01
            yield told

    for _ in in_turns([telling(), clock.work("silent", 0.01, 100_000)], lambda: clock.now > 60):
        pass
    assert clock.spent["silent"] == pytest.approx(30, rel=0.4)


def test_what_is_told_ends_no_slice(clock: Clock) -> None:
    def telling() -> Iterator[str | None]:
        for _ in range(3):
            clock.now += 1
            yield "a"
        yield None
        yield "last"

    assert [told for told in in_turns([telling(), iter("b")], lambda: False) if told] == [*"aaab", "last"]


def test_without_slices_one_way_ends_before_the_next(clock: Clock) -> None:
    ways = [clock.work("a", 5.0, 3), clock.work("b", 0.1, 3)]
    assert [told for told in in_turns(ways, lambda: False, first=inf) if told] == ["a", "b"]
    assert clock.now == pytest.approx(15.3)


def test_nothing_goes_on_once_nothing_is_left_to_do(clock: Clock) -> None:
    ways = [clock.work("a", 1.0, 100), clock.work("b", 1.0, 100)]
    assert list(in_turns(ways, lambda: clock.now >= 4)) == [None] * 4
    assert list(in_turns([clock.work("c", 1.0, 1)], lambda: True)) == []


def test_what_is_needed_at_once_is_finished() -> None:
    def work() -> Pausing[int]:
        yield
        yield
        return 3

    assert finished(work()) == 3


def test_who_has_answers_has_more_time(clock: Clock) -> None:
    def telling(name: str) -> Iterator[str | None]:
        for _ in range(10_000):
            clock.now += 0.01
            clock.spent[name] = clock.spent.get(name, 0.0) + 0.01
            yield name
            yield None

    ways = [clock.work("silent", 0.01, 100_000), telling("telling")]
    for _ in in_turns(ways, lambda: clock.now > 60):
        pass
    assert clock.spent["telling"] > 2 * clock.spent["silent"]


def test_what_takes_long_to_begin_waits_until_the_others_have_had_as_long(clock: Clock) -> None:
    ways = [clock.work("loads", 0.01, 100), clock.work("soon", 0.01, 8), clock.work("later", 0.01, 100)]
    begun = None
    for _ in in_turns(ways, lambda: clock.now > 60, first=0.02, late={ways[0]: 0.1}):
        if begun is None and clock.spent.get("loads"):
            begun = dict(clock.spent)
    assert begun is not None
    assert begun["soon"] == pytest.approx(0.08)
    assert 0.1 <= begun["later"] <= 0.22
