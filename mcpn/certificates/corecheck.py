"""corecheck: plays the objectives of a mission beside the net of its certificate, and draws no net.

``python corecheck.py OUT`` reads the entry ``core.json`` as docs/certificates.md describes it, and walks the
states of the net and what the objectives graph says in pairs: in each pair the same objectives run, every
event of the net is one that the graph knows there, and leads where its routes lead. It needs certcheck.py
beside it, and Python's standard library. Of activities and hardware it says nothing.

Exit code 0: the net does what the objectives graph says. 1: it does not. 2: it is not checked.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator
from functools import cache
from itertools import product
from typing import Any

try:
    from mcpn.certificates import certcheck
except ImportError:  # both files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]

Json = dict[str, Any]
Place = str | tuple[str, tuple[Any, ...]]
"""Where a graph is: at an objective, or an exit; or in a block, with where each branch is."""
EXITS = {"succeed": "success", "fail": "failure", "abort": "abort"}
HANDLER = {"event": str, "once": str, "to": [str]}


class CoreGraph:
    """A graph of sections: that of the mission, or of a branch."""

    def __init__(self, document: Json, where: str) -> None:
        shape = {"entry": str, "sections": [dict]}
        certcheck.shaped(document, shape, where)
        self.entry, self.sections = document["entry"], dict[str, Json]()
        self.branches = dict[str, list[CoreGraph]]()
        for section in document["sections"]:
            shape = {"name": str, "routes": dict, "handlers": [HANDLER]}
            if "branches" in section:
                shape |= {"needed": int, "failing": int, "hasty": bool}
                shape["branches"] = [{"name": str, "mandatory": bool, "graph": dict}]
            certcheck.shaped(section, shape, f"{where}: a section")
            name = section["name"]
            certcheck.need(name not in self.sections, f"{where}: {name} is there twice", certcheck.Malformed)
            self.sections[name] = section
            inside = section.get("branches", ())
            self.branches[name] = [CoreGraph(each["graph"], f"{where}: {each['name']}") for each in inside]
            for outcome, routes in section["routes"].items():
                certcheck.shaped(routes, [str], f"{where}: {name}: {outcome}")
        for section in self.sections.values():
            leads = [*section["routes"].values(), *(each["to"] for each in section["handlers"])]
            for target in {self.entry, *(to for routes in leads for to in routes)} - EXITS.keys():
                certcheck.need(
                    target in self.sections, f"{where}: no section {target[:60]}", certcheck.Malformed
                )

    def enter(self, target: str) -> Place:
        """Where a route leads: an exit, an objective, or a block with its branches at their entries."""
        if target in EXITS or not self.branches[target]:
            return target
        return target, tuple(level.enter(level.entry) for level in self.branches[target])

    def running(self, at: Place) -> Iterator[str]:
        """The objectives that run, or are about to."""
        if isinstance(at, tuple):
            for level, inside in zip(self.branches[at[0]], at[1], strict=True):
                yield from level.running(inside)
        elif at not in EXITS:
            yield at

    def due(self, at: Place, running: frozenset[str], before: frozenset[str]) -> Iterator[tuple[str, ...]]:
        """Events that must be possible: all ends of objectives that run but success, and what is handled."""
        if at in EXITS:
            return
        section = self.sections[at[0] if isinstance(at, tuple) else at]
        for handler in section["handlers"]:
            if handler["once"] not in before:
                yield "declared", handler["event"]
        if isinstance(at, tuple):
            for level, inside in zip(self.branches[at[0]], at[1], strict=True):
                yield from level.due(inside, running, before)
        elif at in running:
            for outcome in section["routes"].keys() - {"success"}:
                what, _, reason = outcome.partition(" ")
                yield (what, at, reason) if reason else (what, at)

    def ended(self, at: Place, objective: str, outcome: str) -> set[Place]:
        """Where an objective's end may lead; nowhere if it does not run, or cannot end so."""
        if isinstance(at, tuple):
            found, levels = set[Place](), self.branches[at[0]]
            for i, (level, inside) in enumerate(zip(levels, at[1], strict=True)):
                for after in level.ended(inside, objective, outcome):
                    found |= self.decided(at[0], (*at[1][:i], after, *at[1][i + 1 :]))
            return found
        routes = self.sections[at]["routes"].get(outcome, []) if at == objective and at not in EXITS else []
        return set(map(self.enter, routes))

    def decided(self, block: str, branches: tuple[Place, ...]) -> set[Place]:
        """A block in which branches have ended: it goes on, or is left."""
        section = self.sections[block]
        well, badly = branches.count("succeed"), branches.count("fail")
        must = [where for where, each in zip(branches, section["branches"], strict=True) if each["mandatory"]]
        over = well + badly == len(branches)
        whole = section["needed"] > len(branches)  # all are awaited
        if "abort" in branches:
            outcome = "abort"
        elif well >= section["needed"] or (whole and over and all(where == "succeed" for where in must)):
            outcome = "success"
        elif over or badly >= section["failing"] or (section["hasty"] and "fail" in must):
            outcome = "failure"
        else:
            return {(block, branches)}
        return set(map(self.enter, section["routes"].get(outcome, [])))

    def happens(self, at: Place, event: str, before: frozenset[str]) -> set[tuple[Place, frozenset[str]]]:
        """Where a declared event may lead, and what has happened then; nowhere if nothing handles it."""
        if at in EXITS:
            return set()
        name = at[0] if isinstance(at, tuple) else at
        if isinstance(at, tuple):
            each = [
                (level.happens(inside, event, before), inside)
                for level, inside in zip(self.branches[name], at[1], strict=True)
            ]
            if any(moved for moved, _ in each):
                found = set[tuple[Place, frozenset[str]]]()
                for chosen in product(*(moved or {(inside, before)} for moved, inside in each)):
                    now = before.union(*(had for _, had in chosen))
                    found |= {(to, now) for to in self.decided(name, tuple(to for to, _ in chosen))}
                return found
        for handler in self.sections[name]["handlers"]:
            if handler["event"] == event and handler["once"] not in before:
                now = before | ({handler["once"]} if handler["once"] else set())
                return {(self.enter(to), now) for to in handler["to"]}
        return set()


