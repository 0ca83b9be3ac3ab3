"""Mutants of certificates that furthercheck and diagcheck read: none that states something false is accepted.

Usage: ``python experiments/faults/further_mutants.py [--mutants N] [--seed S] [--of further|diagrams]
[--second]`` changes N certificates at random, in the net, the claims or the diagrams, and holds each claim
that is proved against the words of docs/certificates.md, read again here on the states as mcpn's explicit
engine lists them, set by set and by linear systems. With ``--second`` the checkers in C++ are asked, too.
Exit code 1 if a claim is false, or one of the checkers alone proves it. 1,000 mutants take some two minutes.
"""

from __future__ import annotations

import copy
import json
import random
import sys
import tempfile
import zipfile
from collections import Counter
from collections.abc import Iterable, Iterator
from functools import cache
from io import BytesIO
from itertools import chain, combinations
from pathlib import Path
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2]))

import numpy as np

from experiments.faults import campaigns
from experiments.faults.both_checkers import proved
from experiments.faults.certificates import SIZES, Truth, apart, change_net
from experiments.shared.missions import generate
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.errors import ConfluenceError, DivergenceError, UnsafeError
from mcpn.mission.xml import read_mission
from mcpn.study import Study

Documents = dict[str, Any]
RATED = """<mission xmlns="urn:mcpn:mission:1" name="rated">
  <robot name="boat">
    <event name="recall" rate="0.05"/>
    <hardware name="gps" failure_rate="0.02" repair_rate="0.5"/>
    <hardware name="sonar" failure_rate="0.03" repairable="false"/>
    <activity name="navigate"><alternative name="by_gps" consumes="gps"/></activity>
    <activity name="look"><alternative name="by_sonar" consumes="sonar"/></activity>
  </robot>
  <objective name="go" activities="navigate" duration="1.5" failure_probability="0.1">
    <on event="recall" goto="abort"/>
  </objective>
  <objective name="see" activities="look" duration="2" failure="again"/>
  <objective name="again" activities="look navigate" duration="1" failure_probability="0.25"/>
</mission>
"""
ENDING = ("success", "failure", "timeout")
CLOSE = 1e-9
"""How far a probability by floats may be from the bounds that are proved."""


