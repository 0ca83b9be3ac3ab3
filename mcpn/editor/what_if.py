"""What if: a mission with other alternatives, or hardware lost from the start, beside that of the files."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

from mcpn.answers.claims import all_claims
from mcpn.did_you_mean import did_you_mean
from mcpn.errors import InputError, Problem
from mcpn.findings import Findings
from mcpn.mission.language.forms import form_of
from mcpn.mission.validate import valid
from mcpn.report.pages.story import StoryLine, headline, story
from mcpn.report.words import modes_in_words
from mcpn.study import Study

if TYPE_CHECKING:
    from mcpn.mission.model import Mission
    from mcpn.mission.requirement import Requirement
    from mcpn.mission.robot import Activity
    from mcpn.spaces.engine_names import Asking


def supposed(mission: Mission, lost: Sequence[str], ways: Mapping[str, Sequence[str]]) -> Mission:
    """A mission as it would be; its files stay as they are.

    Requirements that speak of an alternative which is taken away are left out; :func:`compared` names them.

    Args:
        mission: The mission.
        lost: Hardware that is out of service from the start and never repaired.
        ways: By activity its alternatives, the first preferred; it loses those that are not named.

    Raises:
        InputError: The mission has no such hardware, activity or alternative.
    """
    declared = [h.name for robot in mission.robots for h in robot.hardware]
    activities = {a.name: a for robot in mission.robots for a in robot.activities}
    problems = [_unknown("hardware", name, declared) for name in lost if name not in declared]
    for name, wanted in ways.items():
        if name not in activities:
            problems.append(_unknown("activity", name, list(activities)))
            continue
        known = [way.name for way in activities[name].alternatives]
        problems += [_unknown(f"alternative of {name}", way, known) for way in wanted if way not in known]
        if not wanted or len(set(wanted)) < len(wanted):
            problems.append(Problem(None, f"activity {name} needs an alternative, each once"))
    if problems:
        raise InputError(problems)

    def activity(declared: Activity) -> Activity:
        if declared.name not in ways:
            return declared
        known = {way.name: way for way in declared.alternatives}
        chosen = tuple(known[name] for name in ways[declared.name])
        return replace(declared, alternatives=chosen, switch_back=declared.switch_back and len(chosen) > 1)

    robots = (replace(each, activities=tuple(map(activity, each.activities))) for each in mission.robots)
    gone = {
        f"alternative({name})={way.name}"
        for name, wanted in ways.items()
        for way in activities[name].alternatives
        if way.name not in wanted
    }
    protocols = (
        replace(protocol, requirements=_without_names(protocol.requirements, gone))
        for protocol in mission.protocols
    )
    found = replace(mission, robots=tuple(robots), protocols=tuple(protocols))
    found = valid(replace(found, requirements=_without_names(mission.requirements, gone)))
    return _without(found, lost) if lost else found


def _without_names(requirements: Sequence[Requirement], gone: Collection[str]) -> tuple[Requirement, ...]:
    """The requirements but for those that speak of an alternative which is taken away."""

    def texts(requirement: Requirement) -> Iterator[str]:
        for element in (requirement, *requirement.patterns):
            for field in form_of(type(element)).attributes:
                if isinstance(value := getattr(element, field.name), str):
                    yield "".join(value.split())

    def speaks(requirement: Requirement) -> bool:
        return any(re.search(rf"{re.escape(word)}\b", text) for text in texts(requirement) for word in gone)

    return tuple(requirement for requirement in requirements if not speaks(requirement))


def _without(mission: Mission, lost: Sequence[str]) -> Mission:
    """The mission with hardware that is never in service, which a file is not to say by mistake."""
    robots = []
    for robot in mission.robots:
        hardware = (
            replace(hardware, initial="oos", repairable=False, faulty=True)
            if hardware.name in lost
            else hardware
            for hardware in robot.hardware
        )
        robots.append(replace(robot, hardware=tuple(hardware)))
    found = replace(mission, robots=tuple(robots))
    object.__setattr__(found, "checked", True)  # all but that is as it was
    return found


def _unknown(what: str, name: str, known: Sequence[str]) -> Problem:
    return Problem(None, f"the mission has no {what} {name}{did_you_mean(name, known)}")


def compared(
    study: Study,
    lost: Sequence[str],
    ways: Mapping[str, Sequence[str]],
    **asked: Unpack[Asking],
) -> dict[str, Any]:
    """What is found of a mission as it is and as it would be, question by question.

    Args:
        study: The mission.
        lost: As of :func:`supposed`.
        ways: As of :func:`supposed`.
        **asked: Who verifies it, and within what limit.

    Returns:
        ``rows``: for each question of a page's first screen, and for the modes of each objective whose modes
        are others, what is ``asked``, and what is ``said`` of both, each a state and a sentence.
        ``left_out``: the requirements that are not asked of the mission as it would be, since they speak of
        an alternative that is taken away; those of rounds, tries and so on together.

    Raises:
        InputError: As of :func:`supposed`; or a formula names what the mission would no longer have.
        LimitError: A limit was hit.
    """
    mission = study.mission_net.mission
    study, other = study.bound(**asked), Study(supposed(mission, lost, ways)).bound(**asked)
    required, still = (each.mission_net.graph.requirements for each in (study, other))
    left_out = study.mission_net.graph.copies.told((name for name in required if name not in still), required)
    told: dict[str, list[tuple[str, str]]] = {}
    for number, one in enumerate((study, other)):
        for line in _told(one):
            said = told.setdefault(line.asked, [("note", "")] * 2)
            said[number] = (line.state, line.said)
    rows = [
        {"asked": question, "said": said}
        for question, said in told.items()
        if not question.startswith(MODES) or said[0] != said[1]
    ]
    return {"rows": rows, "left_out": left_out}


MODES = "Modes of "


def _told(study: Study) -> Iterator[StoryLine]:
    checked = study.verdicts()
    sound = checked.verdicts["safe"].holds and checked.verdicts["confluent"].holds
    causes = study.causes() if sound else None
    found = Findings(checked, causes, claims=all_claims(checked, causes))
    yield headline(found)
    yield from story(found)
    for name, modes in checked.modes.items():
        words = (way or "the alternatives named like their activities" for way in modes_in_words(modes))
        yield StoryLine("note", f"{MODES}{name}", "; ".join(words) or "none")
