"""furthercheck: checks a certificate's claims on cut sets at every moment, and on how probable the ends are.

``python furthercheck.py CERTIFICATE`` needs ``certcheck.py`` beside it and nothing else of mcpn. It lists the
states as that does and judges the claims of the entry ``further.json``, which the page docs/certificates.md
describes. Exit codes are those of ``certcheck``.
"""

from __future__ import annotations

import re
import sys
import time
from collections.abc import Callable, Container, Iterable
from fractions import Fraction
from math import lcm
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
except ImportError:  # alone, beside the other file
    import certcheck  # type: ignore[import-not-found, no-redef]

Json = Any
State = int
FURTHER = {**certcheck.FORMAT, "claims": [certcheck.CLAIM]}
GOAL = {"ends": [str], "objective": str}
STOPPED = [{"objective": str, "transitions": [int]}]
CUTS = {"goal": GOAL, "hardware": [str], "cuts": [[str]], "stopped": STOPPED}
SURVIVED = {"survived": [{"lost": [str], "by": int, "run": [int]}]}
HARDWARE = {"name": str, "fails": [str], "repaired": [str]}
OBJECTIVE = {"name": str, "duration": str, "failures": [[str]]}
EVENT = {"event": [str], "rate": [str]}
CHANCE = {"end": str, "low": str, "high": str, "hardware": [HARDWARE], "objectives": [OBJECTIVE]}
CHANCE |= {"events": [EVENT], "stopped": STOPPED}
UNIT = 10**17
"""What the numbers of a vector are parts of."""
DECIMAL = re.compile(r"[0-9]{1,40}(\.[0-9]{1,40})?", re.ASCII)


class LabelledStates:
    """The listed states, with their edges in both directions."""

    def __init__(self, listing: certcheck.Listing) -> None:
        self.listing, self.net, self.edges = listing, listing.net, listing.edges
        self.all = set(range(len(self.edges)))
        self.into: list[list[tuple[int, State]]] = [[] for _ in self.edges]
        for state, edges in enumerate(self.edges):
            for t, after in edges:
                self.into[after].append((t, state))
        self.forced = dict[str, Forced]()
        elements = (of for role, of in self.net.roles if role == "oos")
        self.out = {of: listing.saying("oos", of) for of in sorted(elements)}

    def ending(self, objective: str) -> set[int]:
        """The transitions with which an objective ends by itself."""
        return set[int]().union(
            *(self.net.carrying(what, objective) for what in ("success", "failure", "timeout"))
        )

    def onward(self, start: Iterable[State], within: set[State], without: Container[int]) -> set[State]:
        """The states that some lead to through some, without some transitions."""
        self.listing.within()
        along = self.edges
        return certcheck.grown(start, lambda s: [n for t, n in along[s] if t not in without], within)

    def leading(self, goal: Iterable[State], within: set[State], without: Container[int]) -> set[State]:
        """The states that lead to some through some, without some transitions."""
        self.listing.within()
        into = self.into
        return certcheck.grown(goal, lambda s: [n for t, n in into[s] if t not in without], within)


class CertifiedGoal(NamedTuple):
    """What may still be reached.

    Args:
        running: The states that a run to it passes.
        won: Those in which it is reached.
        over: Transitions that no run to it takes.
        open: The states in which it is not decided.
    """

    running: set[State]
    won: set[State]
    over: set[int]
    open: set[State]


def of_objective(graph: LabelledStates, name: str, stopped: dict[str, set[int]]) -> CertifiedGoal:
    """The success of an objective within its present run."""
    running = graph.listing.saying("objective", name)
    firing = (graph.listing.firing[t] for t in graph.net.carrying("success", name))
    won = running.intersection(set[State]().union(*firing))
    return CertifiedGoal(running, won, graph.ending(name) | stopped.get(name, set()), running)


def goal_of(graph: LabelledStates, said: Json, within: bool = True) -> CertifiedGoal:
    """Ends of the mission, or the success of an objective: within its present run, or of any."""
    ends, name = said["goal"]["ends"], said["goal"]["objective"]
    certcheck.need(bool(ends) != bool(name), "expected ends, or one objective")
    if ends:
        won = graph.listing.ended(*ends)
        return CertifiedGoal(graph.all, won, set(), graph.all - won)
    goal = of_objective(graph, name, stopping(graph, said["stopped"]))
    return goal if within else CertifiedGoal(graph.all, goal.won, set(), graph.all)