class Moments:
    """What the page says of claims in ``further.json``, on the states of a net.

    Args:
        truth: The states.
    """

    def __init__(self, truth: Truth) -> None:
        self.truth, graph = truth, truth.graph
        triples = zip(graph.sources.tolist(), graph.labels.tolist(), graph.targets.tolist(), strict=True)
        self.edges = [(s, truth.events[t], t, n) for s, t, n in triples]
        self.every = set(range(graph.states))
        self.names = sorted({own for role, own in truth.roles if role == "oos"})

    def states(self, role: str, *of: str) -> set[int]:
        """The states that mark a place with a role."""
        return set(np.flatnonzero(self.truth.mask(self.truth.says(role, *of))).tolist())

    def holds(self, claim: Documents) -> bool:
        """Whether what a claim states is so."""
        said = claim["statement"]
        if not claim["holds"]:
            return False
        if claim["kind"] == "chance":
            return self.chance(said)
        if sorted(said["hardware"]) != self.names:
            return False
        family = self.worst(said) if claim["kind"].endswith("worst") else self.defeating(claim["kind"], said)
        minimal = {lost for lost in family if not any(other < lost for other in family)}
        return {frozenset(cut) for cut in said["cuts"]} == minimal

    def run_of(self, name: str, said: Documents) -> tuple[set[int], set[int], list[Any]]:
        """Of an objective: where it runs, where its success may happen, and the steps of its run."""
        stopped = {t for each in said["stopped"] if each["objective"] == name for t in each["transitions"]}
        running = self.states("objective", name)
        own = {(what, name) for what in ENDING}
        steps = [
            edge
            for edge in self.edges
            if edge[0] in running and edge[3] in running and edge[1][:2] not in own and edge[2] not in stopped
        ]
        won = {s for s, event, _, _ in self.edges if event[:2] == ("success", name)} & running
        return running, won, steps

    def leading(self, goal: set[int], steps: Iterable[Any]) -> set[int]:
        """The states that lead to a goal along some edges."""
        before, found = dict[int, set[int]](), set(goal)
        for s, _, _, n in steps:
            before.setdefault(n, set()).add(s)
        todo = list(found)
        while todo:
            new = before.get(todo.pop(), set()) - found
            found |= new
            todo += new
        return found

    def goal(self, said: Documents, within: bool = True) -> tuple[set[int], set[int], list[Any]]:
        """The states in which it is open, those in which it is won, and the steps."""
        ends, name = said["goal"]["ends"], said["goal"]["objective"]
        if ends:
            won = set[int]().union(*map(self.states, ends))
            return self.every - won, won, self.edges
        running, won, steps = self.run_of(name, said)
        return (running, won, steps) if within else (self.every, won, self.edges)

    def lost(self, names: Iterable[str]) -> set[int]:
        """The states in which all of some hardware is out of service."""
        return self.every.intersection(*(self.states("oos", name) for name in names))

    def defeating(self, kind: str, said: Documents) -> set[frozenset[str]]:
        """All sets that are cuts."""
        open_, won, steps = self.goal(said, kind != "cut_sets_at_start")
        moments = open_
        if kind == "cut_sets_at_start":
            moments = self.states("begin")
        elif kind == "cut_sets_at_entry":
            running = open_ if said["goal"]["objective"] else self.every
            moments = self.entered(said) & running
        found = set[frozenset[str]]()
        for names in chain.from_iterable(combinations(self.names, n) for n in range(len(self.names) + 1)):
            unrepaired = [e for e in steps if not (e[1][0] == "repaired" and e[1][1] in names)]
            if not moments & self.lost(names) & self.leading(won, unrepaired):
                found.add(frozenset(names))
        return found

    def entered(self, said: Documents) -> set[int]:
        """The states behind an entry."""
        first = set[int]().union(
            *(self.states(k, n) for k in ("objective", "pending") for n in said["entered"])
        )
        inside = set[int]().union(*(self.states(*role) for role in said["inside"]))
        runs = [self.run_of(name, said) for name in said["again"]]
        going_on = [(running, {(s, t) for s, _, t, _ in steps}) for running, _, steps in runs]

        def ends(s: int, t: int) -> bool:
            return any(s in running and (s, t) not in kept for running, kept in going_on)

        found = {n for s, _, t, n in self.edges if n in first and (s not in inside or ends(s, t))}
        failing = [(n, e, t, s) for s, e, t, n in self.edges if e[0] == "out of service"]
        return self.leading(found, failing)

    def worst(self, said: Documents) -> set[frozenset[str]]:
        """The sets of what is lost in some lost moment."""
        hopeless = dict[str, set[int]]()
        timed = {block: names for block, *names in said["timed"]}
        forced = list[Any]()
        for edge in self.edges:
            s, event, _, n = edge
            names = timed.get(event[1], [event[1]]) if event[0] == "timeout" else [event[1]]
            if event[0] in ("failure", "timeout"):
                for name in names:
                    if name not in hopeless:
                        running, won, steps = self.run_of(name, said)
                        kept = [e for e in steps if e[1][0] != "repaired"]
                        hopeless[name] = running - self.leading(won, kept)
                if any(s in hopeless[name] for name in names):
                    forced.append((n, event, 0, s))
            elif event[0] != "repaired":
                forced.append((n, event, 0, s))
        open_, won, steps = self.goal(said)
        moments = open_ & self.leading({0}, forced)
        for role in said["over"]:
            moments -= self.states(role)
        found, out = set[frozenset[str]](), {name: self.states("oos", name) for name in self.names}
        for s in moments:
            names = frozenset(name for name in self.names if s in out[name])
            unrepaired = [e for e in steps if not (e[1][0] == "repaired" and e[1][1] in names)]
            if names not in found and s not in self.leading(won, unrepaired):
                found.add(names)
        return found

    def chance(self, said: Documents) -> bool:
        """Whether the probability is in the interval, at the least rates and at the largest."""
        return all(
            float(said["low"]) - CLOSE <= self.probability(said, side) <= float(said["high"]) + CLOSE
            for side in (0, 1)
        )

    def probability(self, said: Documents, side: int) -> float:
        """Of an end, by floats."""
        slow = dict[tuple[str, ...], float]()
        for each in said["hardware"]:
            slow["out of service", each["name"]] = float(each["fails"][side])
            slow["repaired", each["name"]] = float(each["repaired"][side])
        slow |= {tuple(each["event"]): float(each["rate"][side]) for each in said["events"]}
        objectives = {each["name"]: each for each in said["objectives"]}
        runs = {name: self.run_of(name, said) for name in objectives}
        ended = self.states("success") | self.states("failure") | self.states("abort")
        hopeless = dict[str, set[int]]()
        for name, (running, won, steps) in runs.items():
            may = [e for e in steps if e[1][0] in ("success", "failure") or slow.get(e[1], 0.0) > 0]
            hopeless[name] = running - self.leading(won, may)
        out = dict[int, list[tuple[int, float]]]()
        at_once = dict[int, list[tuple[int, float]]]()
        for s, event, _, n in self.edges:
            if s in ended:
                continue
            name, rate = event[1], slow.get(event, 0.0)
            if event[0] in ("success", "failure") and s in runs[name][1]:
                shares = {reason: float(share) for reason, share in objectives[name]["failures"]}
                part = shares.get((*event, "")[2], 0.0) if event[0] == "failure" else 1 - sum(shares.values())
                rate = part / float(objectives[name]["duration"])
            elif event[0] == "failure" and len(event) == 2 and s in hopeless[name]:
                at_once.setdefault(s, []).append((n, 1.0))
            if rate > 0 and n != s:
                out.setdefault(s, []).append((n, rate))
        out |= at_once
        (begin,) = [n for s, event, _, n in self.edges if s == 0 and event[0] == "start"]
        goal = self.states(said["end"]) & ended
        hope = self.leading(goal, [(s, None, 0, n) for s, moves in out.items() for n, _ in moves])
        inner = sorted(hope - ended)
        if begin not in inner:
            return float(begin in goal)
        number = {s: i for i, s in enumerate(inner)}
        matrix, right = np.eye(len(inner)), np.zeros(len(inner))
        for s in inner:
            total = sum(rate for _, rate in out[s])
            for n, rate in out[s]:
                if n in goal:
                    right[number[s]] += rate / total
                elif n in number:
                    matrix[number[s], number[n]] -= rate / total
        return float(np.linalg.solve(matrix, right)[number[begin]])


