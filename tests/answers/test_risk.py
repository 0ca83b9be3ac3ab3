"""Numbers of risk against closed forms, and against a simulation on the net."""

from __future__ import annotations

import math
import random
import statistics
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes import chain, linear_systems, passages, section_chains
from mcpn.answers.causes.block_elimination import Elimination
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import Risk, risk
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, InputError, LimitError, Source
from mcpn.mission.model import Block, Each, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests import small
from tests.answers.dense import with_numbers
from tests.draws import fewer
from tests.logic.oracle import Play, fragile_missions
from tests.shares import returns_early
from tests.small import activity, robot

LAMBDA, MU, D = 0.25, 0.5, 1.6
RATES, DURATIONS = st.sampled_from([0.01, 0.1, 0.3]), st.sampled_from([0.5, 1.0, 2.0])


def numbers(found: MissionNet, max_states: int = 5000) -> Risk:
    return risk(Prospects(found, ArraySpace(direct(found.net, max_states=max_states))))


def sections_numbers(found: MissionNet, max_states: int = 5000) -> Risk:
    return risk(Prospects(found, spaces_of(found).space("local", "alternatives"), max_states))


OF_IMPORTANCE = 4 * linear_systems.PRECISION
"""It is a difference of two probabilities, each of which either way has to :data:`PRECISION` of itself."""


def assert_same(one: Risk, other: Risk) -> None:
    """Equal but for rounding: each number by composition and on the whole."""
    assert other.success == pytest.approx(one.success, rel=1e-9, abs=1e-12)
    assert other.failure == pytest.approx(one.failure, rel=1e-9, abs=1e-12)
    assert other.degraded_modes == pytest.approx(one.degraded_modes, rel=1e-9, abs=1e-12)
    assert other.importance == pytest.approx(one.importance, rel=1e-9, abs=OF_IMPORTANCE)
    assert (other.abort is None) == (one.abort is None)
    assert other.abort == pytest.approx(one.abort or 0.0, rel=1e-9, abs=1e-12) or other.abort is None


def mission(hardware: list[Hardware], ways: dict[str, list[tuple[str, ...]]], *blocks: Block) -> MissionNet:
    of = robot(tuple(hardware), *(activity(name, *consumed) for name, consumed in ways.items()))
    return compose(small.mission(of, *blocks))


def objective(name: str, activity: str, duration: float = D, **more: float) -> Objective:
    return Objective(name=name, activities=(activity,), duration=duration, **more)  # type: ignore[arg-type]


def test_one_objective_and_one_sensor() -> None:
    h = Hardware(name="H", failure_rate=LAMBDA, repair_rate=MU)
    found = numbers(mission([h], {"a": [("H",)]}, objective("x", "a", failure_probability=0.2)))
    # The sensor must outlive an exponential duration; repair comes too late, for the objective has failed.
    lives = 1 / (1 + LAMBDA * D)
    assert found.success == pytest.approx(0.8 * lives)
    assert found.failure == pytest.approx(1 - 0.8 * lives)
    assert found.degraded_modes == 0
    assert found.importance == pytest.approx({"H": 0.8})


def test_two_ways_without_repair() -> None:
    hardware = [Hardware(name=n, failure_rate=LAMBDA) for n in ("H1", "H2")]
    found = numbers(mission(hardware, {"a": [("H1",), ("H2",)]}, objective("x", "a")))
    end = 1 / D
    one = end / (end + LAMBDA)
    assert found.success == pytest.approx((end + 2 * LAMBDA * one) / (end + 2 * LAMBDA))
    assert found.degraded_modes == pytest.approx(LAMBDA / (end + 2 * LAMBDA))  # H1 fails first of the three
    assert found.importance == pytest.approx({"H1": 1 - one, "H2": 1 - one})