def stopping(graph: LabelledStates, said: Json) -> dict[str, set[int]]:
    """By objective the transitions that end its run and may begin it again at once, beside its own ends."""
    found = {each["objective"]: set(each["transitions"]) for each in said}
    certcheck.need(len(found) == len(said), "an objective is named twice")
    fine = set[int]().union(*found.values()) <= set(graph.net.events)
    certcheck.need(fine, "what stops an objective is no transition of an event")
    return found


def same_hardware(graph: LabelledStates, names: list[str]) -> dict[str, int]:
    """A bit for each name, if these are all elements that may be out of service."""
    certcheck.need(sorted(names) == sorted(graph.out), f"expected the hardware {', '.join(graph.out)}")
    return {name: 1 << number for number, name in enumerate(names)}


def masks(bit: dict[str, int], sets: Iterable[list[str]]) -> list[int]:
    """Sets of hardware as numbers."""
    found = list[int]()
    for lost in sets:
        fine = set(lost) <= bit.keys() and len(set(lost)) == len(lost)
        certcheck.need(fine, f"{lost} is no set of hardware")
        found.append(sum(bit[name] for name in lost))
    return found


def without_another(cuts: list[int]) -> None:
    """Refutes a list in which one set holds another."""
    for cut in cuts:
        holds = any(other != cut and other & cut == other for other in cuts)
        certcheck.need(not holds, "a cut holds another")


# Cut sets.


def entered(graph: LabelledStates, said: Json) -> set[State]:
    """The states just after an entry, and those that further losses lead to at once."""
    first = graph.listing.saying("objective", *said["entered"], None)
    first |= graph.listing.saying("pending", *said["entered"], None)
    inside = set[State]()
    for role in said["inside"]:
        certcheck.need(len(role) == 2, f"{role} is no role of an element")
        inside |= graph.listing.saying(*role)
    stopped = stopping(graph, said["stopped"])
    again = [of_objective(graph, name, stopped) for name in said["again"]]

    def ends(s: State, t: int, n: State) -> bool:
        return any(s in one.running and (t in one.over or n not in one.running) for one in again)

    start = {n for n in first if any(s not in inside or ends(s, t, n) for t, s in graph.into[n])}
    return graph.listing.closure(start, graph.net.carrying("out of service"))


def cut_sets(graph: LabelledStates, claim: Json) -> None:
    """Lost at one of some states, each set leaves no way; with one element less, some; others hold one."""
    shape, kind = dict[str, Json](CUTS), claim["kind"]
    if kind == "cut_sets_at_entry":
        shape |= {"entered": [str], "inside": [[str]], "again": [str]}
    said, runs = (
        certcheck.part(claim, "statement", **shape),
        certcheck.part(claim, "evidence", **SURVIVED)["survived"],
    )
    bit, goal = same_hardware(graph, said["hardware"]), goal_of(graph, said, kind != "cut_sets_at_start")
    match kind:
        case "cut_sets_at_start":
            moments = graph.listing.saying("begin")
        case "cut_sets_at_entry":
            moments = entered(graph, said)
        case _:
            moments = goal.open
    moments = moments & goal.running

    def lost_in(lost: list[str]) -> set[State]:
        return moments.intersection(*(graph.out[name] for name in lost))

    cuts, survived = masks(bit, said["cuts"]), masks(bit, (each["lost"] for each in runs))
    for lost in said["cuts"]:
        banned = goal.over | graph.net.carrying("repaired", *lost, None)
        after = graph.onward(lost_in(lost), goal.running, banned)
        certcheck.need(not after & goal.won, f"{lost} is survived")
    for each in runs:
        graph.listing.within()
        first = each["run"][: max(each["by"], 0)]
        state = graph.listing.walked(first)
        certcheck.need(state in lost_in(each["lost"]), f"{each['lost']} is not lost at that moment")
        banned = goal.over | graph.net.carrying("repaired", *each["lost"], None)
        for t in each["run"][len(first) :]:
            state = graph.listing.walked([t], state, banned)
            certcheck.need(state in goal.running, f"{each['lost']}: the run leaves what it is of")
        certcheck.need(state in goal.won, f"{each['lost']}: the run does not lead to the goal")
    without_another(cuts)
    for cut in cuts:
        for i in certcheck.indices(cut):
            fine = any(not cut & ~(1 << i) & ~one for one in survived)
            certcheck.need(fine, "less an element a cut is not survived")
    size, whole = len(bit), (1 << len(bit)) - 1
    doubt = whole + 1 - certcheck.above(frozenset(cuts), size)
    doubt -= certcheck.above(frozenset(whole & ~one for one in survived), size)
    certcheck.need(not doubt, f"{doubt} sets are neither cut nor survived")


