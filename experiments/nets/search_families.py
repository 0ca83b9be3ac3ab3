"""What is answered of large nets without their space: bounds and examinations by ``--engine search``.

Usage: ``python experiments/nets/search_families.py [--seconds 15] [--bounds 16] [--engine search]
[FAMILY...]``. Nets are drawn from families: those of :mod:`mcpn.testing.nets` and some that are made here,
each large, where the share of answers is counted, and small, where every answer is compared with that of the
space. Each net has a process with so many seconds of CPU time. ``--paths 16`` asks so many formulas on paths
instead, drawn as well.
"""

from __future__ import annotations

import argparse
import random
import resource
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.nets.mcc_properties import cpu_of_children, told_by
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.testing.nets import FAMILIES

EXAMINATIONS = ("OneSafe", "QuasiLiveness", "StableMarking", "Liveness", "ReachabilityDeadlock")
UPPER_BOUNDS, LTL = "UpperBounds", "LTL"
PATHS = (
    *("A (F G {0})", "A (G F {0})", "A (G ({0} -> F {1}))", "A ((G F {0}) -> G F {1})", "A ({0} U {1})"),
    *(
        "A (G ({0} -> X {1}))",
        "A (G !({0} & F ({1} & F {2})))",
        "A (X X ({0} | G {1}))",
        "A (F G ({0} | {1}))",
    ),
    *("A (F ({0} & F ({1} & X G {2})))", "A ((F G {0}) | G F ({1} & F {2}))", "A (!((G F {0}) & G F {1}))"),
)
"""Formulas on paths, by conditions that are drawn."""


def producers(size: int) -> PetriNet:
    """Producers and consumers at bounded buffers, in a chain."""
    net = NetBuilder(f"producers-{size}")
    for i in range(size):
        for place, tokens in (("idle", size), ("ready", 0), ("free", 2 * size), ("full", 0), ("done", 0)):
            net.place(f"{place}{i}", initial=tokens)
    for i in range(size):
        net.transition(f"make{i}", consume=[f"idle{i}"], produce=[f"ready{i}"])
        net.transition(f"put{i}", consume=[f"ready{i}", f"free{i}"], produce=[f"idle{i}", f"full{i}"])
        net.transition(f"take{i}", consume=[f"full{i}", f"idle{(i + 1) % size}"], produce=[f"done{i}"])
        net.transition(f"end{i}", consume=[f"done{i}"], produce=[f"free{i}", f"idle{(i + 1) % size}"])
    return net.build()


def resources(size: int) -> PetriNet:
    """Processes that take resources one after the other in their own order, and may block each other."""
    net, steps = NetBuilder(f"resources-{size}"), 5
    for r in range(size):
        net.place(f"r{r}", initial=1)
    for i in range(size):
        for k in range(steps):
            net.place(f"p{i}_{k}", initial=int(k == 0))
        order = [(i + (k if i % 2 else steps - k)) % size for k in range(steps)]
        for k in range(steps - 1):
            net.transition(f"take{i}_{k}", consume=[f"p{i}_{k}", f"r{order[k]}"], produce=[f"p{i}_{k + 1}"])
        freed = [f"r{r}" for r in order[: steps - 1]]
        net.transition(f"free{i}", consume=[f"p{i}_{steps - 1}"], produce=[f"p{i}_0", *freed])
    return net.build()


def pool(size: int) -> PetriNet:
    """The swimming pool: bags, cabins and changing."""
    net = NetBuilder(f"pool-{size}")
    stages = ("Out", "Entered", "Undress", "InBath", "Dress", "Dressed")
    for stage in stages:
        net.place(stage, initial=20 * size if stage == "Out" else 0)
    net.place("Cabins", initial=10 * size)
    net.place("Bags", initial=15 * size)
    net.transition("GetKey", consume=["Out", "Cabins"], produce=["Entered"])
    net.transition("GetBag", consume=["Entered", "Bags"], produce=["Undress"])
    net.transition("RelKey", consume=["Undress"], produce=["InBath", "Cabins"])
    net.transition("GetKey2", consume=["InBath", "Cabins"], produce=["Dress"])
    net.transition("RelBag", consume=["Dress"], produce=["Dressed", "Bags"])
    net.transition("RelKey2", consume=["Dressed"], produce=["Out", "Cabins"])
    return net.build()


