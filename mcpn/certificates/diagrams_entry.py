"""The entry ``diagrams.json`` of a certificate: sets of markings that prove claims on very many states."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from math import inf
from typing import Any

from mcpn._kernel import Store, Zdd
from mcpn.certificates.certcheck import ENDS, VERSION
from mcpn.certificates.diagsets import Families, unknown
from mcpn.certificates.entries import Claimed
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.events import What
from mcpn.nets.petri import PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.diagrams.encoding import Encoding
from mcpn.spaces.diagrams.internal_evolution import leading
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace

MOST_PLACES = 1_500
"""Places of a net up to which diagrams are written."""
MOST_NODES = 1_000_000
"""Nodes of all diagrams of a certificate."""
Rows = list[list[int]]


class _NodeRows:
    """Nodes of diagrams on as many levels, each once."""

    def __init__(self) -> None:
        self.rows: Rows = []
        self._number = dict[tuple[int, int, int], int]()

    def node(self, level: int, low: int, high: int) -> int:
        """The number of a node; that of its low child where the high one is empty."""
        if not high:
            return low
        key = level, low, high
        if key not in self._number:
            if len(self.rows) >= MOST_NODES:
                raise LimitError(f"no certificate: its diagrams have more than {MOST_NODES} nodes")
            self._number[key] = len(self.rows) + 2
            self.rows.append([*key])
        return self._number[key]

    def add(self, states: Zdd) -> int:
        """The number of the node that stands for some markings."""
        if not states:
            return 0
        if states.nodes() == 0:  # the empty set of levels alone
            return 1
        found = [0, 1]
        for level, low, high in _rows_of(states):
            found.append(self.node(level, found[low], found[high]))
        return found[-1]


def _rows_of(states: Zdd) -> list[tuple[int, int, int]]:
    """The nodes of a set, children first."""
    raw = states.to_bytes()
    numbers = struct.unpack(f"={len(raw) // 4}I", raw)
    return list(zip(numbers[::3], numbers[1::3], numbers[2::3], strict=True))


class _Pairs:
    """Pairs of a marking, on even levels, and its stable end, on odd ones.

    Args:
        encoding: The net on its levels.
    """

    def __init__(self, encoding: Encoding) -> None:
        self.size = len(encoding.places)
        self.store = Store(2 * self.size, encoding.memory_limit)
        safe = encoding.net.safe_transitions
        undone = {t: self._event(encoding, safe[t]) for t in encoding.events}
        ranks = encoding.net.internal_ranks
        self.undoing_ranks = [list(dict.fromkeys(undone[t] for t in own if t in undone)) for own in ranks]
        self.internal_back = [event for own in self.undoing_ranks for event in own]

    def _event(self, encoding: Encoding, transition: Any) -> int:
        """The event that takes the first marking back to the one before a firing."""
        consume, produce, read = (
            [2 * level for level in encoding.levels(places)]
            for places in (transition.consume, transition.produce, transition.read)
        )
        zero = sorted(
            {2 * encoding.level[encoding.partner[p]] for p in transition.read if p in encoding.partner}
        )
        return self.store.event(produce, consume, read, zero)

    def of(self, states: Zdd, own: bool) -> Zdd:
        """Pairs whose first marking is one of some: with itself, or with any."""
        if not states:
            return self.store.empty()
        table, rows = _NodeRows(), _rows_of(states)
        levels = [self.size] * 2 + [level for level, _, _ in rows]
        anything = dict[tuple[int, int], int]()

        def any_from(child: int, found: int, level: int) -> int:
            """A child with any second marking on the levels from one on that it skips."""
            for skipped in range(levels[child] - 1, level - 1, -1):
                key = child, skipped
                if key not in anything:
                    anything[key] = table.node(2 * skipped + 1, found, found)
                found = anything[key]
            return found

        numbers = [0, 1]
        for level, low, high in rows:
            if own:
                upper = table.node(2 * level + 1, 0, numbers[high])
                numbers.append(table.node(2 * level, numbers[low], upper))
                continue
            lower = any_from(low, numbers[low], level + 1) if numbers[low] else 0
            upper = any_from(high, numbers[high], level + 1) if numbers[high] else 0
            lower, upper = table.node(2 * level + 1, lower, lower), table.node(2 * level + 1, upper, upper)
            numbers.append(table.node(2 * level, lower, upper))
        if not own:
            numbers[-1] = any_from(len(numbers) - 1, numbers[-1], 0)
        flat = [number for row in table.rows for number in row]
        return self.store.from_bytes(struct.pack(f"={len(flat)}I", *flat))


class DiagramWriter:
    """The sets that prove what a check says, and the claims.

    Args:
        mission_net: The mission's net.
        space: All of its markings, as a diagram.
        markings: The same as a graph.

    Raises:
        LimitError: There are too many places or nodes.
    """

    def __init__(self, mission_net: MissionNet, space: SymbolicSpace, markings: Space[Zdd]) -> None:
        if len(mission_net.net.places) > MOST_PLACES:
            raise LimitError(f"no certificate: the net has more than {MOST_PLACES} places")
        self.mission_net, self.space, self.encoding = mission_net, space, space.encoding
        self.reached, self.allowed, self.table = space.reachable, space.allowed, _NodeRows()
        self.stable = self.reached.without(self.encoding.unstable)
        self.markings = markings

    def document(self, claims: Iterable[Claimed]) -> dict[str, Any]:
        """The entry, with claims whose evidence has been made before."""
        pairs, table = _Pairs(self.encoding), _NodeRows()
        within = [pairs.of(allowed, own=False) for allowed in self.allowed]
        goal = pairs.of(self.stable, own=True)
        ends = _leading_pairs(pairs, goal, within) if within else goal
        weights, again = falling_weights(self.encoding.net)
        return {
            "format": "mcpn-certificate",
            "version": VERSION,
            "order": [*self.encoding.places],
            "partners": [[dropped, kept] for dropped, kept in self.encoding.partner.items()],
            "reached": self.table.add(self.reached),
            "ends": table.add(ends),
            "weights": weights,
            "again": again,
            "layers": [self.table.add(layer) for layer in self._layers(again)],
            "claims": [*claims],
            "nodes": self.table.rows,
            "pairs": table.rows,
        }

    def before(self, states: Zdd, transitions: Iterable[int]) -> Zdd:
        """The markings from which one of some transitions may fire and leads into some."""
        found, ranks = self.encoding.store.empty(), self.encoding.net.internal_ranks
        rank_of = {t: rank for rank, own in enumerate(ranks) for t in own}
        for t in transitions:
            if t in self.encoding.undoing:
                where = self.allowed[rank_of[t]] if t in rank_of else self.stable
                found |= states.images([self.encoding.undoing[t]], within=where)
        return found

    def _layers(self, again: Sequence[int]) -> list[Zdd]:
        """The markings from which what does not lower the weights fires 0 times, at most once, and so on."""
        found, beyond = list[Zdd](), self.reached
        while again and beyond:
            beyond = leading(self.encoding, self.before(beyond, again), self.allowed)
            found.append(self.reached - beyond)
        return found

    def ended(self, ends: Iterable[str]) -> Zdd:
        """The markings in which the mission has ended so."""
        places = [self.mission_net.ends[end] for end in ends if end in self.mission_net.ends]
        found = self.encoding.store.empty()
        for place in places:
            found |= self.encoding.restricted(self.reached, [place])
        return found

    def run(self, goal: Zdd) -> list[int]:
        """The events of a short run into a goal."""
        edges = self.markings.run(self.markings.initial.pick(), goal)
        assert edges is not None, "the check has found one"
        every = self.encoding.net.transitions
        return [edge.transition for edge in edges if every[edge.transition].event is not None]

    def evidence(self, kind: str, holds: bool) -> dict[str, Any]:
        """What proves a claim of a kind beside the sets that prove all of them."""
        events = [t for t, each in enumerate(self.encoding.net.transitions) if each.event is not None]
        match kind:
            case "safe" | "confluent":
                return {}
            case "can_always_go_on":
                if holds:
                    return {}
                enabling = (self.encoding.enabling.get(t) for t in events)
                stuck = self.stable.without([c for c in enabling if c is not None])
                return {"run": self.run(stuck - self.ended(("success", "failure", "abort")))}
            case "can_always_end" | "can_always_end_safely":
                layers, left = self._finishing(self.ended(ENDS[kind]), events)
                if holds:
                    return {"layers": [self.table.add(layer) for layer in layers]}
                run = self.run(left)
                closed = self.markings.reached(self._single(left))
                return {"run": run, "closed": self.table.add(closed)}
        return {"run": self.run(self.stable & self.ended(ENDS[kind]))} if holds else {}

    def cut_sets(
        self, ends: Sequence[str], hardware: Sequence[str], cuts: Iterable[Sequence[str]]
    ) -> dict[str, Any]:
        """What proves the minimal cut sets of some ends: a closed set for each, and layers without repair.

        Raises:
            LimitError: Some sets are survived, but never without a repair.
        """
        net, encoding = self.encoding.net, self.encoding
        repairs = {
            t: each.event.element
            for t, each in enumerate(net.transitions)
            if each.event is not None and each.event.what is What.REPAIRED
        }
        events = [t for t, each in enumerate(net.transitions) if each.event is not None]
        every, goal = range(len(net.transitions)), self.ended(ends)
        starts = encoding.restricted(self.stable, [self.mission_net.beginning])
        out = {name: self.mission_net.by_role["oos", name] for name in hardware}
        if any(len(places) > 1 for places in out.values()):
            raise LimitError("no certificate: several places say that hardware is out of service")
        closed = list[int]()
        for cut in cuts:
            lost = encoding.restricted(starts, [place for name in cut for place in out[name]])
            may = [t for t in every if repairs.get(t) not in cut]
            closed.append(self.table.add(self.markings.reached(lost, transitions=may)))
        layers, _ = self._finishing(goal, [t for t in events if t not in repairs])
        self._need_all(starts & layers[-1], [out[name][0] for name in hardware], hardware, cuts)
        return {"closed": closed, "layers": [self.table.add(layer) for layer in layers]}

    def _need_all(
        self, survived: Zdd, out: Sequence[int], hardware: Sequence[str], cuts: Iterable[Sequence[str]]
    ) -> None:
        """Refuses where starts that are survived and cuts leave some set of hardware open."""
        sets, lost = (Families(size, MOST_NODES, inf) for size in (len(self.encoding.places), len(hardware)))
        marks = sorted((self.encoding.bit(place), name) for place, name in zip(out, hardware, strict=True))
        found = sets.read([[*row] for row in _rows_of(survived)], "")[-1] if survived else 0
        literals, number = (
            [(level, not reverse) for (level, reverse), _ in marks],
            {name: i for i, (_, name) in enumerate(marks)},
        )
        known = lost.parts(sets.onto(found, literals, lost, {}, {}), {}, {})
        if unknown(lost, known, [[number[name] for name in cut] for cut in cuts]):
            raise LimitError("some losses are survived, but only if something else is repaired")

    def _single(self, states: Zdd) -> Zdd:
        """The member that :meth:`run` leads to: where its run ends."""
        begin = self.markings.initial.pick()
        edges = self.markings.run(begin, states)
        assert edges is not None, "all markings are reached"
        assert begin is not None, "one is the first"
        return self.encoding.store.singleton(edges[-1].target if edges else begin)

    def _finishing(self, ends: Zdd, events: Sequence[int]) -> tuple[list[Zdd], Zdd]:
        """By layer the markings from which one event more leads to an end; the stable ones that are left."""
        done = self.stable & ends
        layers = [leading(self.encoding, done, self.allowed)]
        while self.reached - layers[-1]:
            more = self.before(layers[-1], events) - done
            if not more:
                break
            done |= more
            layers.append(leading(self.encoding, done, self.allowed))
        return layers, self.stable - done


def _leading_pairs(pairs: _Pairs, goal: Zdd, within: Sequence[Zdd]) -> Zdd:
    """The pairs whose first markings lead to where the goal's are, by internal firings."""
    first, *later = pairs.undoing_ranks
    found, front = pairs.store.empty(), goal
    while front:
        front = front.saturate(first, within=within[0]) - found
        found |= front
        before = [front.images(events, within=where) for events, where in zip(later, within[1:], strict=True)]
        front = pairs.store.empty()
        for each in before:
            front |= each
        front -= found
    return found