class Forced:
    """Runs on which nothing is repaired, and nothing fails that can succeed in its present run.

    Args:
        graph: The states.
        said: What a claim states of timed blocks, and of what stops objectives.
    """

    def __init__(self, graph: LabelledStates, said: Json) -> None:
        self.graph, net = graph, graph.net
        self.repairs, self.hopeless = net.carrying("repaired"), dict[str, set[State]]()
        self.stopped = stopping(graph, said["stopped"])
        held = {block: names for block, *names in said["timed"]}
        certcheck.need(len(held) == len(said["timed"]), "a block is named twice")
        guards = dict[int, set[State]]()
        for t in net.carrying("failure") | net.carrying("timeout"):
            what, element = net.event[t][:2]
            names = held.get(element, [element]) if what == "timeout" else [element]
            guards[t] = set[State]().union(*map(self.losing, names))
        may = {t: guards.get(t, graph.all) for t in net.events if t not in self.repairs}
        self.reached = certcheck.grown(
            [0], lambda s: [n for t, n in graph.edges[s] if t in may and s in may[t]]
        )

    def losing(self, name: str) -> set[State]:
        """The states in which an objective runs and cannot succeed any more without a repair."""
        if name not in self.hopeless:
            goal = of_objective(self.graph, name, self.stopped)
            hopeful = self.graph.leading(goal.won, goal.running, goal.over | self.repairs)
            self.hopeless[name] = goal.running - hopeful
        return self.hopeless[name]


def worst(graph: LabelledStates, claim: Json) -> None:
    """Some moment after which a set leaves no way; of what holds no set there is none."""
    said = certcheck.part(claim, "statement", **CUTS, over=[str], timed=[[str]])
    certcheck.part(claim, "evidence")
    certcheck.need(all(said["timed"]), "a block has no name")
    bit, goal = same_hardware(graph, said["hardware"]), goal_of(graph, said)
    key = repr((said["timed"], said["stopped"]))
    if key not in graph.forced:
        graph.forced[key] = Forced(graph, said)
    by_lost = dict[int, set[State]]()
    for state in (graph.forced[key].reached & goal.open) - graph.listing.ended(*said["over"]):
        lost = sum(bit[name] for name, states in graph.out.items() if state in states)
        by_lost.setdefault(lost, set()).add(state)
    cuts = masks(bit, said["cuts"])
    without_another(cuts)

    unrepaired = graph.leading(goal.won, goal.running, goal.over | graph.net.carrying("repaired"))

    def losing(lost: int) -> set[State]:
        doubtful = by_lost.get(lost, set()) - unrepaired  # the others need no repair at all
        if not doubtful:
            return doubtful
        names = [name for name, own in bit.items() if lost & own]
        banned = goal.over | graph.net.carrying("repaired", *names, None)
        return doubtful - graph.leading(goal.won, goal.running, banned)

    for cut in cuts:
        certcheck.need(losing(cut), "after a cut a way is always left")
    for lost in sorted(by_lost, key=int.bit_count):
        if not any(cut & lost == cut for cut in cuts):
            certcheck.need(not losing(lost), "a set that holds no cut leaves no way")


# Probabilities.


def number(text: str) -> Fraction:
    """A decimal number of the statement, not below 0."""
    certcheck.need(DECIMAL.fullmatch(text), f"found {text[:50]!r}, expected a decimal number")
    return Fraction(text)


