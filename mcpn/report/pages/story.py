"""The first screen of a page: may the mission go, and a sentence for each thing that decides it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mcpn.answers.causes.cutsets import CutSet
from mcpn.answers.claims.claim import Claim, told
from mcpn.answers.claims.found import claims_found, of_verdict
from mcpn.answers.claims.kinds import OF_VERDICTS
from mcpn.answers.verdicts.mission import NOMINAL
from mcpn.nets.events import Event
from mcpn.report.failures.sentences import without_a_rate
from mcpn.report.pages.nominal_run import nominal_run, strip
from mcpn.report.pages.preflight import single_losses
from mcpn.report.words import (
    folded,
    in_words,
    skipped_in_words,
    what_happens,
    wrong_in_words,
)
from mcpn.sentences import enumeration

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes, GoalCauses
    from mcpn.answers.requirements import RequirementAnswer
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.findings import Findings
    from mcpn.spaces.run import Run

MOST_TOLD = 8
"""Cut sets, or names, of one sentence; the tables have all."""

ABORTED = "it ends in a safe way, not accomplished"

MOST_LAST = 3
"""Events of a run that one sentence has."""


@dataclass(frozen=True)
class StoryLine:
    """What a page says first.

    Args:
        state: ``holds``, ``fails``, ``unknown``, or ``note`` for what is neither good nor bad.
        asked: The question, in a few words.
        said: The answer.
        chips: The run that shows it, by what begins.
        events: The events of this run, as JSON.
    """

    state: str
    asked: str
    said: str
    chips: Sequence[str] = ()
    events: str = ""


def headline(findings: Findings) -> StoryLine:
    """Whether the mission may go, and under which conditions."""
    line = verdict_of_all(findings.check)
    if line.state != "holds":
        return line
    conditions = "; ".join(_conditions(findings))
    return replace(
        line, said=f"{line.said} {conditions[0].upper()}{conditions[1:]}." if conditions else line.said
    )


def _conditions(findings: Findings) -> Iterator[str]:
    """What a yes depends on, each in a few words."""
    causes = findings.causes
    if causes is not None:
        alone = single_losses(findings)
        defeats, endangers = alone.defeats, alone.endangers
        worst = f"that of {_few(alone.later)} at the worst moment" if alone.later else ""
        also = f", {worst} too" if worst else ""
        helpers = list(dict.fromkeys(name for helping in alone.helped.values() for name in helping))
        helped = f"; without the help of {_few(helpers)} that of {_few([*alone.helped])} as well" * bool(
            helpers
        )
        if len(defeats) == 1:
            yield f"the loss of {defeats[0]} alone defeats it{also}{helped}"
        elif defeats:
            yield f"{len(defeats)} losses, each alone, defeat it ({_few(defeats)}){also}{helped}"
        elif worst:
            yield f"no loss before the start defeats it alone, {worst} does{helped}"
        elif helped:
            lost = f"the loss of {_few([*alone.helped])} alone defeats it without the help of {_few(helpers)}"
            yield f"{lost}; with it no single loss does"
        else:
            yield "no single loss defeats it"
        if causes.safety is None:
            yield "it has no abort, so nothing says which failures are safe"
        elif endangers:
            yield f"the loss of {_few(endangers)} alone, at its worst moment, endangers the robot"
        else:
            yield "no single loss endangers the robot"
        if unsafe := folded(causes.mission_net, causes.unsafe_aborts):
            yield f"abort is called safe although {_few(unsafe)} failed"
    check = findings.check
    if ignored := [each.event for each in check.ignored]:
        some = ignored[0] if len(ignored) == 1 else f"{len(ignored)} events"
        yield f"{some} {'is' if len(ignored) == 1 else 'are'} ignored in some objectives"
    if late := [h.name for h in check.mission_net.mission.late]:
        yield f"the loss of {_few(late)} is noticed late"


def _few(names: Sequence[str]) -> str:
    return enumeration(names if len(names) <= 3 else [*names[:2], f"{len(names) - 2} more"])


def verdict_of_all(check: MissionCheck) -> StoryLine:
    """Whether the mission may go."""
    asked = "May it go?"
    if check.failing:
        wrong = (of_verdict(check.verdicts[name]).sentence.rstrip(".") for name in check.failing)
        return StoryLine("fails", asked, f"No. {'; '.join(wrong)}.")
    if check.violated:
        broken = enumeration(check.violated)
        return StoryLine("fails", asked, f"No. It does not meet what it requires: {broken}.")
    if not check.passed:
        unknown = len(check.undecided) + len(check.unanswered)
        return StoryLine("unknown", asked, f"Not proved. {unknown} of its questions have no answer.")
    return StoryLine("holds", asked, f"Yes. All required verdicts hold{_with_requirements(check)}.")


def _with_requirements(check: MissionCheck) -> str:
    """What a yes says of the mission's own requirements."""
    answers = check.requirements
    if not answers:
        return "; the mission states no requirements of its own"
    unmet = sum(not a.required and not a.met for a in answers)
    empty = sum(bool(a.met and _idle(check, a)) for a in answers)
    met = "; it meets all that it requires" if any(a.required for a in answers) else ""
    if empty:
        met += f", {empty} of it only since something never happens"
    return (
        f"{met}; {unmet} advised {'requirement is' if unmet == 1 else 'requirements are'} not met"
        if unmet
        else met
    )