def servers(size: int) -> PetriNet:
    """Clients that send to servers, get answers or lose them, and give up after some."""
    net = NetBuilder(f"servers-{size}")
    for i in range(size):
        for place in ("client", "asked", "sent", "worked", "lost", "left"):
            net.place(f"{place}{i}", initial=int(place == "client"))
        net.place(f"patience{i}", initial=3)
    net.place("servers", initial=max(size // 3, 1))
    for i in range(size):
        net.transition(f"ask{i}", consume=[f"client{i}"], produce=[f"asked{i}", f"sent{i}"])
        net.transition(f"work{i}", consume=[f"sent{i}", "servers"], produce=[f"worked{i}"])
        net.transition(f"answer{i}", consume=[f"worked{i}", f"asked{i}"], produce=[f"client{i}", "servers"])
        net.transition(f"lose{i}", consume=[f"sent{i}", f"patience{i}"], produce=[f"lost{i}"])
        net.transition(f"again{i}", consume=[f"lost{i}", f"asked{i}"], produce=[f"client{i}"])
        net.transition(f"leave{i}", consume=[f"client{i}"], read={f"lost{i}": 1}, produce=[f"left{i}"])
    return net.build()


def pipeline(size: int) -> PetriNet:
    """Stages behind each other, each choosing, forking and joining; one branch is never taken."""
    net = NetBuilder(f"pipeline-{size}")
    net.place("never")
    for i in range(size + 1):
        net.place(f"in{i}", initial=int(i == 0))
    for i in range(size):
        for place in ("left", "right", "ldone", "rdone", "short"):
            net.place(f"{place}{i}")
        net.transition(f"fork{i}", consume=[f"in{i}"], produce=[f"left{i}", f"right{i}"])
        net.transition(f"l{i}", consume=[f"left{i}"], produce=[f"ldone{i}"])
        net.transition(f"r{i}", consume=[f"right{i}"], produce=[f"rdone{i}"])
        net.transition(f"join{i}", consume=[f"ldone{i}", f"rdone{i}"], produce=[f"in{i + 1}"])
        net.transition(f"skip{i}", consume=[f"in{i}"], produce=[f"short{i}"])
        net.transition(f"back{i}", consume=[f"short{i}"], produce=[f"in{i + 1}"])
        if i % 4 == 0:
            net.transition(f"dead{i}", consume=[f"ldone{i}", f"short{i}"], produce=["never"])
    return net.build()


def peterson(size: int) -> PetriNet:
    """Pairs that exclude each other by Peterson's algorithm, side by side."""
    net = NetBuilder(f"peterson-{size}")
    for k in range(size):
        for place, tokens in (("turn0", 1), ("turn1", 0), ("off0", 1), ("off1", 1), ("on0", 0), ("on1", 0)):
            net.place(f"{place}_{k}", initial=tokens)
        for i in (0, 1):
            for place in ("idle", "asks", "waits", "in"):
                net.place(f"{place}{i}_{k}", initial=int(place == "idle"))
        for i, j in ((0, 1), (1, 0)):
            idle, asks, waits, inside = (f"{place}{i}_{k}" for place in ("idle", "asks", "waits", "in"))
            net.transition(f"ask{i}_{k}", consume=[idle, f"off{i}_{k}"], produce=[asks, f"on{i}_{k}"])
            for turn in (0, 1):
                net.transition(
                    f"turn{i}{turn}_{k}", consume=[asks, f"turn{turn}_{k}"], produce=[waits, f"turn{j}_{k}"]
                )
            net.transition(f"first{i}_{k}", consume=[waits], read=[f"off{j}_{k}"], produce=[inside])
            net.transition(f"mine{i}_{k}", consume=[waits], read=[f"turn{i}_{k}"], produce=[inside])
            net.transition(f"leave{i}_{k}", consume=[inside, f"on{i}_{k}"], produce=[idle, f"off{i}_{k}"])
    return net.build()


def chemistry(size: int) -> PetriNet:
    """Reactions that bind two kinds, release them and pass a signal down a cascade."""
    net = NetBuilder(f"chemistry-{size}")
    levels, amount = 6, 50 * size
    for i in range(levels):
        for place, tokens in (("kind", amount), ("bound", 0), ("active", 0), ("back", 0)):
            net.place(f"{place}{i}", initial=tokens)
        net.place(f"reset{i}", initial=amount // 3)
    net.place("signal", initial=amount // 2)
    for i in range(levels):
        before = "signal" if i == 0 else f"active{i - 1}"
        net.transition(f"bind{i}", consume=[f"kind{i}", before], produce=[f"bound{i}"])
        net.transition(f"loose{i}", consume=[f"bound{i}"], produce=[f"kind{i}", before])
        net.transition(f"turn{i}", consume=[f"bound{i}"], produce=[f"active{i}", before])
        net.transition(f"meet{i}", consume=[f"active{i}", f"reset{i}"], produce=[f"back{i}"])
        net.transition(f"part{i}", consume=[f"back{i}"], produce=[f"kind{i}", f"reset{i}"])
    return net.build()


OWN: Mapping[str, tuple[Callable[[int], PetriNet], tuple[int, ...], tuple[int, ...]]] = {
    "producers": (producers, (2,), (10, 30)),
    "resources": (resources, (6,), (20, 100)),
    "pool": (pool, (1,), (5, 50)),
    "servers": (servers, (2, 3), (20, 80)),
    "pipeline": (pipeline, (3,), (40, 150)),
    "peterson": (peterson, (1, 2), (10, 40)),
    "chemistry": (chemistry, (), (2, 10)),
}
"""Families made here, their small and their large sizes."""
KNOWN: Mapping[str, tuple[tuple[int, ...], tuple[int, ...]]] = {
    "philosophers": ((5,), (50, 300)),
    "component_ring": ((4,), (30, 100)),
    "slotted_ring": ((4,), (20, 60)),
    "kanban": ((2, 4), (50, 1000)),
    "fms": ((2,), (20, 200)),
    "token_ring": ((5,), (20, 100)),
    "eratosthenes": ((12,), (100, 300)),
    "queens": ((4,), (10, 14)),
}


def drawn(net: PetriNet, bounds: int) -> list[tuple[int, ...]]:
    """Sums of one to four places; the same net has the same."""
    draw = random.Random(net.name)
    count = len(net.places)
    return [tuple(draw.sample(range(count), min(draw.choice((1, 1, 2, 3, 4)), count))) for _ in range(bounds)]


def drawn_paths(net: PetriNet, count: int) -> list[str]:
    """Formulas on paths, of conditions on what may fire and on tokens; the same net has the same."""
    draw = random.Random(f"paths of {net.name}")

    def names(of: list[str], most: int) -> str:
        return ", ".join(f'"{one}"' for one in draw.sample(of, min(draw.randint(1, most), len(of))))

    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]

    def atom() -> str:
        enabled, held = f"enabled({names(transitions, 2)})", f"tokens({names(places, 3)})"
        least = draw.choice((1, 1, 2, 3))
        return draw.choice((enabled, f"!{enabled}", f"{held} >= {least}", f"{held} < {least}"))

    def condition() -> str:
        return " & ".join(atom() for _ in range(draw.choice((1, 1, 2, 3, 4))))

    return [draw.choice(PATHS).format(*(f"({condition()})" for _ in range(3))) for _ in range(count)]


def answer(net: PetriNet, bounds: int, paths: int, engine: str, seconds: int, answers: Connection) -> None:
    """Answers the bounds and the examinations of a net, or formulas on paths; sends them as they come."""
    from mcpn.errors import McpnError, Source
    from mcpn.logic.answering import answer_all
    from mcpn.logic.contest import Property
    from mcpn.logic.questions import Questions
    from mcpn.logic.syntax import parse
    from mcpn.spaces.formula_names import Names

    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    asked = [
        Property(f"{UPPER_BOUNDS}-{i}", places, Source(net.name))
        for i, places in enumerate(drawn(net, bounds))
    ]
    texts = drawn_paths(net, paths)
    asked += [
        Property(f"{LTL}-{i}", parse(text, Names(net)), Source(net.name)) for i, text in enumerate(texts)
    ]
    with suppress(McpnError):
        for verdict in answer_all(Questions(net, engine=engine), asked, () if paths else EXAMINATIONS):
            answers.send((verdict.name.removeprefix(f"{net.name}-"), verdict.value))


def run(net: PetriNet, bounds: int, paths: int, engine: str, seconds: int) -> dict[str, str]:
    """What one process answers in its time."""
    return dict(told_by(answer, net, bounds, paths, engine, seconds))


def main() -> None:
    """Prints a row for each net, and the share of answers by kind of question."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("families", nargs="*")
    parser.add_argument("--seconds", type=int, default=15)
    parser.add_argument("--bounds", type=int, default=16)
    parser.add_argument("--paths", type=int, default=0, help="formulas on paths, and nothing else")
    parser.add_argument("--engine", default="search")
    parser.add_argument("--small", action="store_true", help="the small nets alone")
    parser.add_argument("--large", action="store_true", help="the large nets alone")
    arguments = parser.parse_args()
    bounds, paths = 0 if arguments.paths else arguments.bounds, arguments.paths
    names = [f"{LTL}-{i}" for i in range(paths)]
    names = names or [*(f"{UPPER_BOUNDS}-{i}" for i in range(bounds)), *EXAMINATIONS]
    makers = {name: (FAMILIES[name].net, *sizes) for name, sizes in KNOWN.items()} | dict(OWN)
    given, asked, wrong = Counter[str](), Counter[str](), 0
    for family in arguments.families or makers:
        make, small, large = makers[family]
        for size in (*(() if arguments.large else small), *(() if arguments.small else large)):
            net = make(size)
            before = cpu_of_children()
            found = run(net, bounds, paths, arguments.engine, arguments.seconds)
            cpu = cpu_of_children() - before
            note = ""
            if size in small:
                right = run(net, bounds, paths, "symbolic", 4 * arguments.seconds)
                differ = [name for name in found if name in right and found[name] != right[name]]
                wrong += len(differ)
                note = f"  compared {len(right)}, wrong: {' '.join(differ) or 'none'}"
            else:
                for name in names:
                    kind = name.split("-")[0]
                    asked[kind] += 1
                    given[kind] += name in found
            left = " ".join(name for name in names if name not in found)
            print(f"{net.name:22} {cpu:6.2f} s CPU, open: {left or 'none'}{note}", flush=True)
    for kind, count in asked.items():
        print(f"{kind:22} {given[kind]:4} of {count:4} ({100 * given[kind] / count:.0f} %)")
    print(f"{wrong} wrong on small nets")


if __name__ == "__main__":
    main()
