"""Certificates of missions: mutants that must not be accepted, and what claims cost to write and to check.

Usage: ``python experiments/faults/certificates.py [--mutants N] [--seed S] [--second]`` changes N
certificates at random, in the net or in the claims, and holds each claim that certcheck proves, and with
``--second`` the checker in C++, against what mcpn's engines say of the changed net; exit code 1 if one is
false, or one of the checkers alone proves it. ``--table`` prints claims, bytes and seconds of the worked
missions. 200 mutants take some ten seconds, 10,000 some ten minutes, the table two minutes.
"""

from __future__ import annotations

import argparse
import copy
import json
import random
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Iterator, Mapping
from io import BytesIO
from itertools import chain, combinations
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

import numpy as np

from experiments.faults.both_checkers import proved
from experiments.faults.campaigns import is_so
from experiments.shared.missions import Parameters, generate
from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.errors import ConfluenceError, DivergenceError, UnsafeError
from mcpn.events import Event, What
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.ltl.formulas import Happens, Next, Release, SomePath, Until, normal
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.goal import DEADLOCK, TRUE, And, AtMost, Fires, Formula, Not, Or, marked
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction
from mcpn.study import Study, open_study

Documents = dict[str, Any]
ROOT = Path(__file__).resolve().parents[1]
WORKED = ("ulysse", "courier", "drone", "glider", "rover")
SIZES = [
    Parameters(sections=sections, types=2, hardware=hardware, per_section=2, alternatives=2, depth=1)
    for sections in (1, 2, 3)
    for hardware in (2, 3)
]
OPERATORS = {"not": Not, "and": And, "or": Or, "EX": EX, "EG": EG, "EU": EU}
OPERATORS |= {"X": Next, "U": Until, "R": Release}


# What is true of a changed certificate, by other code than the checker's: mcpn's explicit engine and logic.


class Truth:
    """What a net does, as mcpn's own engine lists and evaluates it.

    Args:
        document: The entry ``net.json``.

    Raises:
        McpnError: It is no net, not safe, not confluent, or its internal firings need not end.
    """

    def __init__(self, document: Documents) -> None:
        builder, names = NetBuilder("mutant", priorities=True), [p["name"] for p in document["places"]]
        self.roles: dict[tuple[str, ...], set[int]] = {}
        for number, place in enumerate(document["places"]):
            builder.place(place["name"], initial=place["initial"])
            for role in place["roles"]:
                self.roles.setdefault(tuple(role), set()).add(number)
        for t in document["transitions"]:
            event = Event(What(t["event"][0]), *t["event"][1:]) if t["event"] else None
            consume, produce, read = ([names[p] for p in t[side]] for side in ("consume", "produce", "read"))
            builder.transition(
                t["name"], consume=consume, produce=produce, read=read, event=event, rank=t["rank"] + 1000
            )
        self.net: PetriNet = builder.build()
        self.events = [tuple(t["event"]) for t in document["transitions"]]
        self.graph: AlternativesGraph = by_reduction(explore(self.net, max_states=20_000))
        self.space = ArraySpace(self.graph)
        self.evaluation = Evaluation(self.space)

    def says(self, role: str, *of: str) -> Formula:
        """That one of some elements, or any where none is named, has a role."""
        places = {
            p for (said, own), on in self.roles.items() if said == role and (not of or own in of) for p in on
        }
        return marked(*sorted(places))

    def formula(self, said: list[Any]) -> Formula:
        """A formula of a claim as mcpn has it."""
        operator, *rest = said
        match operator:
            case "says":
                return self.says(*rest)
            case "at most":
                return AtMost(tuple(map(tuple, rest[1])), rest[0])
            case "fires" | "happens":
                wanted = {tuple(event) for event in rest}
                transitions = tuple(t for t, event in enumerate(self.events) if event and event in wanted)
                return (Fires if operator == "fires" else Happens)(transitions)
            case "deadlock":
                return DEADLOCK
            case "E":
                return SomePath(normal(self.formula(*rest)))  # the engine asks for normal forms
        return OPERATORS[operator](*map(self.formula, rest))

    def holds(self, claim: Documents) -> bool:
        """Whether what a claim states is so."""
        kind, said = claim["kind"], claim["statement"]
        ends = {"success", "failure", "abort"}
        every = Or(*map(self.says, sorted(ends)))
        formulas = {
            "can_succeed": EU(TRUE, self.says("success")),
            "can_fail": EU(TRUE, self.says("failure")),
            "can_be_aborted": EU(TRUE, self.says("abort")),
            "can_always_go_on": Not(EU(TRUE, And(DEADLOCK, Not(every)))),
            "can_always_end": Not(EU(TRUE, Not(EU(TRUE, every)))),
            "can_always_end_safely": Not(
                EU(TRUE, Not(EU(TRUE, Or(self.says("success"), self.says("abort")))))
            ),
        }
        if kind in ("safe", "confluent"):
            return bool(claim["holds"])
        if kind == "nominal_success":
            return bool(claim["holds"]) and self.nominal(said)
        if kind == "cut_sets":
            return bool(claim["holds"]) and self.cut_sets(said)
        formula = formulas[kind] if kind in formulas else self.formula(said["formula"])
        return self.evaluation.holds(formula) is claim["holds"]

    def edges(self, what: str, *of: str | None) -> Any:
        """The edges of an event, of some elements (None is no element), or else of any."""
        carrying = [t for t, e in enumerate(self.events) if e and e[0] == what and (not of or e[1] in of)]
        return np.isin(self.graph.labels, carrying)

    def mask(self, formula: Formula) -> Any:
        """The states that satisfy a formula."""
        return self.evaluation.states(formula).mask

    def nominal(self, said: Mapping[str, list[str]]) -> bool:
        """Whether nominal runs end in success alone, and enter what is meant."""
        graph, none = self.graph, np.zeros(self.graph.states, np.bool_)
        onward = self.edges("start") | (self.edges("success") & ~self.edges("success", *said["fails"], None))
        onward |= self.edges("failure", *said["fails"], None)
        begin = graph.reached(self.edges("repaired", *said["repaired"], None))
        if said["repaired"]:
            begin &= ~self.mask(self.says("oos", *said["repaired"]))
        success = self.mask(self.says("success"))
        endless = self.mask(self.says("objective", *said["endless"])) if said["endless"] else none
        if not begin.any():
            return False
        reached = graph.reached(onward, begin)
        lasting = reached & ~success
        goes_on = none.copy()
        goes_on[graph.sources[onward]] = True
        if (lasting & ~goes_on).any() or graph.staying(lasting & goes_on & ~endless, onward).any():
            return False
        return all((self.mask(self.says("objective", name)) & reached).any() for name in said["meant"])

    def cut_sets(self, said: Documents) -> bool:
        """Whether the sets are the minimal ones, of all that can fail, by trying every set."""
        names = [own for role, own in self.roles if role == "oos"]
        if sorted(said["hardware"]) != sorted(names) or len(names) > 8:
            return False
        goal = self.mask(Or(*map(self.says, said["ends"])))
        cuts = list[frozenset[str]]()
        for lost in map(
            frozenset, chain.from_iterable(combinations(names, n) for n in range(len(names) + 1))
        ):
            start = self.mask(self.says("begin"))
            for name in lost:
                start = start & self.mask(self.says("oos", name))
            reached = self.graph.reached(~self.edges("repaired", *lost, None), start)
            if not (reached & goal).any() and not any(cut <= lost for cut in cuts):
                cuts.append(lost)
        return set(cuts) == {frozenset(cut) for cut in said["cuts"]}  # to name one twice is no other claim


