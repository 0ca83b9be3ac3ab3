"""Generated nets, and the slow, plain explorer that judges the quick ones."""

from __future__ import annotations

import random
from collections import deque

from hypothesis import strategies as st

from mcpn.events import START, Event, What
from mcpn.nets.petri import Marking, NetBuilder, PetriNet

EVENTS = (Event.parse("EV_A"), Event(What.SUCCESS, "x"))

RANKS = st.sampled_from([0, 0, 0, 1, 1, 2])
"""Ranks of internal transitions; most nets have few."""

ODD_NAMES = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co", "Zl", "Zp")),
    min_size=1,
    max_size=6,
)


def counter(bits: int) -> PetriNet:
    """A binary counter from 0 to 2^bits - 1, where it stops: 2^bits markings, one after the other."""
    builder = NetBuilder("counter")
    for bit in range(bits):
        builder.place(f"zero{bit}", initial=1)
        builder.place(f"one{bit}")
    for bit in range(bits):
        builder.transition(
            f"up{bit}",
            consume=[f"zero{bit}", *(f"one{lower}" for lower in range(bit))],
            produce=[f"one{bit}", *(f"zero{lower}" for lower in range(bit))],
        )
    return builder.build()


@st.composite
def nets(
    draw: st.DrawFn,
    *,
    max_places: int = 6,
    max_transitions: int = 6,
    max_weight: int = 1,
    events: bool = True,
) -> PetriNet:
    """Any small net, with read arcs, self-loops, events, priorities and ranks, safe or not."""
    count = draw(st.integers(1, max_places))
    names = [f"p{i}" for i in range(count)]
    size = draw(st.integers(0, max_transitions))
    transitions = [f"t{i}" for i in range(size)]
    priorities = events and draw(st.booleans())
    builder = NetBuilder("net", priorities=priorities)
    for name in names:
        builder.place(name, initial=draw(st.integers(0, max_weight)))
    weights = st.dictionaries(st.sampled_from(names), st.integers(1, max_weight), max_size=3)
    for name in transitions:
        consume, produce, read = draw(weights), draw(weights), draw(weights)
        event = draw(st.none() | st.sampled_from(EVENTS)) if events else None
        rank = draw(RANKS) if priorities and event is None else 0
        builder.transition(name, consume=consume, produce=produce, read=read, event=event, rank=rank)
    return builder.build()


def reachable(net: PetriNet, limit: int = 5000) -> tuple[dict[Marking, int], int, bool]:
    """Markings with their distance, the number of firings, and whether all are 1-safe: the net's own rule."""
    found = {net.initial: 0}
    queue, edges = deque([net.initial]), 0
    safe = max(net.initial, default=0) <= 1
    while queue and safe and len(found) < limit:
        marking = queue.popleft()
        for transition in net.enabled(marking):
            after = net.fire(marking, transition)
            edges += 1
            if max(after) > 1:
                return found, edges, False
            if after not in found:
                found[after] = found[marking] + 1
                queue.append(after)
    return found, edges, safe


def made_safe(net: PetriNet) -> PetriNet:
    """The net without the transitions that put a second token in a place, from the first one reached on."""
    seen, queue, left = {net.initial}, deque([net.initial]), set(net.transitions)
    while queue:
        marking = queue.popleft()
        for transition in net.enabled(marking):
            after = net.fire(marking, transition)
            if max(after) > 1:
                left.discard(net.transitions[transition])
            elif after not in seen:
                seen.add(after)
                queue.append(after)
    kept = tuple(transition for transition in net.transitions if transition in left)
    rest = PetriNet(net.name, net.places, kept, priorities=net.priorities)
    return rest if reachable(rest)[2] else made_safe(rest)


