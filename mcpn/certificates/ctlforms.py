"""The controllers that ctlcheck walks, stepped by their documents: tables of states, or rules on bits.

A type of sections is placed in each of its sections, with the section's own names. A machine is a table of
states with edges; a modular controller has rules: the state of a section is a number, whose bits they ask for
and change. Hardware, facts and handlers that happen once are kept beside. How a document is run is written in
docs/controller.md and docs/formats.md; this file follows them, and imports nothing of mcpn but certcheck.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
except ImportError:  # alone, beside the other files
    import certcheck  # type: ignore[import-not-found, no-redef]

Json = Any
Action = tuple[str, Json]
"""In which section it stands, and the action."""
ENDS = {"succeed": "success", "fail": "failure", "abort": "abort"}
MOST_BITS = 1_000_000
"""Bits of a state of rules."""
SHOWN = {
    "objectives": ("objectives", ("objective",)),
    "pending": ("objectives", ("pending",)),
    "done": ("objectives", ("done",)),
    "mode": ("alternatives", ("active",)),
    "waiting": ("alternatives", ("wait", "want")),
    "refused": ("activities", ("refused",)),
}
"""By key of a state of the document the kind of its names, and the roles of places that say the same."""


class ControllerState(NamedTuple):
    """A state of the controller.

    Args:
        phase: ``before``, ``running``, or how the mission has ended.
        section: The section that runs; empty where none does.
        at: The state of its type.
        gone: Hardware out of service.
        true: Facts, and handlers that have happened once.
    """

    phase: str
    section: str
    at: int
    gone: frozenset[str]
    true: frozenset[str]


class Taken(NamedTuple):
    """What an event, or the entry, does in a section.

    Args:
        to: The state of its type, or the outcome with which the section is left.
        actions: In order.
        true: What is true then, in the names of the mission.
    """

    to: int | str
    actions: list[Json]
    true: frozenset[str]


class PlacedType:
    """The type of a section, with the section's own names; where it is, is a number.

    Args:
        row: The type, as the document says it.
        section: The section.
    """

    def __init__(self, row: Json, section: Json) -> None:
        self.row, self.names = row, section["names"]
        self.own = [self.named("hardware", name) for name in row["hardware"]]
        self.once = [self.named("once", name) for name in row["once"]]
        self.facts = [self.named("facts", name) for name in row["facts"]]

    def named(self, kind: str, name: str) -> str:
        """The section's element that its type calls so."""
        found: str = self.names.get(kind, {}).get(name, name)
        return found

    def entry(self, gone: frozenset[str], true: frozenset[str]) -> Taken:
        """Where it is entered."""
        raise NotImplementedError

    def move(self, at: int, event: int, true: frozenset[str]) -> Taken | None:
        """What an event of the type does, if it is possible."""
        raise NotImplementedError

    def said(self, at: int, gone: frozenset[str], true: frozenset[str]) -> Json:
        """What the state says: by kind names, with what is out of service and true beside it."""
        raise NotImplementedError


class PlacedTable(PlacedType):
    """A machine: a table of states, with edges by event."""

    def __init__(self, row: Json, section: Json) -> None:
        super().__init__(row, section)
        self.moves: list[dict[int, list[Json]]] = [{} for _ in row["states"]]
        for edge in row["edges"]:
            numbers([edge["from"]], len(row["states"]))
            if not isinstance(edge["to"], str):
                numbers([edge["to"]], len(row["states"]))
            self.moves[edge["from"]].setdefault(edge["event"], []).append(edge)
            part(edge["open"] + edge["happened"], row["once"])
        entries = [entry for entry in row["entries"] if entry]
        numbers([entry["to"] for entry in entries], len(row["states"]))
        for each in (*entries, *row["edges"]):
            part(each["gained"] + each["lost"], row["facts"])

    def flags(self, item: Json, key: str) -> frozenset[str]:
        """The facts, and handlers that happen once, that an entry or an edge names."""
        once = self.row["once"]
        return frozenset(self.named("once" if n in once else "facts", n) for n in item[key])

    def entry(self, gone: frozenset[str], true: frozenset[str]) -> Taken:
        """Where it is entered: the entry of what is out of service and true."""
        number = sum((name in gone) << i for i, name in enumerate(self.own))
        for i, name in enumerate(self.facts[: self.row["entering"]]):
            number |= (name in true) << len(self.own) + i
        entry = self.row["entries"][number]
        certcheck.need(entry, "a section cannot be entered like this")
        true = (true | self.flags(entry, "gained")) - self.flags(entry, "lost")
        return Taken(entry["to"], entry["actions"], true)

    def move(self, at: int, event: int, true: frozenset[str]) -> Taken | None:
        """What an event does, by the one edge whose handlers allow it."""
        fits = [
            edge
            for edge in self.moves[at].get(event, ())
            if not self.flags(edge, "open") & true and self.flags(edge, "happened") <= true
        ]
        certcheck.need(len(fits) <= 1, "several edges can be taken on one event")
        for edge in fits:
            gained = self.flags(edge, "open") | self.flags(edge, "gained")
            return Taken(edge["to"], edge["actions"], (true | gained) - self.flags(edge, "lost"))
        return None

    def said(self, at: int, gone: frozenset[str], true: frozenset[str]) -> Json:
        """The state's row."""
        row = self.row["states"][at]
        out = {self.named("hardware", name) for name in row["out_of_service"]}
        certcheck.need(out == gone & set(self.own), "a state says that other hardware is out of service")
        return row


