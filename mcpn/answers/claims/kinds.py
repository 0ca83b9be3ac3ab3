"""The kinds of claims: of each its formula as a template, its three sentences, its evidence, who shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

PAGE, JSON = "page", "JSON"


class ClaimKind(NamedTuple):
    """A kind of claim.

    Args:
        name: A stable name.
        formula: A template: it holds where the claim does. Empty where no formula says it.
        holds: What is so where it holds; ``{0}``, ``{1}``: the names of the subject, in their order.
        fails: What is so where it does not.
        unknown: What is said where that is not known.
        evidence: What shows it.
        shown: Where it is shown.
        why: Why there is no formula.
        good: Whether a mission is better where it holds; ``None`` of what is neither good nor bad.
    """

    name: str
    formula: str
    holds: str
    fails: str
    unknown: str
    evidence: str
    shown: tuple[str, ...] = (JSON,)
    why: str = ""
    good: bool | None = None

    @property
    def sentences(self) -> tuple[str, str, str]:
        """Where it holds, fails, is not known; without their full stop."""
        return self.holds, self.fails, self.unknown


_SAFE_ENDS = "where an abort may come by the failure of what should make safe, safe ends are events"

KINDS: Mapping[str, ClaimKind] = {
    kind.name: kind
    for kind in (
        ClaimKind(
            "can_succeed",
            "EF success",
            "the mission can succeed",
            "the mission can never succeed",
            "whether the mission can succeed is not known",
            "a run",
            good=True,
        ),
        ClaimKind(
            "can_fail",
            "EF failure",
            "the mission can end in failure",
            "the mission can never end in failure",
            "whether the mission can end in failure is not known",
            "a run",
            good=False,
        ),
        ClaimKind(
            "can_be_aborted",
            "EF abort",
            "the mission can be aborted",
            "the mission is never aborted",
            "whether the mission can be aborted is not known",
            "a run",
        ),
        ClaimKind(
            "can_always_end",
            "AG EF ({ends})",
            "whatever has happened, the mission can still end",
            "the mission can reach a state from which it cannot end",
            "whether the mission can always end is not known",
            "all states; where it fails, a run",
            good=True,
        ),
        ClaimKind(
            "can_always_end_safely",
            "AG EF (success | abort)",
            "whatever has happened, the mission can still end safely, in success or abort",
            "the mission can reach a state from which it cannot end safely, in success or abort",
            "whether the mission can always end safely is not known",
            "all states; where it fails, a run",
            why=_SAFE_ENDS,
            good=True,
        ),
        ClaimKind(
            "can_always_go_on",
            "AG (deadlock -> {ends})",
            "in every state before the mission ends some event is possible",
            "the robot can get stuck: no event is possible, and the mission has not ended",
            "whether the robot can get stuck is not known",
            "all states; where it fails, a run",
            good=True,
        ),
        ClaimKind(
            "succeeds_without",
            "E((!happens(OBJ_{0}_EV_OK)) U success)",
            "the mission may end in success without {0}",
            "the mission ends in success only if {0} has succeeded",
            "whether the mission may end in success without {0} is not known",
            "a run",
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "loss_defeats",
            "EF ({sound} & {wins} & E(happens({0}_EV_OOS) & X !{wins_unrepaired}))",
            "the loss of {0} alone, at its worst moment, leaves no way to success",
            "after the loss of {0} alone, whenever it comes, success stays possible",
            "whether the loss of {0} alone leaves a way to success is not known",
            "all states in which no hardware is lost, and the loss in each",
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "loss_endangers",
            "EF ({sound} & {wins} & E(happens({0}_EV_OOS) & X !{wins_unrepaired}))",
            "the loss of {0} alone, at its worst moment, leaves no safe end",
            "after the loss of {0} alone, whenever it comes, a safe end stays possible",
            "whether the loss of {0} alone leaves a safe end is not known",
            "all states in which no hardware is lost, and the loss in each",
            why=_SAFE_ENDS,
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "handled_always",
            "AG (({running}) -> event({0}))",
            "{0} is handled whatever runs",
            "{0} changes nothing while some objectives run",
            "whether {0} is always handled is not known",
            "all states",
            good=True,
        ),
        ClaimKind(
            "ignored",
            "EF (objective({1}) & !event({0}){not_led})",
            "{0} is ignored while {1} runs",
            "{0} is never ignored while {1} runs",
            "whether {0} is ignored while {1} runs is not known",
            "a state",
            good=False,
        ),
        ClaimKind(
            "answered_already",
            "EF (objective({1}) & !event({0}))",
            "{0} changes nothing while {1} runs, where it leads",
            "{0} is handled while {1} runs",
            "whether {0} is handled while {1} runs is not known",
            "a state",
        ),
        ClaimKind(
            "interrupts_answer",
            "E(F (objective({1}) & happens({0}) & X !objective({1})))",
            "{0} interrupts {1}, to which {2} leads",
            "{0} never interrupts {1}, to which {2} leads",
            "whether {0} interrupts {1} is not known",
            "a run",
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "ends_at_once",
            "E(F (!{1} & happens({0}) & X {1}))",
            "{0} may end the mission in {1} at once: nothing runs after it",
            "{0} never ends the mission in {1} at once",
            "whether {0} ends the mission in {1} at once is not known",
            "a run",
            shown=(PAGE, JSON),
        ),
        ClaimKind(
            "alternate_for_ever",
            "E(F G ({events}))",
            "{others} may go on for ever, and nothing else happens",
            "declared events alone never go on for ever",
            "whether declared events alone may go on for ever is not known",
            "a run that repeats",
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "requirement",
            "{formula}",
            "requirement {0} is met",
            "requirement {0} is not met",
            "whether requirement {0} is met is not known",
            "all runs; where it fails, a run",
            why="fair requirements, and those within a protocol, are asked with its names and of fair runs",
            good=True,
        ),
        ClaimKind(
            "met_as_ignored",
            "({formula}) & EF ({running} & !event({1}))",
            "requirement {0} is met, and {1}, of which it speaks, changes nothing in some states",
            "requirement {0} speaks of {1}, which is handled whatever runs, or is not met",
            "whether requirement {0} is met is not known",
            "all runs, and a state",
            why="fair requirements, and those within a protocol, are asked with its names and of fair runs",
            shown=(PAGE, JSON),
            good=False,
        ),
        ClaimKind(
            "failure_loses_mission",
            "E(F ({sound} & objective({1}) & EF success & happens({0}_EV_OOS) & X !EF success))",
            "the failure of {0} alone during {1} can lose the mission, whatever is repaired",
            "after a failure of {0} alone during {1} success stays possible, if only by repairs",
            "what the failure of {0} during {1} costs is not known",
            "all failures of it while the objective runs",
            good=False,
        ),
        ClaimKind(
            "failure_loses_robot",
            "E(F ({sound} & objective({1}) & EF (success | abort) & happens({0}_EV_OOS)"
            " & X !EF (success | abort)))",
            "the failure of {0} alone during {1} can leave no safe end, whatever is repaired",
            "after a failure of {0} alone during {1} a safe end stays possible, if only by repairs",
            "what the failure of {0} during {1} costs is not known",
            "all failures of it while the objective runs",
            why=_SAFE_ENDS,
            good=False,
        ),
        ClaimKind(
            "nominal_success",
            "",
            "while nothing fails, the mission succeeds and leaves nothing out",
            "even on runs on which nothing fails the mission does not do what its blocks say",
            "whether the mission succeeds while nothing fails is not known",
            "all runs of successes; where it fails, one of them",
            why="runs that only failures could continue are finite, and what is left out is a set of blocks",
            good=True,
        ),
    )
}
"""By name, in the order in which they are shown."""
