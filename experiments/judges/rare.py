"""Rare failures: the numbers of risk of the worked missions, with hardware that fails ever more rarely.

For each mission and factor on all failure rates of its hardware: the probability of success, and of its
complement (failure and abort together), by composition and by the explicit engine, and how far each is from
the exact one, relative to it. Storm judges, with rationals; where stormpy is not installed, so does the
elimination of states in ``tests/logic/automata.py``, which takes longer.

    python experiments/judges/rare.py [--missions rover glider courier] [--factors 1 1e-2 ...] [--most 60000]

It takes some ten minutes.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from mcpn.answers.causes.chain import decimal
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.causes.whole_chain import whole_chain
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import McpnError
from mcpn.mission.model import Block, Holder, Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.report.failures.drn import drn
from tests.answers.exact import scaled
from tests.logic.automata import judged, read

HEAD = ("mission", "factor", "end", "exact", "local", "off by", "explicit", "off by")
HERE = Path(__file__).parents[1]
RATE, DURATION = 1e-3, 1.0
"""Failures per hour and hours, of what the mission gives none for."""


def rated(mission: Mission) -> Mission:
    """The mission with a rate for all its hardware that may fail, and a duration for all objectives."""

    def timed(block: Block) -> Block:
        if isinstance(block, Holder):
            return replace(block, blocks=tuple(map(timed, block.blocks)))
        if isinstance(block, Objective) and block.duration is None:
            return replace(block, duration=DURATION)
        return block

    robots = tuple(
        replace(
            of,
            hardware=tuple(
                replace(h, failure_rate=RATE) if h.faulty and h.failure_rate is None else h
                for h in of.hardware
            ),
        )
        for of in mission.robots
    )
    protocols = tuple(replace(p, blocks=tuple(map(timed, p.blocks))) for p in mission.protocols)
    return replace(mission, robots=robots, blocks=tuple(map(timed, mission.blocks)), protocols=protocols)


def exact(text: bytes, label: str) -> Fraction:
    """The probability to come to a label ever."""
    try:
        return judged(text, label)
    except ImportError:
        return read(text.decode()).reaching(label)


def told(value: float, truth: Fraction) -> str:
    """A probability, and how far it is from the exact one."""
    away = abs(Fraction(value) - truth) / truth if truth else abs(value)
    return f"{value:.9e} | {float(away):.1e}"


def rows(mission: Mission, most: int) -> Iterator[str]:
    """The rows of a mission, without its name.

    Raises:
        McpnError: It has no numbers, or more states than the limit.
    """
    found = compose(mission)
    spaces = spaces_of(found)
    by = {engine: Prospects(found, spaces.space(engine, "alternatives")) for engine in ("local", "explicit")}
    text = drn(whole_chain(by["explicit"].within(most), decimal))
    truth = {end: exact(text, end) for end in ("success", "failure", "abort")}
    numbers = {engine: risk(prospects) for engine, prospects in by.items()}
    success = " | ".join(told(of.success, truth["success"]) for of in numbers.values())
    yield f"success | {float(truth['success']):.9e} | {success}"
    ends = truth["failure"] + truth["abort"]
    failure = " | ".join(told(of.failure + (of.abort or 0.0), ends) for of in numbers.values())
    yield f"failure | {float(ends):.9e} | {failure}"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missions", nargs="*", default=["rover", "glider", "courier"])
    parser.add_argument("--factors", nargs="*", type=float, default=[1, 1e-2, 1e-4, 1e-6, 1e-9, 1e-12])
    parser.add_argument("--most", type=int, default=60_000, help="states of the whole that are judged")
    given = parser.parse_args()
    sys.set_int_max_str_digits(0)
    print(f"| {' | '.join(HEAD)} |\n|{'---|' * len(HEAD)}")
    for name in given.missions:
        mission = rated(read_mission(HERE / name / "mission.xml"))
        for factor in given.factors:
            try:
                for row in rows(scaled(mission, factor), given.most):
                    print(f"| {name} | {factor:g} | {row} |", flush=True)
            except McpnError as error:
                print(f"| {name} | {factor:g} | {error} |")


if __name__ == "__main__":
    main()
