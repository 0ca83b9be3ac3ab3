"""diagcheck: checks claims of a certificate whose states are too many to list, by sets as decision diagrams.

``python diagcheck.py CERTIFICATE`` needs ``certcheck.py`` and ``diagsets.py`` beside it and nothing else of
mcpn. The entry ``diagrams.json`` holds sets of markings, and of pairs of a marking and its stable end; that
they hold what they must, and are closed under what may fire, proves each claim. The page docs/certificates.md
describes it in full. Exit codes are those of ``certcheck``.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterable
from functools import cache, cached_property
from typing import Any

try:
    from mcpn.certificates import certcheck
    from mcpn.certificates.diagsets import Families, Literal, Word, unknown
except ImportError:  # alone, beside the other files
    import certcheck  # type: ignore[import-not-found, no-redef]
    from diagsets import Families, Literal, Word, unknown  # type: ignore[import-not-found, no-redef]

Json = Any
DIAGRAMS = {
    **certcheck.FORMAT,
    "order": [int],
    "partners": [[int]],
    "nodes": [[int]],
    "pairs": [[int]],
    "reached": int,
    "ends": int,
    "weights": [int],
    "again": [int],
    "layers": [int],
    "claims": [certcheck.CLAIM],
}
ENDS = ("success", "failure", "abort")
LONGEST = 100_000
"""Internal firings after one event up to which a run is followed."""


class CertifiedSets:
    """The sets of a certificate, and what they prove of its net."""

    def __init__(self, net: certcheck.Net, document: Json, most: int, until: float) -> None:
        self.net, self.document = net, document
        places = len(net.names)
        self.at = dict[int, Literal]()
        for level, place in enumerate(document["order"]):
            fine = 0 <= place < places and place not in self.at
            certcheck.need(fine, f"order: place {place}", certcheck.Malformed)
            self.at[place] = (level, True)
        for pair in document["partners"]:
            fine = len(pair) == 2 and pair[1] in self.at and 0 <= pair[0] < places and pair[0] not in self.at
            certcheck.need(fine and self.at[pair[1]][1], f"partners: {pair}", certcheck.Malformed)
            self.at[pair[0]] = (self.at[pair[1]][0], False)
        certcheck.need(
            len(self.at) == places, "a place is in neither order nor partners", certcheck.Malformed
        )
        known = set(document["again"]) <= {*range(len(net.name))}
        certcheck.need(known, "again: what is no transition", certcheck.Malformed)
        size = len(document["order"])
        self.sets, self.pairs = Families(size, most, until), Families(2 * size, most, until)
        self.roots = self.sets.read(document["nodes"], "diagrams.json: nodes")
        self.pair_roots = self.pairs.read(document["pairs"], "diagrams.json: pairs")
        for dropped, kept in document["partners"]:
            self.opposite(dropped, kept)
        self.cube = [self.literals(net.pre[t]) for t in range(len(net.name))]
        self.word = [self.word_of(t) for t in range(len(net.name))]
        self.ranks = sorted({net.rank[t] for t in net.internal})
        self.reached = self.root(document["reached"])

    def root(self, number: int) -> int:
        """The set that a number of the document names."""
        fine = 0 <= number < len(self.roots)
        certcheck.need(fine, f"diagrams.json: {number} is no node", certcheck.Malformed)
        return self.roots[number]

    def opposite(self, dropped: int, kept: int) -> None:
        """Refutes a pair of places of which not always one alone is marked."""
        net, p, q = self.net, 1 << dropped, 1 << kept
        fine = bool(net.initial & p) != bool(net.initial & q)
        for takes, puts in zip(net.consume, net.produce, strict=True):
            gained, lost = bool(puts & p) - bool(takes & p), bool(takes & q) - bool(puts & q)
            fine = fine and gained == lost
        certcheck.need(fine, f"{net.names[dropped]} is not the reverse of {net.names[kept]}")

    def literals(self, places: int) -> list[Literal] | None:
        """That some places are marked; none where that contradicts itself."""
        found = dict[int, bool]()
        for place in certcheck.indices(places):
            level, so = self.at[place]
            if found.setdefault(level, so) != so:
                return None
        return sorted(found.items())

    def word_of(self, t: int) -> Word | None:
        """What a transition needs and leaves; none where it never fires without a second token in a place."""
        net, cube = self.net, self.cube[t]
        if cube is None:
            return None
        before, after = dict(cube), dict[int, bool]()
        for place in certcheck.indices(net.produce[t] & ~net.consume[t]):
            level, so = self.at[place]
            if before.setdefault(level, not so) == so:
                return None
            after[level] = so
        for place in certcheck.indices(net.consume[t] & ~net.produce[t]):
            level, so = self.at[place]
            after[level] = not so
        return [(level, so, after.get(level, so)) for level, so in sorted(before.items())]

    def split(self, states: int, sets: Families, scale: int = 1) -> tuple[dict[int, int], int]:
        """By rank those of some markings in which it may fire; and the stable ones."""
        allowed = dict[int, int]()
        for rank in self.ranks:
            allowed[rank] = states
            for t in self.net.internal:
                cube = self.cube[t]
                if self.net.rank[t] == rank and cube is not None:
                    states = sets.without(states, [(scale * level, so) for level, so in cube])
        return allowed, states

    def closed(self, states: int, into: int, events: Iterable[int], internal: Iterable[int], why: str) -> int:
        """Refutes markings from which some firings do not lead into others; the stable ones."""
        allowed, stable = self.split(states, self.sets)
        for t in (*internal, *events):
            here = stable if self.net.event[t] else allowed[self.net.rank[t]]
            if (word := self.word[t]) is not None:
                fine = self.sets.leads(here, into, word)
                certcheck.need(fine, f"{why}: {self.net.name[t]} leads out of the set")
        return stable

    def marked(self, states: int, role: str, *of: str) -> list[list[Literal]]:
        """The literals that say that a place is marked which has a role."""
        found = list[list[Literal]]()
        for (said, element), places in self.net.roles.items():
            if said == role and (not of or element in of):
                found += [self.literals(1 << place) or [] for place in certcheck.indices(places)]
        return found

    def minus(self, states: int, roles: Iterable[str]) -> int:
        """Those of some markings that mark no place with one of some roles."""
        for role in roles:
            for cube in self.marked(states, role):
                states = self.sets.without(states, cube)
        return states

    @cached_property
    def stable(self) -> int:
        """The stable ones of a set that holds all markings that are reached; refutes another set."""
        net, sets = self.net, self.sets
        marked = [self.at[p] for p in certcheck.indices(net.initial)]
        levels = [level for level, so in marked if so]
        certcheck.need(sets.has(self.reached, levels), "the initial marking is not in the set")
        allowed, stable = self.split(self.reached, sets)
        for t in range(len(net.name)):
            here = stable if net.event[t] else allowed[net.rank[t]]
            for place in (
                certcheck.indices(net.produce[t] & ~net.consume[t]) if self.cube[t] is not None else ()
            ):
                cube = self.literals(net.pre[t] | 1 << place)
                fine = cube is None or not sets.some(here, cube)
                certcheck.need(fine, f"safe: {net.name[t]} puts a second token in a place")
        return self.closed(self.reached, self.reached, net.events, net.internal, "reached")

    @cached_property
    def terminating(self) -> bool:
        """That internal runs end: refutes weights that do not fall, and layers that are not left."""
        assert self.stable is not None, "it is known what is reached"
        net, document = self.net, self.document
        weights, again = document["weights"], set(document["again"])
        certcheck.need(len(weights) == len(net.names), "expected a weight for each place")
        for t in net.internal:
            lost, gained = (
                sum(weights[p] for p in certcheck.indices(side[t])) for side in (net.consume, net.produce)
            )
            certcheck.need(t in again or gained < lost, f"{net.name[t]} does not lower the weight")
        layers = [self.root(number) for number in document["layers"]]
        others = [t for t in net.internal if t not in again]
        for i, layer in enumerate(layers):
            allowed, _ = self.split(layer, self.sets)
            below = layers[i - 1] if i else 0
            for t in net.internal:
                if (word := self.word[t]) is not None:
                    into = layer if t in others else below
                    fine = self.sets.leads(allowed[net.rank[t]], into, word)
                    certcheck.need(fine, f"{net.name[t]} leads out of layer {i}")
        fine = self.sets.within(self.reached, layers[-1]) if layers else not again & set(net.internal)
        certcheck.need(fine, "a marking is in no layer")
        return True

    @cached_property
    def confluent(self) -> bool:
        """That all internal runs from a marking end alike: refutes pairs that do not show it."""
        certcheck.need(self.terminating, "internal runs end")
        number, pairs = self.document["ends"], self.pairs
        fine = 0 <= number < len(self.pair_roots)
        certcheck.need(fine, f"diagrams.json: {number} is no node", certcheck.Malformed)
        ends = self.pair_roots[number]
        fine = self.sets.within(self.reached, pairs.firsts(ends, self.sets, {}, {}))
        certcheck.need(fine, "confluent: a marking has no end")
        allowed, stable = self.split(ends, pairs, 2)
        certcheck.need(pairs.equals(stable, {}), "confluent: a stable marking has another end than itself")
        for t in self.net.internal:
            if (word := self.word[t]) is not None:
                of_pairs = [(2 * level, before, after) for level, before, after in word]
                fine = pairs.leads(allowed[self.net.rank[t]], ends, of_pairs)
                certcheck.need(fine, f"confluent: {self.net.name[t]} changes the end")
        return True

    @cached_property
    def begun(self) -> int:
        """Stable markings that are reached before the mission starts: all by firings that leave its place."""
        net, sets = self.net, self.sets
        begin = sum(places for (role, _), places in net.roles.items() if role == "begin")
        staying = [t for t in range(len(net.name)) if self.word[t] and not net.consume[t] & begin]
        marked = [self.at[p] for p in certcheck.indices(net.initial)]
        first = 1
        for level in sorted((level for level, so in marked if so), reverse=True):
            first = sets.node(level, 0, first)
        found, before = self.ended_runs(first, staying), 0
        while found != before:
            before = found
            for t in staying:
                if net.event[t] and (after := sets.minus(sets.image(found, self.word[t] or []), found)):
                    found = sets.union(found, self.ended_runs(after, staying), {})
        return sets.minus(found, self.minus(found, ["begin"]))

    def ended_runs(self, states: int, transitions: list[int]) -> int:
        """The stable markings to which some of the internal transitions lead."""
        net, sets = self.net, self.sets
        while True:
            allowed, stable = self.split(states, sets)
            after = states
            for t in transitions if stable != states else ():
                if not net.event[t]:
                    fired = sets.image(allowed[net.rank[t]], self.word[t] or [])
                    after = sets.union(after, fired, {})
            if after == states:
                return stable
            states = after

    def layered(self, layers: list[int], goal: list[str], events: Iterable[int]) -> None:
        """Refutes layers from which not always a goal is marked, or some event leads one layer down."""
        certcheck.need(self.terminating, "internal runs end")
        for i, layer in enumerate(layers):
            left = self.minus(self.closed(layer, layer, (), self.net.internal, f"layer {i}"), goal)
            if i:
                left = self.sets.minus(left, layers[i - 1])
                for t in events:
                    if (word := self.word[t]) is not None:
                        left = self.sets.escaping(left, layers[i - 1], word)
            certcheck.need(not left, f"layer {i}: a state leads to none of the layer below")

    def run(self, run: list[int]) -> int:
        """The stable marking to which a run leads, with internal firings in some order that is permitted."""
        marking = self.settled(self.net.initial)
        for t in run:
            fine = t in self.net.events and not self.net.pre[t] & ~marking
            certcheck.need(fine, f"the run cannot fire transition {t}")
            marking = self.settled(self.net.fired(marking, t))
        return marking

    def settled(self, marking: int) -> int:
        """The stable marking to which internal firings lead in some order that is permitted."""
        net = self.net
        for _ in range(LONGEST):
            covered = [t for t in net.internal if not net.pre[t] & ~marking]
            if not covered:
                return marking
            marking = net.fired(marking, min(covered, key=lambda t: net.rank[t]))
        raise certcheck.Limit(f"more than {LONGEST} internal firings after an event")

    def says(self, marking: int, *roles: str) -> bool:
        """Whether a marking marks a place with one of some roles."""
        return any(marking & places for (role, _), places in self.net.roles.items() if role in roles)

    def stuck(self, stable: int) -> int:
        """The stable markings in which no event may fire, and that are no end."""
        for t in self.net.events:
            cube = self.cube[t]
            stable = stable if cube is None else self.sets.without(stable, cube)
        return self.minus(stable, ENDS)


def judge(of: CertifiedSets, claim: Json) -> None:
    """Refutes a claim that its evidence does not prove."""
    kind, holds = claim["kind"], claim["holds"]
    if kind == "cut_sets":
        cut_sets(of, claim)
        return
    known = certcheck.ENDS.keys()
    certcheck.need(kind in known, f"diagrams.json: kind {kind[:60]!r}", certcheck.Malformed)
    certcheck.part(claim, "statement")
    given, goal = shown(of, claim), certcheck.ENDS[kind]
    certcheck.need(of.stable is not None, "it is known what is reached")
    if kind in ("safe", "confluent"):
        certcheck.need(holds and (kind == "safe" or of.confluent), "that it fails is never certified")
    elif kind == "can_always_go_on" and holds:
        certcheck.need(not of.stuck(of.stable), "some state is stuck")
    elif kind == "can_always_go_on":
        marking = of.run(given["run"])
        fine = not of.says(marking, *ENDS) and all(of.net.pre[t] & ~marking for t in of.net.events)
        certcheck.need(fine, "the run does not lead to where nothing happens")
    elif kind.startswith("can_always"):
        always_ends(of, given, goal, holds=holds)
    elif holds:
        certcheck.need(of.says(of.run(given["run"]), *goal), "the run leads to no such end")
    else:
        certcheck.need(of.minus(of.stable, goal) == of.stable, "a state is such an end")


def shown(of: CertifiedSets, claim: Json) -> Json:
    """The evidence of a claim, sets for their numbers; malformed unless it is what the kind asks for."""
    kind, holds, shape = claim["kind"], claim["holds"], dict[str, Json]()
    if kind == "cut_sets":
        shape = {"closed": [int], "layers": [int]}
    elif kind.startswith("can_always_end"):
        shape = {"layers": [int]} if holds else {"run": [int], "closed": int}
    elif kind.startswith("can") and holds is not (kind == "can_always_go_on"):
        shape = {"run": [int]}
    given = {**certcheck.part(claim, "evidence", **shape)}
    for key in given.keys() - {"run"}:
        numbers = given[key]
        given[key] = of.root(numbers) if isinstance(numbers, int) else [of.root(each) for each in numbers]
    return given


def always_ends(of: CertifiedSets, given: Json, goal: list[str], *, holds: bool) -> None:
    """From each marking an end can be reached, layer by layer; or from one, after a run, none can."""
    if not holds:
        marking, closed = of.run(given["run"]), given["closed"]
        levels = [level for p in certcheck.indices(marking) for level, so in [of.at[p]] if so]
        certcheck.need(of.sets.has(closed, levels), "the run does not lead into the closed set")
        of.closed(closed, closed, of.net.events, of.net.internal, "closed")
        certcheck.need(of.minus(closed, goal) == closed, "an end is in the closed set")
        return
    layers = given["layers"]
    of.layered(layers, goal, of.net.events)
    certcheck.need(layers and of.sets.within(of.reached, layers[-1]), "a marking is in no layer")


def cut_sets(of: CertifiedSets, claim: Json) -> None:
    """Each set is a cut, by a closed set; what is less is survived, by layers; no other is minimal."""
    said = certcheck.part(claim, "statement", ends=[str], hardware=[str], cuts=[[str]])
    given = shown(of, claim)
    closed, layers = given["closed"], given["layers"]
    certcheck.need(claim["holds"], "that it fails is never certified")
    certcheck.need(of.stable is not None, "it is known what is reached")
    net, names, sets, goal = of.net, said["hardware"], of.sets, said["ends"]
    out = {element: places for (role, element), places in net.roles.items() if role == "oos"}
    certcheck.need(sorted(names) == sorted(out), f"expected the hardware {', '.join(sorted(out))}")
    marks = {name: [of.at[place] for place in certcheck.indices(out[name])] for name in names}
    fine = len({level for every in marks.values() for level, _ in every}) == len(names)
    certcheck.need(fine and all(len(every) == 1 for every in marks.values()), "hardware shares places")
    names = sorted(names, key=lambda name: marks[name])
    literals = [marks[name][0] for name in names]
    before = sets.minus(of.stable, of.minus(of.stable, ["begin"]))
    certcheck.need(len(closed) == len(said["cuts"]), "expected a closed set for each cut")
    for cut, into in zip(said["cuts"], closed, strict=True):
        fine = set(cut) <= set(names) and len(set(cut)) == len(cut)
        certcheck.need(fine, f"{cut} is no set of hardware")
        cube = sorted(marks[name][0] for name in cut)
        lost = sets.minus(before, sets.without(before, cube)) if cube else before
        certcheck.need(sets.within(lost, into), f"{cut}: a start is not in its closed set")
        may = set(net.events) - net.carrying("repaired", *cut, None)
        of.closed(into, into, may, net.internal, f"{cut}")
        certcheck.need(of.minus(into, goal) == into, f"{cut}: an end is in its closed set")
    of.layered(layers, goal, set(net.events) - net.carrying("repaired"))
    top, lost_sets = layers[-1] if layers else 0, Families(len(names), sets.most, sets.until)
    starts = sets.minus(of.begun, sets.minus(of.begun, top))
    survived = lost_sets.parts(sets.onto(starts, literals, lost_sets, {}, {}), {}, {})
    cuts = [{names.index(name) for name in cut} for cut in said["cuts"]]
    for number in cuts:
        fine = all(lost_sets.has(survived, number - {each}) for each in number)
        certcheck.need(fine, "less an element a cut is not survived")
    doubt = unknown(lost_sets, survived, cuts)
    certcheck.need(not doubt, f"{doubt} sets are neither cut nor survived")


def checked(path: str, *, most: int = 5_000_000, seconds: float = 600) -> certcheck.Report:
    """Checks the claims by diagrams of a certificate; raises Malformed and Limit as certcheck does."""
    until, entries = time.monotonic() + seconds, certcheck.unpacked(path)
    net = certcheck.Net(certcheck.parsed(entries, "net.json"))
    document = certcheck.parsed(entries, "diagrams.json")
    claims = certcheck.claims_in(document, "diagrams.json", DIAGRAMS)
    sets = cache(lambda: CertifiedSets(net, document, most, until))
    deepest = sys.getrecursionlimit()
    sys.setrecursionlimit(max(deepest, 20 * len(net.names) + 1000))
    try:
        return certcheck.each(lambda claim: judge(sets(), claim), claims)
    finally:
        sys.setrecursionlimit(deepest)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names."""
    words = "Checks claims by diagrams of a certificate."
    return certcheck.ran(checked, words, arguments, "certificate", limit="nodes")


if __name__ == "__main__":
    sys.exit(main())
