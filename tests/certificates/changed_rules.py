"""Changes of modular controllers, and whether two controllers order the same on the same events."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from mcpn.robot.runtime.controller_tables import RuntimePosition, Tables
from mcpn.robot.runtime.documents import BEFORE
from tests.runtime.damage import signed

Document = dict[str, Any]


def _types(controller: Document, key: str) -> Iterator[Document]:
    """The types that have some of a key."""
    return (each for each in controller["types"] if each[key])


def _rule(controller: Document, draw: random.Random) -> tuple[list[Document], int, int]:
    """A list of rules, which of them, and how many bits they may ask for."""
    lists = [
        (rules, each["bits"] * (1 + part))
        for each in controller["types"]
        for part, several in ((False, [each["entries"], each["rules"]]), (True, each["parts"]))
        for rules in several
        if rules
    ]
    rules, bits = draw.choice(lists)
    return rules, draw.randrange(len(rules)), bits


def asks_for_the_opposite(controller: Document, draw: random.Random) -> None:
    """A rule asks that a bit is not set where it asked that it is, or the reverse."""
    rules, at, _ = _rule(controller, draw)
    if asked := rules[at]["if"]:
        asked[draw.randrange(len(asked))] ^= 1


def asks_for_less(controller: Document, draw: random.Random) -> None:
    """A rule forgets a literal."""
    rules, at, _ = _rule(controller, draw)
    if asked := rules[at]["if"]:
        asked.pop(draw.randrange(len(asked)))


def asks_for_more(controller: Document, draw: random.Random) -> None:
    """A rule asks for one bit more."""
    rules, at, bits = _rule(controller, draw)
    literal = draw.randrange(2 * bits)
    if all(literal >> 1 != other >> 1 for other in rules[at]["if"]):
        rules[at]["if"].append(literal)


def does_something_else(controller: Document, draw: random.Random) -> None:
    """A rule has another effect."""
    each = draw.choice([*_types(controller, "rules")])
    draw.choice(each["rules"] + each["entries"])["do"] = draw.randrange(len(each["effects"]))


def is_forgotten(controller: Document, draw: random.Random) -> None:
    """There is one rule less."""
    rules, at, _ = _rule(controller, draw)
    rules.pop(at)


def another_event(controller: Document, draw: random.Random) -> None:
    """A rule is of another event."""
    each = draw.choice([*_types(controller, "rules")])
    draw.choice(each["rules"])["event"] = draw.randrange(len(each["events"]))


def _effect(controller: Document, draw: random.Random) -> tuple[Document, Document]:
    each = draw.choice([*_types(controller, "effects")])
    return each, draw.choice(each["effects"])


def another_bit_changes(controller: Document, draw: random.Random) -> None:
    """An effect changes one bit more, or one less."""
    each, effect = _effect(controller, draw)
    effect["changes"] = sorted({*effect["changes"]} ^ {draw.randrange(each["bits"])})


def another_outcome(controller: Document, draw: random.Random) -> None:
    """An effect leaves the section otherwise, or no more, or at once."""
    _, effect = _effect(controller, draw)
    effect["to"] = draw.choice([None, "success", "failure"])


def goes_on_otherwise(controller: Document, draw: random.Random) -> None:
    """An effect goes on with one part less, or with two in the other order."""
    _, effect = _effect(controller, draw)
    then = effect["then"]
    if len(then) > 1 and draw.random() < 0.5:
        at = draw.randrange(len(then) - 1)
        then[at : at + 2] = then[at : at + 2][::-1]
    elif then:
        then.pop(draw.randrange(len(then)))


def another_action(controller: Document, draw: random.Random) -> None:
    """An action is forgotten, done twice, at another place, or of something else."""
    _, effect = _effect(controller, draw)
    actions = effect["actions"]
    if not actions:
        return
    at, how = draw.randrange(len(actions)), draw.randrange(4)
    if how == 0:
        actions.pop(at)
    elif how == 1:
        actions.insert(draw.randrange(len(actions) + 1), copy.deepcopy(actions[at]))
    elif how == 2:
        actions.insert(draw.randrange(len(actions)), actions.pop(at))
    else:
        key = draw.choice([*actions[at].keys() - {"do"}])
        activities = controller["activities"]
        activity = actions[at].get("activity", "")
        known = {
            "activity": [*activities],
            "hardware": controller["hardware"],
            "objective": [*controller["objectives"]],
            "alternative": [*activities.get(activity, {"alternatives": {}})["alternatives"]],
        }
        actions[at][key] = draw.choice(known[key] or [actions[at][key]])


def another_status(controller: Document, draw: random.Random) -> None:
    """What sections hand on is read from, or written to, other bits; or the idle bits are others."""
    each = draw.choice(controller["types"])
    if each["status"] and draw.random() < 0.7:
        status = draw.choice(each["status"])
        if draw.random() < 0.5:
            status["when"] = draw.randrange(2 * each["bits"])
        else:
            status["changes"] = sorted({*status["changes"]} ^ {draw.randrange(each["bits"])})
    else:
        each["idle"] = sorted({*each["idle"]} ^ {draw.randrange(each["bits"])})


def shows_something_else(controller: Document, draw: random.Random) -> None:
    """What is so is said of other states, or of none."""
    each = draw.choice([*_types(controller, "shown")])
    at = draw.randrange(len(each["shown"]))
    if draw.random() < 0.3:
        each["shown"].pop(at)
    else:
        each["shown"][at]["when"] = draw.randrange(2 * each["bits"])


def leads_elsewhere(controller: Document, draw: random.Random) -> None:
    """A route, or the start, leads to another section or end."""
    names = [each["name"] for each in controller["sections"]]
    if draw.random() < 0.2:
        controller["initial"] = draw.choice(names)
        return
    routes = draw.choice([each for each in controller["sections"] if each["routes"]])["routes"]
    routes[draw.choice(sorted(routes))] = draw.choice([*names, "succeed", "fail", "abort"])


def names_something_else(controller: Document, draw: random.Random) -> None:
    """A section's element has another name, or two of its events change places."""
    section = draw.choice(controller["sections"])
    kinds = [kind for kind, names in section["names"].items() if len(names) > 1]
    if kinds and draw.random() < 0.5:
        names = section["names"][draw.choice(kinds)]
        one, other = draw.sample(sorted(names), 2)
        names[one], names[other] = names[other], names[one]
    elif len(section["events"]) > 1:
        one, other = draw.sample(range(len(section["events"])), 2)
        events = section["events"]
        events[one], events[other] = events[other], events[one]