Condition = tuple[int, int]
"""Of the bits of the first number exactly those of the second are set."""


class PlacedRules(PlacedType):
    """Rules on states that are sets of bits, held as numbers."""

    def __init__(self, row: Json, section: Json) -> None:
        super().__init__(row, section)
        self.bits = bits = row["bits"]
        numbers([bits], MOST_BITS + 1)
        self.idle = mask(row["idle"], bits)
        self.status = [(mask(s["changes"], bits), condition([s["when"]], bits)) for s in row["status"]]
        self.shown = [(s["kind"], s["name"], condition([s["when"]], bits)) for s in row["shown"]]
        known = all(kind in SHOWN for kind, _, _ in self.shown)
        certcheck.need(known, "a state of a type shows something of no kind", certcheck.Malformed)
        certcheck.need(
            len(self.status) == len(self.own) + len(self.once) + len(self.facts),
            "a type has not one status of each of its hardware, handlers and facts",
            certcheck.Malformed,
        )
        self.effects = [(mask(e["changes"], bits), e) for e in row["effects"]]
        for _, effect in self.effects:
            numbers(effect["then"], len(row["parts"]))
        self.entries = [self.rule(each, bits) for each in row["entries"]]
        self.rules: list[list[tuple[Condition, int]]] = [[] for _ in row["events"]]
        for each in row["rules"]:
            numbers([each["event"]], len(self.rules))
            self.rules[each["event"]].append(self.rule(each, bits))
        self.parts = [[self.rule(each, 2 * bits) for each in part] for part in row["parts"]]
        certcheck.need(
            not any(self.effects[effect][1]["then"] for part in self.parts for _, effect in part),
            "a part goes on with parts",
            certcheck.Malformed,
        )

    def so(self, gone: frozenset[str], true: frozenset[str]) -> list[bool]:
        """Of each status, whether it is out of service, has happened, or is true."""
        return [name in gone for name in self.own] + [name in true for name in self.once + self.facts]

    def rule(self, rule: Json, bits: int) -> tuple[Condition, int]:
        """When a rule fits, and the number of its effect."""
        numbers([rule["do"]], len(self.effects))
        return condition(rule["if"], bits), rule["do"]

    def entry(self, gone: frozenset[str], true: frozenset[str]) -> Taken:
        """Where it is entered from its idle bits, changed by what is out of service and true."""
        state = self.idle
        for (changes, _), so in zip(self.status, self.so(gone, true), strict=True):
            state ^= changes * so
        taken = self.taken(self.entries, state, true)
        certcheck.need(taken, "a section cannot be entered like this")
        assert taken is not None
        return taken

    def move(self, at: int, event: int, true: frozenset[str]) -> Taken | None:
        """What an event does, by a rule that fits."""
        return self.taken(self.rules[event], at, true)

    def taken(self, rules: list[tuple[Condition, int]], state: int, true: frozenset[str]) -> Taken | None:
        """What the rules that fit do, all the same, and the parts that follow; nothing where none fits."""
        fits = [effect for when, effect in rules if holds(state, when)]
        if not fits:
            return None
        changes, effect = self.effects[fits[0]]
        certcheck.need(
            all(self.effects[other][1] == effect for other in fits), "rules of one event do different things"
        )
        after, actions, outcomes = state ^ changes, list(effect["actions"]), {effect["to"]}
        for part in effect["then"]:
            both = state | after << self.bits
            for when, number in self.parts[part]:
                if holds(both, when):
                    changes, effect = self.effects[number]
                    after ^= changes
                    actions += effect["actions"]
                    outcomes.add(effect["to"])
                    break
        left = outcomes - {None}
        certcheck.need(len(left) <= 1, "a section is left with two outcomes at once")
        status = zip(self.once + self.facts, self.status[len(self.own) :], strict=True)
        said = {name for name, (_, when) in status if holds(after, when)}
        return Taken(left.pop() if left else after, actions, true - set(self.facts) | said)

    def said(self, at: int, gone: frozenset[str], true: frozenset[str]) -> Json:
        """What literals say of the state."""
        agree = [holds(at, when) for _, when in self.status] == self.so(gone, true)
        certcheck.need(agree, "bits say something else of hardware, handlers or facts")
        row: Json = {kind: {} if kind in ("mode", "waiting") else [] for kind in SHOWN}
        for kind, name, when in self.shown:
            if holds(at, when) and isinstance(row[kind], list):
                row[kind].append(name)
            elif holds(at, when):
                activity, way = name.split(".", 1)
                certcheck.need(activity not in row[kind], f"{activity} has two alternatives at once")
                row[kind][activity] = way
        return row


