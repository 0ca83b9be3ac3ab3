"""sectionctl: checks a controller of many sections against a core mission, each type of section once.

``python sectionctl.py CERTIFICATE controller.json`` reads the entry ``core.json`` of a certificate, and a
controller. Sections that are alike in the mission, and in the controller, are walked once: in pairs of states
of the section alone and of the controller's type, from every status of hardware, as ctlcheck walks states of
a net. That sections are glued at the status of hardware alone is checked, too (papers/mcpn.md has the proof).
It needs sectioncheck.py, ctlcheck.py, and what these need beside it. Exit codes are those of ``certcheck``.
"""

from __future__ import annotations

import sys
import time
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

try:
    from mcpn.certificates import certcheck, ctlcheck, ctlforms
    from mcpn.certificates.coregraph import Event, Json
    from mcpn.certificates.corerobot import Names
    from mcpn.certificates.sections import sectioncheck
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]
    import ctlcheck  # type: ignore[import-not-found, no-redef]
    import ctlforms  # type: ignore[import-not-found, no-redef]
    import sectioncheck  # type: ignore[import-not-found, no-redef]
    from coregraph import Event, Json  # type: ignore[import-not-found, no-redef]
    from corerobot import Names  # type: ignore[import-not-found, no-redef]

NONE: frozenset[str] = frozenset()
SAID = {
    "objective": "objectives",
    "pending": "pending",
    "done": "done",
    "active": "mode",
    "waits": "waiting",
    "refused": "refused",
}
"""By what a core mission says of an element the key of a controller's state that says it."""
KINDS = {key: kind for key, (kind, _) in ctlforms.SHOWN.items()}
KINDS |= {"objective": "objectives", "activity": "activities", "hardware": "hardware"}
KINDS |= {"once": "once", "facts": "facts", "out_of_service": "hardware"}
"""By key of a controller's document the kind of the names that stand there."""


class ControllerAlone(ctlforms.WalkedController):
    """One section of a controller, which it leaves for a target of its routes, whatever comes there."""

    def entered(
        self, route: str, gone: frozenset[str], true: frozenset[str]
    ) -> tuple[ctlforms.ControllerState, list[ctlforms.Action]]:
        """Behind the section nothing is known but where it has led to."""
        return ctlforms.ControllerState(left_for(route), "", 0, gone, true), []

    def begun(
        self, section: str, gone: frozenset[str]
    ) -> tuple[ctlforms.ControllerState, list[ctlforms.Action]]:
        """Where the section is entered with some hardware out of service."""
        try:
            return super().entered(section, gone, NONE)
        except certcheck.Refuted as error:  # perhaps the mission never enters it so
            raise certcheck.Limit(f"{section}, entered without {sorted(gone)}: {error}") from None


def left_for(target: str) -> str:
    """The phase of a controller alone that has left its section."""
    return f"left for {target}"


def names_in(row: Json, key: str = "") -> Iterator[tuple[str, str]]:
    """The names in a type of a controller, each with its kind; activities with alternatives together."""
    if isinstance(row, dict):
        if "kind" in row:
            yield KINDS[row["kind"]], row["name"]
        if "alternative" in row:
            yield "alternatives", f"{row['activity']}.{row['alternative']}"
        for inside, value in row.items():
            if KINDS.get(inside) == "alternatives" and isinstance(value, dict):
                yield from (("alternatives", f"{activity}.{way}") for activity, way in value.items())
            else:
                yield from names_in(value, inside)
    elif isinstance(row, list):
        for each in row:
            yield from names_in(each, key)
    elif isinstance(row, str) and key in KINDS:
        yield KINDS[key], row


