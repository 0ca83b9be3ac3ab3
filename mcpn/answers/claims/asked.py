"""Formulas of claims that a check makes without its states, and that its states can be asked for."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.late import LATE, late_losses
from mcpn.answers.claims.of_check import plain_names
from mcpn.answers.claims.parts import MOST_NAMED, FormulaParts
from mcpn.answers.kinds.by_name import KINDS
from mcpn.logic.evaluate import Evaluation

if TYPE_CHECKING:
    from mcpn.answers.requirements import RequirementAnswer
    from mcpn.answers.verdicts.mission import MissionCheck


def with_formulas(
    claims: Iterable[Claim], check: MissionCheck, parts: FormulaParts[Any], kinds: Collection[str]
) -> Iterator[Claim]:
    """The same claims, with formulas where these need states or routes; and the late losses that are not.

    Args:
        claims: Some claims.
        check: What was found.
        parts: The parts of formulas.
        kinds: Kinds of claims; the others are left out.
    """
    found = list(claims)

    def nominal() -> Mapping[str, str]:
        good, lasts = parts.goes_well()
        return {"good": good, "lasts": lasts}

    said: dict[str, Callable[[], Mapping[str, str]]] = {
        "nominal_success": nominal,
        "nominal_endless": lambda: {**nominal(), "as_meant": parts.as_meant},
        "nominal_either": lambda: {**nominal(), "as_meant": parts.as_meant},
        "can_always_end_safely": lambda: {
            "safe": "" if parts.prospects.safety is None else _safe_from(parts)
        },
        "aborted_by_failure": lambda: {
            "some": " | ".join(_aborts_after(parts, name) for name in _failing(parts))
        },
        "required_events_handled": lambda: {"ignored": _ignored(found, check)},
    }
    for claim in (claim for claim in found if claim.kind in kinds):
        if claim.kind in said:
            told = said[claim.kind]()
            formula = KINDS[claim.kind].formula.format(**told) if all(told.values()) else ""
            yield replace(claim, formula=formula)
        elif claim.kind not in LATE:
            yield claim
    if any(kind in kinds for kind in LATE):
        yield from late_losses(found, parts)
    for answer in check.requirements if "met_as_never" in kinds else ():
        yield from _vacuous(answer, check)


def _safe_from(parts: FormulaParts[Any]) -> str:
    """That a safe end is reached from here, or that the mission has been aborted."""
    safe = parts.prospects.safety
    assert safe is not None, "it can abort"
    formula = parts.reaches(safe)
    return formula and (f"abort | {formula}" if safe.ends_from else formula)


def _ignored(claims: Iterable[Claim], check: MissionCheck) -> str:
    """That an event that must be handled is ignored."""
    required = {event.name for event in check.mission_net.core.events if event.required}
    each = [c.formula for c in claims if c.kind == "ignored" and c.subject[0] in required]
    return (" | ".join(each) or "false") if len(each) <= MOST_NAMED else ""


def _failing(parts: FormulaParts[Any]) -> list[str]:
    """The objectives by which a mission may abort; none where no formula says it of each."""
    names = list(parts.prospects.sections)
    return names if parts.nominal and parts.mean_one(names) else []


def _aborts_after(parts: FormulaParts[Any], name: str) -> str:
    fails = " | ".join(parts.failures_of(name)) or "false"
    return KINDS["abort_after"].formula.format(fails=fails, shelters=parts.shelters_by(name))


def claims_of_aborts(parts: FormulaParts[Any]) -> Iterator[Claim]:
    """Of each objective whether it should make safe and the mission aborts by its failure."""
    aborts = parts.prospects.aborts
    if aborts is None:
        return
    told = set(_failing(parts))
    unsafe = plain_names(parts.net, aborts.unsafe)
    for name in plain_names(parts.net, parts.prospects.sections):
        formula = _aborts_after(parts, name) if name in told else ""
        if name in unsafe or formula:
            yield Claim("abort_after", (name,), name in unsafe, formula=formula)


def _vacuous(answer: RequirementAnswer, check: MissionCheck) -> Iterator[Claim]:
    """Of each part that may be replaced by anything whether it never comes about."""
    from mcpn.answers.claims.of_check import asked_formula
    from mcpn.logic.syntax import parse

    formula = asked_formula(answer)
    if not answer.vacuous or not formula or check.alternatives is None:
        return
    evaluation = Evaluation(check.alternatives)
    for part in answer.vacuous:
        comes = evaluation.holds(parse(f"E(F {part})", answer.asked.names))
        said = KINDS["met_as_never"].formula.format(answer.asked.name, part, formula=formula)
        yield Claim("met_as_never", (answer.asked.name, part), not comes, Assumes(moment="start"), said)
