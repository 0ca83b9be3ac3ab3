"""sectioncheck: proves claims about a core mission of many sections by their types, one section at a time.

``python sectioncheck.py OUT`` reads the entries ``core.json`` and ``sections.json`` as docs/certificates.md
describes them. Sections that differ in names alone are of one type. Each type is played by itself, from
every status of the hardware that it can use; what holds of the mission follows from where its sections lead
(papers/mcpn.md has the proof). It needs certcheck.py, corecheck.py, coregraph.py and corerobot.py beside it,
and Python's standard library.

Exit code 0: all claims are proved. 1: one is refuted. 2: something is not checked.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Iterable, Iterator
from functools import cache, cached_property
from itertools import chain, combinations
from typing import Any

try:
    from mcpn.certificates import certcheck
    from mcpn.certificates.corecheck import CoreMission, CoreState
    from mcpn.certificates.coregraph import ENDS, Event, Json, facts_of, handlers_of
    from mcpn.certificates.corerobot import CoreRobot, Names, RobotMoment
    from mcpn.certificates.sections import sectionforms
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]
    import sectionforms  # type: ignore[import-not-found, no-redef]
    from corecheck import CoreMission, CoreState  # type: ignore[import-not-found, no-redef]
    from coregraph import (  # type: ignore[import-not-found, no-redef]
        ENDS,
        Event,
        Json,
        facts_of,
        handlers_of,
    )
    from corerobot import CoreRobot, Names, RobotMoment  # type: ignore[import-not-found, no-redef]

MOST_STATES = 500_000
"""States of types to keep at most."""
STATUS = ("out of service", "repaired")
"""Events that change nothing but the status of hardware, and how activities react."""
GOALS = {
    "can_always_end": {"success", "failure", "abort"},
    "can_always_end_safely": {"success", "abort"},
    "can_succeed": {"success"},
    "can_fail": {"failure"},
    "can_be_aborted": {"abort"},
}
"""The ends that a claim speaks of."""
KINDS = {*GOALS, "can_always_go_on"}
STATED = {"formula", "nominal_success"}
"""Kinds of claims that state something besides."""
NONE: frozenset[Any] = frozenset()


class Renamed:
    """A section alone with what it can use: everything has a new name, in the order in which it is met.

    Attributes:
        document: The section and its part of the robot, as ``core.json`` would hold them.
        contended: The hardware and the data that several activities of the whole robot compete for.
        targets: Where the section leads: the new name of a target, and the target.
    """

    def __init__(self, section: Json, robot: CoreRobot, software: dict[str, Json]) -> None:
        self.names = dict[tuple[str, str], str]()
        self.targets = dict[str, str]()
        renamed = self.section(section, None)
        own = list(dict.fromkeys(name for each in objectives_of(section) for name in each["activities"]))
        activities = [self.activity(robot.activities[each]) for each in with_producers(own, robot)]
        used = {old: new for (kind, old), new in self.names.items() if kind == "k"}
        self.document = {
            "graph": {"entry": renamed["name"], "sections": [renamed]},
            "robot": {
                "hardware": renaming(robot.hardware, used),
                "software": renaming(software, used),
                "facts": [],
                "events": [],
                "activities": activities,
            },
        }
        self.contended = [new for old, new in used.items() if old in robot.contended]

    def named(self, kind: str, name: str) -> str:
        """The new name of something."""
        return self.names.setdefault((kind, name), f"{kind}{len(self.names):04}")

    def section(self, section: Json, inside: set[str] | None) -> Json:
        """A section with other names; ``inside`` are the sections beside it in a branch."""
        found = {
            **section,
            "name": self.named("s", section["name"]),
            "routes": {
                outcome: self.cases(cases, inside) for outcome, cases in sorted(section["routes"].items())
            },
            "handlers": [self.handler(each, inside) for each in section["handlers"]],
        }
        if "activities" in section:
            return found | {"activities": [self.named("a", each) for each in section["activities"]]}
        return found | {
            "branches": [
                each | {"name": self.named("b", each["name"]), "graph": self.graph(each["graph"])}
                for each in section["branches"]
            ],
            "pauses": [
                {"graph": self.graph(each["graph"]), "handlers": self.handlers(each)}
                for each in section["pauses"]
            ],
        }

    def graph(self, graph: Json) -> Json:
        """The graph of a branch, or of what runs while a block pauses."""
        inside = {each["name"] for each in graph["sections"]}
        return {
            "entry": self.named("s", graph["entry"]),
            "sections": [self.section(each, inside) for each in graph["sections"]],
        }

    def handlers(self, pause: Json) -> list[Json]:
        """What handles events while a block pauses: it leads to what runs meanwhile, or by its exits."""
        inside = {each["name"] for each in pause["graph"]["sections"]}
        return [self.handler(each, inside) for each in pause["handlers"]]

    def cases(self, cases: list[Json], inside: set[str] | None) -> list[Json]:
        """Where something leads."""
        return [case | {"to": self.target(case["to"], inside)} for case in cases]

    def target(self, target: str, inside: set[str] | None) -> str:
        """A section beside it, an exit of a branch, or where the section itself leads."""
        if inside is not None:
            return self.named("s", target) if target in inside else target
        new = self.named("t", target)
        self.targets[new] = target
        return new

    def handler(self, handler: Json, inside: set[str] | None) -> Json:
        """A handler of a declared event."""
        return handler | {"event": self.named("e", handler["event"]), "to": self.cases(handler["to"], inside)}

    def activity(self, activity: Json) -> Json:
        """An activity; what it detects is all known."""
        return {
            **activity,
            "name": self.named("a", activity["name"]),
            "produces": [self.named("k", each) for each in activity["produces"]],
            "detects": [],
            "alternatives": [
                way | {"name": str(number), "consumes": [self.named("k", each) for each in way["consumes"]]}
                for number, way in enumerate(activity["alternatives"])
            ],
        }


def with_producers(found: list[str], robot: CoreRobot) -> list[str]:
    """Some activities, and what may produce for them, in the order in which they are met."""
    for name in found:  # grows while it is walked
        consumed = (k for way in robot.ways(name) for k in way["consumes"])
        producers = dict.fromkeys(robot.producer[k] for k in consumed if k in robot.producer)
        found += [each for each in producers if each not in found]
    return found


def renaming(some: dict[str, Json], used: dict[str, str]) -> list[Json]:
    """What is used of some parts of a robot, with other names."""
    return [some[old] | {"name": new} for old, new in used.items() if old in some]


def objectives_of(section: Json) -> Iterator[Json]:
    """The objectives of a section, at any depth."""
    if "activities" in section:
        yield section
    for each in (*section.get("branches", ()), *section.get("pauses", ())):
        for inner in each["graph"]["sections"]:
            yield from objectives_of(inner)


def apart(section: Json) -> bool:
    """Whether nothing in a section, at any depth, asks facts or what has happened before."""
    if any(facts_of(section)) or section["left"] or any(each["once"] for each in handlers_of(section)):
        return False
    parts = (*section.get("branches", ()), *section.get("pauses", ()))
    return all(apart(inner) for each in parts for inner in each["graph"]["sections"])


class PlayedType:
    """All sections that differ in names alone, played from every status of their hardware.

    Attributes:
        entries: By what is out of service as it is entered, the number of the state.
        stuck: Whether there is a state in which nothing happens.
        leads: Where the section leads, from whatever status.
        leads_steadily: Where it leads with the hardware as it is at first, if that stays so.
        surely: The states that it reaches if it is entered with the hardware as it is at first.
    """

    def __init__(self, one: Renamed, budget: Budget) -> None:
        self.mission = CoreMission({**certcheck.FORMAT, **one.document}, frozenset(one.targets))
        self.mission.robot.contended = {*one.contended}
        hardware = self.mission.robot.hardware
        self.first = frozenset(name for name, each in hardware.items() if each["out"])
        may_fail = [name for name, each in hardware.items() if each["faulty"] or each["out"]]
        sizes = range(len(may_fail) + 1)
        self.states, self.number, self.entries = list[CoreState](), dict[CoreState, int](), dict[Names, int]()
        self.edges, self.exits = list[list[tuple[Event, int]]](), list[list[tuple[Event, str]]]()
        for out in map(frozenset, chain.from_iterable(combinations(may_fail, size) for size in sizes)):
            budget.within(0)
            self.entries[out] = self.met(self.entered(out))
        self.stuck = False
        for state in self.states:  # grows while it is walked
            budget.within(1)
            self.follow(state)
        self.before = list[list[int]]([] for _ in self.states)
        for number, edges in enumerate(self.edges):
            for _, target in edges:
                self.before[target].append(number)
        self.events = sorted({each[0] for some in (self.edges, self.exits) for row in some for each in row})
        self.leads = {target for exits in self.exits for _, target in exits}
        self.leading = cache(self.leading_without)
        self.leads_steadily = self.leading(NONE, True)
        self.surely = certcheck.grown([self.entries[self.first]], lambda n: (to for _, to in self.edges[n]))
        self.led = dict[frozenset[str], bool]()

    def met(self, state: CoreState) -> int:
        """The number of a state."""
        if state not in self.number:
            self.number[state] = len(self.states)
            self.states.append(state)
        return self.number[state]

    def entered(self, out: Names) -> CoreState:
        """The state in which the section has just begun, with some hardware out of service."""
        mission = self.mission
        at = mission.graph.enter(mission.graph.entry)
        start = RobotMoment(NONE, mission.runs(at, ("enters",)), out, NONE)
        end = the_one(mission.robot.settled(start, NONE))
        return CoreState(mission.begun(at, end.begin), NONE, NONE, end.acts, out, NONE, NONE)

    def follow(self, state: CoreState) -> None:
        """Finds where the events of a state lead: to states of the section, or out of it."""
        edges, exits = list[tuple[Event, int]](), list[tuple[Event, str]]()
        for event in self.mission.possible(state):
            after = the_one(self.mission.after(state, event))
            if isinstance(after.at, str):
                self.nothing_runs(state, event)
                exits.append((event, after.at))
            else:
                edges.append((event, self.met(after)))
        self.edges.append(edges)
        self.exits.append(exits)
        self.stuck = self.stuck or not (edges or exits)

    def nothing_runs(self, state: CoreState, event: Event) -> None:
        """What ran in the section stops as it is left: the next one begins from the status alone."""
        stops = self.mission.moved(state.at, NONE, NONE, event)[3]
        left = frozenset(each for each in state.acts if each[0] not in stops)
        still = self.mission.robot.at_rest(RobotMoment(left, NONE, state.out, NONE)).acts
        certcheck.need(not still, "sections are not apart: something still runs behind one", certcheck.Limit)

    def leading_without(self, avoided: frozenset[Event], steadily: bool) -> set[str]:
        """Where it leads without some events; steadily, that is from the status at first, which stays so."""

        def may(event: Event) -> bool:
            return event not in avoided and not (steadily and event[0] in STATUS)

        start = [self.entries[self.first]] if steadily else self.entries.values()
        met = certcheck.grown(start, lambda n: (target for event, target in self.edges[n] if may(event)))
        return {target for n in met for event, target in self.exits[n] if may(event)}

    def nominally(self, fails: Names) -> tuple[set[str], set[str]]:
        """Where nominal runs lead, and the objectives on them; refuted if one stops or goes round.

        Args:
            fails: The objectives that are meant to fail.
        """

        def may(event: Event) -> bool:
            return event[0] == ("failure" if event[1] in fails else "success") and len(event) > 1

        def onward(n: int) -> list[int]:
            return [target for event, target in self.edges[n] if may(event)]

        met = certcheck.grown([self.entries[self.first]], onward)
        ways = {n: {target for event, target in self.exits[n] if may(event)} for n in met}
        certcheck.need(all(ways[n] or onward(n) for n in met), "a nominal run stops in a section")
        left = {*met}
        while last := {n for n in left if left.isdisjoint(onward(n))}:
            left -= last
        certcheck.need(not left, "a nominal run goes round in a section")
        said = (word for n in met for word in self.mission.says(self.states[n]))
        objectives = {element for role, element in said if role == "objective"}
        return set[str]().union(*ways.values()), objectives

    def always_leads(self, to: frozenset[str]) -> bool:
        """Whether from each of its states some run leads to one of some targets."""
        if to not in self.led:
            start = [n for n, exits in enumerate(self.exits) if any(target in to for _, target in exits)]
            self.led[to] = len(certcheck.grown(start, self.before.__getitem__)) == len(self.states)
        return self.led[to]


def the_one(ends: Iterable[Any]) -> Any:
    """The only end of a reaction."""
    found = [*ends]
    certcheck.need(len(found) == 1, "the reaction of a section has no end, or several", certcheck.Limit)
    return found[0]


class Budget:
    """How many states there may be, and how long it may take."""

    def __init__(self, most: int, until: float) -> None:
        self.left, self.until = most, until

    def within(self, more: int) -> None:
        """Gives up where a limit is hit."""
        self.left -= more
        certcheck.need(self.left >= 0, "more states than may be kept (--max-states)", certcheck.Limit)
        certcheck.need(time.monotonic() <= self.until, "the time is over (--seconds)", certcheck.Limit)


class PlayedSections:
    """The sections of a core mission, and the types that they are of."""

    def __init__(self, core: Json, budget: Budget) -> None:
        robot = CoreMission(core).robot  # which refuses what is malformed
        software = {each["name"]: each for each in core["robot"]["software"]}
        sections = core["graph"]["sections"]
        known = not (robot.facts or robot.changing or any(each["late"] for each in robot.hardware.values()))
        fine = known and all(map(apart, sections))
        certcheck.need(
            fine, "sections are not apart: facts, late losses, or what happens once", certcheck.Limit
        )
        self.budget, self.robot, self.sections = budget, robot, {each["name"]: each for each in sections}
        self.entry, self.types = core["graph"]["entry"], dict[str, PlayedType]()
        self.type, self.targets = dict[str, PlayedType](), dict[str, dict[str, str]]()
        self.names = dict[str, dict[tuple[str, str], str]]()
        for section in sections:
            budget.within(0)
            one = Renamed(section, robot, software)
            key = json.dumps([one.document, one.contended], sort_keys=True)
            if key not in self.types:
                self.types[key] = PlayedType(one, budget)
            self.type[section["name"]], self.targets[section["name"]] = self.types[key], one.targets
            self.names[section["name"]] = one.names
        self.reached = certcheck.grown(
            [self.entry], lambda name: self.led(name, self.type[name].leads), self.type
        )
        self.ends = {
            ENDS[to] for name in self.reached for to in self.led(name, self.type[name].leads) if to in ENDS
        }

    def led(self, name: str, some: set[str]) -> Iterator[str]:
        """Where some ways out of a section lead in the mission."""
        return (self.targets[name][to] for to in some)

    def always(self, ends: set[str]) -> bool:
        """Whether from each state that can be reached some run leads to one of some ends."""
        good = {to for to, end in ENDS.items() if end in ends}
        before = dict[str, list[str]]()
        for name in self.reached:
            for to in self.led(name, self.type[name].leads):
                before.setdefault(to, []).append(name)
        todo = [*good]
        while todo:
            for name in before.get(todo.pop(), ()):
                ways = frozenset(way for way, to in self.targets[name].items() if to in good)
                if name not in good and self.type[name].always_leads(ways):
                    good.add(name)
                    todo.append(name)
        return good >= self.reached and self.ends <= ends

    def steadily_reached(self) -> set[str]:
        """The sections that are reached while the status of hardware stays as it is at first."""
        return certcheck.grown(
            [self.entry], lambda name: self.led(name, self.type[name].leads_steadily), self.type
        )

    def reaches(self, ends: set[str]) -> bool:
        """Whether one of some ends is reached so."""
        met = self.steadily_reached()
        return any(
            ENDS.get(to) in ends for name in met for to in self.led(name, self.type[name].leads_steadily)
        )

    @cached_property
    def _ways(self) -> dict[str, list[tuple[str, int]]]:
        found = dict[str, list[tuple[str, int]]]()
        for name in self.robot.activities:
            for number, way in enumerate(self.robot.ways(name)):
                found.setdefault(f"{name}.{way['name']}", []).append((name, number))
        return found

    def ways_named(self, name: str) -> list[tuple[str, int]]:
        """The activity and the number of each alternative that is named so, as ``activity.alternative``."""
        return self._ways.get(name, [])

    @cached_property
    def formulas(self) -> sectionforms.SectionFormulas:
        """What formulas are asked of."""
        return sectionforms.SectionFormulas(self)


def judge(sections: PlayedSections, claim: Json) -> None:
    """Proves a claim, or says why not."""
    kind, holds = claim["kind"], claim["holds"]
    certcheck.need(
        kind in KINDS | STATED, f"no claim of sections is of the kind {kind[:60]}", certcheck.Malformed
    )
    certcheck.part(claim, "evidence")
    if kind == "formula":
        form = sectionforms.read(certcheck.part(claim, "statement", text=str, formula=list)["formula"])
        fine = sections.formulas.holds(form) == holds
        certcheck.need(fine, f"the formula is {not holds}".lower())
        return
    if kind == "nominal_success":
        said = certcheck.part(claim, "statement", fails=[str], endless=[str], meant=[str], repaired=[str])
        certcheck.need(holds, "that it fails is never certified")
        sections.formulas.nominal(said)
        return
    certcheck.part(claim, "statement")
    if kind == "can_always_go_on":
        stuck = any(sections.type[name].stuck for name in sections.reached)
        certcheck.need(holds and not stuck, "in some state of a section nothing happens")
    elif kind.startswith("can_always"):
        certcheck.need(
            holds and sections.always(GOALS[kind]), "sections do not show that the end can always be reached"
        )
    elif holds:
        certcheck.need(sections.reaches(GOALS[kind]), "no run on which no status changes leads there")
    else:
        certcheck.need(not GOALS[kind] & sections.ends, "a section may lead there")


def checked(path: str, *, most: int = MOST_STATES, seconds: float = 600) -> certcheck.Report:
    """Checks the claims by sections of a certificate; raises Malformed and Limit as certcheck does."""
    budget, entries = Budget(most, time.monotonic() + seconds), certcheck.unpacked(path)
    document = certcheck.parsed(entries, "sections.json")
    claims = certcheck.claims_in(document, "sections.json", certcheck.CLAIMS)
    sections = PlayedSections(certcheck.parsed(entries, "core.json"), budget)
    return certcheck.each(lambda claim: judge(sections, claim), claims)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names."""
    words = "Checks claims by sections of a certificate."
    return certcheck.ran(checked, words, arguments, "certificate")


if __name__ == "__main__":
    sys.exit(main())