def numbers(found: list[Json], below: int) -> list[int]:
    """Numbers, which must be whole, not below 0 and below a bound."""
    fine = all(type(each) is int and 0 <= each < below for each in found)
    certcheck.need(
        fine, f"found {str(found)[:60]}, expected numbers from 0, below {below}", certcheck.Malformed
    )
    return found


def part(names: list[str], whole: list[str]) -> None:
    """Malformed unless all names are among some."""
    certcheck.need(
        set(names) <= set(whole), f"found {names}, expected some of {whole}"[:200], certcheck.Malformed
    )


def mask(bits: list[Json], below: int) -> int:
    """Bits as a number."""
    return sum(1 << bit for bit in set(numbers(bits, below)))


def condition(literals: list[Json], bits: int) -> Condition:
    """What literals ask: 2 i that bit i is not set, 2 i + 1 that it is; no bit twice."""
    asked = [literal >> 1 for literal in numbers(literals, 2 * bits)]
    certcheck.need(len(set(asked)) == len(asked), "a rule asks for one bit twice", certcheck.Malformed)
    return mask(asked, bits), mask([literal >> 1 for literal in literals if literal & 1], bits)


def holds(state: int, when: Condition) -> bool:
    """Whether a condition holds in a state."""
    return state & when[0] == when[1]


