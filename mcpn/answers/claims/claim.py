"""One claim about a mission: of which kind, about what, whether it holds, and under which assumptions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Literal, NamedTuple

from mcpn.answers.claims.kinds import KINDS, ClaimKind
from mcpn.sentences import enumeration
from mcpn.spaces.run import Run


class Assumes(NamedTuple):
    """What runs may contain of which a claim speaks.

    Args:
        help: Whether declared events may happen and times may be over.
        repairs: Which hardware may be repaired: ``all``, or that of ``others`` than the claim names.
        failures: Whether objectives fail at any time, or only where they can no longer succeed (``forced``).
        moment: When: from the ``start`` on, at ``some`` moment, or at ``every`` moment.
    """

    help: Literal["none", "declared"] = "declared"
    repairs: Literal["others", "all"] = "all"
    failures: Literal["forced", "any"] = "any"
    moment: Literal["start", "some", "every"] = "some"


AT_SOME_MOMENT = Assumes()


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
        find_run: Looks for a run that shows it, where one does.
    """

    kind: str
    subject: tuple[str, ...]
    holds: bool | None
    assumes: Assumes = AT_SOME_MOMENT
    formula: str = ""
    reason: str = ""
    refers_to: tuple[str, ...] = ()
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
            "reason": self.reason,
            "assumes": self.assumes._asdict(),
            "formula": self.formula or None,
            "refers_to": list(self.refers_to),
            "evidence": self.of.evidence,
            "sentence": self.sentence,
        }


def told(claims: list[Claim]) -> str:
    """Claims of one kind with one answer, which differ in the first name of their subjects, as one sentence.

    Args:
        claims: At least one.
    """
    first = claims[0]
    words = first.of.sentences[{True: 0, False: 1, None: 2}[first.holds]]
    about = list(dict.fromkeys(claim.subject[0] for claim in claims if claim.subject))
    names = f"any one of {enumeration(about)}" if len(about) > 1 else enumeration(about)
    said = words.format(names, *first.subject[1:], others=enumeration(first.refers_to))
    help_ = enumeration(first.refers_to) or "declared events and timeouts"
    without = f" without the help of {help_}" if first.assumes.help == "none" else ""
    return f"{said[:1].upper()}{said[1:]}{without}."
