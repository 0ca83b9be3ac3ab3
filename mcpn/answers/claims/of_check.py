"""The claims that a check has found: verdicts, requirements, events that change nothing, late losses."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim, Severity
from mcpn.answers.kinds.by_name import KINDS, OF_VERDICTS
from mcpn.answers.verdicts.as_written import led_to_by_events

if TYPE_CHECKING:
    from mcpn.answers.requirements import RequirementAnswer
    from mcpn.answers.verdicts.mission import MissionCheck, Verdict
    from mcpn.drawing.compose import MissionNet

MOST_PAIRS = 2_000
"""Pairs of two things up to which each has a claim; of more, one claim says what is so of the others."""


def claims_found(check: MissionCheck) -> Iterator[Claim]:
    """The claims that follow from a check without asking its states again."""
    yield from _of_verdicts(check)
    yield from _of_requirements(check)
    yield from _of_events(check)
    yield from _of_late_losses(check)


def of_verdict(verdict: Verdict, ends: Collection[str] = ()) -> Claim:
    """What a verdict says.

    Args:
        verdict: One of a mission.
        ends: The ends that the mission has.
    """
    kind = KINDS[verdict.kind] if verdict.kind else OF_VERDICTS[verdict.name]
    return Claim(
        kind.name,
        (),
        verdict.holds,
        Assumes(moment="every" if kind.name.startswith("can_always") else "some", given=verdict.given),
        "" if kind.needs_states else kind.formula.format(ends=" | ".join(ends)),
        verdict.explanation if verdict.holds is None else "",
        severity="required" if verdict.required else "informative",
    )


def _of_verdicts(check: MissionCheck) -> Iterator[Claim]:
    return (
        of_verdict(check.verdicts[name], check.mission_net.ends)
        for name in OF_VERDICTS
        if name in check.verdicts
    )


def _of_requirements(check: MissionCheck) -> Iterator[Claim]:
    for answer in check.requirements:
        name, formula = answer.asked.name, asked_formula(answer)
        yield Claim(
            "requirement",
            (name,),
            answer.met,
            Assumes(moment="start"),
            formula,
            answer.reason,
            severity="required" if answer.required else "advice",
        )
        for each in check.changing_nothing:
            if each.event in answer.asked.events and each.objectives:
                running = _some("objective", plain_names(check.mission_net, each.objectives))
                idle = KINDS["met_as_ignored"].formula.format(
                    name, each.event, formula=formula, running=running
                )
                holds = answer.met
                yield Claim("met_as_ignored", (name, each.event), holds, formula=idle if formula else "")


def asked_formula(answer: RequirementAnswer) -> str:
    """What a requirement asks, as a formula of the whole mission; empty where its names are others."""
    asked = answer.asked
    if asked.requirement.fair or "." in asked.name:
        return ""
    # Of a formula on paths: not every run satisfies it. That no run does would be more.
    return asked.text if asked.requirement.expected == "holds" else f"!A({asked.text})"


def _some(word: str, names: Iterable[str]) -> str:
    return f"({' | '.join(f'{word}({name})' for name in names)})"


def _of_events(check: MissionCheck) -> Iterator[Claim]:
    """Which declared events are handled whatever runs, and while what runs the others change nothing."""
    net, changing = check.mission_net, {each.event: each for each in check.changing_nothing}
    if check.alternatives is None and check.markings is None:
        return
    objectives, led = plain_names(net, (objective.name for objective in net.graph.walk())), led_to(net)
    events = [event for event in net.core.events if not event.changes_facts]
    few = len(events) * len(objectives) <= MOST_PAIRS
    for declared in events:
        name, each = declared.name, changing.get(declared.name)
        severity: Severity = "required" if declared.required else "informative"
        inside = led.get(name, [])
        formula = KINDS["handled_always"].formula.format(name, running=_some("objective", objectives))
        yield Claim("handled_always", (name,), each is None, Assumes(moment="every"), formula)
        not_led = "".join(f" & !objective({other})" for other in inside)
        ignored, answering = ((), ()) if each is None else (each.objectives, each.answering)
        for kind, names, asked in (
            ("ignored", ignored, objectives),
            ("answered_already", answering, inside),
        ):
            so = plain_names(net, names)
            for during in asked if few else so:
                formula = KINDS[kind].formula.format(name, during, not_led=not_led)
                yield Claim(kind, (name, during), during in so, formula=formula, severity=severity)
        idle = {*plain_names(net, (*ignored, *answering))}
        if not few and idle and (others := [other for other in objectives if other not in idle]):
            formula = KINDS["handled_else"].formula.format(name, running=_some("objective", others))
            yield Claim("handled_else", (name,), True, Assumes(moment="every"), formula)


def _of_late_losses(check: MissionCheck) -> Iterator[Claim]:
    """During what losses that are noticed late go unnoticed."""
    for each in check.late:
        for kind, names in (
            ("loss_unnoticed", each.unnoticed),
            ("loss_unnoticed_later", each.unnoticed_later),
            ("loss_found_in_time", each.in_time),
        ):
            for during in plain_names(check.mission_net, names):
                yield Claim(kind, (each.hardware, during), True)


def led_to(mission_net: MissionNet) -> Mapping[str, list[str]]:
    """By declared event the objectives that its handlers lead to."""
    copies = mission_net.graph.copies
    return {
        event: plain_names(mission_net, (n for n in copies.objectives if blocks & set(copies.around(n))))
        for event, blocks in led_to_by_events(mission_net.mission).items()
    }


def plain_names(mission_net: MissionNet, objectives: Iterable[str]) -> list[str]:
    """Objectives by the names that mean all copies of each."""
    copies = mission_net.graph.copies
    return list(dict.fromkeys(copies.plain(name) for name in objectives))


def copies_by_name(mission_net: MissionNet, objectives: Iterable[str]) -> Mapping[str, Sequence[str]]:
    """Objectives by the names that mean all copies of each, with all of these copies."""
    plain, every = mission_net.graph.copies.plain, mission_net.graph.copies.objectives
    found: dict[str, list[str]] = {name: [] for name in plain_names(mission_net, objectives)}
    for copy in every:
        if (name := plain(copy)) in found:
            found[name].append(copy)
    return found
