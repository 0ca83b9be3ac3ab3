"""corecheck: plays the core mission of a certificate beside its net, and draws no net.

``python corecheck.py OUT`` reads the entry ``core.json`` as docs/certificates.md describes it: the objectives
graph of the mission, and its robot. It walks the states of the net and what they say in pairs: in each pair
the same objectives and alternatives run, the same waits and is out of service, and the same events are
possible; and each event leads to such a pair. It needs certcheck.py, coregraph.py and corerobot.py beside it,
and Python's standard library.

Exit code 0: the net does what the mission says. 1: it does not. 2: it is not checked.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
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
    acts: frozenset[tuple[str, tuple[str, int]]]
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
        handled = {h["event"] for each in every for h in handlers_of(each)} & self.robot.changing.keys()
        words = f"core.json: {min(handled, default='')[:60]} changes facts and is handled"
        certcheck.need(not handled, words, certcheck.Malformed)
        out = frozenset(name for name, each in self.robot.hardware.items() if each["out"])
        none = frozenset[str]()
        self.first = CoreState("begin", none, self.robot.facts, frozenset(), out, none, none)
        self.moved, self.begun = cache(self._moved), cache(self._begun)

    def runs(self, at: Place, states: tuple[str, ...] = ("runs",)) -> Names:
        """The objectives that are in some states."""
        return frozenset(name for name, state in self.graph.leaves(at) if state in states)

    def possible(self, core: CoreState) -> set[Event]:
        """The events that may happen in a stable state."""
        robot, acts = self.robot, dict(core.acts)
        runs = {name: way for name, (does, way) in acts.items() if does == RUNS}
        used = {k for name, way in runs.items() for k in robot.ways(name)[way]["consumes"]}
        found = set[Event]()
        for name, each in robot.hardware.items():
            if name not in core.out:
                if each["faulty"] and (not each["crash"] or name in used):
                    found.add(("out of service", name))
            elif each["repairable"] and name not in core.unnoticed:
                found.add(("repaired", name))
        for name in runs:
            detects = robot.activities[name]["detects"]
            found |= {("detected", k) for k in detects if k in core.unnoticed}
        for name, changes in robot.changing.items():
            if not core.facts.isdisjoint(changes):
                found.add(("declared", name))
        if core.at == "begin":
            return found | {("start", "")}
        found.update(self.graph.possible(core.at, core.had))
        misused = robot.held(core.acts) & core.unnoticed
        for name in self.runs(core.at):
            if runs.keys() >= set(robot.objectives[name]) and not misused & robot.may_use[name]:
                found.add(("success", name))
        return found

    def after(self, core: CoreState, event: Event) -> Iterator[CoreState]:
        """The stable states to which an event that is possible may lead: one, or by who comes first."""
        what, name, out, unnoticed, suspected = *event[:2], core.out, core.unnoticed, core.suspected
        one = {name} if name else set[str]()
        if what == "out of service":
            out |= one
            unnoticed |= one if self.robot.hardware[name]["late"] else set()
        elif what == "repaired":
            out -= one
        elif what == "detected":
            unnoticed, suspected = unnoticed - one, suspected - one
        elif what in ("failure", "timeout") and name in self.objectives:
            suspected |= self.robot.held(core.acts) & unnoticed & self.robot.may_use[name]
        moves = () if what in ("out of service", "repaired", "detected") else event
        at, had, facts, stops, begin = self.moved(core.at, core.had, core.facts, moves)
        acts = frozenset(each for each in core.acts if each[0] not in stops) if stops else core.acts
        for end in self.robot.settled(RobotMoment(acts, begin, out - unnoticed, suspected), facts):
            begun = self.begun(at, end.begin)
            yield CoreState(begun, had, facts, end.acts, out, unnoticed - end.known, end.suspected)

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
        if isinstance(core.at, str):
            said = {(ENDS.get(core.at, core.at), "")}
        else:
            said = {
                ("objective" if state == "runs" else "pending", name)
                for name, state in self.graph.leaves(core.at)
            }
            said |= {("done", name) for name in self.graph.done(core.at)}
        for name, (does, way) in core.acts:
            if does == "refused":
                said.add(("refused", name))
            else:
                alternative = f"{name}.{self.robot.ways(name)[way]['name']}"
                said.add(("active" if does == RUNS else "waits", alternative))
        said |= {("oos", name) for name in core.out}
        late = (name for name in core.out - core.unnoticed if self.robot.hardware[name]["late"])
        said |= {("known", name) for name in late}
        said |= {("fact", f"{fact}={value}") for fact, value in core.facts}
        return frozenset(said | {("happened", handler) for handler in core.had})


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
            ends, events = [*mission.after(core, event)], events + 1
            left = [each for each in ends if (target, each) in met or says(each) == shown[target]]
            if not left:
                agree(shown[target], says(ends[0]), f"{here}: after {' '.join(event)}")
            for pair in ((target, each) for each in left):
                if pair not in met:
                    met.add(pair)
                    todo.append(pair)
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


def played(graph: certcheck.Listing, entries: dict[str, bytes]) -> tuple[int, int]:
    """Walks the states of a certificate's net beside its core mission, as :func:`walked`."""
    return walked(graph, mission_of(entries))


def checked(path: str, seconds: float = 600, most: int = 2_000_000) -> tuple[int, int]:
    """Checks the net of a certificate; how many pairs and events there are.

    Raises:
        certcheck.Malformed: It has no entry that can be understood.
        certcheck.Refuted: The net does something else.
        certcheck.Limit: A limit was hit.
    """
    until, (entries, net, _) = time.monotonic() + seconds, certcheck.read(path)
    mission = mission_of(entries)  # whatever is malformed is so before anything is refuted
    return walked(certcheck.Listing(net, most, until), mission)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names, and prints what became of it."""
    parser = argparse.ArgumentParser(
        "corecheck", description="Plays a core mission beside a certificate's net."
    )
    parser.add_argument("certificate")
    parser.add_argument("--max-states", type=int, default=2_000_000, help="markings to keep at most")
    parser.add_argument("--seconds", type=float, default=600.0, help="time after which to give up")
    asked = parser.parse_args(arguments)
    try:
        pairs, events = checked(asked.certificate, asked.seconds, asked.max_states)
        code, said = 0, f"proved: {pairs} pairs of states, {events} events"
    except certcheck.Refuted as error:
        code, said = 1, f"refuted: {error}"
    except (certcheck.Malformed, certcheck.Limit, RecursionError, MemoryError) as error:
        code, said = 2, f"not checked: {error or 'there is not enough memory'}"
    line = f"net  {said}".encode("ascii", "backslashreplace").decode()
    sys.stdout.write(line.translate(dict.fromkeys(range(32), "?")) + "\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