Core = tuple[Place, frozenset[str]]
"""Where the mission is (``begin`` before the start), and the handlers that happen once and have."""


def after(mission: CoreGraph, core: Core, event: tuple[str, ...]) -> set[Core]:
    """What the objectives graph allows to be after an event; nothing if the event cannot happen there."""
    (at, had), (what, element) = core, event[:2]
    if what == "start":
        return {(mission.enter(mission.entry), had)} if at == "begin" else set()
    if at == "begin":
        return {core} if what in ("out of service", "repaired", "declared") else set()
    if what in ("success", "failure", "timeout"):
        outcome = f"failure {event[2]}" if len(event) > 2 else what
        return {(to, had) for to in mission.ended(at, element, outcome)}
    return (mission.happens(at, element, had) if what == "declared" else set()) or {core}


def walked(graph: certcheck.Listing, mission: CoreGraph) -> tuple[int, int]:
    """Walks net and objectives graph in pairs; how many pairs there are, and how many events they have.

    Raises:
        certcheck.Refuted: The net does something else.
    """
    running, shown = by_state(graph, "objective"), by_state(graph, "objective", "pending")
    ends = {role: graph.saying(role) for role in ("begin", *EXITS.values())}
    ended = [frozenset(role for role, states in ends.items() if s in states) for s in range(len(shown))]

    @cache
    def says(core: Core) -> tuple[frozenset[str], frozenset[str]]:
        """The objectives that run, or are about to, and how the mission has ended, if it has."""
        if core[0] == "begin" or core[0] in EXITS:
            return frozenset(), frozenset([EXITS.get(str(core[0]), "begin")])
        return frozenset(mission.running(core[0])), frozenset()

    @cache
    def onward(core: Core, event: tuple[str, ...]) -> set[Core]:
        return after(mission, core, event)

    @cache
    def due(core: Core, running: frozenset[str]) -> set[tuple[str, ...]]:
        """Events that must be possible: all ends of what runs but success, and what is handled."""
        return set() if core[0] == "begin" else {*mission.due(core[0], running, core[1])}

    first: Core = ("begin", frozenset())
    certcheck.need((shown[0], ended[0]) == says(first), "state 0 is not one before the start")
    met, todo, events = {(0, first)}, [(0, first)], 0
    for state, core in todo:  # grows while it is walked
        graph.within(len(met))
        here = ", ".join(sorted(shown[state])) or "no objective"
        for t, target in graph.edges[state]:
            event, seen = graph.net.event[t], (shown[target], ended[target])
            left = [each for each in onward(core, event) if says(each) == seen]
            said = ", ".join(sorted(shown[target] | ended[target])) or "nothing"
            certcheck.need(left, f"{here}: after {' '.join(event)} the net says {said}, the mission does not")
            events += 1
            for pair in ((target, each) for each in left):
                if pair not in met:
                    met.add(pair)
                    todo.append(pair)
        missing = due(core, running[state]) - {graph.net.event[t] for t, _ in graph.edges[state]}
        certcheck.need(not missing, f"{here}: the net lacks {' '.join(min(missing, default=()))}")
    return len(met), events


def by_state(graph: certcheck.Listing, *roles: str) -> list[frozenset[str]]:
    """Of each state the elements that it marks with some roles."""
    places = [(places, own) for (role, own), places in graph.net.roles.items() if role in roles]
    return [frozenset(own for on, own in places if marking & on) for marking in graph.stable]


def checked(path: str, seconds: float = 600, most: int = 2_000_000) -> tuple[int, int]:
    """Checks the objectives of a certificate; how many pairs and events there are.

    Raises:
        certcheck.Malformed: It has no entry that can be understood.
        certcheck.Refuted: The net does something else.
        certcheck.Limit: A limit was hit.
    """
    until, entries = time.monotonic() + seconds, certcheck.unpacked(path)
    shape = {**certcheck.FORMAT, "graph": dict}
    core = certcheck.shaped(certcheck.parsed(entries, "core.json"), shape, "core.json")
    mission = CoreGraph(core["graph"], "core.json: graph")
    net = certcheck.Net(certcheck.parsed(entries, "net.json"))
    return walked(certcheck.Listing(net, most, until), mission)


def main(arguments: list[str] | None = None) -> int:
    """Checks the certificate that the command line names, and prints what became of it."""
    parser = argparse.ArgumentParser("corecheck", description="Plays objectives beside a certificate's net.")
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
    line = f"objectives  {said}".encode("ascii", "backslashreplace").decode()
    sys.stdout.write(line.translate(dict.fromkeys(range(32), "?")) + "\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
