"""Two missions compared, for people and for programs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from mcpn.answers.claims.claim import Claim, sentences
from mcpn.answers.versions import Apart, Changed, VersionDifference
from mcpn.report.terminal import Terminal
from mcpn.sentences import enumeration, shortened

MOST_TOLD = 20
"""Sentences of one heading; JSON has all."""


def difference_object(found: VersionDifference, first: str, second: str) -> dict[str, Any]:
    """The comparison for programs.

    Args:
        found: The comparison.
        first: The file of the first mission.
        second: That of the second one.
    """
    return {
        "first": first,
        "second": second,
        "same": found.same,
        "gained": [_pair(each) for each in found.gained],
        "lost": [_pair(each) for each in found.lost],
        "changed": [_pair(each) for each in found.changed],
        "claims": _sides(
            [c.to_json() for c in found.claims.first], [c.to_json() for c in found.claims.second]
        ),
        "verdicts": {name: _sides(*answers) for name, answers in found.verdicts.items()},
        "cut_sets": {
            name: _sides(*([list(lost) for lost in side] for side in only))
            for name, only in found.cut_sets.items()
        },
        "modes": {name: _sides(*map(list, only)) for name, only in found.modes.items()},
        "requirements": {name: _sides(*asks) for name, asks in found.requirements.items()},
        "notes": list(found.notes),
    }


def _sides(first: Any, second: Any) -> dict[str, Any]:
    return {"first": first, "second": second}


def _pair(changed: Changed) -> dict[str, Any]:
    return _sides(changed.before.to_json(), changed.after.to_json()) | {"key": changed.after.key}


def print_difference(found: VersionDifference, first: str, second: str) -> None:
    """Prints what the second mission loses or gains.

    Args:
        found: The comparison.
        first: The file of the first mission.
        second: That of the second one.
    """
    terminal = Terminal()
    if found.same:
        terminal.print(f"{second} loses and gains nothing over {first}", style="bold")
    sections: dict[str, Sequence[str]] = {
        f"what {second} loses": sentences([each.after for each in found.lost]),
        f"what {second} gains": sentences([each.after for each in found.gained]),
        "what changes otherwise": [
            f"{'; '.join(sentences([each.before]))} Now: {'; '.join(sentences([each.after]))}"
            for each in found.changed
        ],
        "requirements that do not ask the same": [
            f"{name}: {was}; then: {now}" for name, (was, now) in found.requirements.items()
        ],
        f"what is said of {first} alone": _told(found.claims.first),
        f"what is said of {second} alone": _told(found.claims.second),
        "verdicts": [
            f"{name}: {_answer(was)}, then {_answer(now)}" for name, (was, now) in found.verdicts.items()
        ],
        "smallest losses that defeat": [*_apart(found.cut_sets, first, second)],
        "functioning modes": [*_apart(found.modes, first, second)],
    }
    for heading, lines in sections.items():
        if lines:
            terminal.print(heading, style="bold")
            for line in lines[:MOST_TOLD]:
                terminal.print(line, indent=2)
            if (more := len(lines) - MOST_TOLD) > 0:
                terminal.print(f"and {more} more, which --json lists", indent=2)
    if not found.same and not any(sections.values()):
        terminal.print("one is asked what the other is not, and it does not hold: --json lists it")
    for note in found.notes:
        terminal.print(note, style="yellow")


def _told(alone: Sequence[Claim]) -> Sequence[str]:
    """Claims of one mission alone: those that hold, and those that should."""
    return sentences(
        [claim for claim in alone if claim.holds is not False or claim.severity != "informative"]
    )


def _answer(holds: bool | None) -> str:
    return {True: "holds", False: "fails", None: "not known"}[holds]


def _apart(found: Mapping[str, Apart[Any]], first: str, second: str) -> Iterator[str]:
    for name, only in found.items():
        sides = []
        for file, those in zip((first, second), only, strict=True):
            if those:
                said = [each if isinstance(each, str) else enumeration(each) or "nothing" for each in those]
                sides.append(f"only in {file}: {shortened(said)}")
        yield f"{name}: {'; '.join(sides)}"
