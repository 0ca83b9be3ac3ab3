"""certcheck: checks a certificate's claims on listed states: verdicts, formulas, cut sets; needs only Python.

``python certcheck.py OUT`` reads a certificate as docs/certificates.md describes it. It trusts the
certificate's net to be the mission's, and nothing else of mcpn: it lists the states itself, in every order of
internal firings. Exit code 0: every claim is proved. 1: the evidence of one does not prove it, which is
refuted. 2: something is not checked, since the file is malformed or a limit was hit; it is named.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
import zipfile
import zlib
from collections import Counter
from collections.abc import Callable, Container, Iterable, Iterator
from functools import cache, reduce
from operator import or_
from typing import Any, NoReturn

VERSION, MOST_BYTES, MOST_APART = 1, 1 << 26, 2_000  # bytes unpacked; places, to find those that are apart
Json = Any
State = int
ENTRIES = "net", "claims", "core", "further", "diagrams", "sections"


class Malformed(Exception):
    """The file is no certificate of this version."""


class Refuted(Exception):
    """The evidence of a claim does not prove it."""


class Limit(Exception):
    """A limit was hit, so that something is not checked."""


def need(holds: object, why: str, error: type[Exception] = Refuted) -> None:
    """Refutes the claim under way, or raises another error, unless something holds."""
    if not holds:
        raise error(why)


PLACE = {"name": str, "initial": int, "roles": [[str]]}
TRANSITION = {"name": str, "event": [str], "rank": int, "consume": [int], "produce": [int], "read": [int]}
FORMAT = {"format": "mcpn-certificate", "version": VERSION}
NET = {**FORMAT, "places": [PLACE], "transitions": [TRANSITION]}
CLAIM = {"key": str, "kind": str, "subject": [str], "holds": bool, "sentence": str}
CLAIM |= {"statement": dict, "evidence": dict}
TRUSTED = dict.fromkeys(("key", "sentence", "why"), str)
CLAIMS = {**FORMAT, "mission": str, "claims": [CLAIM], "trusted": [TRUSTED]}
HOW: dict[type[Exception], str] = {Refuted: "refuted", Limit: "not checked"}
TYPES: dict[Json, str] = {str: "a text", int: "a number", bool: "true or false", dict: "an object"}


def shaped(value: Json, shape: Json, where: str) -> Json:
    """The value, if it has a shape: a type, a constant, a list or an object of shapes."""
    expected = ""
    if isinstance(shape, list):
        expected = "" if isinstance(value, list) else "a list"
        for number, item in enumerate(() if expected else value):
            shaped(item, shape[0], f"{where}[{number}]")
    elif isinstance(shape, dict):
        alike = isinstance(value, dict) and set(value) == set(shape)
        expected = "" if alike else f"an object with {', '.join(shape) or 'no key'}"
        for key, inside in () if expected else shape.items():
            shaped(value[key], inside, f"{where}.{key}")
    elif type(value) is not shape if isinstance(shape, type) else repr(value) != repr(shape):
        expected = TYPES.get(shape, repr(shape))
    if expected:
        raise Malformed(f"{where}: found {json.dumps(value)[:60]}, expected {expected}")
    return value


def unpacked(path: str) -> dict[str, bytes]:
    """The entries of the certificate, by name; together no more than :data:`MOST_BYTES`."""
    entries, left = dict[str, bytes](), MOST_BYTES
    try:
        with zipfile.ZipFile(path) as archive:
            for info in archive.infolist():
                fine = info.filename in {f"{each}.json" for each in ENTRIES} - entries.keys()
                need(fine, f"the entry {info.filename[:60]!r} is not expected, or there twice", Malformed)
                need(info.compress_type in (0, 8), f"{info.filename}: neither stored nor deflated", Malformed)
                with archive.open(info) as stream:
                    entries[info.filename] = stream.read(left + 1)
                left -= len(entries[info.filename])
                need(left >= 0, f"its entries are of more than {MOST_BYTES} bytes", Limit)
    except (OSError, zipfile.BadZipFile, zlib.error, EOFError, RuntimeError, ValueError) as error:
        raise Malformed(f"is no zip that can be read: {error}") from error
    return entries


def parsed(entries: dict[str, bytes], name: str, fraction: Json = None) -> Json:
    """An entry of JSON, without fractions (unless they are read), long numbers, keys that are there twice."""

    def refused(text: str) -> NoReturn:
        raise Malformed(f"{name}: found the number {text[:20]}, expected a whole one of at most 18 digits")

    def members(pairs: list[tuple[str, Json]]) -> dict[str, Json]:
        need(len(dict(pairs)) == len(pairs), f"{name}: a key is there twice in an object", Malformed)
        return dict(pairs)

    need(name in entries, f"there is no entry {name}", Malformed)
    try:
        hooks: Json = {"parse_float": fraction or refused, "parse_constant": refused}
        hooks["parse_int"] = lambda text: int(text) if len(text) <= 18 else refused(text)
        return json.loads(entries[name].decode(), object_pairs_hook=members, **hooks)
    except (ValueError, RecursionError) as error:
        raise Malformed(f"{name}: no JSON: {error}") from error


def indices(mask: int) -> Iterator[int]:
    """The numbers of the bits of a mask."""
    while mask:
        low = mask & -mask
        yield low.bit_length() - 1
        mask ^= low


def grown(start: Iterable[Any], on: Callable[[Any], Iterable[Any]], along: Json = None) -> set[Any]:
    """What some lead to, one after the other, and they themselves; along some where these are given."""
    found = set(start)
    todo = list(found)
    while todo:
        new = [n for n in on(todo.pop()) if n not in found and (along is None or n in along)]
        found.update(new)
        todo += new
    return found


class Net:
    """The net: a marking is an integer, whose bit p says that place p holds a token."""

    def __init__(self, document: Json) -> None:
        shaped(document, NET, "net.json")
        places, transitions = document["places"], document["transitions"]
        self.names = [place["name"] for place in places]
        self.initial, self.roles = 0, dict[tuple[str, ...], int]()
        for number, place in enumerate(places):
            why = f"net.json: place {number} has {place['initial']} tokens, expected 0 or 1"
            need(place["initial"] in (0, 1), why, Malformed)
            self.initial |= place["initial"] << number
            for role in place["roles"]:
                need(len(role) == 2, f"net.json: the role {role} of a place, expected two texts", Malformed)
                self.roles[tuple(role)] = self.roles.get(tuple(role), 0) | 1 << number
        self.name = [each["name"] for each in transitions]
        fine = all(len(set(names)) == len(names) for names in (self.names, self.name))
        need(fine, "net.json: two places or transitions have one name", Malformed)
        self.event = [tuple(each["event"]) for each in transitions]
        self.rank = [each["rank"] for each in transitions]
        self.consume, self.produce, read = (
            [self.mask(each[side], f"transition {each['name']}") for each in transitions]
            for side in ("consume", "produce", "read")
        )
        self.pre = [consume | reads for consume, reads in zip(self.consume, read, strict=True)]
        self.events = [t for t, event in enumerate(self.event) if event]
        self.internal = [t for t, event in enumerate(self.event) if not event]
        for t, event in enumerate(self.event):
            well = 2 <= len(event) <= 3 and not self.rank[t] if event else self.pre[t]
            need(well, f"net.json: transition {self.name[t]}: its event, rank or tokens", Malformed)
        needing = dict[int, list[int]]()
        for t in self.internal:
            for place in indices(self.pre[t]):
                needing.setdefault(place, []).append(t)
        self.wakes = [sorted({u for p in indices(made) for u in needing.get(p, ())}) for made in self.produce]
        self.seen, sides = 0, zip(self.wakes, self.pre, self.produce, strict=True)
        self.looks = [reduce(or_, (self.pre[u] for u in wakes), pre | made) for wakes, pre, made in sides]
        self.apart, self.alone = self.exclusions(), cache(self.first)

    def mask(self, places: list[int], of: str) -> int:
        """Places as bits, each once."""
        fine = all(0 <= place < len(self.names) for place in places) and len(set(places)) == len(places)
        need(fine, f"net.json: {of} names a place that there is not, or one twice", Malformed)
        return sum(1 << place for place in places)

    def fired(self, marking: int, t: int) -> int:
        """The marking after a firing, which must leave at most one token in each place."""
        left, self.seen = marking & ~self.consume[t], self.seen | self.looks[t]
        need(not left & self.produce[t], f"safe: {self.name[t]} puts a second token in a place")
        return left | self.produce[t]

    def exclusions(self) -> list[int]:
        """Of each place those that are never marked with it: no firing puts both, or one beside the other."""
        size, before = len(self.names), list[int]()
        every = (1 << size) - 1 if size <= MOST_APART else 0
        apart = [every & ~self.initial if self.initial >> p & 1 else every for p in range(size)]
        while before != apart:
            before = list(apart)
            for t, needed in enumerate(self.pre):
                never = reduce(or_, (apart[p] for p in indices(needed)), 0)
                if not never & needed:
                    beside = every & ~never & ~self.consume[t] | self.produce[t]
                    for p in indices(self.produce[t]):
                        for q in indices(apart[p] & beside):
                            apart[q] &= ~(1 << p)
                        apart[p] &= ~beside
        return apart

    def first(self, t: int) -> bool:
        """Whether it may fire first wherever it may fire: none that may be covered with it is in its way."""
        takes, never = self.consume[t], reduce(or_, (self.apart[p] for p in indices(self.pre[t])))
        return all(self.rank[u] >= self.rank[t] for u in self.wakes[t]) and not any(
            self.consume[u] & self.pre[t] or (self.pre[u] | self.produce[u]) & takes
            for u in self.internal
            if not self.pre[u] & never and (self.consume[u], self.produce[u]) != (takes, self.produce[t])
        )

    def carrying(self, what: str, *of: str | None) -> set[int]:
        """The transitions of an event, of one of some elements (None is no element), or else of any."""
        return {t for t in self.events if self.event[t][0] == what and (not of or self.event[t][1] in of)}


class Listing:
    """All stable markings, in the order in which a breadth-first search finds them, with their edges."""

    def __init__(self, net: Net, most: int, until: float) -> None:
        self.net, self.most, self.until = net, most, until
        self.number = dict[int, State]()
        self.known: dict[int, dict[int, dict[int, int]]] = {t: {} for t in net.events}
        start = self.settled(net.initial, [t for t in net.internal if net.pre[t] & ~net.initial == 0])
        self.number[start], self.stable, self.edges = 0, [start], list[list[tuple[int, State]]]()
        self.firing, self.back = {t: dict[State, State]() for t in net.events}, [list[tuple[int, State]]()]
        for state, marking in enumerate(self.stable):  # grows while it is walked
            edges, lacking = list[tuple[int, State]](), ~marking
            for t in net.events:
                if not net.pre[t] & lacking:
                    end = self.behind(marking, t)
                    self.firing[t][state] = n = self.number.setdefault(end, len(self.stable))
                    self.stable += [end] * (n == len(self.stable))
                    self.back += [[]] * (n == len(self.back))
                    self.back[n].append((t, state))
                    edges.append((t, n))
            self.edges.append(edges)
            self.within()
        self.stuck = {state for state, edges in enumerate(self.edges) if not edges}
        self.marking = cache(lambda places: {s for s, m in enumerate(self.stable) if m & places})
        self.formulas = Formulas(self)

    def within(self, more: int = 0) -> None:
        """Gives up where a limit is hit."""
        kept = len(self.number) + more
        need(kept <= self.most, f"more than {self.most} markings to keep (--max-states)", Limit)
        need(time.monotonic() <= self.until, "the time is over (--seconds)", Limit)

    def behind(self, marking: int, t: int) -> int:
        """The end behind an event: what changes is alike where all is alike that firings looked at."""
        for seen, changed in self.known[t].items():
            if (end := changed.get(marking & seen)) is not None:
                return marking & ~seen | end
        self.net.seen = 0
        after = self.net.fired(marking, t)
        end = self.settled(after, self.covered(after, [], t))
        seen = self.net.seen
        self.known[t].setdefault(seen, {})[marking & seen] = end & seen
        return end

    def covered(self, marking: int, before: list[int], fired: int) -> list[int]:
        """The internal transitions whose tokens are there, after a firing; before it were some."""
        pre, lacking = self.net.pre, ~marking
        found = [u for u in before if not pre[u] & lacking] if before else before
        return found + [u for u in self.net.wakes[fired] if not pre[u] & lacking and u not in found]

    def settled(self, marking: int, covered: list[int]) -> int:
        """The stable marking in which every run of internal firings ends; refuted if there are several."""
        ends, way, rank = dict[int, Any](), [list[Any]((0, [(marking, covered)], None))], self.net.rank
        while True:  # on the way each marking has what is left of it, and the end that was found
            came_by, left, end = way[-1]
            if left:
                marking, covered = left.pop()
                if covered and marking not in ends:
                    ends[marking] = None
                    self.within(len(ends))
                    least = min(rank[t] for t in covered)
                    choices = [t for t in covered if rank[t] == least]
                    choices = next(([t] for t in choices if self.net.alone(t)), choices)
                    after = [(self.net.fired(marking, t), t) for t in choices]
                    way.append([marking, [(m, self.covered(m, covered, t)) for m, t in after], None])
                    continue
                end = ends[marking] if covered else marking
                need(end is not None, "confluent: internal firings come back to a marking, and need not end")
            else:
                way.pop()
                if not way:
                    return int(end)
                ends[came_by] = end
            need(way[-1][2] in (None, end), "confluent: internal firings lead to two stable markings")
            way[-1][2] = end

    def saying(self, role: str, *of: str | None) -> set[State]:
        """The states that mark a place with a role, of some elements (None is none), or else of any."""
        roles = self.net.roles.items()
        found = (own for (said, element), own in roles if said == role and (not of or element in of))
        return set(self.marking(reduce(or_, found, 0)))

    def ended(self, *ends: str) -> set[State]:
        """The states in which the mission has ended so."""
        return set[State]().union(*map(self.saying, ends))

    def walked(self, run: list[int], start: State = 0, without: Iterable[int] = ()) -> State:
        """Where a run leads: transitions of events, with internal firings between them."""
        state, banned = start, set(without)
        for t in run:
            state = next((n for u, n in self.edges[state] if u == t and u not in banned), -1)
            need(state >= 0, f"the run cannot fire transition {t} when it comes to it")
        return state

    def closure(self, start: Iterable[State], may: Container[int] | None = None) -> set[State]:
        """The states that some lead to, along some transitions where they are given."""
        return grown(start, lambda s: [n for t, n in self.edges[s] if may is None or t in may])


ARITY = {"not": 1, "EX": 1, "EG": 1, "EU": 2, "E": 1, "X": 1, "U": 2, "R": 2, "deadlock": 0}
Form = tuple[Any, ...]
Obligations = frozenset[Form]
# A way: in which states, by which transitions, whether without any, what is left, and what is put off.
Way = tuple[set[State], set[int], bool, Obligations, Obligations]


def on_states(form: Form) -> bool:
    """Whether a formula on paths speaks of their first states alone."""
    inside = form[1:] if form[0] in ("not", "and", "or") else ()
    return form[0] not in ("happens", "X", "U", "R") and all(map(on_states, inside))


class Formulas:
    """Which states of a listing satisfy formulas: nested lists, as the page describes them."""

    def __init__(self, graph: Listing) -> None:
        self.graph, self.all = graph, set(range(len(graph.stable)))
        self.states, self.ways = cache(self.satisfying), dict[Obligations, list[Way]]()
        self.solved: dict[Obligations, set[State]] = {frozenset(): self.all}

    def read(self, said: Json, paths: bool = False) -> Form:
        """A formula on states, or on paths, as tuples."""
        wrong = "claims.json: a formula"
        operator, *rest = shaped(said, list, wrong) or [""]
        shaped(operator, str, wrong)
        if operator in ("and", "or"):
            return operator, *(self.read(each, paths) for each in rest)
        if operator in ("fires", "happens") and (paths or operator == "fires"):
            return operator, *map(tuple, shaped(rest, [[str]], wrong))
        if operator == "says" and len(rest) == 2:
            return operator, *shaped(rest, [str], wrong)
        if operator == "at most" and len(rest) == 2:
            most, pairs = shaped(rest[0], int, wrong), shaped(rest[1], [[int]], wrong)
            if all(len(pair) == 2 and 0 <= pair[0] < len(self.graph.net.names) for pair in pairs):
                return operator, most, tuple(map(tuple, pairs))
        if len(rest) == ARITY.get(operator, -1) and (paths or operator not in ("X", "U", "R")):
            of_paths = operator == "E" or (paths and operator in ("not", "X", "U", "R"))
            read = (self.read(each, of_paths) for each in rest)
            if operator in ("EU", "EG"):
                return "E", ("U" if operator == "EU" else "R", *[("or",)] * (operator == "EG"), *read)
            return operator, *(map(self.normal, read) if operator == "E" else read)
        raise Malformed(f"{wrong}: found {json.dumps(said)[:60]}")

    def fired(self, literal: Form) -> set[int]:
        """The transitions that ``fires`` or ``happens`` names, or those that it does not if it is negated."""
        if literal[0] == "not":
            return set(self.graph.net.events) - self.fired(literal[1])
        return {t for t in self.graph.net.events if self.graph.net.event[t] in literal[1:]}

    def satisfying(self, form: Form) -> set[State]:
        """The states that satisfy a formula on states."""
        graph, (operator, *of) = self.graph, form
        match operator:
            case "says":
                return graph.saying(*of)
            case "at most":
                most, weights = of
                sums = (sum(weight for p, weight in weights if m >> p & 1) for m in graph.stable)
                return {s for s, total in enumerate(sums) if total <= most}
            case "fires":
                return set[State]().union(*(graph.firing[t] for t in self.fired((operator, *of))))
            case "deadlock":
                return graph.stuck
            case "not":
                return self.all - self.states(of[0])
            case "and":
                return self.all.intersection(*map(self.states, of))
            case "or":
                return set[State]().union(*map(self.states, of))
            case "EX":
                return {s for after in self.states(of[0]) for _, s in graph.back[after]}
            case _:
                return self.beginning(of[0])

    def at_first(self, form: Form) -> bool:
        """Whether the first state satisfies a formula on states."""
        match form:
            case ("not", inside):
                return not self.at_first(inside)
            case ("and" | "or" as operator, *each):
                return {"and": all, "or": any}[operator](map(self.at_first, each))
            case ("E", ("U", ("and",), goal)):  # all states are reachable
                return bool(self.beginning(goal))
        return 0 in self.states(form)

    def normal(self, form: Form, wanted: bool = True) -> Form:
        """A formula on paths with negations before formulas on states and steps alone."""
        dual = {"and": "or", "or": "and", "U": "R", "R": "U", "X": "X"}
        if form[0] == "not":
            return self.normal(form[1], not wanted)
        if form[0] in dual:
            return form[0] if wanted else dual[form[0]], *(self.normal(each, wanted) for each in form[1:])
        return form if wanted else ("not", form)

    def split(self, must: list[Form]) -> Iterator[Way]:
        """The ways to satisfy formulas."""
        self.graph.within()
        if not must:
            yield self.all, set(self.graph.net.events), True, frozenset(), frozenset()
            return
        form, *rest = must
        ways: list[tuple[list[Form], list[Form], list[Form]]] = [([], [], [])]  # now, next, put off
        of_step, of_state = "happens" in (form[0], form[0] == "not" and form[1][0]), on_states(form)
        match () if of_state or of_step else form:
            case ("and", *each):
                ways = [(each, [], [])]
            case ("or", *each):
                ways = [([one], [], []) for one in each]
            case ("X", after):
                ways = [([], [after], [])]
            case ("U", left, right):
                ways = [([right], [], []), ([left], [form], [form])]
            case ("R", left, right):
                ways = [([left, right], [], []), ([right], [form], [])]
        for now, after, late in ways:
            for here, may, rests, nexts, put_off in self.split([*now, *rest]):
                here = here & self.states(form) if of_state else here
                may, rests = (may & self.fired(form), rests and form[0] == "not") if of_step else (may, rests)
                yield here, may, rests, nexts | {*after}, put_off | {*late}

    def beginning(self, path: Form) -> set[State]:
        """The states from which a path begins that satisfies a formula on paths."""

        def leads(must: Obligations) -> set[Obligations]:
            if must not in self.ways:
                self.ways[must] = [way for way in self.split(list(must)) if way[0]]
            self.graph.within(len(self.ways))
            return {after for *_, after, _ in self.ways[must]} - self.solved.keys()

        first = frozenset([path])
        later = {must: grown([must], leads) for must in grown([first] * (first not in self.solved), leads)}
        for must in sorted(later, key=lambda each: len(later[each])):  # what others lead to comes first
            if must not in self.solved:
                self.solve([each for each in later[must] if must in later[each]])
        return self.solved[first]

    def solve(self, loop: list[Obligations]) -> None:
        """Finds the states that satisfy obligations which lead to each other; others are solved before."""
        # A node, as one number, is a state with what the path from there must satisfy.
        graph, size, number = self.graph, len(self.graph.stable), {must: n for n, must in enumerate(loop)}
        satisfied, into = set[int](), [list[Any]() for _ in loop]
        for must, n in number.items():
            for here, may, rests, after, late in self.ways[must]:
                if after in number:
                    into[number[after]].append((n * size, here, may, rests, late))
                else:
                    goal, found = self.solved[after], here
                    if after or not rests or len(may) < len(graph.firing):  # else each step will do
                        found = {s for t in may for s, to in graph.firing[t].items() if to in goal}
                        found = here & (found | (graph.stuck & goal if rests else set()))
                    satisfied |= {n * size + s for s in found}

        def before(node: int, put_off: Form | None = None) -> Iterator[int]:
            """The nodes with a step to one within the loop, on which an until is not put off."""
            n, state = divmod(node, size)
            for at, here, may, rests, late in into[n]:
                if put_off not in late:
                    yield from [at + s for t, s in graph.back[state] if s in here and t in may]
                    if rests and state in graph.stuck and state in here:
                        yield at + state

        satisfied = grown(satisfied, before)
        ways = [(at, here, late) for each in into for at, here, _, _, late in each]
        if ways and not frozenset.intersection(*(late for *_, late in ways)):
            alive = {at + s for at, here, _ in ways for s in here} - satisfied
            untils, last = {until for *_, late in ways for until in late}, -1
            while len(alive) != last:  # where a path goes on, and each until is not put off for ever
                last, onward = len(alive), Counter(node for after in alive for node in before(after))
                todo = [node for node in alive if not onward[node]]
                for gone in todo:  # grows while it is walked
                    onward.subtract(before(gone))
                    todo += [node for node in {*before(gone)} if node in alive and not onward[node]]
                alive.difference_update(todo)
                for until in untils:
                    found = {node for after in alive for node in before(after, until)}
                    alive = grown(alive & found, before, alive)
                graph.within(len(alive))
            satisfied = grown(satisfied | alive, before)
        for must, n in number.items():
            self.solved[must] = {node - n * size for node in satisfied if node // size == n}


# By kind of claim that a run or numbers prove: the ends of which it speaks.
ENDS = {"safe": [], "confluent": [], "can_succeed": ["success"], "can_fail": ["failure"]}
ENDS |= {"can_be_aborted": ["abort"], "can_always_end_safely": ["success", "abort"]}
ENDS |= {kind: ["success", "failure", "abort"] for kind in ("can_always_go_on", "can_always_end")}


def part(claim: Json, which: str, **shape: Json) -> Json:
    """What a claim states, or its evidence, if it has the shape that its kind asks for."""
    return shaped(claim[which], shape, f"claims.json: {claim['key']}: {which}")


def judge(graph: Listing, claim: Json) -> None:
    """Refutes a claim that its evidence does not prove."""
    graph.within()
    kind, holds = claim["kind"], claim["holds"]
    if kind not in ENDS:
        {"nominal_success": nominal, "cut_sets": cut_sets}.get(kind, formula)(graph, claim)
        return
    part(claim, "statement")
    goal, always, last = graph.ended(*ENDS[kind]), kind.startswith("can_always"), 0
    if always != holds and ENDS[kind]:
        last = graph.walked(part(claim, "evidence", run=[int])["run"])
    elif kind not in ("can_always_end", "can_always_end_safely"):
        part(claim, "evidence")
    if not ENDS[kind]:
        need(holds, "the states can be listed")
    elif not always:
        need(last in goal if holds else not goal, "the run leads to no such end, or a state is one")
    elif kind == "can_always_go_on":
        stuck = graph.stuck - goal
        need(not stuck if holds else last in stuck, "a state is stuck, or the run leads to none that is")
    elif holds:
        numbers = numbered(graph, claim)
        for s in graph.formulas.all - goal:
            falls = any(0 <= numbers[after] < numbers[s] for _, after in graph.edges[s])
            need(falls, f"the number of state {s} falls along no edge")
    else:
        need(not graph.closure([last]) & goal, "an end can be reached after the run")


def numbered(graph: Listing, claim: Json) -> list[int]:
    """The numbers of the states that a claim gives."""
    numbers: list[int] = part(claim, "evidence", numbers=[int])["numbers"]
    need(len(numbers) == len(graph.stable), f"{len(numbers)} numbers of {len(graph.stable)} states")
    return numbers


def nominal(graph: Listing, claim: Json) -> None:
    """Runs of successes end, in success alone, and enter all that is meant to be entered."""
    net, said = graph.net, part(claim, "statement", fails=[str], endless=[str], meant=[str], repaired=[str])
    numbers = numbered(graph, claim)
    need(claim["holds"], "that it fails is never certified")
    onward = net.carrying("start") | net.carrying("success") | net.carrying("failure", *said["fails"], None)
    onward -= net.carrying("success", *said["fails"], None)
    begin = graph.closure([0], net.carrying("repaired", *said["repaired"], None))
    begin -= graph.saying("oos", *said["repaired"], None)
    need(begin, "what is out of service at first cannot come back")
    reached, success = graph.closure(begin, onward), graph.ended("success")
    free = success | graph.saying("objective", *said["endless"], None)
    for state in reached - success:
        after = [n for t, n in graph.edges[state] if t in onward]
        need(after, f"a nominal run ends in state {state}, which is no success")
        falls = state in free or all(n in free or numbers[n] < numbers[state] for n in after)
        need(falls, f"the number of state {state} does not fall along each nominal edge")
    need(all(number >= 0 for number in numbers), "a number is below 0")
    for name in said["meant"]:
        need(graph.saying("objective", name) & reached, f"no nominal run enters {name}")


def formula(graph: Listing, claim: Json) -> None:
    """A formula is true in the first state, or is not."""
    form = graph.formulas.read(part(claim, "statement", text=str, formula=list)["formula"])
    part(claim, "evidence")
    need(graph.formulas.at_first(form) == claim["holds"], f"the formula is {not claim['holds']}".lower())


def cut_sets(graph: Listing, claim: Json) -> None:
    """Each set is a cut; with one element less each is survived; no other set is minimal."""
    said = part(claim, "statement", ends=[str], hardware=[str], cuts=[[str]])
    runs = part(claim, "evidence", survived=[{"lost": [str], "by": int, "run": [int]}])["survived"]
    need(claim["holds"], "that it fails is never certified")
    names, goal = said["hardware"], graph.ended(*said["ends"])
    can_fail = sorted(of for role, of in graph.net.roles if role == "oos")
    need(sorted(names) == can_fail, f"expected the hardware {', '.join(can_fail)}")
    bit = {name: 1 << number for number, name in enumerate(names)}

    def mask(lost: list[str]) -> int:
        need(set(lost) <= set(names) and len(set(lost)) == len(lost), f"{lost} is no set of hardware")
        return sum(bit[name] for name in lost)

    def started(lost: list[str]) -> set[State]:
        """The states before the start in which all of it is out of service."""
        return graph.saying("begin").intersection(*(graph.saying("oos", name) for name in lost))

    cuts, survived = [mask(lost) for lost in said["cuts"]], [mask(each["lost"]) for each in runs]
    for lost in said["cuts"]:
        may = set(graph.net.events) - graph.net.carrying("repaired", *lost, None)
        need(not graph.closure(started(lost), may) & goal, f"{lost} is survived")
        graph.within()
    for each in runs:
        first, banned = each["run"][: max(each["by"], 0)], graph.net.carrying("repaired", *each["lost"], None)
        start = graph.walked(first)
        need(start in started(each["lost"]), f"{each['lost']} is not lost before the start")
        end = graph.walked(each["run"][len(first) :], start, banned)
        need(end in goal, f"{each['lost']}: the run leads to no such end")
        graph.within()
    for cut in cuts:
        need(not any(other != cut and other & cut == other for other in cuts), "a cut holds another")
        for i in indices(cut):
            need(any(not cut & ~(1 << i) & ~one for one in survived), "less an element a cut is not survived")
    whole, size = (1 << len(names)) - 1, len(names)
    doubt = whole + 1 - above(frozenset(cuts), size)
    doubt -= above(frozenset(whole & ~one for one in survived), size)
    need(not doubt, f"{doubt} sets are neither cut nor survived")


@cache
def above(family: frozenset[int], size: int) -> int:
    """How many sets of some elements hold a member of a family."""
    if not family or 0 in family:
        return len(family) and 1 << size
    last = 1 << size - 1
    without = frozenset(each for each in family if not each & last)
    return above(without, size - 1) + above(frozenset(each & ~last for each in family), size - 1)


Report = list[tuple[str, str, str]]  # of each claim: proved, refuted or not checked; its key; why


def read(path: str) -> tuple[dict[str, bytes], Net, list[Json]]:
    """The entries of a certificate, its net, and its claims; raises Malformed and Limit."""
    entries = unpacked(path)
    net = Net(parsed(entries, "net.json"))
    return entries, net, claims_in(parsed(entries, "claims.json"), "claims.json", CLAIMS)


def claims_in(document: Json, name: str, shape: Json) -> list[Json]:
    """The claims of an entry of some shape, no two with one key."""
    claims: list[Json] = shaped(document, shape, name)["claims"]
    keys = {claim["key"] for claim in claims}
    need(len(keys) == len(claims), f"{name}: two claims have one key", Malformed)
    return claims


def each(judges: Callable[[Json], None], claims: Iterable[Json]) -> Report:
    """What becomes of each claim, by what judges it."""
    report = Report()
    for claim in claims:
        try:
            judges(claim)
            report.append(("proved", claim["key"], claim["sentence"]))
        except (Refuted, Limit) as error:
            report.append((HOW[type(error)], claim["key"], str(error)))
    return report


def judged(listing: Callable[[], Listing], claims: list[Json]) -> Report:
    """What becomes of claims on states that are listed."""
    try:
        graph = listing()
    except (Refuted, Limit) as error:
        how = {str(error).partition(":")[0]: HOW[type(error)]}  # safe or confluent; others are open
        return [(how.get(claim["kind"], "not checked"), claim["key"], str(error)) for claim in claims]
    return each(lambda claim: judge(graph, claim), claims)


def checked(path: str, *, most: int = 2_000_000, seconds: float = 600) -> Report:
    """Checks a certificate, in some time, keeping some markings at most; raises Malformed and Limit."""
    until, (_, net, claims) = time.monotonic() + seconds, read(path)
    return judged(lambda: Listing(net, most, until), claims)


def ran(checker: Callable[..., Report], words: str, said: Json, *files: str, limit: str = "states") -> int:
    """Has a checker check what the command line names, and prints what becomes of each claim."""
    parser = argparse.ArgumentParser(description=words, argument_default=argparse.SUPPRESS)
    for file in files:
        parser.add_argument(file)
    parser.add_argument(f"--max-{limit}", dest="most", type=int, help=f"{limit} to keep at most")
    parser.add_argument("--seconds", type=float, help="time after which to give up")
    asked = vars(parser.parse_args(said))
    paths = [asked.pop(file) for file in files]
    try:
        report = checker(*paths, **asked)
    except (Malformed, Limit, RecursionError, MemoryError) as error:
        report = [("not checked", paths[0], str(error) or "there is not enough memory")]
    for how, key, why in report:  # of any text, without control characters
        line = f"{how:11}  {key}: {why}".encode("ascii", "backslashreplace").decode()
        sys.stdout.write(line.translate(dict.fromkeys(range(32), "?")) + "\n")
    found = {how for how, _, _ in report}
    return 1 if "refuted" in found else 0 if found == {"proved"} else 2


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names."""
    return ran(checked, "Checks a certificate that mcpn has written.", arguments, "certificate")


if __name__ == "__main__":
    sys.exit(main())
