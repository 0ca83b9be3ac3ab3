"""Nets for which a good order of places is hard to find, against closed forms and published counts.

Usage: ``python experiments/nets/hard_nets.py [FAMILY-SIZE...] [--seconds 60] [--gigabytes 4]``

Prints, for each net, the markings that the symbolic engine counts, whether they are as many as they should be
(``-`` where nobody says), the seconds of the processors, the peak memory and the order that won. Each net
runs in a process of its own; one that has no end in a minute is given up. It takes some four minutes.

- ``peterson-N``: Peterson's filter lock for N processes, each test and each turn of a loop a firing
  (IPL 1981). The counts for 3 and 4 processes are those of the Model Checking Contest.
- ``queens-N``: queens are put on a board, none within another's reach; counted by backtracking.
- ``latin-N``: a Latin square is filled (published: 2, 35, 11776, 127545137).
- ``sudoku-4``: a Latin square whose boxes hold each number once too.
- ``barrier-N``: N processes of 12 steps, with a pause after each, meet at a barrier: 24 ** N.
- ``servers-N-M``: N clients, each idle, waiting or served by one of M servers: the sum, over the number k of
  those that are served, of C(N, k) * C(M, k) * k! * 2 ** (N - k).
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from itertools import product
from math import comb, factorial, prod
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.nets import mcc
from mcpn.nets.petri import NetBuilder, PetriNet

DEFAULTS = (
    *("peterson-3", "peterson-4", "peterson-5", "queens-8", "queens-9", "queens-10", "latin-3", "latin-4"),
    *("sudoku-4", "barrier-4", "barrier-20", "servers-10-5", "servers-20-8", "servers-100-20"),
)
PUBLISHED = {"peterson-3": 20754, "peterson-4": 3407946, "latin-3": 11776, "latin-4": 127545137}
COUNTED = {"sudoku-4": 61556225}  # by fillings(), in half a minute
MOST_BY_BACKTRACKING = 10
BARRIER_STEPS = 12
SHOWN = 10**20


def peterson(count: int) -> PetriNet:
    """The filter lock: at each level a process gives way until no other wishes to pass, or another came."""
    builder = NetBuilder(f"peterson-{count}")
    processes, levels = range(count), range(count - 1)
    for i in processes:
        for name, tokens in (("idle", 1), ("quiet", 1), ("wanting", 0), ("critical", 0)):
            builder.place(f"{name}{i}", initial=tokens)
        for level in levels:
            for name in ("ask", "look", "passed"):
                builder.place(f"{name}{i}_{level}")
            for name, j in product(("begin", "same", "alone", "next"), processes):
                builder.place(f"{name}{i}_{level}_{j}")
    for level, i in product(levels, processes):
        builder.place(f"turn{level}_{i}", initial=int(i == 0))

    def step(name: str, before: list[str], after: list[str]) -> None:
        builder.transition(name, consume=before, produce=after)

    for i in processes:
        step(f"wish{i}", [f"idle{i}", f"quiet{i}"], [f"wanting{i}", f"ask{i}_0"])
        step(f"leave{i}", [f"critical{i}", f"wanting{i}"], [f"quiet{i}", f"idle{i}"])
    for i, level in product(processes, levels):
        at = f"{i}_{level}"
        beyond = f"ask{i}_{level + 1}" if level + 1 in levels else f"critical{i}"
        step(f"advance{at}", [f"passed{at}"], [beyond])
        for j in processes:
            turn = f"turn{level}_{j}"
            step(f"yield{at}_{j}", [f"ask{at}", turn], [f"look{at}", f"turn{level}_{i}"])
            step(f"turned{at}_{j}", [f"look{at}", turn], [f"begin{at}_0" if i == j else f"passed{at}", turn])
            step(f"round{at}_{j}", [f"begin{at}_{j}"], [f"same{at}_{j}"])
            if i == j:
                step(f"self{at}_{j}", [f"same{at}_{j}"], [f"next{at}_{j}"])
            else:
                step(f"other{at}_{j}", [f"same{at}_{j}"], [f"alone{at}_{j}"])
                step(f"free{at}_{j}", [f"alone{at}_{j}", f"quiet{j}"], [f"next{at}_{j}", f"quiet{j}"])
                step(f"held{at}_{j}", [f"alone{at}_{j}", f"wanting{j}"], [f"look{at}", f"wanting{j}"])
            step(f"on{at}_{j}", [f"next{at}_{j}"], [f"begin{at}_{j + 1}" if j + 1 < count else f"passed{at}"])
    return builder.build()


def queens(size: int) -> PetriNet:
    """Queens are put on a board; each takes its row, its column and both diagonals."""
    return _filling(f"queens-{size}", product(range(size), repeat=2), _reach)


def _reach(row: int, column: int) -> list[str]:
    return [f"row{row}", f"column{column}", f"down{row - column}".replace("-", "m"), f"up{row + column}"]


def latin(size: int) -> PetriNet:
    """A Latin square is filled; each number takes its cell, its row and its column."""
    return _filling(f"latin-{size}", product(range(size), repeat=3), _square)


def _square(row: int, column: int, number: int) -> list[str]:
    return [f"cell{row}_{column}", f"row{row}_{number}", f"column{column}_{number}"]


def sudoku(size: int) -> PetriNet:
    """A sudoku is filled: a Latin square whose boxes hold each number once too."""
    return _filling(f"sudoku-{size}", product(range(size), repeat=3), _boxed(size))


def _boxed(size: int) -> Callable[..., list[str]]:
    side = int(size**0.5)
    return lambda r, c, n: [*_square(r, c, n), f"box{r // side}_{c // side}_{n}"]


def _filling(name: str, moves: product[tuple[int, ...]], takes: Callable[..., list[str]]) -> PetriNet:
    builder = NetBuilder(name)
    for move in moves:
        taken = takes(*move)
        for place in taken:
            if not builder.has_place(place):
                builder.place(place, initial=1)
        done = builder.place("put" + "_".join(map(str, move)))
        builder.transition(f"t{done}", consume=taken, produce=[done])
    return builder.build()


def fillings(moves: list[list[str]]) -> int:
    """In how many ways some moves can be made of which each takes things that are there once."""
    bit: dict[str, int] = {}
    masks = [sum(1 << bit.setdefault(thing, len(bit)) for thing in move) for move in moves]

    def count(at: int, taken: int) -> int:
        found = 1
        for later in range(at, len(masks)):
            if not masks[later] & taken:
                found += count(later + 1, taken | masks[later])
        return found

    return count(0, 0)


def barrier(count: int) -> PetriNet:
    """Processes of some steps, each with a pause before it, that begin anew when all are at their last."""
    builder = NetBuilder(f"barrier-{count}")
    for i in range(count):
        for step in range(BARRIER_STEPS):
            builder.place(f"at{i}_{step}", initial=int(step == 0))
            builder.place(f"pause{i}_{step}")
        builder.unit([f"{kind}{i}_{step}" for step in range(BARRIER_STEPS) for kind in ("at", "pause")])
        for step in range(BARRIER_STEPS):
            builder.transition(f"rest{i}_{step}", consume=[f"at{i}_{step}"], produce=[f"pause{i}_{step}"])
            if step + 1 < BARRIER_STEPS:
                on = f"at{i}_{step + 1}"
                builder.transition(f"go{i}_{step}", consume=[f"pause{i}_{step}"], produce=[on])
    last = BARRIER_STEPS - 1
    for i in range(count):  # any may be late by one step: it catches up with the one before it
        other = (i + 1) % count
        builder.transition(
            f"catch{i}",
            consume=[f"pause{i}_{last}", f"pause{other}_0"],
            produce=[f"at{i}_0", f"at{other}_1"],
        )
    builder.transition(
        "meet",
        consume=[f"pause{i}_{last}" for i in range(count)],
        produce=[f"at{i}_0" for i in range(count)],
    )
    return builder.build()


def servers(clients: int, count: int) -> PetriNet:
    """Clients that wait for any of some servers."""
    builder = NetBuilder(f"servers-{clients}-{count}")
    for j in range(count):
        builder.place(f"free{j}", initial=1)
    for i in range(clients):
        builder.place(f"idle{i}", initial=1)
        builder.place(f"waiting{i}")
        builder.transition(f"ask{i}", consume=[f"idle{i}"], produce=[f"waiting{i}"])
        for j in range(count):
            served = builder.place(f"served{i}_{j}")
            builder.transition(f"serve{i}_{j}", consume=[f"waiting{i}", f"free{j}"], produce=[served])
            builder.transition(f"done{i}_{j}", consume=[served], produce=[f"idle{i}", f"free{j}"])
    return builder.build()


def expected(family: str, sizes: list[int]) -> int | None:
    """How many markings there are, where that is known without reaching them."""
    if family == "barrier":
        return prod([2 * BARRIER_STEPS] * sizes[0])
    if family == "servers":
        clients, count = sizes
        served = range(min(clients, count) + 1)
        return sum(comb(clients, k) * comb(count, k) * factorial(k) * 2 ** (clients - k) for k in served)
    if family == "queens" and sizes[0] <= MOST_BY_BACKTRACKING:
        return fillings([_reach(*cell) for cell in product(range(sizes[0]), repeat=2)])
    return (PUBLISHED | COUNTED).get(f"{family}-{sizes[0]}")


def net_of(name: str) -> PetriNet:
    """The net of a name."""
    family, *sizes = name.split("-")
    makers: dict[str, Callable[..., PetriNet]] = {
        "peterson": peterson,
        "queens": queens,
        "latin": latin,
        "sudoku": sudoku,
        "barrier": barrier,
        "servers": servers,
    }
    return makers[family](*map(int, sizes))


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("nets", nargs="*", default=DEFAULTS)
    parser.add_argument("--seconds", type=float, default=60)
    parser.add_argument("--gigabytes", type=float, default=4)
    parser.add_argument("--solve", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.solve:
        mcc.solve(net_of(options.solve), options.gigabytes)
        return
    print(f"{'net':16}{'markings':>24}{'answer':>8}{'CPU':>9}{'MB':>7}  order")
    for name in options.nets:
        command = [sys.executable, __file__, "--solve", name, "--gigabytes", str(options.gigabytes)]
        found = mcc.run(command, options.seconds)
        if "failed" in found:
            print(f"{name:16}{'':>24}{'none':>8}  {found['failed']}", flush=True)
            continue
        family, *sizes = name.split("-")
        known = expected(family, [int(size) for size in sizes])
        answer = "-" if known is None else "right" if found["states"] == known else "WRONG"
        states = int(str(found["states"]))
        shown = str(states) if states < SHOWN else f"{states:.6e}"
        print(
            f"{name:16}{shown:>24}{answer:>8}{found['cpu']:9.2f}{found['megabytes']:7}  {found['order']}",
            flush=True,
        )


if __name__ == "__main__":
    main()
