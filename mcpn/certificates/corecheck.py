"""corecheck: plays the core mission of a certificate beside its net, and draws no net.

``python corecheck.py OUT`` reads the entry ``core.json`` as docs/certificates.md describes it: the objectives
graph of the mission, and its robot. It walks the states of the net and what they say in pairs: in each pair
the same objectives and alternatives run, the same waits and is out of service, and the same events are
possible; and each event leads to such a pair. It needs certcheck.py, coregraph.py and corerobot.py beside it,
and Python's standard library.

Exit code 0: the net does what the mission says. 1: it does not. 2: it is not checked.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
    from mcpn.certificates.coregraph import ENDS, CoreGraph, Event, Json, Place, facts_of, handlers_of
    from mcpn.certificates.corerobot import RUNS, CoreRobot, Facts, Names, RobotMoment
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]
    from coregraph import (  # type: ignore[import-not-found, no-redef]
        ENDS,
        CoreGraph,
        Event,
        Json,
        Place,
        facts_of,
        handlers_of,
    )
    from corerobot import (  # type: ignore[import-not-found, no-redef]
        RUNS,
        CoreRobot,
        Facts,
        Names,
        RobotMoment,
    )


NET = "net"
"""The key of what is shown: that the net is the mission's."""


OF_HARDWARE = ("out of service", "repaired", "detected")
"""Events that move no objective."""
Acts = frozenset[tuple[str, tuple[str, int]]]
"""What activities do that are not idle."""


class CoreState(NamedTuple):
    """A state of a core mission.

    Args:
        at: Where it is: ``begin``, an exit, or a place.
        had: The handlers that happen once and have.
        facts: The value of every fact.
        acts: What activities do that are not idle.
        out: Hardware out of service.
        unnoticed: That of it which is not known to be.
        suspected: That of it which will be, as soon as nobody has it.
    """

    at: Place
    had: Names
    facts: Facts
    acts: Acts
    out: Names
    unnoticed: Names
    suspected: Names