def another_world(controller: Document, draw: random.Random) -> None:
    """Hardware is repairable, broken at first, or may fail otherwise; a fact changes otherwise."""
    key = draw.choice(["out_of_service", "unrepairable", "crashing", "changing"])
    if key == "changing":
        if controller["changing"]:
            controller["changing"].pop(draw.choice(sorted(controller["changing"])))
    elif controller["hardware"]:
        controller[key] = sorted({*controller[key]} ^ {draw.choice(controller["hardware"])})


CHANGES: tuple[Callable[[Document, random.Random], None], ...] = (
    asks_for_the_opposite,
    asks_for_less,
    asks_for_more,
    does_something_else,
    is_forgotten,
    another_event,
    another_bit_changes,
    another_outcome,
    goes_on_otherwise,
    another_action,
    another_status,
    shows_something_else,
    leads_elsewhere,
    names_something_else,
    another_world,
)


class Place(NamedTuple):
    """Where a controller is; sections by their names."""

    phase: str
    section: str
    state: int
    gone: frozenset[str]
    true: frozenset[str]


class Played:
    """A controller that the runtime plays."""

    def __init__(self, controller: Document) -> None:
        self.tables = Tables(signed(copy.deepcopy(controller)))

    def first(self) -> Place:
        tables = self.tables
        return self.place(RuntimePosition(BEFORE, None, 0, tables.out_of_service, tables.true_at_first))

    def place(self, at: RuntimePosition) -> Place:
        name = at.section.name if at.section else ""
        return Place(at.phase, name, at.state, frozenset(at.gone), frozenset(at.true))

    def at(self, place: Place) -> RuntimePosition:
        section = self.tables.sections[place.section] if place.section else None
        return RuntimePosition(place.phase, section, place.state, place.gone, place.true)

    def told(self, place: Place) -> tuple[object, ...]:
        """What the runtime says of a place."""
        at = self.at(place)
        inside = at.section.state(at.state) if at.section else None
        said = inside and (
            *({*each} for each in (inside.objectives, inside.pending, inside.done, inside.refused)),
            dict(inside.mode),
            dict(inside.waiting),
        )
        return at.phase, said, place.gone, self.tables.values(place.true), self.tables.possible(at)

    def after(self, place: Place, event: str) -> tuple[Place, list[str], list[Any]]:
        """The place after an event, the verbs, and the actions without their order."""
        moved = self.tables.after(self.at(place), event)
        assert moved is not None, "it is possible"
        position, actions = moved
        told = sorted((str(each), each.objective or "", each.parameters, each.seconds) for each in actions)
        return self.place(position), [each.verb for each in actions], told


def lockstep(one: Document, other: Document) -> bool:
    """Whether two controllers say the same and order the same, but for the order of actions of one verb."""
    first, second = Played(one), Played(other)
    pairs = {(first.first(), second.first())}
    todo = list(pairs)
    while todo:
        here, there = todo.pop()
        told = first.told(here)
        if told != second.told(there):
            return False
        for event in first.tables.possible(first.at(here)):
            moved, verbs, actions = first.after(here, event)
            expected, *rest = second.after(there, event)
            if [verbs, actions] != rest:
                return False
            if (moved, expected) not in pairs:
                pairs.add((moved, expected))
                todo.append((moved, expected))
    return True
