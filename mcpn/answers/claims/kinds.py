"""The kinds of claims: of each its formula as a template, its three sentences, its evidence, who shows it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

TERMINAL, PAGE, JSON = "terminal", "page", "JSON"
EVERYWHERE = (TERMINAL, PAGE, JSON)


class ClaimKind(NamedTuple):
    """A kind of claim.

    Args:
        name: A stable name.
        formula: A template: it holds where the claim does. Empty where no formula says it.
        holds: What is so where it holds; ``{0}``, ``{1}``: the names of the subject, in their order;
            ``{given}``: what is supposed.
        fails: What is so where it does not.
        unknown: What is said where that is not known.
        evidence: What shows it.
        shown: Where it is shown.
        why: Why there is no formula.
        good: Whether a mission is better where it holds; ``None`` of what is neither good nor bad.
        verdict: The verdict that it is, if it is one.
        several: How several names stand in the place of one.
        joint: What stands between them.
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
    verdict: str = ""
    several: str = "any one of {}"
    joint: str = ", "

    @property
    def sentences(self) -> tuple[str, str, str]:
        """Where it holds, fails, is not known; without their full stop."""
        return self.holds, self.fails, self.unknown


_SAFE_ENDS = "where an abort may come by the failure of what should make safe, safe ends are events"

_UNSEEN = "it is asked of the present run of an objective, which no word of formulas names"
_OF_MARKINGS = "formulas speak of stable states, and this is so of all markings"