# Changes.


def change_net(net: Documents, draw: random.Random) -> str:
    """Changes a net at one place; says how."""
    places, transitions = net["places"], net["transitions"]
    t, place = draw.choice(transitions), draw.choice(places)
    match how := draw.choice(["arc", "arc", "arc", "rank", "event", "initial", "role", "drop", "swap"]):
        case "arc":
            side, number = t[draw.choice(["consume", "produce", "read"])], draw.randrange(len(places))
            if side and draw.random() < 0.5:
                side.pop(draw.randrange(len(side)))
            elif number not in side:
                side.append(number)
        case "rank":
            internal = [each for each in transitions if not each["event"]]
            draw.choice(internal or [t])["rank"] += draw.choice([-1, 1])
        case "event":
            t["event"], t["rank"] = copy.copy(draw.choice(transitions)["event"]), 0
        case "initial":
            place["initial"] = 1 - place["initial"]
        case "role":
            other = draw.choice(places)
            place["roles"], other["roles"] = other["roles"], place["roles"]
        case "drop":
            transitions.remove(t)
        case "swap":
            other = draw.choice(transitions)
            side = draw.choice(["consume", "produce", "read"])
            t[side], other[side] = other[side], t[side]
    return f"net: {how}"


def change_claims(document: Documents, draw: random.Random) -> str:
    """Changes a claim at one place; says how."""
    claim, other = draw.choice(document["claims"]), draw.choice(document["claims"])
    match how := draw.choice(["holds", "kind", "statement", "statement", "evidence", "evidence", "move"]):
        case "holds":
            claim["holds"] = not claim["holds"]
            if draw.random() < 0.5:
                claim["evidence"] = draw.choice([{}, {"run": []}, copy.deepcopy(other["evidence"])])
        case "kind":
            claim["kind"] = other["kind"]
        case "move":
            claim["statement"], claim["evidence"] = copy.deepcopy((other["statement"], other["evidence"]))
        case part:
            lists = list(_lists(claim[part]))
            if lists:
                found = draw.choice(lists)
                _change_list(found, draw, draw.choice(lists))
    return f"claims: {how}"


def _lists(value: Any) -> Iterator[list[Any]]:
    """All lists inside a value."""
    if isinstance(value, list):
        yield value
    for inside in value.values() if isinstance(value, dict) else value if isinstance(value, list) else ():
        yield from _lists(inside)