# Certificates and their changes.


@cache
def originals(of: str) -> list[tuple[Documents, Documents]]:
    """The nets of small missions, each with the other entry."""
    found = list[tuple[Documents, Documents]]()
    studies = [Study(generate(parameters, seed)) for seed, parameters in enumerate(SIZES)]
    if of == "further":
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "rated.xml"
            path.write_text(RATED)
            rated = certificate_of_causes(Study(read_mission(path)).causes(), chances=True)
        found += [documents_of(rated.to_bytes(), of)] * 3
        studies = studies[:4]
    for study in studies:
        every = (
            [certificate_of_causes(study.causes())]
            if of == "further"
            else [
                certificate_of(study.verdicts(), max_states=1),
                certificate_of_causes(study.causes(), max_states=1),
            ]
        )
        found += [documents_of(made.to_bytes(), of) for made in every]
    return found


def documents_of(data: bytes, of: str) -> tuple[Documents, Documents]:
    """The net and another entry of a certificate."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        return json.loads(archive.read("net.json")), json.loads(archive.read(f"{of}.json"))


def change(document: Documents, draw: random.Random) -> str:
    """Changes an entry at one place; says where."""
    claim, other = draw.choice(document["claims"]), draw.choice(document["claims"])
    parts = [part for part in ("nodes", "pairs", "weights", "again", "layers", "order") if document.get(part)]
    match how := draw.choice(["statement", "evidence", "holds", "kind", *parts, *parts]):
        case "holds":
            claim["holds"] = not claim["holds"]
            claim["evidence"] = draw.choice([{}, {"run": []}, copy.deepcopy(other["evidence"])])
        case "kind":
            claim["kind"] = other["kind"]
            if draw.random() < 0.5:
                claim["statement"], claim["evidence"] = copy.deepcopy((claim["statement"], other["evidence"]))
        case "statement" | "evidence":
            _vary(claim[how], draw)
        case part:
            _vary(document[part], draw)
    return how


def _vary(value: Any, draw: random.Random) -> None:
    """Changes one number, text or list inside a value."""
    places = list(_places(value))
    if not places:
        return
    holder, key = draw.choice(places)
    found = holder[key]
    if isinstance(found, bool):
        holder[key] = not found
    elif isinstance(found, int):
        holder[key] = found + draw.choice([-2, -1, 1, 2, 10**12, -(10**12)])
    elif isinstance(found, str):
        same = [h[k] for h, k in places if isinstance(h[k], str)]
        digits = found.replace(".", "").isdigit()
        holder[key] = (
            draw.choice([f"{found}1", f"0.{found}"]) if digits and "." in found else draw.choice(same)
        )
    elif isinstance(found, list) and found:
        if draw.random() < 0.5:
            found.pop(draw.randrange(len(found)))
        else:
            found.append(copy.deepcopy(draw.choice(found)))


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """All places inside a value that hold something."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, found in inside:
        yield value, key
        yield from _places(found)


