"""What every composed mission owes in its markings, whatever its engine."""

from __future__ import annotations

import numpy as np

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.templates.names import names_of
from mcpn.report.words import situation_in_words
from mcpn.runtime.tables import Inside
from mcpn.spaces.markings.graph import Ints
from mcpn.testing.kit.contract import states_of
from mcpn.testing.kit.subject import Subject

INTERFACE = ("available", "take", "answer", "release", "error")


def invariants_of_units(of: Subject) -> None:
    """Each interface of a resource is in one state, so is the resource itself, and each declared unit.

    At rest one place says so. Between two of them a template may pass through places of its own, but never
    do two of them say so at a time.

    Raises:
        Violation: One does not, in some marking.
    """
    found = of.mission_net
    sharing = found.usage.sharing
    for unit in of.net.units:
        places = ", ".join(of.net.places[place].name for place in unit)
        said = of.markings.tokens(dict.fromkeys(unit, 1))
        of.require(said <= 1, f"the templates say that one of these is marked at a time: {places}")
    for hardware in found.mission.hardware:
        name = hardware.name
        said = tokens(of, name, *(part for parts in states_of(of.templates).values() for part in parts))
        one(of, said, f"hardware {name} is not in one state: {', '.join(states_of(of.templates))}")
        out = tokens(of, name, *states_of(of.templates)["out of service"])
        for owner in sharing.owners(name):
            said = tokens(of, name, *INTERFACE, owner=owner) + out
            one(of, said, f"the interface of hardware {name}{_of(owner)} does not hold one token")
    for software in found.mission.software:
        name = software.name
        if found.usage.producer[name] not in found.usage.started:
            continue
        for owner in sharing.owners(name):
            said = tokens(of, name, *INTERFACE, "waiting", "free", owner=owner)
            one(of, said, f"the interface of software {name}{_of(owner)} does not hold one token")
            if sharing.serves(found.usage.producer[name]):
                said = tokens(of, name, "unused", "waiting", "busy", owner=owner)
                message = f"software {name}{_of(owner)} is not in one state: unused, waiting or busy"
                one(of, said, message)
            else:
                said = tokens(of, name, "notAvailable", "waiting", "free", "busy", "error")
                of.require(said <= 1, f"software {name} is in several states")


def one(of: Subject, said: Ints, message: str) -> None:
    """Sees that one place of several is marked at rest, and never more than one."""
    of.require((said == 1) | ((said == 0) & ~of.stable), message)


def promises_at_rest(of: Subject) -> None:
    """In each stable marking hardware has a known status, and each activity of an objective is one thing.

    Raises:
        Violation: It is not so.
    """
    found = of.mission_net
    for hardware in found.mission.hardware:
        lasting = [
            part for state, parts in states_of(of.templates).items() if state != "between" for part in parts
        ]
        known = tokens(of, hardware.name, *lasting) == 1
        of.require(known | ~of.stable, f"{hardware.name} is neither available nor used nor out of service")
    for state in np.flatnonzero(of.stable).tolist():
        wrong = not_one_thing(found, situation(found, of.markings.marking(state)))
        if wrong is not None:
            raise of.violation(state, wrong)


def idle_again(of: Subject) -> None:
    """Where the mission has ended, everything but the status of hardware is as it was before it began.

    Raises:
        Violation: Something is not.
    """
    ends = np.zeros(of.markings.states, np.bool_)
    for place in of.mission_net.ends.values():
        ends |= of.markings.marked(place)
    for state in np.flatnonzero(of.stable & ends).tolist():
        if left := of.mission_net.not_idle(of.markings.marking(state)):
            raise of.violation(
                state, f"the mission has ended, and these are not as before: {', '.join(left)}"
            )


def check_promises(of: Subject) -> None:
    """All of these.

    Raises:
        Violation: One is broken.
    """
    invariants_of_units(of)
    promises_at_rest(of)
    idle_again(of)


def not_one_thing(found: MissionNet, now: Situation | Inside) -> str | None:
    """The activity of an objective that runs which does not do one of three: run, wait, be refused."""
    activities = {section.name: section.activities for section in found.graph.walk()}
    for objective in now.objectives:
        for activity in activities[objective]:
            said = [activity in those for those in (now.mode, now.waiting, now.refused)]
            if said.count(True) != 1:
                done = situation_in_words(now)
                return f"{activity} of {objective} does not do one of three, run, wait, be refused: {done}"
    return None


def tokens(of: Subject, name: str, *parts: str, owner: str | None = None) -> Ints:
    """By state, the tokens in some places of a resource, or of one owner's interface, those that it has."""
    usage = of.mission_net.usage
    index, names = of.net.place_index, names_of(usage)
    kind = "hardware" if name in usage.hardware else "software"
    called = [names.of(kind, name, part, *([owner] if owner else [])) for part in parts]
    places = [index[place] for place in called if place in index]
    return np.asarray(np.sum([of.markings.marked(p) for p in places], axis=0, dtype=np.int64), np.int64)


def _of(owner: str | None) -> str:
    return "" if owner is None else f" for {owner}"