KINDS: Mapping[str, ClaimKind] = {
    kind.name: kind
    for kind in (
        ClaimKind(
            "nominal_success",
            "",
            "while nothing fails{given} the mission succeeds",
            "while nothing fails, the mission does not do what its blocks say",
            "whether the mission succeeds while nothing fails is not known",
            "all runs of successes; where it fails, one of them",
            EVERYWHERE,
            "runs that only failures could continue are finite, and what is left out is a set of blocks",
            verdict="nominal_success",
            good=True,
        ),
        ClaimKind(
            "nominal_endless",
            "",
            "while nothing fails{given} the mission goes on for ever, as it is meant to",
            "while nothing fails, the mission does not do what its blocks say",
            "whether the mission goes on for ever while nothing fails is not known",
            "all runs of successes",
            EVERYWHERE,
            "runs that only failures could continue are finite, and what is left out is a set of blocks",
            good=True,
        ),
        ClaimKind(
            "nominal_either",
            "",
            "while nothing fails{given} the mission succeeds, or goes on for ever, as it is meant to",
            "while nothing fails, the mission does not do what its blocks say",
            "whether the mission succeeds while nothing fails is not known",
            "all runs of successes",
            EVERYWHERE,
            "runs that only failures could continue are finite, and what is left out is a set of blocks",
            good=True,
        ),
        ClaimKind(
            "can_succeed",
            "EF success",
            "the mission can succeed",
            "the mission can never succeed",
            "whether the mission can succeed is not known",
            "a run",
            EVERYWHERE,
            verdict="success_reachable",
            good=True,
        ),
        ClaimKind(
            "can_fail",
            "EF failure",
            "the mission can end in failure",
            "the mission can never end in failure",
            "whether the mission can end in failure is not known",
            "a run",
            EVERYWHERE,
            verdict="failure_reachable",
            good=False,
        ),
        ClaimKind(
            "can_be_aborted",
            "EF abort",
            "the mission can be aborted: not accomplished, and safe as far as its text says",
            "the mission is never aborted",
            "whether the mission can be aborted is not known",
            "a run",
            EVERYWHERE,
            verdict="abort_reachable",
        ),
        ClaimKind(
            "aborted_by_failure",
            "",
            "the mission can be aborted by the failure of what should make the robot safe",
            "no abort is reached by the failure of what should make the robot safe",
            "whether an abort is reached by the failure of what should make the robot safe is not known",
            "all states; where it holds, a run",
            EVERYWHERE,
            "which objectives should make safe is read from the runs of successes",
            verdict="abort_by_failure",
            good=False,
        ),
        ClaimKind(
            "can_always_end_safely",
            "AG EF (success | abort)",
            "whatever has happened, the mission can still end safely, in success or abort",
            "the mission can reach a state from which it cannot end safely, in success or abort",
            "whether the mission can always end safely is not known",
            "all states; where it fails, a run",
            EVERYWHERE,
            _SAFE_ENDS,
            verdict="can_always_end_safely",
            good=True,
        ),
        ClaimKind(
            "can_always_end",
            "AG EF ({ends})",
            "whatever has happened, the mission can still end",
            "the mission can reach a state from which it cannot end",
            "whether the mission can always end is not known",
            "all states; where it fails, a run",
            EVERYWHERE,
            verdict="can_always_finish",
            good=True,
        ),
        ClaimKind(
            "required_events_handled",
            "",
            "every event that must be handled is handled, or changes nothing while its answer runs",
            "an event that must be handled is ignored",
            "whether every event that must be handled is handled is not known",
            "all states",
            EVERYWHERE,
            "`ignored` says it of each event",
            verdict="events_handled",
            good=True,
        ),
        ClaimKind(
            "can_always_go_on",
            "AG (deadlock -> {ends})",
            "in every state before the mission ends some event is possible",
            "the robot can get stuck: no event is possible, and the mission has not ended",
            "whether the robot can get stuck is not known",
            "all states; where it fails, a run",
            EVERYWHERE,
            verdict="deadlock_free",
            good=True,
        ),
        ClaimKind(
            "reacts_in_one_way",
            "",
            "the reaction to an event is always the same, and ends",
            "the reaction to an event depends on chance, or never ends",
            "whether the reaction to an event is always the same is not known",
            "all conflicts of internal transitions; where it fails, two runs",
            EVERYWHERE,
            "stable states, of which formulas speak, follow from it",
            verdict="confluent",
            good=True,
        ),
        ClaimKind(
            "nothing_twice",
            "",
            "nothing is started or counted twice",
            "something can be started or counted twice",
            "whether something can be started twice is not known",
            "all markings; where it fails, a run",
            EVERYWHERE,
            _OF_MARKINGS,
            verdict="safe",
            good=True,
        ),
        ClaimKind(
            "nothing_piles_up",
            "",
            "nothing piles up without end",
            "something can pile up without end",
            "whether something can pile up is not known",
            "all markings; where it fails, a run",
            EVERYWHERE,
            _OF_MARKINGS,
            verdict="bounded",
            good=True,
        ),
        ClaimKind(
            "something_unused",
            "",
            "some parts of the mission can never be used; the warnings name them",
            "every part of the mission can be used",
            "whether every part of the mission can be used is not known",
            "all states",
            EVERYWHERE,
            "what is never used is a set of elements, each with its line",
            verdict="unselectable",
        ),
        ClaimKind(
            "succeeds_without",
            "E((!happens(OBJ_{0}_EV_OK)) U success)",
            "the mission may end in success without {0}",
            "the mission ends in success only if {0} has succeeded",
            "whether the mission may end in success without {0} is not known",
            "a run",
            shown=EVERYWHERE,
            good=False,
        ),
        ClaimKind(
            "without_repair_defeated",
            "",
            "there is no way to success without a repair",
            "some way to success needs no repair",
            "whether the mission needs a repair for success is not known",
            "all states",
            EVERYWHERE,
            "that nothing fails, and that nothing is repaired, is asked of the mission's start alone",
            good=False,
        ),
        ClaimKind(
            "loss_before_defeats",
            "E(happens({0}_EV_OOS) & X {then})",
            "the loss of {0} before the start, not repaired, leaves no way to success",
            "the loss of {0} before the start, not repaired, leaves a way to success",
            "whether the loss of {0} before the start leaves a way to success is not known",
            "all states after the loss",
            EVERYWHERE,
            joint=", or of ",
            several="{}",
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
            "losses_defeat",
            "",
            "the losses of {0}, at their worst moments, leave no way to success",
            "the losses of {0}, whenever they come, leave a way to success",
            "whether the losses of {0} leave a way to success is not known",
            "all states, and the losses in each",
            EVERYWHERE,
            "several losses come at several moments, which a formula would have to order",
            joint=", or of ",
            several="{}",
            good=False,
        ),
        ClaimKind(
            "without_repair_endangered",
            "",
            "there is no way to a safe end without a repair",
            "some way to a safe end needs no repair",
            "whether the mission needs a repair for a safe end is not known",
            "all states",
            EVERYWHERE,
            "that nothing fails, and that nothing is repaired, is asked of the mission's start alone",
            good=False,
        ),
        ClaimKind(
            "loss_before_endangers",
            "E(happens({0}_EV_OOS) & X {then})",
            "the loss of {0} before the start, not repaired, leaves no way to a safe end",
            "the loss of {0} before the start, not repaired, leaves a way to a safe end",
            "whether the loss of {0} before the start leaves a way to a safe end is not known",
            "all states after the loss",
            EVERYWHERE,
            _SAFE_ENDS,
            joint=", or of ",
            several="{}",
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
            "losses_endanger",
            "",
            "the losses of {0}, at their worst moments, leave no way to a safe end",
            "the losses of {0}, whenever they come, leave a way to a safe end",
            "whether the losses of {0} leave a way to a safe end is not known",
            "all states, and the losses in each",
            EVERYWHERE,
            "several losses come at several moments, which a formula would have to order",
            joint=", or of ",
            several="{}",
            good=False,
        ),
        ClaimKind(
            "abort_after",
            "",
            "the mission is aborted where {0} fails, which should make the robot safe: no such abort counts "
            "as a safe end, but in probabilities it counts as an abort",
            "the mission is not aborted by the failure of {0}",
            "whether the mission is aborted by the failure of {0} is not known",
            "all states in which it aborts",
            EVERYWHERE,
            "which objectives should make safe is read from the runs of successes",
            several="one of {}",
            good=False,
        ),
        ClaimKind(
            "says_what_is_safe",
            "",
            "the mission says by its aborts which ends are safe besides success",
            "the mission has no abort, so that nothing says which of its failures are safe",
            "whether the mission has an abort is not known",
            "its text",
            EVERYWHERE,
            "it is a question to the text",
            good=True,
        ),
        ClaimKind(
            "handled_always",
            "AG (({running}) -> event({0}))",
            "whatever runs, the mission handles {0}",
            "while some objectives run, {0} changes nothing",
            "whether {0} is always handled is not known",
            "all states",
            good=True,
            several="{}",
        ),
        ClaimKind(
            "ignored",
            "EF (objective({1}) & !event({0}){not_led})",
            "{0} is ignored during {1}",
            "{0} is never ignored during {1}",
            "whether {0} is ignored during {1} is not known",
            "a state",
            EVERYWHERE,
            several="{}",
            good=False,
        ),
        ClaimKind(
            "answered_already",
            "EF (objective({1}) & !event({0}))",
            "{0} changes nothing during {1}, where it leads",
            "{0} is handled during {1}",
            "whether {0} is handled during {1} is not known",
            "a state",
            EVERYWHERE,
            several="{}",
        ),
        ClaimKind(
            "loss_unnoticed",
            "",
            "nothing notices the loss of {0} during {1}, which can then no longer succeed",
            "the loss of {0} during {1} is noticed, or takes nothing",
            "whether the loss of {0} during {1} is noticed is not known",
            "all losses of it while nothing else has failed",
            EVERYWHERE,
            _UNSEEN,
            several="{}",
            good=False,
        ),
        ClaimKind(
            "loss_unnoticed_later",
            "",
            "once other hardware has failed, nothing notices the loss of {0} during {1}, which can then no "
            "longer succeed",
            "the loss of {0} during {1} is noticed, or takes nothing",
            "whether the loss of {0} during {1} is noticed is not known",
            "all losses of it",
            EVERYWHERE,
            _UNSEEN,
            several="{}",
            good=False,
        ),
        ClaimKind(
            "loss_found_in_time",
            "",
            "after the loss of {0}, {1} can succeed only if the loss is found in time",
            "after the loss of {0}, {1} does not depend on whether the loss is found in time",
            "whether {1} depends on the loss of {0} being found is not known",
            "all losses of it while nothing else has failed",
            EVERYWHERE,
            _UNSEEN,
            several="{}",
            good=False,
        ),
        ClaimKind(
            "interrupts_answer",
            "E(F (objective({1}) & happens({0}) & X !objective({1})))",
            "{0} interrupts {1}, to which {2} leads",
            "{0} never interrupts {1}, to which {2} leads",
            "whether {0} interrupts {1} is not known",
            "a run",
            shown=EVERYWHERE,
            good=False,
        ),
        ClaimKind(
            "ends_at_once",
            "E(F (!{1} & happens({0}) & X {1}))",
            "{0} may end the mission in {1} at once: nothing runs after it",
            "{0} never ends the mission in {1} at once",
            "whether {0} ends the mission in {1} at once is not known",
            "a run",
            shown=EVERYWHERE,
        ),
        ClaimKind(
            "alternate_for_ever",
            "E(F G ({events}))",
            "{others} may go on for ever, and nothing else happens",
            "declared events alone never go on for ever",
            "whether declared events alone may go on for ever is not known",
            "a run that repeats",
            shown=EVERYWHERE,
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
            "requirement {0} is met, and says nothing of {1} where {1} is ignored",
            "requirement {0} speaks of {1}, which is handled whatever runs, or is not met",
            "whether requirement {0} is met is not known",
            "all runs, and a state",
            why="fair requirements, and those within a protocol, are asked with its names and of fair runs",
            shown=EVERYWHERE,
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
            "event_decides",
            "E(F (EF success & happens({0}) & X !EF success))",
            "{0} can put success out of reach, whatever is repaired",
            "{0} never puts success out of reach",
            "whether {0} puts success out of reach is not known",
            "all states in which it happens",
            EVERYWHERE,
            good=False,
        ),
        ClaimKind(
            "fact_defeats",
            "EF success & EF (fact({0})={1} & !success) & AG (fact({0})={1} & !success -> !EF success)",
            "once {0} is {1} success is out of reach",
            "while {0} is {1} success may still be reached, or the mission never comes there",
            "whether success is out of reach once {0} is {1} is not known",
            "all states in which it is so",
            EVERYWHERE,
            good=False,
        ),
        ClaimKind(
            "end_decides",
            "E(F (EF success & happens({event}) & X !EF success))",
            "the {1} of {0} can put success out of reach, whatever is repaired",
            "the {1} of {0} never puts success out of reach",
            "whether the {1} of {0} puts success out of reach is not known",
            "all states in which it happens",
            good=False,
        ),
        ClaimKind(
            "outcome_comes",
            "E(F happens({event}))",
            "the {1} of {0} comes on some run",
            "the {1} of {0} never comes",
            "whether the {1} of {0} ever comes is not known",
            "a state",
        ),
        ClaimKind(
            "selected",
            "EF alternative({0})={1}",
            "{0} runs as {1} in some state",
            "{0} never runs as {1}",
            "whether {0} ever runs as {1} is not known",
            "a state",
        ),
        ClaimKind(
            "waits_for_hardware",
            "EF !({ends} | {some})",
            "the mission can come to wait for hardware alone: nothing but failures and repairs is possible",
            "until the mission ends something may happen that is not only of hardware",
            "whether the mission can wait for hardware alone is not known",
            "a state",
            EVERYWHERE,
            good=False,
        ),
    )
}
"""By name, in the order in which they are shown."""

OF_VERDICTS: Mapping[str, ClaimKind] = {kind.verdict: kind for kind in KINDS.values() if kind.verdict}
"""By verdict, in the order in which they are read."""