def interval(texts: list[str]) -> tuple[Fraction, Fraction]:
    """The least and the largest rate; either both are 0 or none is."""
    certcheck.need(len(texts) == 2, "a rate is two numbers")
    low, high = map(number, texts)
    certcheck.need(0 < low <= high or low == high == 0, f"{texts} are no rates")
    return low, high


Rate = tuple[Fraction, Fraction]


class JumpStates:
    """The states as a Markov chain: by state its edges with their rates, of those that it comes to."""

    def __init__(self, graph: LabelledStates, said: Json) -> None:
        self.graph = graph
        net, listing = graph.net, graph.listing
        by_event = dict[tuple[str, ...], Rate]()
        for each in said["hardware"]:
            by_event["out of service", each["name"]] = interval(each["fails"])
            by_event["repaired", each["name"]] = interval(each["repaired"])
        same_hardware(graph, [each["name"] for each in said["hardware"]])
        for each in said["events"]:
            fine = len(each["event"]) == 2 and each["event"][0] in ("declared", "detected")
            fine = fine and tuple(each["event"]) not in by_event
            certcheck.need(fine, f"{each['event']} has no rate of its own")
            by_event[tuple(each["event"])] = interval(each["rate"])
        self.rates = {t: by_event.get(net.event[t], (Fraction(0),) * 2) for t in net.events}
        self.end = {t for t in net.events if net.event[t][0] in ("success", "failure")}
        self.of_state = dict[tuple[State, int], Rate]()
        self.hasty = dict[State, set[int]]()
        self.stopped = stopping(graph, said["stopped"])
        names = [each["name"] for each in said["objectives"]]
        known = {net.event[t][1] for t in self.end}
        certcheck.need(len(set(names)) == len(names) and set(names) == known, "expected each objective once")
        for each in said["objectives"]:
            self.objective(each)
        ends = listing.ended("success", "failure", "abort")
        begin = [n for t, n in graph.edges[0] if net.event[t][0] == "start"]
        certcheck.need(len(begin) == 1, "the mission has not one start")
        self.begin, self.moves = begin[0], dict[State, list[tuple[State, Rate]]]()
        todo = begin
        while todo:
            state = todo.pop()
            if state not in self.moves:
                self.moves[state] = [] if state in ends else self.leaving(state)
                todo += [n for n, _ in self.moves[state]]

    def objective(self, said: Json) -> None:
        """Gives the ends of an objective their rates, where it can still succeed, and where it cannot."""
        graph, name = self.graph, said["name"]
        shares = dict[str, Fraction]()
        for pair in said["failures"]:
            certcheck.need(
                len(pair) == 2 and pair[0] not in shares, f"{name}: {pair} is no share of failures"
            )
            shares[pair[0]] = number(pair[1])
        well, duration = 1 - sum(shares.values()), number(said["duration"])
        goal = of_objective(graph, name, self.stopped)
        certcheck.need(well >= 0, f"{name}: its shares are more than 1")
        certcheck.need(duration or not goal.won, f"{name} has no duration")
        failing = graph.net.carrying("failure", name)
        for state in goal.won:
            for t in graph.net.carrying("success", name):
                self.of_state[state, t] = (well / duration,) * 2
            for t in failing:
                share = shares.get((*graph.net.event[t], "")[2], Fraction(0))
                self.of_state[state, t] = (share / duration,) * 2
        never = {t for t, (_, high) in self.rates.items() if not high and t not in self.end}
        hopeful = graph.leading(goal.won, goal.running, goal.over | never)
        fails = {t for t in failing if len(graph.net.event[t]) == 2}
        for state in goal.running - hopeful:
            self.hasty.setdefault(state, set()).update(fails)

    def leaving(self, state: State) -> list[tuple[State, Rate]]:
        """The edges of a state with their rates, all alike where something fails at once."""
        edges = self.graph.edges[state]
        at_once = [(n, (Fraction(1),) * 2) for t, n in edges if t in self.hasty.get(state, ())]
        slow = [(n, self.of_state.get((state, t), self.rates[t])) for t, n in edges]
        return at_once or [(n, rate) for n, rate in slow if rate[1] and n != state]


