"""Claims on sets of losses, before the start and later, and on aborts; and all claims on causes together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.claims.asked import claims_of_aborts
from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.critical import claims_of_critical
from mcpn.answers.claims.entries import GOALS, claims_of_entries, together
from mcpn.answers.claims.helped import Helped
from mcpn.answers.claims.made import claims_of, claims_of_losses, in_order
from mcpn.answers.claims.moments import Moments
from mcpn.answers.claims.of_cells import claims_of_cells
from mcpn.answers.claims.of_objectives import claims_of_objectives
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.claims.reached import Reached
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import HELPING, What
from mcpn.sentences import enumeration

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, GoalCauses
    from mcpn.answers.causes.fmeca import Row
    from mcpn.answers.verdicts.mission import MissionCheck

BEFORE = Assumes(repairs="others", moment="start")
UNAIDED = Assumes("none", "others", moment="start")


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
    found += claims_of_aborts(FormulaParts(causes.prospects))
    found += claims_of_entries(causes)
    found += claims_of_objectives(causes)
    found += Reached(causes.prospects).hardware()
    found += Helped(FormulaParts(causes.prospects)).needs_help()
    found += claims_of_cells(rows, FormulaParts(causes.prospects))
    if causes.safety is not None and () in causes.safety.cut_sets:
        found.append(Claim("can_end_safely", (), False))
    if () in causes.mission.cut_sets:
        found.append(Claim("can_succeed", (), False, formula=KINDS["can_succeed"].formula))
    return in_order(found)


def all_claims(check: MissionCheck, causes: Causes | None, rows: Sequence[Row] = ()) -> list[Claim]:
    """The claims of a check and those on losses, each once."""
    found = [*claims_of(check), *([] if causes is None else claims_of_causes(causes, rows))]
    return [*{claim.key: claim for claim in found}.values()]


def _of_goal(causes: Causes, goal: GoalCauses, verb: str, words: str) -> Iterator[Claim]:
    """Of each loss before the start whether it does harm, and the sets of several that do."""
    before, at_worst = f"loss_before_{verb}s", f"losses_{verb}"
    mission, prospects = causes.mission_net.core, causes.prospects
    certain = causes.safety is not goal or (prospects.safety is not None and not prospects.safety.ends_from)
    yield from claims_of_critical(causes, goal, verb, words, certain)
    reached = prospects.mission if causes.safety is not goal else prospects.safety
    assert reached is not None, "it can abort"
    parts, kind = FormulaParts(prospects), f"without_repair_{verb}ed"
    needs_repair = not prospects.hopeful(reached, repairs=False) & prospects.space.initial
    unrepaired = parts.reaches(reached, parts.repairs)
    said = KINDS[kind].formula.format(unrepaired=unrepaired) if unrepaired else ""
    yield Claim(kind, (), needs_repair, Assumes(repairs="none", moment="start"), said)
    if () in goal.cut_sets:
        return
    # What crashes as it runs is never lost before by an event; that it is gone from the start is supposed.
    begin = prospects.space.initial
    fails = {name: prospects.carrying(What.OUT_OF_SERVICE, name) for name in prospects.hardware}
    can_fail = [name for name, own in fails.items() if own and begin & prospects.space.enabling(own)]
    alone = [(name,) for name in can_fail if name not in causes.unused]
    known, minimal = {*can_fail}, {*goal.cut_sets}
    several = [lost for lost in goal.cut_sets if len(lost) > 1 and {*lost} <= known]
    certain = not any(h.initial == "oos" for h in mission.hardware)

    def formula(lost: Sequence[str], left_out: Sequence[str] = ()) -> str:
        """That no run succeeds after these losses without some events."""
        repairs = [f"{name}_EV_RD" for name in lost if prospects.carrying(What.REPAIRED, name)]
        reaches = parts.reaches(reached, [*left_out, *repairs])
        said = f"!{reaches}"
        for name in reversed(lost):
            said = KINDS[before].formula.format(name, then=said)
        return said if certain and reaches else ""

    for lost in (*alone, *several):
        yield Claim(before, (together(lost),), lost in minimal, BEFORE, formula(lost))
    if goal.unaided is not None and goal.unaided.helpers:
        help_ = sorted(str(event) for event in prospects.space.net.events if event.what in HELPING)
        for lost in (
            lost for lost in goal.unaided.cut_sets if lost and lost not in minimal and {*lost} <= known
        ):
            said = formula(lost, help_)
            yield Claim(before, (together(lost),), True, UNAIDED, said, refers_to=goal.unaided.helpers)
    for lost in (lost for lost in goal.cut_sets if not {*lost} <= known):
        yield Claim(f"missing_{verb}s", (enumeration(lost),), True, BEFORE)
    for lost in (lost for lost in goal.only_at_worst if len(lost) > 1):
        said = Moments(parts).lost_at_worst(at_worst, lost)
        yield Claim(at_worst, (together(lost),), True, Assumes(repairs="others"), said)
    if goal.nonmonotone is not None:
        less, more = enumeration(goal.nonmonotone.lost) or "nothing", enumeration(goal.nonmonotone.larger)
        yield Claim(f"more_losses_spare_{dict(GOALS)[verb]}", (less, more), True, Assumes(repairs="none"))