def _idle(check: MissionCheck, answer: RequirementAnswer) -> bool:
    """Whether a requirement speaks of an event that is ignored somewhere."""
    return any(each.event in answer.asked.events for each in check.ignored)


def story(findings: Findings) -> Iterator[StoryLine]:
    """The answers of the first screen, each in a sentence."""
    yield from _translated(findings.check)
    yield from _nominal(findings)
    yield _success(findings)
    if findings.causes is not None:
        mission, safety = findings.causes.mission, findings.causes.safety
        yield _safety(findings, safety)
        yield from _by_word(findings.causes)
        yield _lost(mission, single_losses(findings).helped)
        yield from _survived(findings)
    yield from _claimed(findings.claims)
    yield from _ignored(findings.check)
    yield from _unnoticed(findings.check)
    yield from _required(findings.check)
    yield from _granted(findings.check)
    if (chance := findings.risk) is not None:
        aborts = "" if chance.abort is None else f", is aborted with {chance.abort:.6g}"
        told = (
            f"it succeeds with probability {_near_one(chance.success)}{aborts} "
            f"and fails with {chance.failure:.6g}"
        )
        if chance.unrated:
            told += f"; {without_a_rate(chance)}"
        yield StoryLine("note", "How probable?", f"With the given rates {told}.")
    yield _never(findings.check)
    yield _unproved(findings)


CLAIMED = {
    "succeeds_without": "What may success leave out?",
    "interrupts_answer": "What interrupts an answer?",
    "ends_at_once": "What ends it at once?",
    "alternate_for_ever": "What may go on for ever?",
    "met_as_ignored": "What is met as it never happens?",
}
"""By kind of claim that a page tells where it holds, what it answers."""


def _claimed(claims: Sequence[Claim]) -> Iterator[StoryLine]:
    """The claims that hold and that a reader should know; what success may do without is said together."""
    for kind, asked in CLAIMED.items():
        together: dict[tuple[str, ...], list[Claim]] = {}
        for claim in claims:
            if claim.kind == kind and claim.holds:
                apart = claim.subject if kind != "succeeds_without" else ()
                together.setdefault(apart, []).append(claim)
        if together:
            said = [told(same) for same in together.values()]
            more = len(said) - MOST_TOLD
            said = [*said[:MOST_TOLD], *([f"And {more} more, which check --json lists."] if more > 0 else [])]
            yield StoryLine("note", asked, " ".join(said))


def _near_one(chance: float) -> str:
    """A probability; one that only rounding would make certain says by how much it is not."""
    said = f"{chance:.6g}"
    return f"1 - {1 - chance:.3g}" if said == "1" and chance < 1 else said


