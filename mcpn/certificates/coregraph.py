"""coregraph: where the objectives graph of a core mission is, and where an event leads; corecheck plays it.

It reads the member ``graph`` of the entry ``core.json`` as docs/certificates.md describes it. It needs
certcheck.py and corerobot.py beside it, and Python's standard library.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
    from mcpn.certificates.corerobot import Facts, Names, so
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]
    from corerobot import Facts, Names, so  # type: ignore[import-not-found, no-redef]

Json = dict[str, Any]
Event = tuple[str, ...]


class AtObjective(NamedTuple):
    """A graph is at an objective, which ``enters``, ``waits`` to begin, ``runs`` or has ``halted``."""

    name: str
    state: str


class InBlock(NamedTuple):
    """A graph is in a block.

    Args:
        name: The block.
        entered: Whether the event has just led there.
        phases: Each with its number and where its graphs are: 0 and the branches, then what runs while the
            block pauses, by its number from 1. The last one is under way.
    """

    name: str
    entered: bool
    phases: tuple[tuple[int, tuple[Any, ...]], ...]

    @property
    def phase(self) -> int:
        """The number of that under way."""
        return self.phases[-1][0]


Place = str | AtObjective | InBlock
"""Where a graph is: at an exit, at an objective or in a block."""
ENDS = {"succeed": "success", "fail": "failure", "abort": "abort"}
CASE = {"when": [[str]], "to": str}
"""Where something leads if facts are so."""
HANDLER = {"event": str, "once": str, "to": [CASE], "pauses": int}
LEFT = {"when": [[str]], "to": [CASE]}
SECTION = {"name": str, "routes": dict, "handlers": [HANDLER], "left": [LEFT]}
OBJECTIVE = {**SECTION, "activities": [str], "sets": [[str]]}
BRANCH = {"name": str, "mandatory": bool, "graph": dict}
PAUSE = {"graph": dict, "handlers": [HANDLER]}
BLOCK = {**SECTION, "branches": [BRANCH], "pauses": [PAUSE], "needed": int, "failing": int, "hasty": bool}
OWN_ENDS = {"success", "failure"}
"""The outcomes for which each section has a route."""
GO_ON = "go on"
"""The exit of what runs while a block pauses by which it goes on."""


def handlers_of(section: Json) -> list[Json]:
    """All handlers of a section, those while it pauses among them."""
    return [*section["handlers"], *(h for each in section.get("pauses", ()) for h in each["handlers"])]


def facts_of(section: Json) -> Iterator[str]:
    """The facts that a section asks or changes."""
    leads = [*section["routes"].values(), *(e["to"] for e in [*section["left"], *handlers_of(section)])]
    for each in [*section["left"], *(case for cases in leads for case in cases)]:
        yield from (fact for fact, _ in each["when"])
    yield from (fact for fact, *_ in section.get("sets", ()))


def paired(some: list[list[str]], size: int = 2) -> bool:
    """Whether lists are all of one size."""
    return all(len(each) == size for each in some)


def fitting(section: Json) -> bool:
    """Whether a section has routes for how it ends, and names in it differ."""
    routes, sets = section["routes"].keys(), section.get("sets", [])
    names = [each["name"] for each in section.get("branches", ())] + section.get("activities", [])
    others = () if "branches" in section else routes - OWN_ENDS - {"timeout"}
    fine = paired(sets, 3) and all(on in ("success", "failure", "start") for *_, on in sets)
    fine = fine and len({(fact, on) for fact, _, on in sets}) == len(sets)
    fine = fine and len(set(names)) == len(names) and routes >= OWN_ENDS
    return fine and all(each.startswith("failure ") for each in others)


class CoreGraph:
    """A graph of sections: that of the mission, of a branch, or of what runs while a block pauses."""

    def __init__(self, document: Json, where: str, exits: set[str]) -> None:
        certcheck.shaped(document, {"entry": str, "sections": [dict]}, where)
        self.entry, self.exits, self.sections = document["entry"], exits, dict[str, Json]()
        self.phases = dict[str, list[list[CoreGraph]]]()
        for section in document["sections"]:
            certcheck.shaped(section, BLOCK if "branches" in section else OBJECTIVE, f"{where}: a section")
            name = section["name"]
            fine = name not in self.sections and name not in exits
            certcheck.need(fine, f"{where}: {name[:60]} is there twice, or an exit", certcheck.Malformed)
            self.sections[name] = section
            for outcome, cases in section["routes"].items():
                certcheck.shaped(cases, [CASE], f"{where}: {name}: {outcome}")
            if "branches" in section:
                leaving = section["routes"].keys() | {GO_ON}
                exits = {*ENDS} if "abort" in leaving else {*ENDS} - {"abort"}
                inside = [
                    CoreGraph(each["graph"], f"{where}: {each['name']}", exits)
                    for each in section["branches"]
                ]
                pauses = [
                    [CoreGraph(each["graph"], f"{where}: {name}", leaving)] for each in section["pauses"]
                ]
                self.phases[name] = [inside, *pauses]
                for level, each in zip(pauses, section["pauses"], strict=True):
                    level[0].complete(each["handlers"], len(pauses), f"{where}: {name}")
        for name, section in self.sections.items():
            fine = fitting(section) and all(paired(each["when"]) for each in section["left"])
            certcheck.need(fine, f"{where}: {name}: its routes, names, sets or left", certcheck.Malformed)
            leads = [*section["routes"].values(), *(each["to"] for each in section["left"])]
            handlers = [{"event": "", "once": "", "to": cases, "pauses": 0} for cases in leads]
            self.complete(
                [*section["handlers"], *handlers], len(section.get("pauses", ())), f"{where}: {name}"
            )
        certcheck.need(
            self.entry in self.sections, f"{where}: no section {self.entry[:60]}", certcheck.Malformed
        )

    def complete(self, handlers: list[Json], pauses: int, where: str) -> None:
        """Something of this graph leads to what there is, whatever facts are."""
        for each in handlers:
            fine = 0 <= each["pauses"] <= pauses and not (each["pauses"] and each["to"])
            if not each["pauses"]:
                fine = bool(each["to"]) and not each["to"][-1]["when"]
                known = all(case["to"] in self.exits or case["to"] in self.sections for case in each["to"])
                fine = fine and known and all(paired(case["when"]) for case in each["to"])
            certcheck.need(
                fine, f"{where}: found {str(each)[:90]}, expected where it leads", certcheck.Malformed
            )

    def every(self) -> Iterator[Json]:
        """All sections, at any depth."""
        for name, section in self.sections.items():
            yield section
            for level in (level for levels in self.phases.get(name, ()) for level in levels):
                yield from level.every()

    def levels(self, at: InBlock) -> list[tuple[CoreGraph, Place]]:
        """The graphs of a block that are under way, each with where it is."""
        number, inside = at.phases[-1]
        return list(zip(self.phases[at.name][number], inside, strict=True))

    def leaves(self, at: Place) -> Iterator[AtObjective]:
        """The objectives that run, or are about to."""
        if isinstance(at, AtObjective):
            yield at
        elif isinstance(at, InBlock):
            for level, inside in self.levels(at):
                yield from level.leaves(inside)

    def done(self, at: Place) -> Iterator[str]:
        """Branches that have ended while others run."""
        for number, insides in at.phases if isinstance(at, InBlock) else ():
            for i, (level, inside) in enumerate(zip(self.phases[at[0]][number], insides, strict=True)):
                if isinstance(inside, str):
                    yield self.sections[at[0]]["branches"][i]["name"]
                yield from level.done(inside)

    def becoming(self, at: Place, to: Callable[[str], str]) -> Place:
        """The same with other states of objectives under way; no block has just been entered."""
        if isinstance(at, AtObjective):
            return AtObjective(at.name, to(at.name))
        if isinstance(at, str):
            return at
        inside = tuple(level.becoming(place, to) for level, place in self.levels(at))
        return InBlock(at.name, False, (*at.phases[:-1], (at.phase, inside)))

    def led(self, cases: list[Json], facts: Facts) -> Place:
        """Where the first case leads whose facts are so."""
        return self.enter(next(case["to"] for case in cases if so(case["when"], facts)))

    def routed(self, name: str, outcome: str, facts: Facts) -> Place:
        """Where an outcome of a section leads."""
        return self.led(self.sections[name]["routes"][outcome], facts)

    def enter(self, target: str) -> Place:
        """An exit, an objective, or a block with its branches at their entries."""
        if target in self.exits:
            return target
        if target not in self.phases:
            return AtObjective(target, "enters")
        inside = tuple(level.enter(level.entry) for level in self.phases[target][0])
        return InBlock(target, True, ((0, inside),))

    def within(self, at: InBlock, inside: list[Place], facts: Facts) -> Place:
        """A block in which something has come to where it is: it goes on, goes on again, or is left."""
        if at.phase:
            outcome = inside[0] if isinstance(inside[0], str) else ""
        else:
            outcome = self.decided(self.sections[at.name], inside)
        if outcome == GO_ON:
            return self.becoming(InBlock(at.name, False, at.phases[:-1]), lambda _: "enters")
        if outcome:
            return self.routed(at.name, outcome, facts)
        return InBlock(at.name, at.entered, (*at.phases[:-1], (at.phase, tuple(inside))))

    @staticmethod
    def decided(section: Json, branches: list[Place]) -> str:
        """How a block ends with branches where they are; empty if it goes on."""
        well, badly = branches.count("succeed"), branches.count("fail")
        must = [where for where, each in zip(branches, section["branches"], strict=True) if each["mandatory"]]
        over = well + badly == len(branches)
        whole = section["needed"] > len(branches)  # all are awaited
        if "abort" in branches:
            return "abort"
        if well >= section["needed"] or (whole and over and all(where == "succeed" for where in must)):
            return "success"
        if over or badly >= section["failing"] or (section["hasty"] and "fail" in must):
            return "failure"
        return ""

    def handlers(self, at: AtObjective | InBlock) -> list[Json]:
        """What handles events there, if nothing in it does: of a block that pauses, of what is around it."""
        section: Json = self.sections[at.name]
        pausing = isinstance(at, InBlock) and at.phase
        found: list[Json] = (section["pauses"][pausing - 1] if pausing else section)["handlers"]
        return found

    def possible(self, at: Place, had: Names) -> Iterator[Event]:
        """The events that may happen there, but success: that is for the robot to say."""
        if isinstance(at, str):
            return
        routes = self.sections[at.name]["routes"].keys()
        if isinstance(at, InBlock):
            for level, inside in self.levels(at):
                yield from level.possible(inside, had)
            if "timeout" in routes and not at.phase:
                yield "timeout", at.name
        elif at.state == "runs":
            for outcome in routes - {"success"}:
                what, _, reason = outcome.partition(" ")
                yield (what, at.name, reason) if reason else (what, at.name)
        for each in self.handlers(at):
            if each["once"] not in had:
                yield "declared", each["event"]

    def ended(self, at: Place, name: str, outcome: str, facts: Facts) -> Place | None:
        """Where it comes to as an objective ends, or the time of a block; nowhere if that is not there."""
        if isinstance(at, str):
            return None
        if at.name == name:
            return self.routed(name, outcome, facts)
        levels = self.levels(at) if isinstance(at, InBlock) else []
        for i, (level, inside) in enumerate(levels):
            after = level.ended(inside, name, outcome, facts)
            if after is not None and isinstance(at, InBlock):
                places = [after if i == j else place for j, (_, place) in enumerate(levels)]
                return self.within(at, places, facts)
        return None

    def happens(self, at: Place, event: str, had: Names, facts: Facts) -> tuple[Place, Names] | None:
        """Where a declared event leads, and what has happened then; nowhere if nothing handles it."""
        if isinstance(at, str):
            return None
        if isinstance(at, InBlock):
            levels = self.levels(at)
            moved = [level.happens(inside, event, had, facts) for level, inside in levels]
            if any(moved):
                after = [each[0] if each else inside for each, (_, inside) in zip(moved, levels, strict=True)]
                return self.within(at, after, facts), had.union(*(each[1] for each in moved if each))
        for each in self.handlers(at):
            if each["event"] == event and each["once"] not in had:
                return self.taken(at, each, facts), had | ({each["once"]} if each["once"] else set())
        return None

    def taken(self, at: AtObjective | InBlock, handler: Json, facts: Facts) -> Place:
        """Where a handler leads: away, or to what runs while the block pauses."""
        if handler["pauses"]:
            (level,) = self.phases[at.name][handler["pauses"]]
            halted = self.becoming(at, lambda _: "halted")
            meanwhile = (handler["pauses"], (level.enter(level.entry),))
            phases = halted.phases if isinstance(halted, InBlock) else ()
            return InBlock(at.name, False, (*phases, meanwhile))
        if isinstance(at, InBlock) and at.phase:
            (level,) = self.phases[at.name][at.phase]
            return self.within(at, [level.led(handler["to"], facts)], facts)
        return self.led(handler["to"], facts)

    def left(self, at: Place, facts: Facts, new: Facts) -> Place:
        """Where it comes to as facts have become so: what ran before is left, outer blocks first."""
        if isinstance(at, str) or (at.entered if isinstance(at, InBlock) else at.state != "runs"):
            return at
        for each in self.sections[at.name]["left"]:
            when = {(fact, value) for fact, value in each["when"]}
            if when <= facts and when & new:
                return self.led(each["to"], facts)
        if isinstance(at, AtObjective):
            return at
        levels = self.levels(at)
        after = [level.left(inside, facts, new) for level, inside in levels]
        return at if after == [inside for _, inside in levels] else self.within(at, after, facts)
