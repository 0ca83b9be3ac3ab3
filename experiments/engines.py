"""Why mcpn has a kernel of its own: the same nets by other decision diagrams, in one run.

Usage: ``python experiments/engines.py [--seconds 60]``

Engines: ours (zero-suppressed diagrams, saturation); ``dd.cudd`` and ``oxidd`` (BDDs of CUDD and OxiDD, an
image for each transition in turn until nothing is new, called from Python); ``dd.autoref`` (the same in pure
Python); ``pyeda`` (mcpn's reference engine). All but pyeda use the same order of places, so that only the
algorithm and its implementation differ. Each run has a process and a limit of time of its own; an engine that
gave up on a member of a family is not asked for a larger one. Engines that are not installed are left out and
named (they come with ``mcpn[experiments]``).
It takes up to ten minutes with its defaults.
"""

from __future__ import annotations

import argparse
import multiprocessing
import platform
import sys
import time
from collections.abc import Callable
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.order import cuthill_mckee, force
from mcpn.testing.nets import component_ring, philosophers, slotted_ring

FAMILIES: dict[str, tuple[Callable[[int], PetriNet], tuple[int, ...]]] = {
    "philosophers": (philosophers, (4, 10, 20, 40, 80)),
    "slotted ring": (slotted_ring, (2, 5, 8, 10, 12)),
    "ring": (component_ring, (2, 4, 6, 8, 16)),
}
Engine = Callable[[PetriNet, tuple[int, ...]], int]


def ours(net: PetriNet, order: tuple[int, ...]) -> int:
    """Saturation in the kernel."""
    from mcpn.spaces.diagrams.symbolic import reach

    return reach(net, order=order).states


def chained(manager: Any, net: PetriNet, order: tuple[int, ...]) -> int:
    """A fixpoint of images of single transitions, each applied to all found so far, with a dd manager."""
    names = [f"p{place}" for place in order]
    manager.declare(*names)

    def cube(marked: set[int], unmarked: set[int]) -> Any:
        literals = {f"p{p}": True for p in marked} | {f"p{p}": False for p in unmarked}
        return manager.cube(literals)

    moves = []
    for t in net.safe_transitions:
        take, put, read = set(t.consume), set(t.produce), set(t.read)
        moves.append((cube(take | read, put), [f"p{p}" for p in take | put], cube(put, take)))
    initial = {p for p, tokens in enumerate(net.initial) if tokens}
    found = cube(initial, set(order) - initial)
    while True:
        before = found
        for enabled, changed, after in moves:
            found = found | (manager.exist(changed, found & enabled) & after)
        if found == before:
            return int(manager.count(found, nvars=len(order)))


def cudd(net: PetriNet, order: tuple[int, ...]) -> int:
    """CUDD through dd."""
    from dd.cudd import BDD

    return chained(BDD(), net, order)


def autoref(net: PetriNet, order: tuple[int, ...]) -> int:
    """The pure Python BDDs of dd."""
    from dd.autoref import BDD

    return chained(BDD(), net, order)


def oxidd(net: PetriNet, order: tuple[int, ...]) -> int:
    """OxiDD through its Python package."""
    from oxidd.bdd import BDDManager

    manager = BDDManager(50_000_000, 5_000_000, 1)
    manager.add_vars(len(order))
    level = {place: i for i, place in enumerate(order)}

    def cube(marked: set[int], unmarked: set[int]) -> Any:
        result = manager.true()
        for place in sorted(marked | unmarked, key=level.__getitem__, reverse=True):
            literal = manager.var(level[place]) if place in marked else manager.not_var(level[place])
            result = result & literal
        return result

    moves = []
    for t in net.safe_transitions:
        take, put, read = set(t.consume), set(t.produce), set(t.read)
        moves.append((cube(take | read, put), cube(take | put, set()), cube(put, take)))
    initial = {p for p, tokens in enumerate(net.initial) if tokens}
    found = cube(initial, set(order) - initial)
    while True:
        before = found
        for enabled, changed, after in moves:
            found = found | ((found & enabled).exists(changed) & after)
        if found == before:
            return int(found.sat_count(len(order)))


def pyeda(net: PetriNet, order: tuple[int, ...]) -> int:
    """The reference engine of mcpn on pyeda."""
    from mcpn.spaces.pyeda_reference import count

    return count(net).states


ENGINES: dict[str, tuple[Engine, str | None]] = {
    "mcpn": (ours, "mcpn"),
    "dd.cudd": (cudd, "dd"),
    "oxidd": (oxidd, "oxidd"),
    "dd.autoref": (autoref, "dd"),
    "pyeda": (pyeda, "pyeda"),
}


def child(engine: str, net: PetriNet, order: tuple[int, ...], pipe: Any) -> None:
    """Runs an engine and sends what it counted and the CPU time that it took; imports are not counted."""
    try:
        ENGINES[engine][0](philosophers(2), tuple(range(len(philosophers(2).places))))  # imports, tables
        started = time.process_time()
        states = ENGINES[engine][0](net, order)
        pipe.send((states, time.process_time() - started))
    except (ImportError, AttributeError) as error:
        pipe.send(f"not usable: {error}")
    except (MemoryError, RuntimeError, OverflowError) as error:
        pipe.send(f"gave up: {error}")


def measure(engine: str, net: PetriNet, order: tuple[int, ...], seconds: float) -> tuple[int, float] | str:
    """States and seconds, or why there are none."""
    here, there = multiprocessing.Pipe()
    context = multiprocessing.get_context("spawn")
    process = context.Process(target=child, args=(engine, net, order, there))
    process.start()
    result: tuple[int, float] | str = here.recv() if here.poll(seconds + 3) else f"more than {seconds:.0f} s"
    process.kill()
    process.join()
    return result


def main() -> None:
    """Prints a line for each net: seconds of each engine, and how many times longer than ours."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=60)
    limit = parser.parse_args().seconds
    for engine, (_, package) in ENGINES.items():
        try:
            print(f"{engine}: {version(package) if package else ''}")
        except PackageNotFoundError:
            print(f"{engine}: {package} is not installed here as a package")
    print(f"Python {platform.python_version()}, {platform.system()} {platform.machine()}; seconds of CPU")
    for family, (make, sizes) in FAMILIES.items():
        gone: set[str] = set()
        for size in sizes:
            net = make(size)
            order = force(net, cuthill_mckee(net))
            cells, base, states = [], 0.0, 0
            for engine in ENGINES:
                if engine in gone:
                    continue
                result = measure(engine, net, order, limit)
                if isinstance(result, str):
                    gone.add(engine)
                    cells.append(f"{engine} {result}")
                    continue
                found, seconds = result
                if engine == "mcpn":
                    base, states = max(seconds, 1e-4), found
                elif found != states and states < 2**53:  # beyond, counts of dd are rounded
                    raise SystemExit(f"{engine} counts {found} states of {net.name}, mcpn {states}")
                cells.append(f"{engine} {seconds:.4f} ({seconds / base:.0f} x)")
            print(f"{family} {size}, {states} states: {'; '.join(cells)}", flush=True)


if __name__ == "__main__":
    sys.exit(main())
