"""The pre-flight list of a page: what people test before the mission goes, for no proof covers it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from mcpn.report.words import folded
from mcpn.sentences import enumeration

if TYPE_CHECKING:
    from mcpn.findings import Findings

MOST_NAMED = 12
"""Names of one item."""


@dataclass(frozen=True)
class Tick:
    """Something to tick.

    Args:
        what: What to do.
        why: Why the proof does not do it.
    """

    what: str
    why: str


def preflight(findings: Findings) -> Iterator[Tick]:
    """What is to be tested before the mission goes, the most dangerous first."""
    yield from _single_losses(findings)
    yield from _aborts(findings)
    yield from _late(findings)
    yield from _ignored(findings)
    yield from _granted(findings)
    yield from _open(findings)
    yield Tick(
        "Run each driver once, with its hardware unplugged too: does it report what is lost?",
        "The proof speaks of the mission and its controller. Drivers are no part of it.",
    )


@dataclass(frozen=True)
class SingleLosses:
    """Hardware whose loss alone does harm.

    Args:
        defeats: What is lost before the start leaves no success.
        later: What does so only where it is lost at the worst moment.
        endangers: What leaves no safe end where it is lost at the worst moment, and nothing helps.
        helped: What leaves success only with the help of a declared event or a timeout, each with what helps.
    """

    defeats: Sequence[str] = ()
    later: Sequence[str] = ()
    endangers: Sequence[str] = ()
    helped: Mapping[str, Sequence[str]] = field(default_factory=dict)


def single_losses(findings: Findings) -> SingleLosses:
    """Hardware whose loss alone does harm, by what it does."""
    causes = findings.causes
    if causes is None:
        return SingleLosses()
    defeats = [lost[0] for lost in causes.mission.cut_sets if len(lost) == 1]

    held = [claim for claim in findings.claims if claim.holds]
    aided = [c.subject[0] for c in held if c.kind == "loss_defeats" and c.assumes.help == "declared"]
    later = [name for name in aided if name not in defeats]
    helped = {c.subject[0]: c.refers_to for c in held if c.kind == "loss_defeats" and c.refers_to}
    endangers = dict.fromkeys(c.subject[0] for c in held if c.kind == "loss_endangers")
    return SingleLosses(defeats, later, list(endangers), helped)


def _single_losses(findings: Findings) -> Iterator[Tick]:
    lost = single_losses(findings)
    if endangers := lost.endangers:
        why = f"{_each(endangers)} alone, at its worst moment, leaves no success and no safe abort."
        yield Tick(f"Test {_named(endangers)}: single points of failure.", why)
    if only := [name for name in lost.defeats if name not in endangers]:
        yield Tick(f"Test {_named(only)}.", f"{_each(only)} alone leaves no way to success.")
    if only := [name for name in lost.later if name not in endangers]:
        why = f"{_each(only)} alone leaves no way to success where it comes at the worst moment."
        yield Tick(f"Test {_named(only)}.", why)
    by_help: dict[tuple[str, ...], list[str]] = {}
    for name, helpers in lost.helped.items():
        by_help.setdefault(tuple(helpers), []).append(name)
    for helpers, names in by_help.items():
        why = f"Only they help after {_each(names)[:1].lower()}{_each(names)[1:]} at the worst moment."
        yield Tick(f"Test {_named(names)} with {_named(helpers)}.", why)


def _aborts(findings: Findings) -> Iterator[Tick]:
    causes = findings.causes
    if causes is not None and (names := folded(causes.mission_net, causes.unsafe_aborts)):
        yield Tick(
            f"Test {_named(names)}: {'its' if len(names) == 1 else 'their'} failure ends in abort, too.",
            "The mission calls this abort safe, though what should make it safe has failed.",
        )


def _ignored(findings: Findings) -> Iterator[Tick]:
    for ignored in findings.check.ignored[:MOST_NAMED]:
        yield Tick(f"Accept that {ignored.sentence}.", "Nothing around handles it there: it changes nothing.")


def _late(findings: Findings) -> Iterator[Tick]:
    mission = findings.check.mission_net.mission
    costs = {each.hardware: "; ".join(each.sentences) for each in findings.check.late}
    for hardware in mission.late:
        finders = [a.name for a in mission.activities if hardware.name in a.detects]
        by = f"{_named(finders)} runs, or " if finders else ""
        cost = costs.get(hardware.name, "")
        yield Tick(
            f"Test {hardware.name}: its loss is noticed late.",
            f"The robot learns of it only while {by}as an objective fails; until then it goes on"
            f"{': ' * bool(cost)}{cost}.",
        )


def _granted(findings: Findings) -> Iterator[Tick]:
    if sound := [h.name for h in findings.check.mission_net.mission.hardware if not h.faulty]:
        yield Tick(
            f"Check that {_named(sound)} cannot fail.", "The mission says so, and the proof believes it."
        )


def _open(findings: Findings) -> Iterator[Tick]:
    check = findings.check
    for name in check.undecided:
        yield Tick(f"Decide {name} in another way.", "The verdict is not known.")
    for answer in check.requirements:
        if answer.met is None:
            yield Tick(
                f"Decide '{answer.asked.words}' in another way.", answer.reason or "The answer is not known."
            )
        elif not answer.met and not answer.required:
            yield Tick(f"Accept that it does not hold: '{answer.asked.words}'.", "It is only advised.")
        elif answer.says_nothing_of:
            yield Tick(f"Read '{answer.asked.words}' again.", answer.says_nothing_of)
    if idle := list(dict.fromkeys(problem.message for problem in check.unselectable)):
        yield Tick(f"Accept what never runs: {'; '.join(idle[:3])}.", "It is declared, and no run does it.")
    for note in findings.notes:
        yield Tick("Find out what this page does not know.", note)
    if count := len(findings.warnings):
        yield Tick(
            f"Read the {f'{count} warnings' if count > 1 else 'warning'} below.",
            f"{'They are' if count > 1 else 'It is'} legal, and often not meant.",
        )


def _each(names: Sequence[str]) -> str:
    return "Its loss" if len(names) == 1 else "The loss of any one of them"


def _named(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMED
    return enumeration(names if more <= 0 else [*names[:MOST_NAMED], f"{more} more"])