def _nominal(findings: Findings) -> Iterator[StoryLine]:
    """Whether the mission succeeds while nothing fails, and if not, what goes wrong."""
    verdict = findings.check.verdicts.get(NOMINAL)
    if verdict is None:
        return
    said = of_verdict(verdict).sentence
    state = {True: "holds", False: "fails", None: "unknown"}[verdict.holds]
    if verdict.holds is not False:
        yield StoryLine(state, "If nothing fails?", said)
        return
    run = verdict.runs[0] if verdict.runs and not verdict.runs[0].tail else None
    events = [] if run is None else [str(event) for event, _ in in_words(findings.check.mission_net, run)]
    chips = strip(findings, events) if events and findings.controller is not None else []
    said = f"{said} {verdict.explanation[:1].upper()}{verdict.explanation[1:]}."
    yield StoryLine(state, "If nothing fails?", said, chips, json.dumps(events) if chips else "")


def _translated(check: MissionCheck) -> Iterator[StoryLine]:
    """What of the answers holds of the behaviour tree that the mission was made of."""
    for translated in check.mission_net.mission.translated:
        from mcpn.trees.ledger import of_translated

        made, survives = of_translated(translated)
        state = "holds" if not translated.approximations else "note"
        yield StoryLine(state, "And the tree?", f"{made[0].upper()}{made[1:]}. {survives}")


def _success(findings: Findings) -> StoryLine:
    """Whether it can succeed, and the run without failures."""
    verdict = findings.check.verdicts["success_reachable"]
    number = {True: 0, False: 1, None: 2}[verdict.holds]
    said, chips, events = of_verdict(verdict).sentence, list[str](), list[str]()
    if verdict.holds and findings.controller is not None:
        found = nominal_run(findings)
        if found is None and verdict.runs and not verdict.runs[0].tail:
            found = [str(event) for event, _ in in_words(findings.check.mission_net, verdict.runs[0])]
            wrong = wrong_in_words(findings.check.mission_net, verdict.runs[0])
            said += f" Its shortest run to success{f', and {wrong}' if wrong else ''}:"
        elif found is not None:
            said += " The run on which nothing fails:"
        if found is not None:
            chips, events = strip(findings, found), found
    state = ("holds", "fails", "unknown")[number]
    return StoryLine(state, "Can it succeed?", said, chips, json.dumps(events) if events else "")


def _lost(goal: GoalCauses, helped: Mapping[str, Sequence[str]]) -> StoryLine:
    """What keeps a mission from success."""
    asked, cut_sets, worst = "What defeats it?", goal.cut_sets, goal.only_at_worst
    if () in cut_sets:
        said = "It can never succeed, whatever the hardware does."
        return StoryLine("fails", asked, said)
    also = " too" if cut_sets else ""
    later = f" Lost at the worst moment, this defeats it{also}: {_listed(worst)}." if worst else ""
    if cut_sets:
        lost = _listed(cut_sets)
        said = f"Lost before it starts and not repaired, this leaves no way to success: {lost}.{later}"
        return StoryLine("note", asked, said)
    if later:
        return StoryLine("note", asked, f"Lost before the start, no hardware defeats it.{later}")
    if helped:
        helpers = enumeration(list(dict.fromkeys(name for helping in helped.values() for name in helping)))
        said = f"At its worst moment, and without the help of {helpers}, the loss of one of these: "
        return StoryLine("note", asked, f"{said}{', '.join(helped)}. With this help no loss does.")
    return StoryLine("holds", asked, "No loss of hardware alone keeps it from success.")


def _listed(cut_sets: Sequence[CutSet]) -> str:
    lost = "; ".join(map(_together, cut_sets[:MOST_TOLD]))
    more = len(cut_sets) - MOST_TOLD
    return lost if more <= 0 else f"{lost}; and {more} more, which the table of causes lists"


