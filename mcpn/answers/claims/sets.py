"""Claims on hardware that is lost before the start, on sets of losses, and on aborts after a failure."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.entries import claims_of_entries
from mcpn.answers.claims.found import plain_names
from mcpn.answers.claims.kinds import KINDS
from mcpn.answers.claims.made import claims_of_losses, in_order, some_run
from mcpn.events import What
from mcpn.sentences import enumeration

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, GoalCauses
    from mcpn.answers.causes.fmeca import Row

BEFORE = Assumes(repairs="others", moment="start")


def claims_of_causes(causes: Causes, rows: Sequence[Row] = ()) -> list[Claim]:
    """The claims on what losses cost, in the order of their kinds.

    Args:
        causes: Of a mission.
        rows: Its FMECA table, where there is one.
    """
    found = claims_of_losses(causes.prospects, rows)
    found += _of_goal(causes, causes.mission, "defeat", "success")
    if causes.safety is not None:
        found += _of_goal(causes, causes.safety, "endanger", "(success | abort)")
    found.append(Claim("says_what_is_safe", (), causes.safety is not None))
    names = plain_names(causes.mission_net, causes.unsafe_aborts)
    found += [Claim("abort_after", (name,), True) for name in names]
    found += claims_of_entries(causes)
    return in_order(found)


def _of_goal(causes: Causes, goal: GoalCauses, verb: str, words: str) -> Iterator[Claim]:
    """Of each loss before the start whether it does harm, and the sets of several that do."""
    before, at_worst = f"loss_before_{verb}s", f"losses_{verb}"
    needs_repair = () in goal.cut_sets
    yield Claim(f"without_repair_{verb}ed", (), needs_repair, Assumes(moment="start"))
    if needs_repair:
        return
    mission, prospects = causes.mission_net.mission, causes.prospects
    # What crashes as it runs is never lost before by an event; that it is gone from the start is supposed.
    begin = prospects.space.initial
    fails = {name: prospects.carrying(What.OUT_OF_SERVICE, name) for name in prospects.hardware}
    can_fail = [name for name, own in fails.items() if own and begin & prospects.space.enabling(own)]
    alone = [(name,) for name in can_fail if name not in causes.unused]
    known, minimal = {*can_fail}, {*goal.cut_sets}
    several = [lost for lost in goal.cut_sets if len(lost) > 1 and {*lost} <= known]
    certain = causes.safety is not goal or (prospects.safety is not None and not prospects.safety.ends_from)
    certain &= not any(h.initial == "oos" for h in mission.hardware)
    for lost in (*alone, *several):
        repairs = [f"{name}_EV_RD" for name in lost if prospects.carrying(What.REPAIRED, name)]
        formula = f"!{some_run(repairs, words)}"
        for name in reversed(lost):
            formula = KINDS[before].formula.format(name, then=formula)
        yield Claim(before, (_set(lost),), lost in minimal, BEFORE, formula if certain else "")
    for lost in (lost for lost in goal.cut_sets if not {*lost} <= known):
        yield Claim(f"missing_{verb}s", (enumeration(lost),), True, BEFORE)
    for lost in (lost for lost in goal.only_at_worst if len(lost) > 1):
        yield Claim(at_worst, (_set(lost),), True, Assumes(repairs="others"))


def _set(lost: Sequence[str]) -> str:
    return f"{enumeration(lost)}{' together' * (len(lost) > 1)}"
