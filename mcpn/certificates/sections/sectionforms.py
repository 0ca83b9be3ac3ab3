"""sectionforms: formulas and nominal success on missions of many sections, asked of one section at a time.

That some state satisfies a formula is true if one of a section does that is surely reached; it is false if
no state does that a section can have. What a section alone cannot say, as the status of hardware that it does
not use, is neither. The page docs/certificates.md has the rules, papers/mcpn.md why they suffice.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cache
from typing import Any, NamedTuple

try:
    from mcpn.certificates import certcheck
    from mcpn.certificates.coregraph import ENDS, Event
except ImportError:  # the files alone, beside each other
    import certcheck  # type: ignore[import-not-found, no-redef]
    from coregraph import ENDS, Event  # type: ignore[import-not-found, no-redef]

PlayedSections = Any
PlayedType = Any
"""The classes of sectioncheck, which imports this file."""
Form = tuple[Any, ...]
TRUE: Form = ("and",)
FALSE: Form = ("or",)
UNKNOWN: Form = ("unknown",)
MOST_WORK = 5_000_000
"""Atoms times sections up to which a formula is asked of every section."""
KINDS = {"objective": "s", "pending": "s", "done": "b", "refused": "a", "oos": "k"}
"""By role of a place the kind of its element's name."""
ALTERNATIVES = {"active": "active", "wait": "waits", "want": "waits"}
HARDWARE = ("out of service", "repaired", "detected")
UNSHOWN = "sections do not show it"


class PlaceOrEvent(NamedTuple):
    """What a state says, and the events that may happen there."""

    says: frozenset[tuple[str, str]]
    events: frozenset[Event]


def read(said: Any, paths: bool = False) -> Form:
    """A formula of a claim on states, or on paths, as tuples; malformed if it is none."""
    wrong, shaped = "sections.json: a formula", certcheck.shaped
    operator, *rest = shaped(said, list, wrong) or [""]
    shaped(operator, str, wrong)
    if operator in ("and", "or"):
        return operator, *(read(each, paths) for each in rest)
    if operator == "fires" or (operator == "happens" and paths):
        return operator, *map(tuple, shaped(rest, [[str]], wrong))
    if operator == "says" and len(rest) == 2:
        return operator, *shaped(rest, [str], wrong)
    if operator == "at most" and len(rest) == 2:
        most, pairs = shaped(rest[0], int, wrong), shaped(rest[1], [[int]], wrong)
        if all(len(pair) == 2 and pair[0] >= 0 for pair in pairs):
            return operator, most, tuple(map(tuple, pairs))
    fine = len(rest) == certcheck.ARITY.get(operator, -1) and (paths or operator not in ("X", "U", "R"))
    certcheck.need(fine, f"{wrong}: found {str(said)[:60]}", certcheck.Malformed)
    of_paths = operator == "E" or (paths and operator in ("not", "X", "U", "R"))
    return operator, *(read(each, of_paths) for each in rest)


JOINING = {"and", "or", "not", "EU", "E", "U"}
"""The operators that sections are asked, and that join formulas."""


def either(one: bool | None, wanted: bool) -> bool | None:
    """The same, or the contrary."""
    return one if wanted or one is None else not one


def value(form: Form, state: PlaceOrEvent) -> bool | None:
    """Whether a state satisfies a formula; None where it does not say."""
    operator, *of = form
    if operator == "says":
        return (of[0], of[1]) in state.says
    if operator == "fires":
        return not state.events.isdisjoint(of)
    if operator == "not":
        return either(value(of[0], state), False)
    if operator not in ("and", "or"):
        return None
    decides, unknown = operator == "or", False
    for each in of:
        found = value(each, state)
        if found is decides:
            return decides
        unknown = unknown or found is None
    return None if unknown else not decides


def joined(operator: str, parts: Iterable[Form]) -> Form:
    """Formulas joined by ``and`` or ``or``, less those that do not matter."""
    decides, idle = (TRUE, FALSE) if operator == "or" else (FALSE, TRUE)
    kept = [each for each in parts if each != idle]
    return decides if decides in kept else kept[0] if len(kept) == 1 else (operator, *kept)


