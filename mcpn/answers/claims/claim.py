"""A claim about a mission: its subject, answer and assumptions; claims alike are folded into one sentence."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import field
from typing import Any, Literal, NamedTuple, TypeAlias

from mcpn.answers.kinds.by_name import KINDS
from mcpn.answers.kinds.kind import ClaimKind
from mcpn.records import record
from mcpn.sentences import enumeration, shortened
from mcpn.spaces.run import Run


class Assumes(NamedTuple):
    """What runs may contain of which a claim speaks.

    Args:
        help: Whether declared events may happen and times may be over.
        repairs: Which hardware may be repaired: ``none``, ``all``, or what the claim does not name.
        failures: Whether objectives fail at any time, or only where they can no longer succeed (``forced``).
        moment: When: from the ``start`` on, at ``some`` moment, or at ``every`` moment.
        given: What it takes besides, in words: an objective that succeeds, hardware that works again.
    """

    help: Literal["none", "declared"] = "declared"
    repairs: Literal["none", "others", "all"] = "all"
    failures: Literal["forced", "any"] = "any"
    moment: Literal["start", "some", "every"] = "some"
    given: tuple[str, ...] = ()


Severity: TypeAlias = Literal["required", "advice", "informative"]
AT_SOME_MOMENT = Assumes()
MOST_NAMED = 12
"""Names of one sentence."""


@record(frozen=True)
class Claim:
    """What is said of one mission.

    Args:
        kind: The name of its kind.
        subject: What it is about: names of the mission, as its kind orders them.
        holds: Whether it is so; ``None`` where that is not known.
        assumes: Under which assumptions.
        formula: Holds on the mission's stable states where the claim does; empty where none says it.
        reason: Why it is not known.
        refers_to: What it names besides: of a claim that assumes no help the events with whose help it would
            be otherwise; how many losses.
        severity: Whether a mission must be so, had better be so, or may be so.
        during: Objectives that run at moments of which it speaks; ``""``: before the start.
        find_run: Looks for a run that shows it, where one does.
        find_lasso: The same of a run that goes on for ever, with the number of events before it repeats.
    """

    kind: str
    subject: tuple[str, ...]
    holds: bool | None
    assumes: Assumes = AT_SOME_MOMENT
    formula: str = ""
    reason: str = ""
    refers_to: tuple[str, ...] = ()
    severity: Severity = "informative"
    during: tuple[str, ...] = ()
    find_run: Callable[[], Run | None] | None = field(default=None, compare=False, repr=False)
    find_lasso: Callable[[], tuple[Run, int] | None] | None = field(default=None, compare=False, repr=False)

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
            "during": list(self.during),
            "evidence": self.of.evidence,
            "sentence": self.sentence,
        }


Makers: TypeAlias = Sequence[tuple[tuple[str, ...], Callable[[], Iterable[Claim]]]]
"""What makes claims, each after the kinds that it makes."""


def made_by(makers: Makers, kinds: Collection[str]) -> Iterator[Claim]:
    """The claims of some kinds; what makes none of them is not asked."""
    for own, make in makers:
        if any(kind in kinds for kind in own):
            yield from (claim for claim in make() if claim.kind in kinds)


def told(claims: Sequence[Claim], most: int = MOST_NAMED, moments: str | None = None) -> str:
    """Claims of one kind with one answer, which differ in one name of their subjects, as one sentence.

    Args:
        claims: At least one.
        most: Names that it has; it says how many more there are.
        moments: The moments of which they speak, in fewer words than their objectives.
    """
    first = claims[0]
    words = first.of.sentences[{True: 0, False: 1, None: 2}[first.holds]]
    subject = [list(dict.fromkeys(names)) for names in zip(*(claim.subject for claim in claims), strict=True)]
    # Sets of losses stand first.
    shown = [
        names[0] if len(names) == 1 else _several(first.of, names, most, ", " if number else first.of.joint)
        for number, names in enumerate(subject)
    ]
    given = f", and {enumeration(first.assumes.given)}," if first.assumes.given else ","
    when = _moments(first.during, most) if moments is None else moments
    said = words.format(
        *shown, given=given, others=enumeration(first.refers_to), moments=f", {when}" * bool(when)
    )
    help_ = enumeration(first.refers_to) or "declared events and timeouts"
    without = f" without the help of {help_}" if first.assumes.help == "none" else ""
    # Names are written as they are.
    name_first = words.startswith("{") and (not subject or said.startswith(subject[0][0]))
    begin = said if name_first else f"{said[:1].upper()}{said[1:]}"
    return f"{begin}{without}."


def _several(kind: ClaimKind, names: Sequence[str], most: int, joint: str) -> str:
    """Several names in the place of one."""
    more = f"{joint if len(joint) > 2 else ' and '}{len(names) - most} more"
    listed = enumeration(names) if joint == ", " else joint.join(names)
    if len(names) > most:
        listed = joint.join(names[:most]) + more
    return kind.several.format(listed)


def _moments(during: Sequence[str], most: int) -> str:
    """While which objectives run, or before the start."""
    names = [name for name in during if name]
    listed = enumeration(names) if len(names) <= most else shortened(names, most)
    while_ = [f"while {'one of ' * (len(names) > 1)}{listed} runs"] * bool(names)
    return ", or ".join([*while_, *["before the start"] * ("" in during)])


def sentences(claims: Iterable[Claim], most: int = MOST_NAMED, differ: int = 0) -> list[str]:
    """Claims in sentences; those that differ in one of their names alone are said together.

    Args:
        claims: Of any kinds.
        most: Names of one sentence.
        differ: Which of their names may differ.
    """
    together: dict[Any, list[Claim]] = {}
    for claim in claims:
        same = (*claim.subject[:differ], *claim.subject[differ + 1 :])
        key = claim.kind, same, claim.holds, claim.assumes, claim.refers_to, claim.during
        together.setdefault(key, []).append(claim)
    return [told(same, most) for same in together.values()]
