"""Formulas of claims on losses that are noticed late: what goes on in vain, in the present run."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from typing import Any

from mcpn.answers.claims.claim import Claim
from mcpn.answers.claims.of_check import plain_names
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import Event, What

LATE = ("loss_unnoticed", "loss_unnoticed_later")
"""Kinds of claims on late losses that have a formula."""


def late_losses(claims: Iterable[Claim], parts: FormulaParts[Any]) -> Iterator[Claim]:
    """What losses that are noticed late cost; of what they cost nothing too, where a formula says it."""
    held = {(claim.kind, claim.subject): claim for claim in claims if claim.kind in LATE}
    for (kind, (hardware, objective)), claim in held.items():
        formulas = _unnoticed(parts, hardware, objective)
        yield replace(claim, formula=formulas[LATE.index(kind)])
    for late in (h.name for h in parts.net.core.late if ("known", h.name) in parts.net.by_role):
        for objective in plain_names(parts.net, parts.prospects.objectives):
            for kind, formula in zip(LATE, _unnoticed(parts, late, objective), strict=True):
                if formula and (kind, (late, objective)) not in held:
                    yield Claim(kind, (late, objective), False, formula=formula)


def _unnoticed(parts: FormulaParts[Any], hardware: str, name: str) -> tuple[str, str]:
    """That nothing notices a loss: while nothing else has failed; and only once something has."""
    prospects, space, open_ = parts.prospects, parts.space, open_run(parts, name)
    if not open_:
        return "", ""
    events = {t: str(space.net.transitions[t].event) for t in prospects.failing}
    own = prospects.carrying(What.OUT_OF_SERVICE, hardware)
    beside = sorted({event for t, event in events.items() if t not in own})
    runs = f"objective({name})"
    found = Event(What.DETECTED, hardware)
    finding = f" & !event({found})" if prospects.carrying(What.DETECTED, hardware) else ""
    lost = f"happens({hardware}_EV_OOS) & X ({runs} & !{open_}{finding})"
    alone = " & ".join(f"!happens({event})" for event in beside) or "true"
    said = {"alone": alone, "sound": parts.sound, "open": open_, "lost": lost}
    first, later = (KINDS[kind].formula.format(hardware, name, **said) for kind in LATE)
    return first, later


def open_run(parts: FormulaParts[Any], name: str) -> str:
    """That the present run of an objective can still succeed without a repair, where a formula says it."""
    space, goal = parts.space, parts.prospects.objectives.get(name)
    if goal is None or not parts.mean_one([name]) or not goal.won or goal.ends_from:
        return ""
    # Where an event ends a run and begins the next one, no word tells the two apart.
    if space.after(goal.running, goal.ends) & goal.running:
        return ""
    runs, ends = f"objective({name})", f"event({Event(What.SUCCESS, name)})"
    steps = " & ".join([runs, *(f"!happens({event})" for event in parts.repairs)])
    return f"E(({steps}) U ({runs} & {ends}))"