def test_repair_before_it_is_needed() -> None:
    h = Hardware(name="H", failure_rate=LAMBDA, repair_rate=MU)
    found = numbers(
        mission([h], {"free": [()], "a": [("H",)]}, objective("x", "free", 3.0), objective("y", "a"))
    )
    end = 1 / 3.0
    in_service = (end + MU) / (end + LAMBDA + MU)  # a two-state chain at an exponential moment
    assert found.success == pytest.approx(in_service / (1 + LAMBDA * D))


def test_branches_succeed_independently() -> None:
    hardware = [Hardware(name=n, failure_rate=r) for n, r in (("H1", LAMBDA), ("H2", 2 * LAMBDA))]
    block = Parallel(name="both", blocks=(objective("x", "a"), objective("y", "b", 0.5)))
    found = numbers(mission(hardware, {"a": [("H1",)], "b": [("H2",)]}, block))
    assert found.success == pytest.approx(1 / (1 + LAMBDA * D) / (1 + 2 * LAMBDA * 0.5))


def test_what_fails_at_once_is_no_mode() -> None:
    hardware = [Hardware(name="H1", failure_rate=1e9), Hardware(name="H2", failure_rate=LAMBDA)]
    block = Parallel(name="both", blocks=(objective("x", "a"), objective("y", "b", 0.5)))
    found = numbers(mission(hardware, {"a": [("H1",), ()], "b": [("H2",)]}, block))
    # H1 fails at once: one degraded mode. Where y ends before x, by itself or with H2, x alone is another.
    first = 2.0 + LAMBDA
    assert found.degraded_modes == pytest.approx(1 + first / (first + 1 / D), rel=1e-6)


def test_an_objective_that_waits_does_not_fail() -> None:
    ways: dict[str, list[tuple[str, ...]]] = {"a": [("H",)], "free": [()], "b": [("H",)]}
    after = Recursive(
        name="after", blocks=(objective("z", "free"), objective("y", "b", 0.1, failure_probability=0.3))
    )
    block = Parallel(name="both", blocks=(objective("x", "a", 5.0), after))
    found = numbers(mission([Hardware(name="H", faulty=False)], ways, block))
    # Whenever x gives the resource back, y ends one way or the other by its own probability.
    assert found.success == pytest.approx(0.7)
    assert found.failure == pytest.approx(0.3)


def test_a_mission_that_never_ends_has_neither() -> None:
    h = Hardware(name="H", failure_rate=LAMBDA, repair_rate=MU)
    ways: dict[str, list[tuple[str, ...]]] = {"a": [("H",), ()]}
    again = replace(objective("x", "a"), success="x", failure="x")
    for found in (numbers(mission([h], ways, again)), sections_numbers(mission([h], ways, again))):
        assert (found.success, found.failure, found.degraded_modes) == (0, 0, math.inf)
        assert found.importance == {"H": 0}


def test_durations_must_be_known() -> None:
    with pytest.raises(InputError, match="objective x has no duration"):
        numbers(mission([], {"a": [()]}, Objective(name="x", activities=("a",))))


@pytest.mark.parametrize("tries", [2, 4])
def test_a_line_without_a_duration_is_told_once(tries: int) -> None:
    source = Source("m.xml", 7)
    again = Objective(name="x", activities=("a",), retries=tries - 1, failure="y", source=source)
    last = Objective(name="y", activities=("a",), source=Source("m.xml", 8))
    with pytest.raises(InputError, match=rf"objective x \(all {tries}\) has no duration") as error:
        numbers(mission([], {"a": [()]}, again, last))
    assert [p.source and p.source.line for p in error.value.problems] == [7, 8]