def _survived(findings: Findings) -> Iterator[StoryLine]:
    """Which hardware may be lost alone: so that success is still possible, and so that only an abort is."""
    causes, mission_net = findings.causes, findings.check.mission_net
    if causes is None:
        return
    faulty = [h for h in mission_net.mission.hardware if h.faulty and h.name not in causes.unused]
    asked = "What does it survive?"

    def left(cut_sets: Sequence[CutSet]) -> list[str]:
        alone = {lost[0] for lost in cut_sets if len(lost) == 1}
        return [] if () in cut_sets else [h.name for h in faulty if h.name not in alone]

    succeeding, lost = left(causes.mission.cut_sets), single_losses(findings)
    if succeeding:
        always = [name for name in succeeding if name not in (*lost.later, *lost.helped)]
        helped = [name for name in succeeding if name in lost.helped and name not in lost.later]
        said = (
            f"It can still succeed after the loss of any one of these alone: {', '.join(always)}."
            if always
            else "At the worst moment, no loss."
        )
        if lost.later:
            said += f" Only where they are lost before the start: {', '.join(lost.later)}."
        if helped:
            by = enumeration(list(dict.fromkeys(each for name in helped for each in lost.helped[name])))
            said += f" Only with the help of {by}: {', '.join(helped)}."
        yield StoryLine("holds" if always else "note", asked, said)
        yield from _left_out(findings, causes, succeeding)
    if causes.safety is None:
        return
    known = {*succeeding, *lost.endangers}
    aborting = [name for name in left(causes.safety.cut_sets) if name not in known]
    if aborting:
        names = ", ".join(aborting)
        said = f"After the loss of any one of these alone it can only be aborted: {names}."
        yield StoryLine("note", "What makes it give up?", said)


def _left_out(findings: Findings, causes: Causes, hardware: Sequence[str]) -> Iterator[StoryLine]:
    """Objectives that cannot succeed without hardware whose loss a mission survives."""
    without: dict[tuple[str, ...], list[str]] = {}
    for lost in hardware:
        if names := [name for name, goal in causes.objectives.items() if (lost,) in goal.cut_sets]:
            without.setdefault(tuple(folded(findings.check.mission_net, names)), []).append(lost)
    if not without:
        return
    told = []
    for objectives, needed in list(without.items())[:MOST_TOLD]:
        more = f" and {len(objectives) - MOST_TOLD} more" if len(objectives) > MOST_TOLD else ""
        told.append(f"without {' or '.join(needed)}: {', '.join(objectives[:MOST_TOLD])}{more}")
    said = f"These objectives cannot succeed then; {'; '.join(told)}."
    yield StoryLine("note", "What is lost then?", said)


def _together(lost: CutSet) -> str:
    return enumeration(lost) + (" together" if len(lost) > 1 else "")


def _safety(findings: Findings, goal: GoalCauses | None) -> StoryLine:
    """What makes a mission that can abort end in neither success nor abort."""
    asked = "What endangers the robot?"
    if goal is None:
        said = "Not known: the mission has no abort, so nothing says which of its failures are safe."
        return StoryLine("note", asked, said)
    verdict, cut_sets, worst = (
        findings.check.verdicts["can_always_end_safely"],
        goal.cut_sets,
        goal.only_at_worst,
    )
    if () in cut_sets:
        return StoryLine("fails", asked, "It can never succeed, and never be aborted.")
    if not cut_sets and verdict.holds is False:
        return _unsafe(findings, verdict.runs)
    end = "reach a safe abort" if findings.causes and findings.causes.unsafe_aborts else "be aborted"
    if worst:
        said = (
            f"At the worst moment it can neither succeed nor {end} after the loss of this: {_listed(worst)}."
        )
        if cut_sets:
            said += f" And lost before it starts and not repaired: {_listed(cut_sets)}."
        return StoryLine("note", asked, said)
    if not cut_sets:
        said = f"Whatever hardware is lost, it can still succeed or be aborted: {ABORTED}."
        if findings.causes and findings.causes.unsafe_aborts:
            return StoryLine("note", asked, "No loss of hardware alone, but failures of what makes it safe.")
        return StoryLine("holds", asked, said)
    said = f"Lost before it starts and not repaired, this leaves no way to succeed or {end}:"
    return StoryLine("note", asked, f"{said} {_listed(cut_sets)}.")


def _by_word(causes: Causes) -> Iterator[StoryLine]:
    """Aborts that are reached by the failure of what should make the robot safe."""
    if names := folded(causes.mission_net, causes.unsafe_aborts):
        several = len(names) > 1
        said = (
            f"{_few(names)} should make the robot safe, and where {'one of them' if several else 'it'} fails "
            "the mission is aborted all the same. The answers of this page count no such abort as safe; "
            "probabilities of an abort count it."
        )
        yield StoryLine("fails", "Is every abort safe?", said)