class ControllerBySections:
    """A controller beside the sections of a core mission.

    Args:
        played: The sections.
        document: The controller's document.
    """

    def __init__(
        self, played: sectioncheck.PlayedSections, document: Json, budget: sectioncheck.Budget
    ) -> None:
        self.played, self.document, self.budget = played, document, budget
        self.sections = {each["name"]: each for each in document["sections"]}
        certcheck.need(
            len(self.sections) == len(document["sections"]), "a section is there twice", certcheck.Malformed
        )
        ctlforms.numbers([each["type"] for each in document["sections"]], len(document["types"]))
        self.used = [sorted({*names_in(row)}) for row in document["types"]]
        self.robots = {*document["all_hardware"]} - {*document["crashing"], *document["common_causes"]}
        self.of_hardware = {
            ctlcheck.text_of((what, name)): name
            for name in document["hardware"]
            for what in ("out of service", "repaired")
        }
        self.timed = defaultdict[str, list[str]](list)
        for name, block in document.get("blocks", {}).items():
            for objective in block["objectives"]:
                self.timed[objective].append(name)

    def walked(self) -> tuple[int, int, int]:
        """The numbers of pairs, events and types of sections that are walked; Refuted if one differs."""
        certcheck.need(self.document["form"] != "flat", "a flat controller has no sections", certcheck.Limit)
        self.robot_is_the_missions()
        pairs, events, known = 0, 0, set[Any]()
        for name in sorted(self.played.reached):
            self.budget.within(0)
            certcheck.need(name in self.sections, f"{name}: the controller has no such section")
            self.section_is_the_missions(name)
            key = self.key(name)
            if key not in known:
                known.add(key)
                more = WalkedAlone(self, name).walked()
                pairs, events = pairs + more[0], events + more[1]
        return pairs, events, len(known)

    def robot_is_the_missions(self) -> None:
        """Refutes the controller unless what all its sections share is the mission's."""
        document, robot = self.document, self.played.robot
        fails = {name for name, each in robot.hardware.items() if each["faulty"]}
        out = {name for name, each in robot.hardware.items() if each["out"]}
        stays = {name for name in fails if not robot.hardware[name]["repairable"]}
        crash = {name for name, each in robot.hardware.items() if each["crash"]}
        words = "hardware is out of service at first that never fails"
        certcheck.need(out <= fails, words, certcheck.Limit)
        ctlcheck.same("hardware may fail", fails, set(document["hardware"]))
        ctlcheck.same("hardware is never repaired", stays, set(document["unrepairable"]))
        ctlcheck.same("hardware is out of service at first", out, set(document["out_of_service"]))
        ctlcheck.same("hardware fails only as it is used", crash & fails, set(document["crashing"]))
        asked = {*document["late"], *document["facts"], *document["changing"]}
        certcheck.need(not asked, "the controller asks facts, or what is detected late")
        certcheck.need(document["initial"] == self.played.entry, "another section is the first one")
        reached = (self.played.names[section] for section in self.played.reached)
        for name in {old for names in reached for kind, old in names if kind == "a"}:
            certcheck.need(name in document["activities"], f"there is no activity {name}")
            in_core = ctlcheck.use_in_core(robot.activities[name])
            ctlcheck.same_use(name, in_core, document["activities"][name])

    def section_is_the_missions(self, name: str) -> None:
        """Refutes the controller unless objectives and timers of a section are the mission's."""
        objectives, blocks = self.document["objectives"], self.document.get("blocks", {})
        names = self.played.names[name]
        foreign = {
            self.of_hardware[text] for text in self.sections[name]["events"] if text in self.of_hardware
        }
        fine = all(("k", hardware) in names for hardware in foreign)
        certcheck.need(fine, f"{name}: the controller waits for hardware that the section cannot use")
        for section in every_section(self.played.sections[name]):
            own, timed = section["name"], "timeout" in section["routes"]
            if "activities" in section:
                found = objectives.get(own)
                fine = found is not None and sorted(found["activities"]) == sorted(section["activities"])
                fine = fine and (found["timeout"] is not None) == timed
                certcheck.need(fine, f"the objective {own} has other activities, or a timer")
            else:
                inside = {o["name"] for each in section["branches"] for o in objectives_in(each["graph"])}
                there = blocks[own]["objectives"] if own in blocks else []
                fine = (own in blocks) == timed and (not timed or {*there} == inside)
                certcheck.need(fine, f"the block {own} has other objectives, or a timer")

    def key(self, name: str) -> Any:
        """What the walk of a section depends on: the same of sections that differ in names alone."""
        played, section, names = self.played.type[name], self.sections[name], self.played.names[name]
        of = section["names"]
        used = [
            self.renamed(names, kind, of.get(kind, {}).get(own, own))
            for kind, own in self.used[section["type"]]
        ]
        texts = {ctlcheck.text_of(self.event(name, event)): event for event in played.events}
        events = [texts.get(text, text) for text in section["events"]]
        targets = {old: new for new, old in self.played.targets[name].items()}
        routes = sorted((outcome, targets.get(to, f"?{to}")) for outcome, to in section["routes"].items())
        held = sorted(new for (kind, old), new in names.items() if kind == "k" and old in self.robots)
        return id(played), section["type"], tuple(used), tuple(events), tuple(routes), tuple(held)

    def renamed(self, names: dict[tuple[str, str], str], kind: str, name: str) -> Any:
        """What a name in the controller is called in the section that is played."""
        match kind:
            case "hardware":
                return names.get(("k", name), f"?{name}")
            case "activities":
                return names.get(("a", name), f"?{name}")
            case "objectives":  # of branches, too
                both = names.get(("s", name)), names.get(("b", name))
                return both if any(both) else f"?{name}"
            case "alternatives":
                ways = self.played.ways_named(name)
                own = tuple((names["a", of], number) for of, number in ways if ("a", of) in names)
                return own or f"?{name}"
        return f"?{name}"

    def event(self, name: str, event: Event) -> tuple[str, ...]:
        """An event of a section that is played, in the names of the section."""
        what, element, *reason = event
        return what, self.old(name).get(element, element), *reason

    def old(self, name: str) -> dict[str, str]:
        """The names of a section, by those with which it is played."""
        return {new: old for (_, old), new in self.played.names[name].items()}

    def alone(self, name: str) -> Json:
        """The document of a controller of this section alone."""
        document, section, names = self.document, self.sections[name], self.played.names[name]
        local = {old for kind, old in names if kind == "k"}
        kept = {old for kind, old in names if kind == "s"}
        blocks = {block for objective in kept for block in self.timed.get(objective, ())}
        return {
            **document,
            "hardware": [each for each in document["hardware"] if each in local],
            "out_of_service": [],
            "blocks": {each: document["blocks"][each] for each in blocks},
            "types": [document["types"][section["type"]]],
            "sections": [{**section, "type": 0}],
        }