def falling_weights(net: PetriNet) -> tuple[list[int], list[int]]:
    """A weight for each place such that most internal transitions lower the sum; and those that do not.

    What raises it costs as much as it does, so that few do.
    """
    from mcpn.nets.programs import LinearProgram

    internal = [t for t, each in enumerate(net.transitions) if each.event is None]
    changes = [_change(net, t) for t in internal]
    places = len(net.places)
    rows = [({**change, places + i: -1.0}, -1e9, -1.0) for i, change in enumerate(changes)]
    bounds = [1000.0] * places + [1e6] * len(internal)
    costs = [0.0] * places + [1.0] * len(internal)
    found = LinearProgram(costs, rows, [0.0] * len(bounds), bounds).minimise() if internal else None
    values = found.values if found is not None and found.kind == "solved" else (0.0,) * places
    weights = [round(1000 * value) for value in values[:places]]
    sums = (sum(weights[p] * by for p, by in change.items()) for change in changes)
    return weights, [t for t, by in zip(internal, sums, strict=True) if by >= 0]


def _change(net: PetriNet, t: int) -> dict[int, float]:
    """By place how many tokens a firing adds."""
    change = dict[int, float]()
    for arcs, sign in ((net.transitions[t].consume, -1.0), (net.transitions[t].produce, 1.0)):
        for place, weight in arcs:
            change[place] = change.get(place, 0.0) + sign * weight
    return {place: by for place, by in change.items() if by}