@st.composite
def token_nets(draw: st.DrawFn) -> PetriNet:
    """Small nets with weights and several tokens, without priorities; most of them are bounded."""
    count = draw(st.integers(1, 5))
    names = [f"p{i}" for i in range(count)]
    builder = NetBuilder("tokens")
    for name in names:
        builder.place(name, initial=draw(st.integers(0, 5)))
    weights = st.dictionaries(st.sampled_from(names), st.integers(1, 3), max_size=3)
    for number in range(draw(st.integers(0, 6))):
        consume, produce, read = draw(weights), draw(weights), draw(weights)
        # As many tokens come as go, more seldom: with a net of such transitions only, the sum never grows.
        spare = sum(consume.values()) + draw(st.sampled_from([0, 0, 0, 0, 0, 1]))
        kept = {}
        for name, weight in produce.items():
            kept[name] = min(weight, spare)
            spare -= kept[name]
        builder.transition(f"t{number}", consume=consume, produce=kept, read=read)
    return builder.build()


def graph_of(net: PetriNet, limit: int = 400) -> dict[Marking, list[tuple[int, Marking]]] | None:
    """Every reachable marking with its firings by the net's own rule, unless there are more than a limit."""
    found: dict[Marking, list[tuple[int, Marking]]] = {}
    stack = [net.initial]
    while stack:
        marking = stack.pop()
        if marking not in found:
            if len(found) == limit:
                return None
            found[marking] = [(t, net.fire(marking, t)) for t in net.enabled(marking)]
            stack.extend(after for _, after in found[marking])
    return found


def pt_nets() -> st.SearchStrategy[PetriNet]:
    """Small nets with weights and several tokens: what place/transition nets can say, and events."""
    return nets(max_weight=4)


def safe_ish_nets() -> st.SearchStrategy[PetriNet]:
    """Small nets with weights 1 and at most one token a place at first: many of them are 1-safe."""
    return nets(max_weight=1)


@st.composite
def state_machines(draw: st.DrawFn) -> tuple[PetriNet, int]:
    """Rings of states side by side that synchronise on common transitions, and how many: all 1-safe."""
    builder = NetBuilder("machines")
    machines = draw(st.integers(1, 4))
    sizes = [draw(st.integers(1, 4)) for _ in range(machines)]
    for machine, size in enumerate(sizes):
        start = draw(st.integers(0, size - 1))
        for state in range(size):
            builder.place(f"m{machine}s{state}", initial=int(state == start))
            after = f"m{machine}s{(state + 1) % size}"
            builder.transition(f"m{machine}t{state}", consume=[f"m{machine}s{state}"], produce=[after])
    moves = st.tuples(st.integers(0, 3), st.integers(0, 3))
    for number in range(draw(st.integers(0, 8))):
        members = draw(st.sets(st.integers(0, machines - 1), min_size=1, max_size=2))
        consume, produce = [], []
        for machine in sorted(members):
            source, target = draw(moves)
            consume.append(f"m{machine}s{source % sizes[machine]}")
            produce.append(f"m{machine}s{target % sizes[machine]}")
        builder.transition(f"t{number}", consume=consume, produce=produce)
    return builder.build(), machines


def events(names: st.SearchStrategy[str]) -> st.SearchStrategy[Event]:
    """Events of every kind: of an element, or of whatever a text says."""
    of_elements = [what for what in What if what is not What.START]
    typed = st.builds(Event, st.sampled_from(of_elements), names.filter(bool))
    return st.just(START) | typed | names.map(Event.parse)


