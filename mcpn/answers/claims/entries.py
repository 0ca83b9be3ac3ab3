"""Claims on what losses leave by one moment of a mission: from its start, from the entry of a section on."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.moments import Moments
from mcpn.answers.claims.of_check import MOST_PAIRS
from mcpn.answers.claims.parts import FormulaParts
from mcpn.sentences import counted, enumeration

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, Survival

LEFT = Assumes("declared", "others")
GOALS = (("defeat", "success"), ("endanger", "safety"))
"""What losses do to a goal of a mission, and what the goal is called within the name of a kind."""


def together(lost: Sequence[str]) -> str:
    """A set of losses, as a sentence names it."""
    return f"{enumeration(lost)}{' together' * (len(lost) > 1)}"


def claims_of_entries(causes: Causes) -> Iterator[Claim]:
    """What losses leave from the start and from the entry of each section on.

    Beyond :data:`MOST_PAIRS` pairs the sections at which a loss costs the same have one claim.
    """
    entries = [found for found in causes.survival if found.section is not None]
    every = len(causes.prospects.hardware) * len(entries) <= MOST_PAIRS
    formula = Moments(FormulaParts(causes.prospects)).lost_at_entry if every else _no_formula
    sections: dict[tuple[str, str], list[str]] = {}
    for found in causes.survival:
        name = found.section or ""
        moment = f"the entry of {name}" if name else "the start"
        for claim in claims_of_survival(found, name, moment, formula):
            if claim.kind.startswith("loss_at_entry"):
                sections.setdefault((claim.kind, claim.subject[0]), []).append(name)
            if every or not claim.kind.startswith("loss_at_entry"):
                yield claim
    for (kind, lost), harmed in sections.items() if not every else ():
        yield Claim(kind, (lost, enumeration(harmed)), True, LEFT)
    for verb, noun in GOALS:
        reached = [f.section or "" for f in entries if noun == "success" or f.safety is not None]
        lost_for_all = {f.section for f in entries if (level := _level(f, noun)) and () in level.cut_sets}
        for name in causes.prospects.hardware:
            harmed_by = {*sections.get((kind := f"loss_at_entry_{verb}s", name), ())} | lost_for_all
            spared = [section for section in reached if section not in harmed_by]
            for section in spared if every else ():
                yield Claim(kind, (name, section), False, LEFT, formula(kind, section, (name,)))
            if spared and not every:
                yield Claim(f"loss_at_entries_spares_{noun}", (name,), True, LEFT)


def _no_formula(kind: str, section: str, lost: Sequence[str] = ()) -> str:
    """That there is none."""
    return ""


def claims_of_survival(
    found: Survival, section: str, moment: str, formula: Callable[..., str] = _no_formula
) -> Iterator[Claim]:
    """What the mission survives from one moment on.

    Args:
        found: At that moment.
        section: The section that is entered then, or several in words; empty of the start.
        moment: The moment, in words.
        formula: Of a kind on one section the formula, where there is one; see :class:`Moments`.
    """
    for verb, noun in GOALS:
        level = _level(found, noun)
        if level is None:
            continue
        if level.always is None or level.at_most is None:
            if section:
                kind = f"no_way_from_entry_to_{noun}"
                yield Claim(kind, (section,), True, formula=formula(kind, section))
            continue
        for lost in level.cut_sets if section else ():
            kind = f"loss_at_entry_{verb}s"
            yield Claim(kind, (together(lost), section), True, LEFT, formula(kind, section, lost))
        if not level.always and not level.cut_sets:
            continue  # nothing may be lost, so that no number of losses is survived or not
        number = counted(level.always or 1, "resource")
        yield Claim(f"any_lost_{verb}", (moment,), not level.always, LEFT, refers_to=(number,))
        number = counted(level.at_most, "resource")
        yield Claim(f"most_lost_spare_{noun}", (moment,), True, LEFT, refers_to=(number,))


def _level(found: Survival, noun: str) -> Survival | None:
    return found if noun == "success" else found.safety
