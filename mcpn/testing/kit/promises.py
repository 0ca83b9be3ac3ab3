"""What every composed mission owes in its markings, whatever its engine."""

from __future__ import annotations

import numpy as np

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.templates.net_names import names_of
from mcpn.report.words import situation_in_words
from mcpn.robot.runtime.controller_tables import Inside
from mcpn.spaces.markings.graph import Ints
from mcpn.testing.kit.contract import states_of
from mcpn.testing.kit.subject import Subject

INTERFACE = ("available", "take", "answer", "release", "error")


def invariants_of_units(subject: Subject) -> None:
    """Each interface of a resource is in one state, so is the resource itself, and each declared unit.

    At rest one place says so. Between two of them a template may pass through places of its own, but never
    do two of them say so at a time.

    Raises:
        Violation: One does not, in some marking.
    """
    found = subject.mission_net
    sharing = found.usage.sharing
    for unit in subject.net.units:
        places = ", ".join(subject.net.places[place].name for place in unit)
        said = subject.markings.tokens(dict.fromkeys(unit, 1))
        subject.require(said <= 1, f"the templates say that one of these is marked at a time: {places}")
    for hardware in found.core.hardware:
        name = hardware.name
        said = tokens(
            subject, name, *(part for parts in states_of(subject.templates).values() for part in parts)
        )
        one(subject, said, f"hardware {name} is not in one state: {', '.join(states_of(subject.templates))}")
        out = tokens(subject, name, *states_of(subject.templates)["out of service"])
        for owner in sharing.owners(name):
            said = tokens(subject, name, *INTERFACE, owner=owner) + out
            one(subject, said, f"the interface of hardware {name}{_of(owner)} does not hold one token")
    for software in found.mission.software:
        name = software.name
        if found.usage.producer[name] not in found.usage.started:
            continue
        for owner in sharing.owners(name):
            said = tokens(subject, name, *INTERFACE, "waiting", "free", owner=owner)
            one(subject, said, f"the interface of software {name}{_of(owner)} does not hold one token")
            if sharing.serves(found.usage.producer[name]):
                said = tokens(subject, name, "unused", "waiting", "busy", owner=owner)
                message = f"software {name}{_of(owner)} is not in one state: unused, waiting or busy"
                one(subject, said, message)
            else:
                said = tokens(subject, name, "notAvailable", "waiting", "free", "busy", "error")
                subject.require(said <= 1, f"software {name} is in several states")


def one(subject: Subject, said: Ints, message: str) -> None:
    """Sees that one place of several is marked at rest, and never more than one."""
    subject.require((said == 1) | ((said == 0) & ~subject.stable), message)


def promises_at_rest(subject: Subject) -> None:
    """In each stable marking hardware has a known status, and each activity of an objective is one thing.

    Raises:
        Violation: It is not so.
    """
    found = subject.mission_net
    for hardware in found.core.hardware:
        lasting = [
            part
            for state, parts in states_of(subject.templates).items()
            if state != "between"
            for part in parts
        ]
        known = tokens(subject, hardware.name, *lasting) == 1
        subject.require(
            known | ~subject.stable, f"{hardware.name} is neither available nor used nor out of service"
        )
    for state in np.flatnonzero(subject.stable).tolist():
        wrong = not_one_thing(found, situation(found, subject.markings.marking(state)))
        if wrong is not None:
            raise subject.violation(state, wrong)


def idle_again(subject: Subject) -> None:
    """Where the mission has ended, everything but the status of hardware is as it was before it began.

    Raises:
        Violation: Something is not.
    """
    ends = np.zeros(subject.markings.states, np.bool_)
    for place in subject.mission_net.ends.values():
        ends |= subject.markings.marked(place)
    for state in np.flatnonzero(subject.stable & ends).tolist():
        if left := subject.mission_net.not_idle(subject.markings.marking(state)):
            raise subject.violation(
                state, f"the mission has ended, and these are not as before: {', '.join(left)}"
            )


def check_promises(subject: Subject) -> None:
    """All of these.

    Raises:
        Violation: One is broken.
    """
    invariants_of_units(subject)
    promises_at_rest(subject)
    idle_again(subject)


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


def tokens(subject: Subject, name: str, *parts: str, owner: str | None = None) -> Ints:
    """By state, the tokens in some places of a resource, or of one owner's interface, those that it has."""
    usage = subject.mission_net.usage
    index, names = subject.net.place_index, names_of(usage)
    kind = "hardware" if name in usage.hardware else "software"
    called = [names.of(kind, name, part, *([owner] if owner else [])) for part in parts]
    places = [index[place] for place in called if place in index]
    return np.asarray(np.sum([subject.markings.marked(p) for p in places], axis=0, dtype=np.int64), np.int64)


def _of(owner: str | None) -> str:
    return "" if owner is None else f" for {owner}"
