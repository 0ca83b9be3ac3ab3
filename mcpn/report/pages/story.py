"""The first screen of a page: may the mission go, and a sentence for each thing that decides it."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from mcpn.answers.claims.claim import Claim, sentences, told
from mcpn.answers.claims.of_check import claims_found, of_verdict
from mcpn.answers.claims.unasked import DEFEATING, UNASKED, unasked
from mcpn.answers.kinds.by_name import OF_VERDICTS
from mcpn.answers.verdicts.mission import NOMINAL
from mcpn.report.failures.sentences import MOST_TOLD, kept, losses, spared
from mcpn.report.pages.nominal_run import nominal_run, strip
from mcpn.report.words import (
    folded,
    in_words,
    skipped_in_words,
    wrong_in_words,
)
from mcpn.sentences import counted, enumeration, shortened

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes
    from mcpn.answers.requirements import RequirementAnswer
    from mcpn.answers.verdicts.mission import MissionCheck, Verdict
    from mcpn.findings import Findings

MOST_FIRST = 3
"""Names of one sentence of the headline."""


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
    return replace(line, said=" ".join([line.said, *_conditions(findings)]))


def _conditions(findings: Findings) -> Iterator[str]:
    """What a yes depends on, in sentences."""
    if findings.causes is not None:
        for verb in ("defeat", "endanger"):
            claims, unused = findings.claims, findings.causes.unused
            yield from losses(claims, verb, MOST_FIRST) or kept(claims, verb, unused, MOST_FIRST)
        unsaid = [c for c in findings.claims if c.kind == "says_what_is_safe" and not c.holds]
        yield from sentences([*unsaid, *findings.held("abort_after")], MOST_FIRST)
    yield from sentences(findings.held("ignored"), MOST_FIRST, differ=1)
    if late := [h.name for h in findings.check.mission_net.core.late]:
        yield f"The loss of {shortened(late)} is noticed late."


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
        says = f"{empty} of its requirements say{'s' * (empty == 1)}"
        met += f"; {says} nothing of an event where it is ignored"
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
        yield _safety(findings, findings.causes)
        yield from _noted(findings.held("abort_after"), "Is every abort safe?", "fails")
        yield _lost(findings, findings.causes)
        yield from _claimed(findings.claims, DEFEATING)
        yield from _survived(findings, findings.causes)
    yield from _claimed(findings.claims, UNASKED)
    yield from _ignored(findings)
    yield from _noted(late_losses(findings), "What goes unnoticed?", "note")
    yield from _required(findings.check)
    yield from _granted(findings.check)
    numbers = [*findings.held("chance"), *findings.held("unrated")]
    yield from _noted(numbers, "How probable?", "note")
    yield _never(findings.check)
    yield _unproved(findings)


def _claimed(claims: Sequence[Claim], kinds: Mapping[str, str]) -> Iterator[StoryLine]:
    """The claims that hold and that a reader should know."""
    for kind, said in unasked(claims, kinds):
        yield StoryLine("note", kinds[kind], " ".join(said))


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


def _noted(claims: Sequence[Claim], asked: str, state: str) -> Iterator[StoryLine]:
    """Claims that hold, where there are some."""
    if claims:
        yield StoryLine(state, asked, " ".join(sentences(claims, MOST_TOLD)))


def late_losses(findings: Findings) -> list[Claim]:
    """What losses that are noticed late cost."""
    kinds = ("loss_unnoticed", "loss_unnoticed_later", "loss_found_in_time")
    return [claim for kind in kinds for claim in findings.held(kind)]


def _lost(findings: Findings, causes: Causes) -> StoryLine:
    """What keeps a mission from success."""
    asked = "What defeats it?"
    if said := losses(findings.claims, "defeat"):
        state = "fails" if findings.held("without_repair_defeated") else "note"
        return StoryLine(state, asked, " ".join(said))
    return StoryLine("holds", asked, " ".join(spared(causes)))


def _survived(findings: Findings, causes: Causes) -> Iterator[StoryLine]:
    """Which hardware may be lost alone, and which objectives cannot succeed then."""
    if said := kept(findings.claims, "defeat", causes.unused):
        yield StoryLine("holds", "What does it survive?", " ".join(said))
    alone = {lost[0] for lost in causes.mission.cut_sets if len(lost) == 1}
    faulty = [h.name for h in findings.check.mission_net.core.hardware if h.faulty]
    if () not in causes.mission.cut_sets:
        yield from _left_out(findings, causes, [name for name in faulty if name not in alone])


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
        told.append(f"without {' or '.join(needed)}, {', '.join(objectives[:MOST_TOLD])}{more}")
    said = f"What has not begun cannot succeed then: {'; '.join(told)}."
    yield StoryLine("note", "What is lost then?", said)


def _safety(findings: Findings, causes: Causes) -> StoryLine:
    """What leaves a mission that can abort no safe end."""
    asked, verdict = "What endangers the robot?", findings.check.verdicts.get("can_always_end_safely")
    if verdict is None:
        unsaid = [claim for claim in findings.claims if claim.kind == "says_what_is_safe"]
        return StoryLine("note", asked, " ".join(sentences(unsaid)))
    if said := losses(findings.claims, "endanger"):
        state = "fails" if findings.held("without_repair_endangered") else "note"
        return StoryLine(state, asked, " ".join(said))
    if verdict.holds is False:
        return _shown(findings, verdict)
    said = kept(findings.claims, "endanger", causes.unused) or spared(causes, "endanger")
    return StoryLine("holds", asked, " ".join(said))


def _shown(findings: Findings, verdict: Verdict) -> StoryLine:
    """A verdict that fails, with its run where that has no internal firings."""
    said, run = of_verdict(verdict).sentence, verdict.runs[0] if verdict.runs else None
    if run is None or run.tail or findings.controller is None:
        return StoryLine("fails", "What endangers the robot?", said)
    texts = [str(event) for event, _ in in_words(findings.check.mission_net, run.of_events)]
    chips = strip(findings, texts)
    return StoryLine("fails", "What endangers the robot?", said, chips, json.dumps(texts))


def _ignored(findings: Findings) -> Iterator[StoryLine]:
    """Where the declared events are ignored, of missions that declare some."""
    asked = "What is ignored?"
    if ignored := [*sentences(findings.held("ignored"), MOST_TOLD, differ=1)]:
        yield StoryLine("note", asked, " ".join(_first(ignored)))
    elif handled := [*findings.held("handled_always"), *findings.held("answered_already")]:
        yield StoryLine("holds", asked, " ".join(_first(sentences(handled, MOST_TOLD))))


def _first(said: Sequence[str]) -> list[str]:
    """The first sentences, and how many more there are."""
    more = len(said) - MOST_TOLD
    return [*said[:MOST_TOLD], *([f"And {more} more, which check --json lists."] if more > 0 else [])]


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
    told += [f"met, but silent of an event where it is ignored: {_quoted(empty)}"] if empty else []
    state = "fails" if violated else "unknown" if unknown else "note" if advice or empty else "holds"
    yield StoryLine(state, asked, f"{'; '.join(told)}.")


def _granted(check: MissionCheck) -> Iterator[StoryLine]:
    """Hardware that the mission declares not to fail: the page says nothing of its loss."""
    if sound := [h.name for h in check.mission_net.core.hardware if not h.faulty]:
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
    """How the claims are known, what is not known, and what no claim speaks of."""
    asked, check, claims = "What is not proved?", findings.check, findings.claims
    open_ = sentences(claim for claim in claims if claim.holds is None)
    known = [claim for claim in claims if claim.holds is not None]
    runs = sum(claim.of.evidence == "a run" for claim in known if claim.holds)
    again = sum(bool(claim.formula) for claim in known)
    said = (
        f"{counted(len(claims), 'claim')}: {runs} shown by a run, {len(known) - runs} decided from all "
        f"states, {len(claims) - len(known)} not known; mcpn ask answers {again} again by their formulas. "
        "Rates are taken as given. Drivers are not part of it."
    )
    state = "unknown" if check.undecided else "note" if open_ or findings.notes else "holds"
    return StoryLine(state, asked, " ".join([*open_[:MOST_TOLD], *findings.notes, said]))


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
