"""The questions of whoever signs for a robot's safety, each by a name.

Nothing is decided here that ``check`` or ``causes`` do not decide: a question says which of their answers it
means, what counts as an answer of yes, and what shows it where the answer is no.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Unpack

from mcpn.answers.claims.claim import sentences
from mcpn.answers.claims.of_check import claims_found, of_verdict
from mcpn.errors import SemanticsError
from mcpn.sentences import enumeration, shortened

if TYPE_CHECKING:
    from mcpn.answers.causes.find import GoalCauses
    from mcpn.answers.claims.claim import Claim
    from mcpn.answers.spaces_by_engine import MissionSpaces, MissionSubject
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.spaces.engine_names import Asking
    from mcpn.spaces.run import Run

ASKED = {
    "ends_safely": "Whatever fails, the mission can still end; where it can abort, safely.",
    "events_answered": "Every handled event is answered in one reaction, which ends and is always the same.",
    "no_event_ignored": "No declared event is ignored, except while what it leads to already runs.",
    "dark_after_stop": "After a stop nothing dangerous runs.",
    "no_single_loss_endangers": "No single loss of hardware, at whatever moment, leaves no safe end.",
    "no_late_loss_endangers": "No loss noticed late lets an objective go on in vain, or leaves no safe end.",
    "no_abort_by_failure": "No abort is reached by the failure of a safing objective.",
    "succeeds_if_nothing_fails": "While nothing fails, the mission succeeds, or goes on where that is meant.",
}
"""By name what is asked, as a sentence that is to be true."""


@dataclass(frozen=True)
class SafetyAnswer:
    """The answer to one question of safety.

    Args:
        name: One of :data:`ASKED`.
        holds: Whether the sentence is true; ``None`` where it does not apply, or is not known.
        why: What stands against it, or why there is no answer; a line each.
        run: A run that shows it, where one does.
        applies: Whether it says something of this mission.
        notes: What the answer says and what it leaves open; a line each.
    """

    name: str
    holds: bool | None
    why: tuple[str, ...] = ()
    run: Run | None = None
    applies: bool = True
    notes: tuple[str, ...] = ()

    @property
    def sentence(self) -> str:
        """What is asked."""
        return ASKED[self.name]

    @property
    def is_open(self) -> bool:
        """Whether it is answered with no, or should have an answer and has none."""
        return self.applies and not self.holds

    def _with(self, notes: tuple[str, ...]) -> SafetyAnswer:
        return replace(self, notes=(*self.notes, *notes))


def robot_safety(
    subject: MissionSubject,
    *,
    dangerous: Sequence[str] = (),
    stops: Sequence[str] = (),
    **asked: Unpack[Asking],
) -> list[SafetyAnswer]:
    """Asks the questions of safety of a mission.

    Args:
        subject: The mission's spaces, or its net.
        dangerous: Activities that must not run after a stop.
        stops: Events that stop the robot, by their names.
        **asked: Who is asked, and within what limit.

    Returns:
        The answers, in the order of :data:`ASKED`.

    Raises:
        InputError: A dangerous activity or a stop is none of the mission; found before anything is explored.
        LimitError: A limit was hit.
    """
    from mcpn.answers.mission_names import MissionNames
    from mcpn.answers.spaces_by_engine import spaces_of
    from mcpn.answers.verdicts.mission import ENDS_SAFELY, check
    from mcpn.logic.evaluate import Evaluation
    from mcpn.logic.syntax import parse
    from mcpn.logic.witness import explain

    spaces = spaces_of(subject, **asked)
    names = MissionNames(spaces.mission)
    formulas = {
        (stop, activity): f"G (happens({stop}) -> X G !activity({activity}))"
        for stop in stops
        for activity in dangerous
    }
    meant = {pair: parse(text, names) for pair, text in formulas.items()}
    for alone in (*(f"happens({stop})" for stop in stops), *(f"activity({each})" for each in dangerous)):
        parse(alone, names)
    checked = check(spaces)
    claims = [*claims_found(checked)]

    def after_stop() -> SafetyAnswer:
        if not meant:
            said = (("an event that stops the robot", stops), ("a dangerous activity", dangerous))
            lacks = enumeration([what for what, given in said if not given])
            return _does_not_apply("dark_after_stop", f"{lacks} must be named")
        if checked.alternatives is None:
            return SafetyAnswer("dark_after_stop", None, ("not known: the stable states are not",))
        evaluation, run = Evaluation(checked.alternatives), None
        # What is ignored never happens in formulas, so that they would be met there.
        why = [*sentences((c for c in _held(claims, "ignored") if c.subject[0] in stops), differ=1)]
        for each in (each for each in checked.changing_nothing if each.event in stops):
            for activity in dangerous if each.answering else ():
                here = " | ".join(f"objective({name})" for name in each.answering)
                later = f"AG (({here}) & !event({each.event}) -> AG !activity({activity}))"
                if not evaluation.holds(parse(later, names)):
                    why.append(f"{activity} may run after {each.event} during {shortened(each.answering)}")
        for (stop, activity), formula in meant.items():
            if not evaluation.holds(formula):
                why.append(f"{activity} may run after {stop}")
                run = run or explain(evaluation, formula, names).run
        return SafetyAnswer("dark_after_stop", not why, tuple(why), run)

    cannot_abort = ("that it ends, in success or failure, is all that is proved: it cannot be aborted",)
    lost_alone, single = _single_losses(spaces)
    return [
        _by_verdict("ends_safely", checked, ENDS_SAFELY, "can_always_finish")._with(
            () if spaces.mission.abort is not None else cannot_abort
        ),
        _by_verdict("events_answered", checked, "confluent")._with(_where_handled(claims)),
        _listed("no_event_ignored", [*sentences(_held(claims, "ignored"), differ=1)]),
        after_stop(),
        single,
        _late_losses(checked, lost_alone),
        _no_abort_by_failure(checked),
        _by_verdict("succeeds_if_nothing_fails", checked, "nominal_success"),
    ]


def single_losses(goal: GoalCauses) -> list[str]:
    """Hardware whose loss alone defeats a goal, before the mission or at the worst moment."""
    alone = (lost[0] for cut_sets in goal.moments.values() for lost in cut_sets if len(lost) == 1)
    return sorted(dict.fromkeys(alone))


def _single_losses(spaces: MissionSpaces) -> tuple[list[str] | None, SafetyAnswer]:
    """Hardware whose loss alone leaves no safe end, where that is known, and the answer on it."""
    from mcpn.answers.causes.find import find_causes
    from mcpn.answers.claims import claims_of_losses

    name = "no_single_loss_endangers"
    try:
        causes = find_causes(spaces)
    except SemanticsError as error:
        return None, SafetyAnswer(name, None, (f"not known: {error}",))
    goal, notes = causes.safety, list[str]()
    if goal is None:
        goal = causes.mission
        notes.append("the mission cannot be aborted: its only safe end is success")
    if any(not lost for cut_sets in goal.moments.values() for lost in cut_sets):
        said = "there may be no safe end left even while nothing is lost"
        return single_losses(goal), SafetyAnswer(name, False, (said,), notes=tuple(notes))
    # Also after objectives that failed by themselves: those runs are the claims'.
    kind = "loss_defeats" if causes.safety is None else "loss_endangers"
    claims = [c for c in claims_of_losses(causes.prospects) if c.kind == kind and c.holds]
    shown = {claim.subject[0]: claim.find_run for claim in claims}
    lost = sorted({*single_losses(goal), *shown})
    run = goal.find_run((lost[0],)) if lost else None
    if lost and run is None and (find := shown.get(lost[0])) is not None:
        run = find()
    why = tuple(f"{each} alone{_moments(goal, each)}" for each in lost)
    return lost, SafetyAnswer(name, not lost, why, run, notes=tuple(notes))


def _moments(goal: GoalCauses, hardware: str) -> str:
    """When a loss that does no harm before the mission does it; empty where it does it then too."""
    return "" if (hardware,) in goal.cut_sets else ", at the worst moment"


def _late_losses(checked: MissionCheck, alone: Sequence[str] | None) -> SafetyAnswer:
    """What goes on in vain after a loss that is noticed late, and such losses that leave no safe end."""
    name, late = "no_late_loss_endangers", [each.name for each in checked.mission_net.core.late]
    if not late:
        return _does_not_apply(name, "all losses are noticed at once")
    kinds = ("loss_unnoticed", "loss_unnoticed_later", "loss_found_in_time")
    why = sentences(claim for kind in kinds for claim in _held([*claims_found(checked)], kind))
    why += [f"the loss of {each} alone leaves no safe end" for each in late if each in (alone or ())]
    if alone is None and not why:
        return SafetyAnswer(name, None, ("not known: the effects of single losses are not",))
    return _listed(name, why)


def _where_handled(claims: Sequence[Claim]) -> tuple[str, ...]:
    """Of which events an answer on handled events speaks."""
    always = sentences(_held(claims, "handled_always"))
    idle = (sentences(_held(claims, kind), differ=1) for kind in ("ignored", "answered_already"))
    return (*always, *(sentence for each in idle for sentence in each))


def _held(claims: Sequence[Claim], kind: str) -> list[Claim]:
    return [claim for claim in claims if claim.kind == kind and claim.holds]


def _does_not_apply(name: str, why: str) -> SafetyAnswer:
    return SafetyAnswer(name, None, (f"does not apply: {why}",), applies=False)


def _by_verdict(name: str, checked: MissionCheck, *verdicts: str) -> SafetyAnswer:
    """The first of some verdicts that the mission has, where yes is yes."""
    verdict = next(checked.verdicts[each] for each in verdicts if each in checked.verdicts)
    if verdict.holds:
        return SafetyAnswer(name, True)
    said = of_verdict(verdict).sentence, verdict.explanation
    run = verdict.runs_of_events[0] if verdict.runs else None
    return SafetyAnswer(name, verdict.holds, tuple(filter(None, said)), run)


def _no_abort_by_failure(checked: MissionCheck) -> SafetyAnswer:
    from mcpn.answers.verdicts.mission import UNSAFE_ABORT

    name, verdict = "no_abort_by_failure", checked.verdicts.get(UNSAFE_ABORT)
    if verdict is None:
        return _does_not_apply(name, "the mission cannot be aborted")
    if verdict.holds is None:
        return SafetyAnswer(name, None, (f"not known: {verdict.explanation}",))
    if not verdict.holds:
        return SafetyAnswer(name, True)
    run = verdict.runs_of_events[0] if verdict.runs else None
    return SafetyAnswer(name, False, (verdict.explanation,), run)


def _listed(name: str, found: Sequence[str]) -> SafetyAnswer:
    """Yes where nothing was found."""
    return SafetyAnswer(name, not found, tuple(found))