def _ignored(check: MissionCheck) -> Iterator[StoryLine]:
    """Where the declared events are ignored, of missions that declare some."""
    asked, events = (
        "What is ignored?",
        [e.name for e in check.mission_net.mission.events if not e.changes_facts],
    )
    if check.ignored:
        told = "; ".join(f"{each.event} while {each.words}" for each in check.ignored[:MOST_TOLD])
        more = len(check.ignored) - MOST_TOLD
        told += f"; and {more} more, which check lists" if more > 0 else ""
        said = f"{told}. What is required of these events holds only where they are handled."
        yield StoryLine("note", asked, said)
    elif events and (check.alternatives is not None or check.markings is not None):
        again = [each.event for each in check.changing_nothing]
        always = [name for name in events if name not in again]
        said = f"No event: {_few(always)} {_is(always)} handled whatever runs" if always else "No event"
        if again:
            they = "it leads" if len(again) == 1 else "they lead"
            nothing = "changes nothing" if len(again) == 1 else "change nothing"
            said += (
                f"{', and' if always else ':'} {_few(again)} {nothing} only while what {they} to runs already"
            )
        yield StoryLine("holds", asked, f"{said}.")


def _unnoticed(check: MissionCheck) -> Iterator[StoryLine]:
    """What losses that are noticed late cost, of missions with such hardware."""
    asked, late = "What goes unnoticed?", [h.name for h in check.mission_net.mission.late]
    if check.late:
        said = "; ".join(sentence for each in check.late[:MOST_TOLD] for sentence in each.sentences)
        yield StoryLine("note", asked, f"{said[:1].upper()}{said[1:]}.")
    elif late and check.alternatives is not None:
        yield StoryLine(
            "holds", asked, f"The loss of {_few(late)} is noticed late; no objective fails for that."
        )


def _is(names: Sequence[str]) -> str:
    return "is" if len(names) == 1 else "are"


def _unsafe(findings: Findings, runs: Sequence[Run]) -> StoryLine:
    """Says by a run that a mission can end in neither success nor abort with all hardware in service."""
    asked, said = (
        "What endangers the robot?",
        "It can reach a state from which it can neither succeed nor be aborted",
    )
    if not runs or runs[0].tail:
        return StoryLine("fails", asked, f"{said}, whatever the hardware does.")
    mission_net = findings.check.mission_net
    events = [event for event, _ in in_words(mission_net, runs[0].of_events) if isinstance(event, Event)]
    last = ", then ".join(what_happens(event, mission_net.mission.name) for event in events[-MOST_LAST:])
    texts = list(map(str, events))
    chips = () if findings.controller is None else strip(findings, texts)
    return StoryLine("fails", asked, f"{said}, for example when {last}.", chips, json.dumps(texts))


def _required(check: MissionCheck) -> Iterator[StoryLine]:
    """How many requirements are met, and which are not."""
    asked, answers = "What must hold?", check.requirements
    if not answers:
        yield StoryLine("note", asked, "The mission states no requirements of its own.")
        return
    violated = [a.asked.words for a in answers if a.required and a.met is False]
    unknown = [a.asked.words for a in answers if a.met is None]
    advice = [a.asked.words for a in answers if not a.required and a.met is False]
    met = sum(bool(a.met) for a in answers)
    told = [f"{met} of {len(answers)} requirements are met"]
    told += [f"violated: {_quoted(violated)}"] if violated else []
    told += [f"not known: {_quoted(unknown)}"] if unknown else []
    told += [f"not met, and only advised: {_quoted(advice)}"] if advice else []
    empty = [a.asked.words for a in answers if a.met and _idle(check, a)]
    told += [f"met only since something never happens: {_quoted(empty)}"] if empty else []
    state = "fails" if violated else "unknown" if unknown else "note" if advice or empty else "holds"
    yield StoryLine(state, asked, f"{'; '.join(told)}.")


def _granted(check: MissionCheck) -> Iterator[StoryLine]:
    """Hardware that the mission declares not to fail: the page says nothing of its loss."""
    if sound := [h.name for h in check.mission_net.mission.hardware if not h.faulty]:
        more = f" and {len(sound) - MOST_TOLD} more" if len(sound) > MOST_TOLD else ""
        said = f"That these never fail, as the mission says of them: {', '.join(sound[:MOST_TOLD])}{more}."
        yield StoryLine("note", "What is taken for granted?", said)