@st.composite
def odd_nets(draw: st.DrawFn, *, line_breaks: bool = False) -> PetriNet:
    """Small nets whose names are whatever the model allows, places and transitions of one name included."""
    letters = st.sampled_from(
        "{}\\\"'<>&#:*?!()[]-> .,p1é→\u00a0\U0001f916" + ("\n\r\t" if line_breaks else "")
    )
    texts = st.text(letters, max_size=5) | st.sampled_from(["net", "tr", "id1", "id2", "node", "p*3", "p?1"])
    texts |= ODD_NAMES
    places = draw(st.lists(texts, min_size=1, max_size=5, unique=True))
    names = draw(st.lists(texts, max_size=5, unique=True))
    builder = NetBuilder(draw(texts), priorities=draw(st.booleans()))
    for name in places:
        builder.place(name, initial=draw(st.integers(0, 3) | st.just(10**18 - 1)))
    weights = st.dictionaries(st.sampled_from(places), st.integers(1, 3) | st.just(10**18 - 1), max_size=3)
    for name in names:
        consume, produce, read = draw(weights), draw(weights), draw(weights)
        event = draw(st.none() | events(texts.filter(bool)))
        rank = draw(RANKS) if event is None else 0
        builder.transition(name, consume=consume, produce=produce, read=read, event=event, rank=rank)
    return builder.build()


@st.composite
def cascades(draw: st.DrawFn) -> PetriNet:
    """Nets of ranks whose transitions bring about others, which compete; 1-safe, and what fires ends.

    An event marks starts and tokens to compete for. Transitions of later ranks each take a start and mark a
    place of their own; others, mostly of the first rank, follow on these or on one another, and take or read
    what is competed for, as some of the former do. So a conflict between two is open where others bring them
    about, at once or by several steps.
    """
    builder = NetBuilder("cascades", priorities=True)
    rivals = [f"c{i}" for i in range(draw(st.sampled_from([1, 1, 2])))]
    starts = [f"s{i}" for i in range(draw(st.sampled_from([2, 2, 3])))]
    builder.place("begin", initial=1)
    for name in (*rivals, *starts):
        builder.place(name)
    builder.transition("go", consume=["begin"], produce=[*rivals, *starts], event=Event.parse("GO"))
    brought, taken, wanted = list[str](), set[str](), st.lists(st.sampled_from(rivals), max_size=1)
    for number, start in enumerate(starts):
        builder.place(f"q{number}")
        takes = [start, *(draw(wanted) if draw(st.integers(0, 2)) == 0 else ())]
        rank = draw(st.sampled_from([1, 1, 1, 2]))
        builder.transition(f"first{number}", consume=takes, produce=[f"q{number}"], rank=rank)
        brought.append(f"q{number}")
    for number in range(draw(st.integers(2, 4))):
        builder.place(f"r{number}")
        last = [place for place in brought if place not in taken] or brought
        takes = [draw(st.sampled_from(last))]
        if draw(st.integers(0, 4)) == 0:
            takes = draw(st.lists(st.sampled_from(brought), min_size=1, max_size=2, unique=True))
        taken.update(takes)
        asked = draw(wanted)
        reads = draw(st.integers(0, 5)) == 0
        builder.transition(
            f"then{number}",
            consume=[*takes, *(() if reads else asked)],
            read=asked if reads else [],
            produce=[f"r{number}"],
            rank=draw(st.sampled_from([0, 0, 0, 0, 1])),
        )
        brought.append(f"r{number}")
    return builder.build()


@st.composite
def falls(draw: st.DrawFn) -> PetriNet:
    """Nets of ranks whose tokens fall from place to later place, so that all evolution ends.

    An event marks some of the first places. Transitions compete for tokens, wait for those of others and may
    put a second one in a place: often in some orders only.
    """
    builder = NetBuilder("falls", priorities=True)
    count = draw(st.integers(4, 9))
    first = draw(st.integers(1, count - 2))
    builder.place("top", initial=1)
    for number in range(count):
        builder.place(f"p{number}", initial=int(number >= first and draw(st.integers(0, 5)) == 0))
    builder.transition(
        "let_go", consume=["top"], produce=[f"p{i}" for i in range(first)], event=Event.parse("GO")
    )
    for number in range(draw(st.integers(2, 9))):
        takes = draw(st.sets(st.integers(0, count - 2), min_size=1, max_size=2))
        later = st.integers(max(takes) + 1, count - 1)
        puts = draw(st.sets(later, max_size=2))
        others = sorted({*range(count)} - takes - puts)
        reads = {draw(st.sampled_from(others))} if others and draw(st.integers(0, 3)) == 0 else set()
        builder.transition(
            f"fall{number}",
            consume=[f"p{i}" for i in sorted(takes)],
            produce=[f"p{i}" for i in sorted(puts)],
            read=[f"p{i}" for i in sorted(reads)],
            rank=draw(st.sampled_from([0, 0, 1, 1, 2])),
        )
    return builder.build()


