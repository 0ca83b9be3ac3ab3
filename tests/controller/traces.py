"""Runs of events with what the controller does on them, as lines that every target's program prints."""

from __future__ import annotations

import logging
import random
from collections import deque
from typing import Any

from mcpn.robot.runtime import Action, Controller, Refused
from mcpn.robot.runtime.controller_tables import Tables

logging.getLogger("mcpn.robot.runtime").setLevel(logging.ERROR)

Place = tuple[str | None, int, frozenset[str], str | None, frozenset[str]]


class Traced:
    """The Python runtime as a program that reads lines of events; an empty line begins again."""

    def __init__(self, document: dict[str, Any]) -> None:
        self.tables = Tables(document)
        self.restart()

    def restart(self) -> None:
        self.controller = Controller(self.tables, log=1)

    @property
    def place(self) -> Place:
        c = self.controller
        return c.section, c._state, c.out_of_service, c.outcome, c.happened

    def line(self, event: str) -> str:
        try:
            actions: tuple[Action, ...] = self.controller.handle(event)
            status = "taken"
        except Refused as refused:
            actions, status = (), "refused" if refused.known else "unknown"
        said = "; ".join(map(str, actions))
        return f"{status}: {said}".strip() + self.rest()

    def rest(self) -> str:
        c = self.controller
        mode = sorted(f"{a}.{way}" for a, way in c.mode.items())
        return f" | {' '.join(mode)} | {' '.join(c.possible)} | {c.outcome or '-'}"

    def lines(self, events: list[str]) -> list[str]:
        found = []
        for event in events:
            if event:
                found.append(canonical(self.line(event)))
            else:
                self.restart()
        return found


def canonical(line: str) -> str:
    """A line with its mode sorted (targets print it in the order of the mission) and single spaces."""
    actions, mode, *rest = (" ".join(part.split()) for part in line.split("|"))
    return " | ".join((actions, " ".join(sorted(mode.split())), *rest))


def random_events(traced: Traced, rng: random.Random, steps: int, noise: float = 0.1) -> list[str]:
    """Events at random, some of them impossible or unknown; the mission begins again when it has ended."""
    every = sorted(traced.tables.known)
    events: list[str] = [""]
    traced.restart()
    after_end = 0
    while len(events) < steps:
        possible = traced.controller.possible
        after_end += traced.controller.outcome is not None
        if not possible or after_end > 5:
            after_end = 0
            traced.restart()
            events.append("")
        elif rng.random() < noise:
            events.append(rng.choice([rng.choice(every), "no_such_EV", rng.choice(every) + "x", "x" * 1000]))
            traced.line(events[-1])
        else:
            events.append(rng.choice(possible))
            traced.line(events[-1])
    return events


def tour(traced: Traced) -> tuple[list[str], set[tuple[Place, str]]]:
    """Events that take every edge between all reachable places at least once, and these edges."""
    traced.restart()
    after: dict[Place, dict[str, Place]] = {}
    start = traced.place
    paths: dict[Place, str] = {start: traced.controller.snapshot()}
    queue = deque([start])
    while queue:
        at = queue.popleft()
        after[at] = {}
        traced.controller.restore(paths[at])
        for event in traced.controller.possible:
            traced.controller.restore(paths[at])
            traced.controller.handle(event)
            to = traced.place
            after[at][event] = to
            if to not in paths:
                paths[to] = traced.controller.snapshot()
                queue.append(to)
    left = {(at, event) for at, events in after.items() for event in events}
    every = set(left)
    events, at = [""], start
    while left:
        path = _to_an_edge_left(after, at, left)
        if path is None:
            events.append("")
            at = start
            path = _to_an_edge_left(after, at, left)
            assert path is not None
        for event in path:
            left.discard((at, event))
            at = after[at][event]
        events += path
    return events, every


def _to_an_edge_left(
    after: dict[Place, dict[str, Place]], start: Place, left: set[tuple[Place, str]]
) -> list[str] | None:
    origin: dict[Place, tuple[Place, str] | None] = {start: None}
    queue = deque([start])
    while queue:
        at = queue.popleft()
        for event, to in after[at].items():
            if (at, event) in left:
                path = [event]
                while (before := origin[at]) is not None:
                    at, step = before
                    path.append(step)
                return path[::-1]
            if to not in origin:
                origin[to] = (at, event)
                queue.append(to)
    return None