def _quoted(words: Sequence[str]) -> str:
    return enumeration([f"'{text}'" for text in words[:MOST_TOLD]])


def _never(check: MissionCheck) -> StoryLine:
    """What can never run."""
    asked, verdict = "What can never run?", check.verdicts["unselectable"]
    if verdict.holds is None:
        return StoryLine("unknown", asked, of_verdict(verdict).sentence)
    if not check.unselectable:
        return StoryLine("holds", asked, of_verdict(verdict).sentence)
    told = "; ".join(problem.message for problem in check.unselectable[:3])
    more = len(check.unselectable) - 3
    return StoryLine("note", asked, f"{told}{f'; and {more} more, among the warnings' if more > 0 else ''}.")


def _unproved(findings: Findings) -> StoryLine:
    """What is not known, of what a page says elsewhere."""
    asked, check = "What is not proved?", findings.check
    if check.undecided:
        wrong = " ".join(of_verdict(check.verdicts[name]).sentence for name in check.undecided)
        return StoryLine("unknown", asked, wrong)
    if findings.notes:
        return StoryLine("note", asked, " ".join(findings.notes))
    unknown = sum(claim.holds is None for claim in findings.claims)
    asked_again = sum(bool(claim.formula) for claim in findings.claims if claim.holds is not None)
    said = (
        f"Of the mission as written {len(findings.claims) - unknown} claims are decided from all its states, "
        f"{asked_again} of them with a formula that mcpn ask answers again; {unknown} are not known. "
        "Rates are taken as given. Drivers are not part of it."
    )
    return StoryLine("holds" if not unknown else "note", asked, said)


def runs_of(check: MissionCheck) -> Iterator[dict[str, Any]]:
    """Each verdict, then each requirement, as a sentence with its runs in mission words."""
    yield from _verdicts(check)
    yield from _requirements(check)


def _requirements(check: MissionCheck) -> Iterator[dict[str, Any]]:
    """Each requirement in its author's words, with the run that violates it."""
    silent = [claim for claim in claims_found(check) if claim.kind == "met_as_ignored" and claim.holds]
    for answer in check.requirements:
        asked = answer.asked
        state = {True: "holds", False: "fails", None: "unknown"}[answer.met]
        runs, notes = [], [f"{'' if asked.requirement.expected == 'holds' else 'not: '}{asked.text}"]
        if asked.sentence not in asked.words:
            notes.insert(0, asked.sentence)
        notes += [told([claim]) for claim in silent if claim.subject[0] == asked.name]
        if answer.witness is not None and not answer.met:
            steps = [(str(event), words) for event, words in in_words(check.mission_net, answer.witness.run)]
            runs = [{"steps": steps, "events": json.dumps([event for event, _ in steps])}]
            notes += answer.witness.notes
        yield {
            "name": asked.name,
            "sentence": asked.words,
            "state": state if answer.required or answer.met else "note",
            "explanation": _joined((*notes, answer.reason, answer.says_nothing_of, answer.advice)),
            "runs": runs,
        }


def _joined(parts: Iterable[str]) -> str:
    """Sentences one after the other, and what is no sentence behind a semicolon."""
    return "; ".join(filter(None, parts)).replace(".; ", ". ")


def _verdicts(check: MissionCheck) -> Iterator[dict[str, Any]]:
    """Each verdict as a sentence, with its runs in mission words."""
    for name in OF_VERDICTS:
        if name not in check.verdicts:
            continue
        verdict = check.verdicts[name]
        skipped = skipped_in_words(verdict.skipped) if verdict.skipped else ""
        state = {True: "holds", False: "fails", None: "unknown"}[verdict.holds]
        runs = []
        for run in verdict.runs:
            steps = list(in_words(check.mission_net, run))
            events = None if run.tail else json.dumps([str(event) for event, _ in steps])
            runs.append({"steps": [(str(event), words) for event, words in steps], "events": events})
        yield {
            "name": name,
            "sentence": of_verdict(verdict).sentence,
            "state": state if verdict.required else "note",
            "explanation": "; ".join(filter(None, (verdict.explanation, skipped))),
            "runs": runs,
        }