class CoreMission:
    """A core mission, as ``core.json`` holds it; or a section of one, which has other exits."""

    def __init__(self, document: Json, exits: Names = frozenset(ENDS)) -> None:
        certcheck.shaped(document, {**certcheck.FORMAT, "graph": dict, "robot": dict}, "core.json")
        self.graph = CoreGraph(document["graph"], "core.json: graph", {*exits})
        every = [*self.graph.every()]
        self.objectives = {each["name"]: each for each in every if "activities" in each}
        fine = len({each["name"] for each in every}) == len(every)
        certcheck.need(fine, "core.json: two sections have one name", certcheck.Malformed)
        own = {name: each["activities"] for name, each in self.objectives.items()}
        self.robot = CoreRobot(document["robot"], own)
        unknown = {fact for each in every for fact in facts_of(each)} - {fact for fact, _ in self.robot.facts}
        certcheck.need(
            not unknown, f"core.json: no fact {min(unknown, default='')[:60]}", certcheck.Malformed
        )
        makers = {each["name"] for each in document["robot"]["activities"] if each["produces"]}
        makers &= {name for each in own.values() for name in each}
        words = f"core.json: an objective runs {min(makers, default='')[:60]}, which produces"
        certcheck.need(not makers, words, certcheck.Malformed)
        handled = {h["event"] for each in every for h in handlers_of(each)} & self.robot.changing.keys()
        words = f"core.json: {min(handled, default='')[:60]} changes facts and is handled"
        certcheck.need(not handled, words, certcheck.Malformed)
        out = frozenset(name for name, each in self.robot.hardware.items() if each["out"])
        none = frozenset[str]()
        self.first = CoreState("begin", none, self.robot.facts, frozenset(), out, none, none)
        # Of many states parts are the same: what follows from these is found once.
        self.moved, self.begun, self.handled = (
            cache(self._moved),
            cache(self._begun),
            cache(self._handled),
        )
        self.of_hardware, self.successes = cache(self._of_hardware), cache(self._successes)
        self.place_says, self.acts_say = cache(self._place_says), cache(self._acts_say)

    def runs(self, at: Place, states: tuple[str, ...] = ("runs",)) -> Names:
        """The objectives that are in some states."""
        return frozenset(name for name, state in self.graph.leaves(at) if state in states)

    def possible(self, core: CoreState) -> set[Event]:
        """The events that may happen in a stable state."""
        found = {*self.of_hardware(core.acts, core.out, core.unnoticed)}
        for name, changes in self.robot.changing.items():
            if not core.facts.isdisjoint(changes):
                found.add(("declared", name))
        if core.at == "begin":
            return found | {("start", "")}
        found.update(self.handled(core.at, core.had))
        return found | self.successes(core.at, core.acts, core.unnoticed)

    def _handled(self, at: Place, had: Names) -> frozenset[Event]:
        """The events by which the mission may leave a place, but success."""
        return frozenset(self.graph.possible(at, had))

    def _of_hardware(self, acts: Acts, out: Names, unnoticed: Names) -> frozenset[Event]:
        """The events of hardware that may happen."""
        robot = self.robot
        runs = {name: way for name, (does, way) in acts if does == RUNS}
        used = {k for name, way in runs.items() for k in robot.ways(name)[way]["consumes"]}
        found = set[Event]()
        for name, each in robot.hardware.items():
            if name not in out:
                if each["faulty"] and (not each["crash"] or name in used):
                    found.add(("out of service", name))
            elif each["repairable"] and name not in unnoticed:
                found.add(("repaired", name))
        for name in runs:
            detects = robot.activities[name]["detects"]
            found |= {("detected", k) for k in detects if k in unnoticed}
        return frozenset(found)

    def _successes(self, at: Place, acts: Acts, unnoticed: Names) -> frozenset[Event]:
        """The objectives under way that may succeed."""
        robot, runs = self.robot, {name for name, (does, _) in acts if does == RUNS}
        misused = robot.held(acts) & unnoticed
        return frozenset(
            ("success", name)
            for name in self.runs(at)
            if runs.issuperset(robot.objectives[name]) and not misused & robot.may_use[name]
        )

    def after(self, core: CoreState, event: Event) -> list[CoreState]:
        """The stable states to which an event that is possible may lead: one, or by who comes first."""
        (what, name, *_), (at, had, facts, acts, out, unnoticed, suspected) = event, core
        moves = () if what in OF_HARDWARE else event
        if what == "out of service":
            out |= {name}
            unnoticed |= {name} if self.robot.hardware[name]["late"] else set()
        elif what == "repaired":
            out -= {name}
        elif what == "detected":
            unnoticed, suspected = unnoticed - {name}, suspected - {name}
        elif what in ("failure", "timeout") and name in self.objectives:
            suspected |= self.robot.held(acts) & unnoticed & self.robot.may_use[name]
        at, had, facts, stops, begin = self.moved(at, had, facts, moves)
        acts = frozenset(each for each in acts if each[0] not in stops) if stops else acts
        known = out - unnoticed if unnoticed else out
        return [
            CoreState(
                self.begun(at, end.begin), had, facts, end.acts, out, unnoticed - end.known, end.suspected
            )
            for end in self.robot.settled(RobotMoment(acts, begin, known, suspected), facts)
        ]

    def _begun(self, at: Place, waiting: Names) -> Place:
        """The same where all objectives under way run, but for some that wait."""
        return self.graph.becoming(at, lambda name: "waits" if name in waiting else "runs")

    def _moved(
        self, before: Place, had: Names, facts: Facts, event: Event
    ) -> tuple[Place, Names, Facts, Names, Names]:
        """Where the mission comes to by an event, or by none, what has happened once, and how facts are then.

        Last come the activities that stop, and the objectives that are about to begin.
        """
        at = before
        if event:
            at, had, facts = self.led(before, had, facts, event)
        ended = self.runs(before) - self.runs(at)
        stops = frozenset(a for each in ended for a in self.robot.objectives[each])
        return at, had, facts, stops, self.runs(at, ("enters", "waits"))

    def led(self, at: Place, had: Names, facts: Facts, event: Event) -> tuple[Place, Names, Facts]:
        """Where an event leads, what has happened once, and how facts are then."""
        what, name, before = *event[:2], facts
        if what == "start":
            at = self.graph.enter(self.graph.entry)
        elif what == "declared" and name in self.robot.changing:
            facts = frozenset(self.robot.changing[name].get(fact, fact) for fact in facts)
        elif what == "declared":
            at, had = self.graph.happens(at, name, had, facts) or (at, had)
        else:
            on = "success" if what == "success" else "failure"
            sets = self.objectives[name]["sets"] if name in self.objectives else ()
            facts = changed(facts, {fact: value for fact, value, when in sets if when == on})
            outcome = " ".join((what, *event[2:]))
            at = self.graph.ended(at, name, outcome, facts) or at
        if facts != before:
            at = self.graph.left(at, facts, facts - before)
        for name, state in self.graph.leaves(at):
            sets = self.objectives[name]["sets"] if state == "enters" else ()
            facts = changed(facts, {fact: value for fact, value, when in sets if when == "start"})
        return at, had, facts

    def says(self, core: CoreState) -> frozenset[tuple[str, str]]:
        """What places of the net say in such a state, as pairs of role and element."""
        said = {("oos", name) for name in core.out}
        late = (name for name in core.out - core.unnoticed if self.robot.hardware[name]["late"])
        said |= {("known", name) for name in late}
        said |= {("fact", f"{fact}={value}") for fact, value in core.facts}
        said |= {("happened", handler) for handler in core.had}
        return self.place_says(core.at).union(self.acts_say(core.acts), said)

    def _place_says(self, at: Place) -> frozenset[tuple[str, str]]:
        """The same of a place of the mission."""
        if isinstance(at, str):
            return frozenset({(ENDS.get(at, at), "")})
        said = {
            ("objective" if state == "runs" else "pending", name) for name, state in self.graph.leaves(at)
        }
        return frozenset(said | {("done", name) for name in self.graph.done(at)})

    def _acts_say(self, acts: Acts) -> frozenset[tuple[str, str]]:
        """The same of what activities do."""
        said = set[tuple[str, str]]()
        for name, (does, way) in acts:
            alternative = name if does == "refused" else f"{name}.{self.robot.ways(name)[way]['name']}"
            said.add(({RUNS: "active", "refused": does}.get(does, "waits"), alternative))
        return frozenset(said)