def every_section(section: Json) -> Iterator[Json]:
    """A section, and those in it, at any depth."""
    yield section
    for each in (*section.get("branches", ()), *section.get("pauses", ())):
        for inner in each["graph"]["sections"]:
            yield from every_section(inner)


def objectives_in(graph: Json) -> Iterator[Json]:
    """The objectives in the sections of a graph."""
    for section in graph["sections"]:
        yield from sectioncheck.objectives_of(section)


class WalkedAlone:
    """A section of the controller beside the same of the mission, both alone."""

    def __init__(self, whole: ControllerBySections, name: str) -> None:
        self.whole, self.name, self.played = whole, name, whole.played.type[name]
        self.old, self.targets = whole.old(name), whole.played.targets[name]
        self.controller = ControllerAlone(whole.alone(name))
        row, own = self.controller.types[name].row, self.controller.types[name].own
        words = f"{name}: the controller looks at facts, or at hardware that the section cannot use"
        fine = not row["once"] and not row["facts"] and {*own} <= {*self.old.values()}
        certcheck.need(fine, words, certcheck.Limit)

    def hardware(self, out: Names) -> frozenset[str]:
        """Hardware in the names of the section."""
        return frozenset(self.old[name] for name in out)

    def walked(self) -> tuple[int, int]:
        """How many pairs and events there are."""
        todo, taken = list[tuple[int, ctlforms.ControllerState]](), 0
        idle = ctlforms.ControllerState("before", "", 0, NONE, NONE)
        for out, number in self.played.entries.items():
            then, actions = self.controller.begun(self.name, self.hardware(out))
            ctlcheck.followed(self.controller, idle._replace(gone=then.gone), then, actions, "")
            todo.append((number, then))
        met = set(todo)
        for number, state in todo:  # grows while it is walked
            self.whole.budget.within(1)
            try:
                self.alike(number, state)
                for pair in self.onward(number, state):
                    taken += 1
                    if pair is not None and pair not in met:
                        met.add(pair)
                        todo.append(pair)
            except certcheck.Refuted as error:
                raise certcheck.Refuted(f"{self.name}, state {state.at}: {error}") from None
        return len(met), taken

    def alike(self, number: int, state: ctlforms.ControllerState) -> None:
        """Refutes the controller unless both say the same."""
        core = self.played.states[number]
        ctlcheck.same("hardware is out of service", {*self.hardware(core.out)}, state.gone)
        certcheck.need(not state.true, "something has happened, or is true")
        said: dict[str, set[str]] = {key: set() for key in ctlforms.SHOWN}
        for role, element in self.played.mission.says(core):
            if role in ("active", "waits"):
                name, _, way = element.rpartition(".")
                ways = self.whole.played.robot.ways(self.old[name])
                said[SAID[role]].add(f"{self.old[name]}.{ways[int(way)]['name']}")
            elif role in SAID:
                said[SAID[role]].add(self.old[element])
        for key, names in self.controller.shown(state).items():
            ctlcheck.same(key, said[key], names)

    def onward(
        self, number: int, state: ctlforms.ControllerState
    ) -> Iterator[tuple[int, ctlforms.ControllerState] | None]:
        """The pairs after a pair, none where the section is left; both must have the same events."""
        after = dict[str, tuple[Event, int | str]]()
        edges: list[tuple[Event, int | str]] = [*self.played.edges[number], *self.played.exits[number]]
        for event, target in edges:
            after[ctlcheck.text_of(self.whole.event(self.name, event))] = event, target
        moves = {event: (then, actions) for event, then, actions in self.controller.onward(state)}
        ctlcheck.same("events", set(after), moves.keys())
        for text, (then, actions) in moves.items():
            event, target = after[text]
            ended = ctlcheck.ended_by(self.whole.event(self.name, event))
            try:
                ctlcheck.followed(self.controller, state, then, actions, ended)
            except certcheck.Refuted as error:
                raise certcheck.Refuted(f"{text}: {error}") from None
            if isinstance(target, str):
                there = ctlforms.ControllerState(left_for(self.targets[target]), "", 0, state.gone, NONE)
                certcheck.need(then == there, f"{text}: the controller leads elsewhere")
                yield None
            else:
                certcheck.need(then.phase == "running", f"{text}: the controller leaves the section")
                yield target, then


def checked(
    certificate: str, controller: str, *, most: int = sectioncheck.MOST_STATES, seconds: float = 600
) -> certcheck.Report:
    """Checks a controller against a core mission; raises Malformed and Limit as certcheck does."""
    budget = sectioncheck.Budget(most, time.monotonic() + seconds)
    core = certcheck.parsed(certcheck.unpacked(certificate), "core.json")
    played = sectioncheck.PlayedSections(core, budget)

    def walk(document: Json) -> str:
        pairs, events, types = ControllerBySections(played, document, budget).walked()
        return f"{len(played.reached)} sections, {types} of them walked: {pairs} pairs, {events} events"

    return ctlcheck.reported(controller, walk)


def main(arguments: list[str] | None = None) -> int:
    """Checks the controller that the command line names against the core mission of a certificate."""
    words = "Checks a hierarchical or modular controller against a core mission, by types of sections."
    return certcheck.ran(checked, words, arguments, "certificate", "controller")


if __name__ == "__main__":
    sys.exit(main())