def _change_list(found: list[Any], draw: random.Random, other: list[Any]) -> None:
    """Changes one item of a list: drops, doubles or replaces it."""
    if not found:
        found.extend(copy.deepcopy(other[:1]))
        return
    at = draw.randrange(len(found))
    item = found[at]
    if isinstance(item, int) and draw.random() < 0.7:
        found[at] = item + draw.choice([-2, -1, 1, 2])
    elif isinstance(item, str) and item in {*OPERATORS, "E"} and draw.random() < 0.7:
        found[at] = draw.choice(["and", "or", "not", "EX", "EG", "E", "X", "U", "R"])
    elif draw.random() < 0.4:
        found.pop(at)
    elif draw.random() < 0.5:
        found.insert(at, copy.deepcopy(item))
    elif other:
        found[at] = copy.deepcopy(draw.choice(other))


# The campaign.


def certificates() -> list[tuple[Documents, Documents]]:
    """The nets and claims of small missions, with those on their cut sets."""
    found = list[tuple[Documents, Documents]]()
    for seed, parameters in enumerate(SIZES):
        study = Study(generate(parameters, seed))
        net, claims = documents_of(certificate_of(study.verdicts()).to_bytes())
        more = documents_of(certificate_of_causes(study.causes()).to_bytes())[1]["claims"]
        known = {claim["key"] for claim in claims["claims"]}
        claims["claims"] += [claim for claim in more if claim["key"] not in known]
        found.append((net, claims))
    return found


def documents_of(data: bytes) -> tuple[Documents, Documents]:
    """The net and the claims of a certificate."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        return json.loads(archive.read("net.json")), json.loads(archive.read("claims.json"))


def judged(net: Documents, claims: Documents, second: bool = False) -> tuple[int, list[str]]:
    """How many claims are proved, and those of them that are false, or that one of both checkers proves."""
    first, other = proved("claims", {"net": net, "claims": claims}, second)
    stated, wrong = (
        [claim for claim in claims["claims"] if claim["key"] in first | other],
        apart(first, other),
    )
    if not stated:
        return 0, []
    try:
        truth = Truth(net)
    except (UnsafeError, ConfluenceError, DivergenceError) as error:
        return len(stated), wrong + [f"{claim['key']}: {error}" for claim in stated]
    return len(stated), wrong + [claim["key"] for claim in stated if not is_so(truth.holds, claim)]


def apart(first: set[str], other: set[str]) -> list[str]:
    """The claims that one of both checkers proves."""
    return [f"{key}: one of the checkers alone proves it" for key in sorted(first ^ other)]


def campaign(mutants: int, seed: int, second: bool = False) -> tuple[Counter[str], list[str]]:
    """Changes certificates; what became of each change, and the false claims that were proved."""
    draw, originals = random.Random(seed), certificates()
    found, wrong = Counter[str](), list[str]()
    for number in range(mutants):
        net, claims = copy.deepcopy(draw.choice(originals))
        every = len(claims["claims"])
        how = change_net(net, draw) if draw.random() < 0.6 else change_claims(claims, draw)
        stated, false = judged(net, claims, second)
        wrong += [f"mutant {number} of seed {seed}, {how}: {key}" for key in false]
        found[
            f"{how}: {'every claim' if stated == every else 'some claims' if stated else 'no claim'} proved"
        ] += 1
    return found, wrong


def table() -> None:
    """Prints what the certificates of the worked missions cost, in seconds of CPU of one process."""
    print("| mission | states | proved | trusted | bytes | check | write | certcheck | ratio | corecheck |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in WORKED:
        begun = time.process_time()
        check = open_study(ROOT / name / "mission.xml").verdicts()
        answered = time.process_time()
        certificate = certificate_of(check)
        data = certificate.to_bytes()
        written = time.process_time()
        with tempfile.NamedTemporaryFile() as file:
            file.write(data)
            file.flush()
            report = certcheck.checked(file.name)
            done = time.process_time()
            corecheck.checked(file.name)
        played = time.process_time() - done
        proved = sum(how == "proved" for how, _, _ in report)
        times = (answered - begun, written - answered, done - written)
        assert check.stable_sizes is not None
        counts = (check.stable_sizes[0], f"{proved} of {len(report)}", len(certificate.trusted), len(data))
        shown = [*map(str, counts), *(f"{each:.2f}" for each in times)]
        print(f"| {name} | {' | '.join(shown)} | {times[2] / times[0]:.1f} | {played:.2f} |")


def main() -> None:
    """What the command line asks for."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--mutants", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--second", action="store_true", help="ask the checker in C++, too")
    parser.add_argument("--table", action="store_true")
    asked = parser.parse_args()
    if asked.table:
        table()
        return
    found, wrong = campaign(asked.mutants, asked.seed, asked.second)
    for what, times in sorted(found.items()):
        print(f"{times:6}  {what}")
    for line in wrong:
        print(f"FALSE BUT PROVED: {line}")
    print(f"{asked.mutants} mutants, {len(wrong)} false claims proved")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
