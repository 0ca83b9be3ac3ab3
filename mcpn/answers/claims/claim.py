"""One claim about a mission: of which kind, about what, whether it holds, and under which assumptions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple, TypeAlias

from mcpn.answers.claims.kind import ClaimKind
from mcpn.answers.claims.kinds import KINDS
from mcpn.sentences import enumeration
from mcpn.spaces.run import Run


class Assumes(NamedTuple):
    """What runs may contain of which a claim speaks.

    Args:
        help: Whether declared events may happen and times may be over.
        repairs: Which hardware may be repaired: ``all``, or that of ``others`` than the claim names.
        failures: Whether objectives fail at any time, or only where they can no longer succeed (``forced``).
        moment: When: from the ``start`` on, at ``some`` moment, or at ``every`` moment.
        given: What it takes besides, in words: an objective that succeeds, hardware that works again.
    """

    help: Literal["none", "declared"] = "declared"
    repairs: Literal["others", "all"] = "all"
    failures: Literal["forced", "any"] = "any"
    moment: Literal["start", "some", "every"] = "some"
    given: tuple[str, ...] = ()


Severity: TypeAlias = Literal["required", "advice", "informative"]
AT_SOME_MOMENT = Assumes()
MOST_NAMED = 12
"""Names of one sentence."""


@dataclass(frozen=True)
class Claim:
    """What is said of one mission.

    Args:
        kind: The name of its kind.
        subject: What it is about: names of the mission, as its kind orders them.
        holds: Whether it is so; ``None`` where that is not known.
        assumes: Under which assumptions.
        formula: Holds on the mission's stable states where the claim does; empty where none says it.
        reason: Why it is not known.
        refers_to: Other events that it names: of a claim that assumes no help those with whose help it would
            be otherwise.
        severity: Whether a mission must be so, had better be so, or may be so.
        find_run: Looks for a run that shows it, where one does.
    """

    kind: str
    subject: tuple[str, ...]
    holds: bool | None
    assumes: Assumes = AT_SOME_MOMENT
    formula: str = ""
    reason: str = ""
    refers_to: tuple[str, ...] = ()
    severity: Severity = "informative"
    find_run: Callable[[], Run | None] | None = field(default=None, compare=False, repr=False)

    @property
    def of(self) -> ClaimKind:
        """Its kind."""
        return KINDS[self.kind]

    @property
    def key(self) -> str:
        """The same for one claim of all versions of a mission: its kind, its subject, what helps."""
        aided = [] if self.assumes.help == "declared" else ["without help"]
        return ": ".join([self.kind, *filter(None, [", ".join(self.subject)]), *aided])

    @property
    def sentence(self) -> str:
        """What is so, in a sentence."""
        return told([self])

    def to_json(self) -> dict[str, Any]:
        """The claim as a JSON object."""
        return {
            "key": self.key,
            "kind": self.kind,
            "subject": list(self.subject),
            "holds": self.holds,
            "severity": self.severity,
            "reason": self.reason,
            "assumes": {**self.assumes._asdict(), "given": list(self.assumes.given)},
            "formula": self.formula or None,
            "refers_to": list(self.refers_to),
            "evidence": self.of.evidence,
            "sentence": self.sentence,
        }


def told(claims: Sequence[Claim], most: int = MOST_NAMED) -> str:
    """Claims of one kind with one answer, which differ in one name of their subjects, as one sentence.

    Args:
        claims: At least one.
        most: Names that it has; it says how many more there are.
    """
    first = claims[0]
    words = first.of.sentences[{True: 0, False: 1, None: 2}[first.holds]]
    subject = [list(dict.fromkeys(names)) for names in zip(*(claim.subject for claim in claims), strict=True)]
    shown = [names[0] if len(names) == 1 else _several(first.of, names, most) for names in subject]
    given = f", and {enumeration(first.assumes.given)}," if first.assumes.given else ","
    said = words.format(*shown, given=given, others=enumeration(first.refers_to))
    help_ = enumeration(first.refers_to) or "declared events and timeouts"
    without = f" without the help of {help_}" if first.assumes.help == "none" else ""
    # Names are written as they are.
    begin = said if words.startswith("{") else f"{said[:1].upper()}{said[1:]}"
    return f"{begin}{without}."


def _several(kind: ClaimKind, names: Sequence[str], most: int) -> str:
    """Several names in the place of one."""
    more = f"{kind.joint if len(kind.joint) > 2 else ' and '}{len(names) - most} more"
    listed = enumeration(names) if kind.joint == ", " else kind.joint.join(names)
    if len(names) > most:
        listed = kind.joint.join(names[:most]) + more
    return kind.several.format(listed)


def sentences(claims: Iterable[Claim], most: int = MOST_NAMED) -> list[str]:
    """Claims in sentences; those that differ in their first name alone are said together."""
    together: dict[Any, list[Claim]] = {}
    for claim in claims:
        key = claim.kind, claim.subject[1:], claim.holds, claim.assumes, claim.refers_to
        together.setdefault(key, []).append(claim)
    return [told(same, most) for same in together.values()]


def told_together(claims: Iterable[Claim], by: int, most: int = MOST_NAMED) -> Iterator[str]:
    """Claims of one kind with one answer in sentences, those together that have one name in common.

    Args:
        claims: Of one kind.
        by: Which name of their subjects.
        most: As of :func:`told`.
    """
    together: dict[str, list[Claim]] = {}
    for claim in claims:
        together.setdefault(claim.subject[by], []).append(claim)
    return (told(same, most) for same in together.values())
