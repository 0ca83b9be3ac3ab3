"""The pre-flight list of a page: what people test before the mission goes, for no proof covers it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Claim, sentences, told
from mcpn.report.pages.story import late_losses
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


def _single_losses(findings: Findings) -> Iterator[Tick]:
    told = set[str]()
    for kind in ("loss_endangers", "loss_before_defeats", "loss_defeats"):
        lost = [c for c in findings.held(kind) if c.assumes.help == "declared" or c.refers_to]
        lost = [c for c in lost if c.subject[0] not in told and c.subject[0] in _hardware(findings)]
        told |= {claim.subject[0] for claim in lost}
        for sentence, names in _together(lost):
            yield Tick(f"Test {_named(names)}.", sentence)


def _hardware(findings: Findings) -> set[str]:
    return {hardware.name for hardware in findings.check.mission_net.core.hardware}


def _together(claims: Sequence[Claim]) -> Iterator[tuple[str, list[str]]]:
    """Claims of one kind that differ in their first name, in a sentence, and these names and what helps."""
    by_help: dict[tuple[str, ...], list[Claim]] = {}
    for claim in claims:
        by_help.setdefault(claim.refers_to, []).append(claim)
    for helpers, same in by_help.items():
        yield told(same), [*(claim.subject[0] for claim in same), *helpers]


def _aborts(findings: Findings) -> Iterator[Tick]:
    for sentence, names in _together(findings.held("abort_after")):
        yield Tick(f"Test {_named(names)}.", sentence)


def _ignored(findings: Findings) -> Iterator[Tick]:
    for sentence in list(sentences(findings.held("ignored"), differ=1))[:MOST_NAMED]:
        yield Tick(f"Accept this: {sentence}", "Nothing around handles it there: it changes nothing.")


def _late(findings: Findings) -> Iterator[Tick]:
    mission = findings.check.mission_net.core
    for hardware in mission.late:
        finders = [a.name for a in mission.activities if hardware.name in a.detects]
        by = f"{_named(finders)} runs, or " if finders else ""
        costs = sentences(claim for claim in late_losses(findings) if claim.subject[0] == hardware.name)
        yield Tick(
            f"Test {hardware.name}: its loss is noticed late.",
            " ".join([f"The robot learns of it only while {by}as an objective fails.", *costs]),
        )


def _granted(findings: Findings) -> Iterator[Tick]:
    if sound := [h.name for h in findings.check.mission_net.core.hardware if not h.faulty]:
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


def _named(names: Sequence[str]) -> str:
    more = len(names) - MOST_NAMED
    return enumeration(names if more <= 0 else [*names[:MOST_NAMED], f"{more} more"])