def changed(facts: Facts, to: dict[str, str]) -> Facts:
    """Facts of which some have other values."""
    return frozenset({**dict(facts), **to}.items()) if to else facts


NAMELESS = {"begin", *ENDS.values()}
ROLES = {
    role: role
    for role in ("objective", "pending", "done", "active", "refused", "oos", "known", "fact", "happened")
}
ROLES |= {"wait": "waits", "want": "waits"} | {role: role for role in NAMELESS}


def labels(graph: certcheck.Listing) -> list[frozenset[tuple[str, str]]]:
    """Of each state what its places say, in the words of :meth:`CoreMission.says`."""
    said = [
        ((ROLES[role], "" if role in NAMELESS else own), places)
        for (role, own), places in graph.net.roles.items()
        if role in ROLES
    ]
    return [frozenset(word for word, places in said if marking & places) for marking in graph.stable]


def walked(graph: certcheck.Listing, mission: CoreMission) -> tuple[int, int]:
    """Walks net and core mission in pairs; how many pairs there are, and how many events they have.

    Raises:
        certcheck.Refuted: The net does something else.
    """
    shown, says, event_of = labels(graph), mission.says, graph.net.event
    first = (0, mission.first)
    agree(shown[0], says(mission.first), "before the start")
    met, todo, events = {first}, [first], 0
    for state, core in todo:  # grows while it is walked
        graph.within(len(met))
        here = ", ".join(sorted(name for name, _ in mission.graph.leaves(core.at))) or str(core.at)
        possible, edges = mission.possible(core), {event_of[t]: target for t, target in graph.edges[state]}
        certcheck.need(len(edges) == len(graph.edges[state]), f"{here}: the net has an event twice")
        agree(frozenset(edges), frozenset(possible), f"{here}: possible")
        for event, target in edges.items():
            ends, fits, events = mission.after(core, event), False, events + 1
            for each in ends:
                pair = (target, each)
                if pair in met:
                    fits = True
                elif says(each) == shown[target]:
                    fits = True
                    met.add(pair)
                    todo.append(pair)
            if not fits:
                after = f"{here}: after {' '.join(event)}"
                certcheck.need(ends, f"{after}: the mission comes to no end")
                agree(shown[target], says(ends[0]), after)
    return len(met), events


def agree(net: frozenset[Any], mission: frozenset[Any], where: str) -> None:
    """The net says what the mission does."""
    if net != mission:
        more, less = (
            "; ".join(" ".join(each) for each in sorted(some)) for some in (net - mission, mission - net)
        )
        raise certcheck.Refuted(
            f"{where}: the net alone says {more or 'nothing'}, the mission {less or 'nothing'}"
        )


def mission_of(entries: dict[str, bytes]) -> CoreMission:
    """The core mission of a certificate."""
    return CoreMission(certcheck.parsed(entries, "core.json"))


def played(listing: Callable[[], certcheck.Listing], entries: dict[str, bytes]) -> certcheck.Report:
    """Walks the states of a certificate's net beside its core mission; what becomes of the claim on the net.

    Raises:
        certcheck.Malformed: It has no entry that can be understood.
        certcheck.Limit: A limit was hit.
    """
    mission = mission_of(entries)  # whatever is malformed is so before anything is refuted
    try:
        pairs, events = walked(listing(), mission)
    except certcheck.Refuted as error:
        return [("refuted", NET, str(error))]
    return [("proved", NET, f"{pairs} pairs of states, {events} events")]


def checked(path: str, *, most: int = 2_000_000, seconds: float = 600) -> certcheck.Report:
    """Checks the net of a certificate; raises Malformed and Limit as certcheck does."""
    until, (entries, net, _) = time.monotonic() + seconds, certcheck.read(path)
    return played(lambda: certcheck.Listing(net, most, until), entries)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names."""
    words = "Plays a core mission beside a certificate's net."
    return certcheck.ran(checked, words, arguments, "certificate")


if __name__ == "__main__":
    sys.exit(main())