@st.composite
def conflicting_nets(draw: st.DrawFn, *, ranks: int = 1) -> PetriNet:
    """Machines side by side, all 1-safe, whose internal moves are in conflict and end.

    One or two machines move to later states by internal transitions, which may ask for states of others or
    move both; there are several ways from the first state, and some from each other one but the last.
    Further machines are moved by events alone: a conflict comes up with different states of them beside it,
    and leads to one marking here and to two there. Places and transitions are in any order.

    Args:
        draw: Given by hypothesis.
        ranks: How many ranks internal transitions may have.

    Returns:
        A strategy of nets with priorities.
    """
    sizes = draw(st.lists(st.integers(3, 4), min_size=1, max_size=2))
    moving = range(len(sizes))
    sizes += [2] * draw(st.integers(1, 3))
    every, drawn = range(len(sizes)), list[tuple[list[str], list[str], list[str], Event | None, int]]()

    def later(machine: int, state: int) -> str:
        return f"m{machine}s{draw(st.integers(state + 1, sizes[machine] - 1))}"

    for machine in moving:
        for state in range(sizes[machine] - 1):
            for _ in range(draw(st.integers(1, 2)) + (state == 0)):
                consume, produce = [f"m{machine}s{state}"], [later(machine, state)]
                others = [m for m in every if m != machine]
                if len(moving) > 1 and draw(st.integers(0, 5)) == 0:
                    other = 1 - machine
                    others.remove(other)
                    with_it = draw(st.integers(0, sizes[other] - 2))
                    consume.append(f"m{other}s{with_it}")
                    produce.append(later(other, with_it))
                asked = draw(st.lists(st.sampled_from(others), max_size=2, unique=True))
                read = [f"m{m}s{draw(st.integers(0, sizes[m] - 1))}" for m in asked]
                drawn.append((consume, produce, read, None, draw(st.integers(0, ranks - 1))))
    for machine, size in enumerate(sizes):
        for state in {0, size - 1}:
            to = (state + 1) % size
            ends = [f"m{machine}s{state}"], [f"m{machine}s{to}"]
            drawn.append((*ends, [], Event.parse(f"EV_{machine}_{state}"), 0))
    builder = NetBuilder("machines", priorities=True)
    places = [f"m{machine}s{state}" for machine, size in enumerate(sizes) for state in range(size)]
    for name in draw(st.permutations(places)):
        builder.place(name, initial=int(name.endswith("s0")))
    for number, (consume, produce, read, event, rank) in enumerate(draw(st.permutations(drawn))):
        builder.transition(f"t{number}", consume=consume, produce=produce, read=read, event=event, rank=rank)
    return builder.build()


def reordered(net: PetriNet, order: random.Random) -> PetriNet:
    """The same net with its places and transitions in another order."""
    builder = NetBuilder(net.name, priorities=net.priorities)
    names = [place.name for place in net.places]
    for p in order.sample(range(len(names)), len(names)):
        builder.place(names[p], initial=net.initial[p])
    for t in order.sample(net.transitions, len(net.transitions)):
        consume, produce, read = ([names[p] for p, _ in arcs] for arcs in (t.consume, t.produce, t.read))
        builder.transition(t.name, consume=consume, produce=produce, read=read, event=t.event, rank=t.rank)
    return builder.build()
