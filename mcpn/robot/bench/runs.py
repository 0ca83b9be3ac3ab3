"""Runs of a controller in virtual time, one or many: how they end, and what they see of the controller."""

from __future__ import annotations

import random
from bisect import bisect_right
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from math import inf, sqrt
from statistics import NormalDist

from mcpn.events import Event
from mcpn.robot.bench.controller_places import ControllerPlace, StartDemand
from mcpn.robot.bench.nominal_run import nominal_run
from mcpn.robot.bench.world import BenchNode, World
from mcpn.robot.runtime.controller import timeout_event, timer_order
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.robot.runtime.machines import TypeTables

MOST_EVENTS = 10_000
"""Of one run: a mission may go on for ever."""

ENDS = ("success", "failure", "abort")


@dataclass(frozen=True, slots=True)
class TracedEvent:
    """One event of a run.

    Args:
        hours: When it happened, since the start.
        event: Its text.
        refused: Whether the controller refused it, as it may one of a script.
    """

    hours: float
    event: str
    refused: bool = False


@dataclass(frozen=True)
class BenchRun:
    """One run.

    Args:
        outcome: How it ended; ``None`` where nothing more could happen, or too much did.
        hours: How long it took.
        degraded: How often it came into a degraded functioning mode.
        events: What happened.
    """

    outcome: str | None
    hours: float
    degraded: int
    events: tuple[TracedEvent, ...]


@dataclass(frozen=True)
class Coverage:
    """What the runs have seen of a controller.

    Args:
        modes: Functioning modes that were seen.
        every_mode: Of so many; ``None`` of rules, which list none.
        edges: Edges of sections that were taken, by section, state and event.
        every_edge: Of so many.
    """

    modes: int
    every_mode: int | None
    edges: int
    every_edge: int | None


@dataclass
class Bench:
    """Many runs of one mission.

    Args:
        runs: How many.
        outcomes: How many ended so; ``None`` counts those that did not end.
        hours: Their mean length.
        degraded: By run, how often it came into a degraded functioning mode: mean, and its standard error.
        traces: The first runs that did not end in success.
        taken: Events that were taken in all.
        coverage: Of the controller.
    """

    runs: int
    outcomes: Counter[str | None] = field(default_factory=Counter)
    hours: float = 0.0
    degraded: tuple[float, float] = (0.0, 0.0)
    traces: list[BenchRun] = field(default_factory=list)
    taken: int = 0
    coverage: Coverage = Coverage(0, None, 0, None)


def one_run(
    world: World,
    rng: random.Random,
    script: Sequence[tuple[float, str]] = (),
    most_events: int = MOST_EVENTS,
) -> BenchRun:
    """Plays one run.

    Args:
        world: The fake drivers.
        rng: Draws what happens.
        script: Events with the hours at which they happen besides, in order.
        most_events: It is cut off after so many.
    """
    node, now, degraded, seen = world.start, 0.0, 0, world.start.seen
    events: list[TracedEvent] = []
    timers: dict[str, float] = {}
    waiting = list(script)[::-1]
    asked: tuple[StartDemand, ...] = ()
    while node.place.outcome is None and len(events) < most_events:
        failed = None
        if asked:
            first, *rest = asked
            asked = tuple(rest)
            if rng.random() >= world.demands.probability[first.hardware]:
                continue
            failed, event = first, first.event
        elif node.at_once:
            event = node.at_once[0] if len(node.at_once) == 1 else rng.choice(node.at_once)
        else:
            if node.degraded and node.seen != seen:
                degraded += 1
            drawn = rng.expovariate(node.rates[-1]) if node.rates else inf
            timer = min(timers, key=lambda name: timer_order(name, 3600 * timers[name])) if timers else None
            ends = inf if timer is None else timers[timer]
            told = waiting[-1][0] if waiting else inf
            soonest = min(now + drawn, ends, told)
            if soonest == inf:
                break
            now = soonest
            if told == soonest:
                event = waiting.pop()[1]
            elif timer is not None and ends == soonest:
                event = timeout_event(timer)
            else:
                at = bisect_right(node.rates, rng.random() * node.rates[-1])
                event = node.events[min(at, len(node.events) - 1)]
        if failed is None:  # what fails on demand fails with what has started it
            seen = node.seen
        step = world.after(node, event)
        events.append(TracedEvent(now, event, step is None))
        if step is None:
            continue
        node, actions = step
        if failed is None:
            asked = world.demands.started(node.place.inside, actions)
        else:
            asked = world.demands.following(failed, asked, node.place.inside, actions)
        # Hardware that is lost, and not known to be, cannot fail on demand.
        asked = tuple(demand for demand in asked if demand.hardware not in node.place.gone)
        for action in actions:
            if action.verb == "arm" and action.objective is not None and action.seconds is not None:
                timers[action.objective] = now + action.seconds / 3600
            elif action.verb == "disarm" and action.objective is not None:
                timers.pop(action.objective, None)
    return BenchRun(node.place.outcome, now, degraded, tuple(events))