def chance(graph: LabelledStates, claim: Json) -> None:
    """One vector no step raises, one that none lowers: so the probability is between them."""
    said = certcheck.part(claim, "statement", **CHANCE)
    shown = certcheck.part(claim, "evidence", above=[int], below=[int])
    certcheck.need(said["end"] in ("success", "failure", "abort"), f"{said['end']!r} is no end")
    chain, goal = JumpStates(graph, said), graph.listing.ended(said["end"])
    common = lcm(*(rate.denominator for out in chain.moves.values() for _, both in out for rate in both))
    for vector in shown.values():
        certcheck.need(len(vector) == len(graph.edges), f"{len(vector)} numbers of {len(graph.edges)} states")
    above, below = shown["above"], shown["below"]
    onward = dict[State, list[State]]()
    for state, out in chain.moves.items():
        up, down = above[state], below[state]
        certcheck.need(up >= 0, f"the number above of state {state} is below 0")
        if not out:
            # A state that nothing leaves has ended so, or never will.
            fine = up >= UNIT and down <= UNIT if state in goal else down <= 0
            certcheck.need(fine, f"state {state} has ended otherwise")
            continue
        gain = loss = 0
        for after, (low, high) in out:
            least, most = (
                low.numerator * (common // low.denominator),
                high.numerator * (common // high.denominator),
            )
            rise, fall = above[after] - up, below[after] - down
            gain += rise * (most if rise > 0 else least)
            loss += fall * (least if fall > 0 else most)
        certcheck.need(gain <= 0, f"a step from state {state} raises the numbers above")
        certcheck.need(down <= 0 or loss >= 0, f"a step from state {state} lowers the numbers below")
        for after, _ in out:
            onward.setdefault(after, []).append(state)
    settled = [state for state, out in chain.moves.items() if not out or below[state] <= 0]
    leave = certcheck.grown(settled, lambda state: onward.get(state, ()))
    certcheck.need(
        len(leave) == len(chain.moves), "some state is never left, and its number below is above 0"
    )
    certcheck.need(Fraction(above[chain.begin], UNIT) <= number(said["high"]), "it may be more probable")
    certcheck.need(Fraction(below[chain.begin], UNIT) >= number(said["low"]), "it may be less probable")


KINDS = {"cut_sets_at_start": cut_sets, "cut_sets_at_entry": cut_sets, "cut_sets_whenever": cut_sets}
KINDS |= {"cut_sets_at_worst": worst, "chance": chance}


def judge(graph: LabelledStates, claim: Json) -> None:
    """Refutes a claim that its evidence does not prove."""
    where = f"further.json: {claim['key']}: kind"
    certcheck.need(claim["kind"] in KINDS, f"{where}: found {claim['kind'][:60]!r}", certcheck.Malformed)
    certcheck.need(claim["holds"], "that it fails is never certified")
    graph.listing.within()
    KINDS[claim["kind"]](graph, claim)


def judged(listing: Callable[[], certcheck.Listing], entries: dict[str, bytes]) -> certcheck.Report:
    """What becomes of the further claims, on states that are listed."""
    document = certcheck.parsed(entries, "further.json")
    claims = certcheck.claims_in(document, "further.json", FURTHER)
    try:
        graph = LabelledStates(listing())
    except (certcheck.Refuted, certcheck.Limit) as error:
        return [("not checked", claim["key"], str(error)) for claim in claims]
    return certcheck.each(lambda claim: judge(graph, claim), claims)


def checked(path: str, *, most: int = 2_000_000, seconds: float = 600) -> certcheck.Report:
    """Checks the further claims of a certificate; raises Malformed and Limit as certcheck does."""
    until, entries = time.monotonic() + seconds, certcheck.unpacked(path)
    net = certcheck.Net(certcheck.parsed(entries, "net.json"))
    return judged(lambda: certcheck.Listing(net, most, until), entries)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names."""
    words = "Checks cut sets at every moment, and chances."
    return certcheck.ran(checked, words, arguments, "certificate")


if __name__ == "__main__":
    sys.exit(main())