class SectionFormulas:
    """The sections of a mission, asked formulas."""

    def __init__(self, played: PlayedSections) -> None:
        self.played, self.steady = played, played.steadily_reached()
        self.owners = dict[tuple[str, str], set[str]]()
        for section in played.reached:
            for named in played.names[section]:
                self.owners.setdefault(named, set()).add(section)
        self.way = cache(self.way_to)
        self.states = dict[int, list[PlaceOrEvent]]()
        self.known = dict[tuple[int, bool, Form], bool]()
        begun = PlaceOrEvent(frozenset({("begin", "")}), frozenset({("start", "")}))
        self.outside = [(True, begun)]
        for end in played.ends:
            sure = played.reaches({end})
            self.outside.append((sure, PlaceOrEvent(frozenset({(end, "")}), frozenset())))

    # Formulas in the names of a section.

    def atoms(self, form: Form) -> int:
        """How many atoms a formula has."""
        if form[0] == "fires":
            return len(form)
        return sum(map(self.atoms, form[1:])) if form[0] in JOINING else 1

    def event(self, section: str | None, event: Event) -> Event | Form:
        """An event in the names of a section; FALSE or UNKNOWN where it is none of the section."""
        if len(event) < 2:  # no transition has such an event
            return FALSE
        what, element, *reason = event
        names = self.played.names[section] if section is not None else {}
        if what in HARDWARE:
            new = names.get(("k", element))
            return UNKNOWN if new is None else (what, new, *reason)
        if what == "start":
            return event if section is None else FALSE
        new = names.get(("e" if what == "declared" else "s", element))
        return FALSE if new is None else (what, new, *reason)

    def named(self, section: str | None, form: Form) -> Form:
        """A formula on states in the names of a section, or of none: before the start, behind the ends."""
        operator, *of = form
        names = self.played.names[section] if section is not None else {}
        if operator == "E" and of[0][0] == "happens":
            operator, of = "fires", [*of[0][1:]]
        if operator == "fires":
            found = [self.event(section, event) for event in of]
            own = [each for each in found if each not in (FALSE, UNKNOWN)]
            return joined("or", [("fires", *own) if own else FALSE, UNKNOWN if UNKNOWN in found else FALSE])
        if operator == "says":
            role, element = of
            if role in ("begin", "success", "failure", "abort"):
                return ("says", role, "") if section is None else FALSE
            if role in ALTERNATIVES:
                ways = ((names.get(("a", name)), number) for name, number in self.played.ways_named(element))
                runs = sorted(f"{name}.{number}" for name, number in ways if name is not None)
                return joined("or", (("says", ALTERNATIVES[role], each) for each in runs))
            if role not in KINDS:
                return UNKNOWN
            new = names.get((KINDS[role], element))
            return ("says", role, new) if new is not None else UNKNOWN if role == "oos" else FALSE
        if operator in ("and", "or"):
            return joined(operator, (self.named(section, each) for each in of))
        if operator == "not":
            inside = self.named(section, of[0])
            return {TRUE: FALSE, FALSE: TRUE, UNKNOWN: UNKNOWN}.get(inside, ("not", inside))
        return UNKNOWN

    def concerned(self, form: Form) -> set[str] | None:
        """The sections in which alone a formula on states may be true; None where these may be all."""
        operator, *of = form
        if operator == "says" and of[0] in KINDS and of[0] != "oos":
            return self.owners.get((KINDS[of[0]], of[1]), set())
        if operator == "says" and of[0] in ("begin", *ENDS.values()):
            return set()
        if operator == "says" and of[0] in ALTERNATIVES:
            some = (self.owners.get(("a", name), ()) for name, _ in self.played.ways_named(of[1]))
            return set[str]().union(*some)
        if operator == "fires" or (operator == "E" and of[0][0] == "happens"):
            events = [event for event in (of if operator == "fires" else of[0][1:]) if len(event) > 1]
            if any(event[0] in HARDWARE for event in events):
                return None
            kinds = (("e" if event[0] == "declared" else "s", event[1]) for event in events)
            return set[str]().union(*(self.owners.get(kind, ()) for kind in kinds))
        parts = [self.concerned(each) for each in of] if operator in ("and", "or") else [None]
        known = [part for part in parts if part is not None]
        if operator == "or":
            return set[str]().union(*known) if len(known) == len(parts) else None
        return set.intersection(*known) if known else None

    # States.

    def of_type(self, played: PlayedType) -> list[PlaceOrEvent]:
        """The states of a type."""
        if id(played) not in self.states:
            self.states[id(played)] = [
                PlaceOrEvent(
                    played.mission.says(state),
                    frozenset(event for event, _ in (*played.edges[n], *played.exits[n])),
                )
                for n, state in enumerate(played.states)
            ]
        return self.states[id(played)]

    def some(self, section: str, form: Form, sure: bool) -> bool:
        """Whether a state satisfies a formula for sure; or, of all that there may be, perhaps does."""
        played, named = self.played.type[section], self.named(section, form)
        if named in (TRUE, FALSE, UNKNOWN):
            return named == TRUE or (named == UNKNOWN and not sure)
        key = id(played), sure, named
        if key not in self.known:
            states = self.of_type(played)
            numbers: Iterable[int] = played.surely if sure else range(len(states))
            wanted = (True,) if sure else (True, None)
            self.known[key] = any(value(named, states[n]) in wanted for n in numbers)
        return self.known[key]

    def reached(self, form: Form) -> bool:
        """Whether some state satisfies a formula on states; refuted if sections do not show it."""
        concerned, outside = self.concerned(form), self.named(None, form)
        sections = self.played.reached if concerned is None else concerned
        self.played.budget.within(0)
        work = len(sections) * self.atoms(form)
        certcheck.need(work <= MOST_WORK, "the formula is too long to ask each section")
        if any(sure and value(outside, state) is True for sure, state in self.outside):
            return True
        if any(self.some(section, form, True) for section in sections if section in self.steady):
            return True
        perhaps = any(value(outside, state) is not False for _, state in self.outside)
        perhaps = perhaps or any(self.some(section, form, False) for section in sections)
        certcheck.need(not perhaps, UNSHOWN)
        return False

    def avoiding(self, events: Iterable[Event], ends: set[str]) -> bool:
        """Whether the mission may come to an end by a run without some events; refuted if it is not shown."""
        avoided = {*events}
        fine = all(len(event) > 1 and event[0] in ("success", "failure", "timeout") for event in avoided)
        certcheck.need(fine, UNSHOWN)
        targets = {to for to, end in ENDS.items() if end in ends}
        self.played.budget.within(0)
        ways = (self.way(end) for end in sorted(ends))
        owners = {section for event in avoided for section in self.owners.get(("s", event[1]), ())}
        if any(way is not None and owners.isdisjoint(way) for way in ways):
            return True

        def leads(steadily: bool) -> Callable[[str], Iterator[str]]:
            def of(section: str) -> Iterator[str]:
                played, names = self.played.type[section], self.played.names[section]
                own = frozenset(
                    (event[0], names["s", event[1]], *event[2:])
                    for event in avoided
                    if ("s", event[1]) in names
                )
                every = played.leads_steadily if steadily else played.leads
                found = every if not own else played.leading(own, steadily)
                return (self.played.targets[section][to] for to in found)

            return of

        type_, entry = self.played.type, [self.played.entry]
        met = certcheck.grown(entry, leads(True), type_)
        if any(to in targets for section in met for to in leads(True)(section)):
            return True
        met = certcheck.grown(entry, leads(False), type_)
        perhaps = any(to in targets for section in met for to in leads(False)(section))
        certcheck.need(not perhaps, UNSHOWN)
        return False

    def way_to(self, end: str) -> frozenset[str] | None:
        """The sections of a shortest way to an end on which the status of hardware stays as at first."""
        came: dict[str, str] = {self.played.entry: ""}
        for section in (todo := [self.played.entry]):  # grows while it is walked
            for to in self.played.led(section, self.played.type[section].leads_steadily):
                if ENDS.get(to) == end:
                    found, at = set[str](), section
                    while at:
                        found.add(at)
                        at = came[at]
                    return frozenset(found)
                if to not in came and to not in ENDS:
                    came[to] = section
                    todo.append(to)
        return None

    def holds(self, form: Form) -> bool:
        """Whether the first state satisfies a formula; refuted if sections do not show it."""
        match form:
            case ("not", inside):
                return not self.holds(inside)
            case ("EU", ("and",), goal) | ("E", ("U", ("and",), goal)):
                return self.reached(goal)
            case ("E", ("U", ("not", ("happens", *events)), goal)):
                return self.avoiding(events, self.ends_of(goal))
        raise certcheck.Refuted(UNSHOWN)

    def ends_of(self, goal: Form) -> set[str]:
        """The ends that a formula names, and nothing else."""
        parts = goal[1:] if goal[0] == "or" else (goal,)
        fine = all(each[0] == "says" and each[1] in ENDS.values() for each in parts)
        certcheck.need(fine, UNSHOWN)
        return {each[1] for each in parts}

    def nominal(self, said: dict[str, list[str]]) -> None:
        """Refutes that runs of successes end, in success alone, and enter all that is meant to be entered."""
        certcheck.need(not said["endless"] and not said["repaired"], UNSHOWN)
        names, fails = self.played.names, {*said["fails"]}
        todo, under_way, done, entered = [(self.played.entry, False)], set[str](), set[str](), set[str]()
        while todo:
            section, behind = todo.pop()
            if behind:
                under_way.discard(section)
                done.add(section)
                continue
            certcheck.need(section not in under_way, "nominal runs come back to a section")
            if section in done:
                continue
            under_way.add(section)
            todo.append((section, True))
            played, old = self.played.type[section], {new: name for (_, name), new in names[section].items()}
            failing = frozenset(
                new for (kind, name), new in names[section].items() if kind == "s" and name in fails
            )
            targets, objectives = played.nominally(failing)
            entered |= {old[name] for name in objectives}
            for to in (self.played.targets[section][way] for way in sorted(targets)):
                certcheck.need(ENDS.get(to, "success") == "success", f"a nominal run ends in {to}")
                if to not in ENDS:
                    todo.append((to, False))
        certcheck.need({*said["meant"]} <= entered, "no nominal run enters what is meant to be entered")