def judged(net: Documents, document: Documents, of: str, second: bool = False) -> tuple[int, list[str]]:
    """How many claims are proved, and those of them that are false, or that one of both checkers proves."""
    first, other = proved(of, {"net": net, of: document}, second)
    stated = [claim for claim in document["claims"] if claim["key"] in first | other]
    wrong = apart(first, other)
    if not stated:
        return 0, []
    try:
        truth = Truth(net)
    except UnsafeError as error:
        return len(stated), wrong + [f"{claim['key']}: {error}" for claim in stated]
    except (ConfluenceError, DivergenceError) as error:
        # What diagrams prove of reaching and closing is so whatever the order of internal firings.
        ends = (
            ("can_always_end", "can_always_end_safely", "cut_sets")
            if isinstance(error, DivergenceError)
            else ()
        )
        false = [c for c in stated if of == "further" or c["kind"] in ("confluent", *ends)]
        return len(stated), wrong + [f"{claim['key']}: {error}" for claim in false]
    judge = Moments(truth).holds if of == "further" else truth.holds
    return len(stated), wrong + [claim["key"] for claim in stated if not campaigns.is_so(judge, claim)]


def campaign(of: str, mutants: int, seed: int, second: bool = False) -> tuple[Counter[str], list[str]]:
    """Changes certificates; what became of each change, and the false claims that were proved."""
    draw, found, wrong = random.Random(seed), Counter[str](), list[str]()
    for number in range(mutants):
        net, document = copy.deepcopy(draw.choice(originals(of)))
        every = len(document["claims"])
        how = change_net(net, draw) if draw.random() < 0.5 else f"{of}: {change(document, draw)}"
        stated, false = judged(net, document, of, second)
        wrong += [f"mutant {number} of seed {seed}, {how}: {key}" for key in false]
        outcome = "every claim" if stated == every else "some claims" if stated else "no claim"
        found[f"{how}: {outcome} proved"] += 1
    return found, wrong


if __name__ == "__main__":
    sys.exit(
        campaigns.ran(
            "Mutants of certificates with further claims and diagrams.", ("further", "diagrams"), campaign
        )
    )
