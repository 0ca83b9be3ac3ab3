"""Orders of places for decision diagrams: candidates, none of which is good for every net.

A greedy order goes on with the place that closes most of what has begun. FORCE (Aloul, Markov, Sakallah,
GLSVLSI 2003) moves each place to where the transitions around it are, again and again; it starts from the
file's order or from reverse Cuthill-McKee on the graph of places and transitions. Sloan's order (1986) keeps
those few that are met before all their neighbours are placed. Units of which one place is marked at a time
stay together where they are ordered as wholes. Saturation works from the bottom, so that an order and its
reverse differ.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from pathlib import Path

from mcpn._kernel import closing as kernel_closing
from mcpn._kernel import clustered as kernel_clustered
from mcpn._kernel import force as kernel_force
from mcpn._kernel import sloan as kernel_sloan
from mcpn.errors import InputError, Problem, Source
from mcpn.files import read_bounded, write_atomically
from mcpn.nets.petri import PetriNet
from mcpn.nets.provenance import CONTROL
from mcpn.nets.structure import state_machine_units

Order = tuple[int, ...]
"""Indices of places, the first on top."""

MAX_ROUNDS = 200
MAX_BYTES = 100_000_000
MOST_PAIRS = 20_000_000
"""Pairs of neighbours up to which orders are made that look at each."""


def candidates(net: PetriNet, seed: int | None = None) -> Iterator[tuple[str, Order]]:
    """Orders worth trying, with their names, the most often good first; each is made when it is asked for.

    Args:
        net: The net.
        seed: Where given, FORCE from an order drawn with it is tried first.

    Yields:
        Pairs of name and order, without repeats; the same for the same net and seed.
    """
    seen: set[Order] = set()
    for name, order in chain(_drawn(net, seed), _of_composed(net) if net.priorities else _named(net)):
        if order not in seen:
            seen.add(order)
            yield name, order


def read_order(path: Path, net: PetriNet) -> Order:
    """Reads an order: names of places, one a line, the first on top; empty lines and ``#`` comments aside.

    Args:
        path: The file, UTF-8.
        net: The net whose places it orders.

    Returns:
        The order.

    Raises:
        InputError: A line names no place of the net or names one again, or places are missing.
    """
    try:
        lines = read_bounded(path, MAX_BYTES).decode().splitlines()
    except UnicodeDecodeError as error:
        raise InputError.at(Source(str(path)), "not UTF-8 text") from error
    order: dict[int, int] = {}
    problems = []
    for number, line in enumerate(lines, 1):
        name = line.strip()
        place = net.place_index.get(name)
        if place is not None and place not in order:
            order[place] = number
        elif place is not None:
            duplicate = f"place {name} again, after line {order[place]}"
            problems.append(Problem(Source(str(path), number), duplicate))
        elif name and not name.startswith("#"):
            problems.append(
                Problem(Source(str(path), number), f"found {name!r}, expected a place of the net")
            )
    missing = [place.name for i, place in enumerate(net.places) if i not in order]
    if missing:
        more = f" and {len(missing) - 3} more" if len(missing) > 3 else ""
        problems.append(Problem(Source(str(path)), f"places are missing: {', '.join(missing[:3])}{more}"))
    if problems:
        raise InputError(problems)
    return tuple(order)


def write_order(path: Path, net: PetriNet, order: Order, name: str) -> None:
    """Writes an order so that :func:`read_order` reads it.

    Args:
        path: The file; it is replaced at once or not at all.
        net: The net.
        order: Indices of places, the first on top.
        name: What the order is called, for a comment.

    Raises:
        InputError: The file cannot be written.
    """
    lines = [f"# {name}", *(net.places[p].name for p in order)]
    write_atomically(path, "\n".join(lines) + "\n")


def _drawn(net: PetriNet, seed: int | None) -> Iterator[tuple[str, Order]]:
    if seed is not None:
        from random import Random

        start = list(range(len(net.places)))
        Random(seed).shuffle(start)
        yield f"force-seed-{seed}", force(net, tuple(start))


def _of_composed(net: PetriNet) -> Iterator[tuple[str, Order]]:
    # Sections belong on top, above the workers that they start and the resources below these. Composition
    # declares resources first, and FORCE may end with either end up, so each order is tried both ways.
    file = tuple(range(len(net.places)))
    for name, order in (
        ("force", force(net, file)),
        ("file", file),
        ("force-rcm", force(net, cuthill_mckee(net))),
        ("units", by_units(net, net.units)),
    ):
        ways = [(f"{name}-reversed", order[::-1]), (name, order)]
        yield from ways[::-1] if _stands_on_resources(net, order) else ways


def _stands_on_resources(net: PetriNet, order: Order) -> bool:
    """Whether the middle of what says what runs next is above the middle of the resources."""
    parts = [place.provenance and place.provenance.part for place in net.places]
    control = [level for level, p in enumerate(order) if parts[p] in CONTROL]
    resources = [level for level, p in enumerate(order) if parts[p] == "resource"]
    return sum(control) * len(resources) < sum(resources) * len(control)


def _named(net: PetriNet) -> Iterator[tuple[str, Order]]:
    # As they won on nets of the contest and on those of experiments/nets/hard_nets.py; each of the first
    # four is good for nets of which the others are bad.
    seeded = cuthill_mckee(net)
    few_pairs = sum(len(places) ** 2 for places in _touched(net)) <= MOST_PAIRS
    if few_pairs:
        yield "closing", closing(net, seeded)
    forced = force(net, seeded)
    units = net.units or state_machine_units(net)
    if units:
        by_force = together(net, units, forced)
        yield "units", by_units(net, units)
        yield "units-by-force-rcm-reversed", by_force[::-1]
    if few_pairs:
        yield "sloan", sloan(net, seeded)
    components = state_machine_units(net) if net.units else units
    if components:
        yield "components-forced-reversed", as_wholes(net, components)[::-1]
    yield "force-rcm-reversed", forced[::-1]
    if units:
        yield "units-by-force-rcm", by_force
    file = tuple(range(len(net.places)))
    yield "force-reversed", force(net, file)[::-1]
    yield "file", file


def _touched(net: PetriNet) -> list[list[int]]:
    """Places beside each transition."""
    return [sorted({p for side in (t.consume, t.produce, t.read) for p, _ in side}) for t in net.transitions]


def blocks(net: PetriNet, units: Iterable[Sequence[int]]) -> list[list[int]]:
    """All places by unit; a place of several units is of the first, one of none is alone, after the units."""
    placed: set[int] = set()
    groups: list[list[int]] = []
    for unit in (*units, *([p] for p in range(len(net.places)))):
        if fresh := [p for p in dict.fromkeys(unit) if p not in placed]:
            placed.update(fresh)
            groups.append(fresh)
    return groups


def by_units(net: PetriNet, units: Iterable[Sequence[int]]) -> Order:
    """Places of a unit together, units and their places as they are given."""
    return tuple(p for block in blocks(net, units) for p in block)


def together(net: PetriNet, units: Iterable[Sequence[int]], order: Order) -> Order:
    """Units by the mean of their places in an order, and the places of each as they stand there."""
    level = {p: i for i, p in enumerate(order)}
    grouped = blocks(net, units)
    grouped.sort(key=lambda block: sum(level[p] for p in block) / len(block))
    return tuple(p for block in grouped for p in sorted(block, key=level.__getitem__))


def as_wholes(net: PetriNet, units: Iterable[Sequence[int]]) -> Order:
    """FORCE on units instead of places; the places of each stand as they are given."""
    grouped = blocks(net, units)
    number = {p: i for i, block in enumerate(grouped) for p in block}
    touched = ({number[p] for p in places} for places in _touched(net))
    beside = [sorted(near) for near in touched if len(near) > 1]
    return tuple(p for i in kernel_force(beside, list(range(len(grouped))), MAX_ROUNDS) for p in grouped[i])


def clustered(net: PetriNet) -> Order:
    """Places in clusters: those that hang together stand together, however many hang on one of them.

    Two places pull each other by each transition beside both, less the more places it is beside. The two
    clusters that pull most, divided by a power of their sizes, are made one, again and again. So branches of
    a block that share a resource are one cluster each; FORCE mixes them, as it draws all of them to what they
    share. It says in which order the two parts of each cluster stand, and resources are below. Each step
    stands beside its worker.
    """
    start, touched = force(net, tuple(range(len(net.places)))), _touched(net)
    order = tuple(kernel_clustered(touched, list(start)))
    return _beside_workers(net, touched, order if _stands_on_resources(net, order) else order[::-1])


def _beside_workers(net: PetriNet, touched: Sequence[Sequence[int]], order: Order) -> Order:
    """Moves steps beside their workers.

    What looks at all branches of a block draws the steps of all of them together. It would say on top which
    branches run, have succeeded and have failed: all combinations, down to where their workers say it
    again. So a step stands above the place of a worker that pulls it most, and below it what nothing
    but steps leads to, such as the outcome of their branch; of several steps below the first.
    """
    parts = [place.provenance and place.provenance.part for place in net.places]
    pulls: dict[int, Counter[int]] = {}
    for places in touched:
        for step in (p for p in places if parts[p] == "step"):
            drawn = {p: (len(places) - 1) ** -2 for p in places if parts[p] == "worker"}
            pulls.setdefault(step, Counter()).update(drawn)
    above, below = dict[int, list[int]](), dict[int, list[int]]()
    leading: dict[int, list[list[int]]] = {}
    level = {p: i for i, p in enumerate(order)}
    for t in net.safe_transitions:
        steps = sorted((p for p in t.consume if parts[p] == "step"), key=level.__getitem__)
        for place in t.produce:
            leading.setdefault(place, []).append(steps)
    for place in order:
        if pull := pulls.get(place):
            strongest = max(pull, key=lambda p: (pull[p], -level[p]))
            above.setdefault(strongest, []).append(place)
        elif parts[place] == "block" and all(ways := leading.get(place, [[]])):
            first = min((way[0] for way in ways), key=level.__getitem__)
            below.setdefault(first, []).append(place)
    moved = {p for places in (*above.values(), *below.values()) for p in places}

    def block(place: int) -> Iterator[int]:
        for step in above.get(place, ()):
            yield from block(step)
        yield place
        yield from below.get(place, ())

    return tuple(p for place in order if place not in moved for p in block(place))


def cuthill_mckee(net: PetriNet) -> Order:
    """Reverse Cuthill-McKee on the bipartite graph of places and transitions (Cuthill, McKee 1969).

    Each component is walked breadth first, neighbours of low degree first, from a node at its rim, found by
    walking to a farthest node of low degree until no farther one is found (George, Liu 1979).
    """
    count = len(net.places)
    touched = _touched(net)
    neighbours: list[list[int]] = [[] for _ in range(count)]
    for number, places in enumerate(touched):
        for place in places:
            neighbours[place].append(count + number)
    neighbours += touched

    def walk(start: int) -> tuple[list[int], list[int]]:
        """Nodes as they are reached, and their distances."""
        seen, visited, distances = {start}, [start], [0]
        for at, node in enumerate(visited):  # grows while it is walked
            unseen = (n for n in neighbours[node] if n not in seen)
            fresh = sorted(unseen, key=lambda n: (len(neighbours[n]), n))
            seen.update(fresh)
            visited += fresh
            distances += [distances[at] + 1] * len(fresh)
        return visited, distances

    order: list[int] = []
    placed: set[int] = set()
    for node in range(count):
        if node in placed:
            continue
        visited, distances = walk(node)
        far = 0
        while distances[-1] > far:
            far = distances[-1]
            rim = [n for n, distance in zip(visited, distances, strict=True) if distance == far]
            visited, distances = walk(min(rim, key=lambda n: (len(neighbours[n]), n)))
        placed.update(visited)
        order += visited
    return tuple(node for node in reversed(order) if node < count)


def force(net: PetriNet, start: Order) -> Order:
    """FORCE from a given order; wide transitions pull less.

    Args:
        net: The net.
        start: The order to begin with.

    Returns:
        The order of least total span that was passed, with each span divided by the transition's width.
    """
    touched = [places for places in _touched(net) if len(places) > 1]
    return tuple(kernel_force(touched, list(start), MAX_ROUNDS))


def closing(net: PetriNet, start: Order) -> Order:
    """A greedy order: the next place is the one that brings transitions under way nearest to their end.

    Args:
        net: The net.
        start: Where this order leaves a choice, the first there is the next.
    """
    return tuple(kernel_closing(_touched(net), list(start)))


def sloan(net: PetriNet, start: Order) -> Order:
    """Sloan's order of the graph in which the places of a transition are neighbours.

    Args:
        net: The net.
        start: The first there of each component says where its ends are looked for.
    """
    return tuple(kernel_sloan(_touched(net), list(start)))