class WalkedController:
    """A controller: sections, each of a type, and the hardware, facts and handlers that all share."""

    def __init__(self, document: Json) -> None:
        self.document = document
        self.failing = set(document["hardware"])
        self.repairable = self.failing - set(document["unrepairable"])
        self.late, self.crashing = document["late"], set(document["crashing"])
        self.sections = {section["name"]: section for section in document["sections"]}
        self.own = {name: {e: i for i, e in enumerate(s["events"])} for name, s in self.sections.items()}
        activities = document["activities"].values()
        self.producers = dict[str, set[str]]()
        for name, activity in document["activities"].items():
            for each in activity["produces"]:
                self.producers.setdefault(each, set()).add(name)
        there = {*document["all_hardware"], *self.producers}
        consumed = {
            x for each in activities for way in each["alternatives"].values() for x in way["consumes"]
        }
        words = f"controller: neither hardware nor produced: {sorted(consumed - there)}"
        certcheck.need(consumed <= there, words, certcheck.Malformed)
        of = PlacedRules if document["form"] == "modular" else PlacedTable
        numbers([section["type"] for section in document["sections"]], len(document["types"]))
        self.types = {name: of(document["types"][s["type"]], s) for name, s in self.sections.items()}
        self.known = dict[ControllerState, dict[str, set[str]]]()

    def first(self) -> ControllerState:
        """Before the mission starts."""
        gone = frozenset(self.document["out_of_service"])
        return ControllerState("before", "", 0, gone, frozenset(self.late[h] for h in gone if h in self.late))

    def entered(
        self, route: str, gone: frozenset[str], true: frozenset[str]
    ) -> tuple[ControllerState, list[Action]]:
        """Where a route leads: to an end, or into a section, by what is out of service and what is true."""
        if route in ENDS:
            return ControllerState(ENDS[route], "", 0, gone, true), []
        to, actions, true = self.types[route].entry(gone, true)
        certcheck.need(isinstance(to, int), f"{route} is left as it is entered")
        return ControllerState("running", route, int(to), gone, true), [(route, each) for each in actions]

    def onward(self, state: ControllerState) -> Iterator[tuple[str, ControllerState, list[Action]]]:
        """Each event that is possible, with the state after it and its actions."""
        own = self.own.get(state.section, {})
        for event, number in own.items():
            found = self.own_move(state, event, number)
            if found is not None:
                yield event, *found
        for name in sorted(self.failing):
            if (
                name not in state.gone
                and name not in self.crashing
                and (event := f"{name}_EV_OOS") not in own
            ):
                yield event, state._replace(gone=state.gone | {name}), []
            known = self.late.get(name)
            back = name in state.gone and name in self.repairable and (known is None or known in state.true)
            if back and (event := f"{name}_EV_RD") not in own:
                yield event, state._replace(gone=state.gone - {name}, true=state.true - {known}), []
        for event, change in self.document["changing"].items():
            true = (state.true | set(change["true"])) - set(change["false"])
            if event not in own and true != state.true:
                yield event, state._replace(true=true), []
        if state.phase == "before":
            yield "MISSION_EV_START", *self.entered(self.document["initial"], state.gone, state.true)

    def own_move(
        self, state: ControllerState, event: str, number: int
    ) -> tuple[ControllerState, list[Action]] | None:
        """What an event of the section's type does."""
        section, gone = state.section, state.gone
        if (taken := self.types[section].move(state.at, number, state.true)) is None:
            return None
        if event.endswith("_EV_OOS") and event[:-7] in self.failing:
            gone |= {event[:-7]}
        elif event.endswith("_EV_RD"):
            gone -= {event[:-6]}
        actions = [(section, each) for each in taken.actions]
        if isinstance(taken.to, int):
            return ControllerState("running", section, taken.to, gone, taken.true), actions
        after, more = self.entered(self.sections[section]["routes"][taken.to], gone, taken.true)
        return after, actions + more

    def shown(self, state: ControllerState) -> dict[str, set[str]]:
        """What the state says, by key, in the names of the mission."""
        if state in self.known:
            return self.known[state]
        shown: dict[str, set[str]] = {key: set() for key in SHOWN}
        if state.section:
            type_ = self.types[state.section]
            said = type_.said(state.at, state.gone, state.true)
            for key, (kind, _) in SHOWN.items():
                words = said[key].values() if kind == "alternatives" else said[key]
                fine = all(isinstance(each, str) for each in words)
                certcheck.need(fine, f"a state says in {key} what is no text", certcheck.Malformed)
                names = (
                    [f"{a}.{way}" for a, way in said[key].items()] if kind == "alternatives" else said[key]
                )
                shown[key] = {type_.named(kind, name) for name in names}
        self.known[state] = shown
        return shown

    def facts(self, state: ControllerState) -> set[str]:
        """The value of each fact, as ``fact=value``."""
        return {
            f"{fact}={value}"
            for fact, values in self.document["facts"].items()
            for value, true in values.items()
            if set(true) == state.true & {flag for flags in values.values() for flag in flags}
        }

    def running(self, state: ControllerState) -> dict[str, str]:
        """The alternative of each activity that runs."""
        return dict(mode.split(".", 1) for mode in self.shown(state)["mode"])

    def timed(self, state: ControllerState) -> set[str]:
        """The objectives and blocks whose timers run."""
        shown = self.shown(state)
        here, blocks = shown["objectives"] | shown["pending"], self.document.get("blocks", {})
        timed = {
            name for name in shown["objectives"] if self.document["objectives"][name]["timeout"] is not None
        }
        return timed | {name for name, block in blocks.items() if here & {*block["objectives"]}}