def nominal_run_of(world: World) -> BenchRun:
    """Plays the run on which nothing fails; it takes no time."""
    node = world.start

    def take(event: Event) -> BenchNode:
        nonlocal node
        step = world.after(node, str(event))
        assert step is not None, "it is possible"
        node = step[0]
        return node

    def possible() -> list[Event]:
        return [Event.parse(event) for event in node.place.possible]

    tables = world.tables
    back = tables.out_of_service.intersection(tables.repairs.values())
    events = nominal_run(possible, take, back)
    return BenchRun(node.place.outcome, 0.0, 0, tuple(TracedEvent(0.0, str(event)) for event in events))


def one_run_of(
    world: World,
    seed: int,
    number: int,
    script: Sequence[tuple[float, str]] = (),
    most_events: int = MOST_EVENTS,
) -> BenchRun:
    """One of many runs, the same however many there are.

    Args:
        world: The fake drivers.
        seed: Of all of them.
        number: Which one.
        script: Events with the hours at which they happen besides, in order.
        most_events: It is cut off after so many.
    """
    return one_run(world, random.Random(f"{seed} {number}"), script, most_events)


def bench(
    world: World,
    runs: int,
    seed: int,
    script: Sequence[tuple[float, str]] = (),
    most_traces: int = 10,
    most_events: int = MOST_EVENTS,
) -> Bench:
    """Plays many runs.

    Args:
        world: The fake drivers.
        runs: How many.
        seed: What happens is drawn from; run *n* is the same however many there are.
        script: Events with the hours at which they happen besides, in order.
        most_traces: How many runs that did not end in success are kept.
        most_events: A run is cut off after so many.
    """
    found = Bench(runs)
    total = squares = 0
    for number in range(runs):
        run = one_run_of(world, seed, number, script, most_events)
        found.outcomes[run.outcome] += 1
        found.hours += run.hours / runs
        found.taken += sum(not event.refused for event in run.events)
        total += run.degraded
        squares += run.degraded**2
        if run.outcome != "success" and len(found.traces) < most_traces:
            found.traces.append(run)
    mean = total / runs
    found.degraded = mean, sqrt(max(0.0, squares / runs - mean**2) / runs)
    found.coverage = coverage(world)
    return found


def interval(count: int, total: int, confidence: float) -> tuple[float, float]:
    """Wilson's score interval of a probability.

    Args:
        count: How often it was so.
        total: Of so many times.
        confidence: How probable it is that the interval holds the probability.
    """
    z = NormalDist().inv_cdf(0.5 + confidence / 2)
    share, weight = count / total, z * z / total
    middle = (share + weight / 2) / (1 + weight)
    half = z * sqrt(share * (1 - share) / total + weight / (4 * total)) / (1 + weight)
    low, high = middle - half, middle + half
    return (0.0 if count == 0 else low), (1.0 if count == total else high)


def edge_of(tables: Tables, place: ControllerPlace, event: str) -> tuple[str, int, str] | None:
    """The edge of a section that an event takes: its section, state and event, if it is of the section."""
    if place.section is None or event not in tables.sections[place.section[0]].number:
        return None
    return (*place.section, event)


def coverage(world: World) -> Coverage:
    """What the runs so far have seen of the controller."""
    running = [place for place in world.places if place.section is not None]
    modes = {place.seen for place in running}
    tried = ((place, event) for place in running for event in place.edges)
    edges = {edge for place, event in tried if (edge := edge_of(world.tables, place, event)) is not None}
    every_mode, every_edge = set[object](), 0
    for section in world.tables.sections.values():
        if not isinstance(section.machine, TypeTables):
            return Coverage(len(modes), None, len(edges), None)
        for state, moves in enumerate(section.machine.moves):
            inside = section.state(state)
            every_mode.add((inside.objectives, tuple(sorted(inside.mode.items()))))
            every_edge += len(moves)
    return Coverage(len(modes), len(every_mode), len(edges), every_edge)