def row_of_sections(count: int) -> Mission:
    """So many objectives, each by one of two resources of five; a failure leads on but now and then."""
    hardware = tuple(
        Hardware(name=f"H{i}", failure_rate=0.01 * (i + 1), repair_rate=0.3 / (i + 1)) for i in range(5)
    )
    pairs = [("H0", "H1"), ("H1", "H2"), ("H3", "H0"), ("H4", "H2")]
    activities = tuple(
        Activity(name=f"a{k}", alternatives=tuple(Alternative(name=f"a{k}{h}", consumes=(h,)) for h in pair))
        for k, pair in enumerate(pairs)
    )
    blocks = tuple(
        objective(f"s{i}", f"a{i % 4}", 0.5 + i % 3, failure_probability=0.05 * (i % 2))
        if i % 7 == 6 or i == count - 1
        else replace(
            objective(f"s{i}", f"a{i % 4}", 0.5 + i % 3, failure_probability=0.05 * (i % 2)),
            failure=f"s{i + 1}",
        )
        for i in range(count)
    )
    return Mission(
        name="m", robots=(Robot(name="r", hardware=hardware, activities=activities),), blocks=blocks
    )


def recursion(found: Mission, frozen: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The probability of success and the expected degraded modes by status of all hardware at the start.

    The model written down for missions of :func:`row_of_sections`: backward, with the status of all hardware
    and the alternative in use as the states of each section. No net, no graph, no composition.
    """
    hardware = found.hardware
    number = {h.name: i for i, h in enumerate(hardware)}
    ways = {a.name: [number[x.consumes[0]] for x in a.alternatives] for a in found.activities}
    statuses = list(product((0, 1), repeat=len(hardware)))
    index = {status: i for i, status in enumerate(statuses)}
    next_values = {"succeed": (np.ones(len(statuses)), np.zeros(len(statuses)))}
    next_values["fail"] = (np.zeros(len(statuses)), np.zeros(len(statuses)))
    blocks = [b for b in found.blocks if isinstance(b, Objective)]
    for block, later in reversed(list(zip(blocks, [*(b.name for b in blocks[1:]), "succeed"], strict=True))):
        chosen, well = ways[block.activities[0]], next_values[later]
        badly = next_values[block.failure or "fail"]
        assert block.duration is not None
        states = [(way, status) for way in (0, 1) for status in statuses if not status[chosen[way]]]
        place = {state: i for i, state in enumerate(states)}
        matrix, gain = np.zeros((len(states),) * 2), np.zeros((len(states), 2))
        for (way, status), i in place.items():
            leaving = 1 / block.duration
            chance = block.failure_probability or 0.0
            end = (1 - chance) * np.array([w[index[status]] for w in well])
            gain[i] += leaving * (end + chance * np.array([w[index[status]] for w in badly]))
            for k, h in enumerate(hardware):
                rate = (h.repair_rate if status[k] else h.failure_rate) or 0.0
                if h.name == frozen:
                    continue
                leaving += rate
                after = (*status[:k], 1 - status[k], *status[k + 1 :])
                other = chosen[1 - way]
                if k != chosen[way]:
                    matrix[i, place[way, after]] += rate
                elif not after[other]:
                    matrix[i, place[1 - way, after]] += rate
                    gain[i, 1] += rate * (way == 0)
                else:
                    gain[i] += rate * np.array([w[index[after]] for w in badly])
            matrix[i] /= leaving
            gain[i] /= leaving
        solved = np.linalg.solve(np.eye(len(states)) - matrix, gain)
        values = np.zeros((len(statuses), 2))
        for status, i in index.items():
            working = [way for way in (0, 1) if not status[chosen[way]]]
            if working:
                values[i] = solved[place[working[0], status]] + (0, working[0])
            else:
                values[i] = [w[i] for w in badly]
        next_values[block.name] = values[:, 0], values[:, 1]
    return next_values[blocks[0].name]


def test_three_hundred_sections_are_those_of_a_recursion() -> None:
    of = row_of_sections(300)
    found = sections_numbers(compose(of))
    success, modes = recursion(of)
    assert found.success == pytest.approx(success[0], rel=1e-9)
    assert found.success + found.failure == pytest.approx(1, rel=1e-9)
    assert found.degraded_modes == pytest.approx(modes[0], rel=1e-9)
    without = recursion(of, "H2")[0]
    assert found.importance["H2"] == pytest.approx(without[0] - without[1 << 2], rel=1e-9)


@pytest.mark.parametrize("unknowns", [4096, 0], ids=["together", "one by one"])
def test_a_few_sections_are_those_of_the_whole(unknowns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(chain, "UNKNOWNS", unknowns)
    of = row_of_sections(9)
    assert_same(numbers(compose(of)), sections_numbers(compose(of)))
    assert numbers(compose(of)).success == pytest.approx(recursion(of)[0][0], rel=1e-9)


def test_a_section_that_is_never_entered_has_no_part() -> None:
    # Where the objective fails its branch succeeds, so that the block is never tried again.
    h = Hardware(name="H", failure_rate=LAMBDA)
    first = replace(objective("x", "a", failure_probability=0.2), failure="succeed")
    block = Parallel(name="p", blocks=(Each(name="each", values=("v",), blocks=(first,)),), retries=1)
    found = mission([h], {"a": [("H",)]}, block, objective("y", "a"))
    assert "p_try2" in {section.name for section in found.graph.sections}
    assert_same(numbers(found), sections_numbers(found))
    assert sections_numbers(found).success == pytest.approx(1 / (1 + LAMBDA * D) ** 2)


def test_much_hardware_to_remember_is_a_limit_that_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    found = compose(row_of_sections(4))
    monkeypatch.setattr(section_chains, "MOST_HARDWARE", 4)
    with pytest.raises(LimitError, match=r"5 hardware .* remember 2\^5 states of them, the limit is 2\^4"):
        sections_numbers(found)
    assert numbers(found).success > 0  # the whole as one section remembers nothing
    # Hardware that no later section uses is not remembered: one section at a time uses two.
    monkeypatch.setattr(section_chains, "MOST_HARDWARE", 3)
    with pytest.raises(LimitError, match="section s2 and those after it use 4"):
        sections_numbers(found)
    monkeypatch.setattr(section_chains, "MOST_HARDWARE", 1)
    hardware = [Hardware(name=f"H{i}", failure_rate=LAMBDA) for i in range(20)]
    last = Objective(name="end", activities=("a19",), duration=D)
    alone = sections_numbers(mission(hardware, {"a19": [("H19",)]}, last))
    assert alone.success == pytest.approx(1 / (1 + LAMBDA * D))
    assert alone.importance == pytest.approx({h.name: float(h.name == "H19") for h in hardware})


def test_a_large_section_is_a_limit_that_is_named() -> None:
    with pytest.raises(LimitError, match=r"section s0 has .* states: numbers of risk list every state"):
        sections_numbers(compose(row_of_sections(4)), max_states=3)


WAYS = {"by sections": (passages, "MOST_DENSE"), "by iteration": (linear_systems, "MOST_DENSE")}
"""Ways to solve loops of sections, and the limit that is 0 where no other way may be taken."""


@contextmanager
def solved(way: str) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        if way != "by sections":
            patch.setattr(passages, "MOST_BYTES", 0)
        if way in WAYS:
            patch.setattr(*WAYS[way], 0)
        yield


@pytest.mark.parametrize("way", [*WAYS, "directly"])
def test_sections_in_a_loop(way: str) -> None:
    h = Hardware(name="H", failure_rate=LAMBDA, repair_rate=MU)
    ways: dict[str, list[tuple[str, ...]]] = {"free": [()], "a": [("H",)]}
    first = objective("x", "free", 3.0)
    found = mission([h], ways, first, replace(objective("y", "a"), failure="x"))
    with solved(way):
        assert_same(numbers(found), sections_numbers(found))
        assert sections_numbers(found).success == pytest.approx(1)


@st.composite
def loops(draw: st.DrawFn) -> MissionNet:
    """Sections in a row, each in up to three ways; where one fails, any may come, also itself again."""
    hardware = [
        Hardware(name=f"h{i}", failure_rate=draw(RATES), repair_rate=draw(RATES))
        for i in range(draw(st.integers(2, 4)))
    ]
    names_of_hardware = st.sampled_from([h.name for h in hardware])
    ways = st.lists(names_of_hardware, min_size=1, max_size=3, unique=True)
    count = draw(st.integers(2, 5))
    names = [f"x{i}" for i in range(count)]
    activities: dict[str, list[tuple[str, ...]]] = {
        f"a{i}": [(name,) for name in draw(ways)] for i in range(draw(st.integers(1, 3)))
    }
    blocks = [
        replace(
            objective(name, draw(st.sampled_from(sorted(activities))), draw(DURATIONS)),
            failure_probability=0.1,
            failure=draw(st.sampled_from([*names, None])),
        )
        for name in names
    ]
    return mission(hardware, activities, *blocks)


def test_rounding_is_no_degraded_mode() -> None:
    """Each section leads to the other when it fails; an error of rounding once made the number infinite."""
    hardware = [Hardware(name=f"h{i}", failure_rate=0.01, repair_rate=0.1) for i in range(3)]
    ways: dict[str, list[tuple[str, ...]]] = {"a": [("h2",), ("h0",)], "b": [("h1",)]}
    first = replace(objective("x", "a", 0.5), failure="y", failure_probability=0.1)
    second = replace(objective("y", "b", 2.0), failure="x", failure_probability=0.1)
    found = mission(hardware, ways, first, second)
    assert math.isfinite(numbers(found).degraded_modes)
    assert_same(numbers(found), sections_numbers(found))


@fewer(0.5)
@given(loops(), st.sampled_from([*WAYS, "directly"]))
def test_sections_that_lead_back_are_those_of_the_whole(found: MissionNet, way: str) -> None:
    with solved(way):
        assert_same(numbers(found), sections_numbers(found))


@pytest.mark.parametrize("back", ["x0", "x{before}"])
def test_equal_sections_in_a_row_are_eliminated_once(back: str) -> None:
    """Forty sections that lead back where they fail: few products, and the numbers of one system."""
    hardware = [Hardware(name=f"h{i}", failure_rate=0.1 * (i + 1), repair_rate=1.0) for i in range(3)]
    blocks = [
        replace(
            objective(f"x{i}", "a" if i % 2 else "b", 0.5),
            failure_probability=0.1,
            failure=back.format(before=max(0, i - 1)),
        )
        for i in range(40)
    ]
    found = mission(hardware, {"a": [("h0",), ("h1",)], "b": [("h2",), ()]}, *blocks)
    plans = list[Elimination]()

    def planned(*given: Any) -> Elimination:
        plans.append(Elimination(*given))
        return plans[-1]

    with solved("by sections"), pytest.MonkeyPatch.context() as patch:
        patch.setattr(passages, "Elimination", planned)
        by_sections = sections_numbers(found)
    assert max(plan.products for plan in plans) <= 40
    with solved("directly"):
        assert_same(by_sections, sections_numbers(found))


class Simulation:
    """Runs of the net in time; what races is drawn as the model says, with no matrix and no graph."""

    def __init__(self, found: MissionNet) -> None:
        self.play = Play(found)
        self.sections = {s.name: s for s in found.graph.walk()}
        self.hardware = {h.name: h for h in found.core.hardware}
        self.lost: dict[tuple[tuple[int, ...], str], bool] = {}
        self.roles = found.roles
        self.first = {f"{a.name}.{a.alternatives[0].name}" for a in found.core.activities}

    def is_lost(self, marking: tuple[int, ...], name: str) -> bool:
        key = marking, name
        if key not in self.lost:
            for_ever = frozenset(h.name for h in self.hardware.values() if not h.repair_rate)
            self.lost[key] = not self.play.objective_survives(marking, name, for_ever)
        return self.lost[key]

    def run(self, seed: random.Random, longest: int = 2000) -> tuple[str | None, int]:
        """How a run ends, and how often it came into another mode that is degraded."""
        play, modes = self.play, 0
        marking, last = play.after(play.initial, ["MISSION_EV_START"]), self.mode(play.initial)
        for _ in range(longest):
            for end in ("success", "failure"):
                if play.marks(f"MISSION_{end}")(marking):
                    return end, modes
            edges = dict(play.edges(marking))
            at_once = [
                e
                for e in edges
                if e.endswith("_EV_FAIL")
                and self.is_lost(marking, e.removeprefix("OBJ_").removesuffix("_EV_FAIL"))
            ]
            if not at_once and self.mode(marking) != last and self.mode(marking)[1]:
                modes += 1
            last = self.mode(marking)
            if at_once:
                marking = edges[seed.choice(at_once)]
                continue
            rates = {e: self.rate(e, edges) for e in edges}
            first = min(
                ((seed.expovariate(r), e) for e, r in rates.items() if r > 0),
                default=None,
                key=lambda p: p[0],
            )
            if first is None:
                return None, modes
            marking = edges[first[1]]
        return None, modes

    def mode(self, marking: tuple[int, ...]) -> tuple[frozenset[int], bool]:
        """What runs in which alternatives, and whether one of these is not the first."""
        running = {i for i, (kind, _) in self.roles.items() if kind in ("active", "objective") and marking[i]}
        alternatives = {self.roles[i][1] for i in running if self.roles[i][0] == "active"}
        return frozenset(running), bool(alternatives - self.first)

    def rate(self, event: str, edges: Collection[str]) -> float:
        name, _, kind = event.removeprefix("OBJ_").rpartition("_EV_")
        if kind == "OOS":
            return self.hardware[name].failure_rate or 0.0
        if kind == "RD":
            return self.hardware[name].repair_rate or 0.0
        if kind == "TIMEOUT":
            return 0.0  # in numbers of risk no time is ever over
        section = self.sections[name]
        assert section.duration is not None
        if kind == "OK":
            return (1 - section.failure_probability) / section.duration
        return section.failure_probability / section.duration if f"OBJ_{name}_EV_OK" in edges else 0.0


@fewer(0.1)
@given(fragile_missions(max_hardware=3, max_objectives=3, max_sections=5), st.data())
def test_numbers_are_those_of_simulation(mission: Mission, data: st.DataObject) -> None:
    found = compose(data.draw(with_numbers(mission)))
    try:
        computed = numbers(found, max_states=600)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    simulation, seed = Simulation(found), random.Random(7)
    runs = 400
    ended = [simulation.run(seed) for _ in range(runs)]
    ends = [end for end, _ in ended]
    for outcome, probability in (("success", computed.success), ("failure", computed.failure)):
        share = ends.count(outcome) / runs
        # Five standard deviations: a false alarm in a million comparisons.
        width = 5 * math.sqrt(max(probability * (1 - probability), 1 / runs) / runs)
        assert abs(share - probability) <= width
    if None not in ends:
        modes = [count for _, count in ended]
        width = 5 * math.sqrt(max(statistics.variance(modes), 1 / runs) / runs)
        assert abs(statistics.fmean(modes) - computed.degraded_modes) <= width


@fewer(0.1)
@given(
    st.one_of(
        fragile_missions(max_hardware=3, max_objectives=3, max_sections=5),
        missions(None, protocols=False, max_hardware=3, max_objectives=3, max_sections=5),
        missions(None, protocols=False, max_hardware=3, max_sections=6, max_events=2),
    ),
    st.data(),
)
def test_numbers_by_composition_and_by_diagrams_are_those_of_the_whole(
    mission: Mission, data: st.DataObject
) -> None:
    found = compose(data.draw(with_numbers(mission)))
    try:
        whole = numbers(found, max_states=600)
    except (LimitError, ConfluenceError) as error:
        returns_early(type(error).__name__)
        return
    assert_same(whole, sections_numbers(found))
    assert_same(whole, risk(Prospects(found, spaces_of(found).space("symbolic", "alternatives"))))
