"""A mission's report as one page of HTML that needs nothing else: no network, no other file.

The page holds the mission as drawn, verdicts with their runs, functioning modes, causes and the FMECA as
tables, and the controller, run in the browser by a small script. Every text of the mission is escaped, and
the page forbids itself all scripts but its own.
"""

from __future__ import annotations

import base64
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import resources
from typing import TYPE_CHECKING, Any

from mcpn import __version__
from mcpn.net.events import Event
from mcpn.report.failures.sentences import risk_counts, without_a_rate
from mcpn.report.failures.tables import COLUMNS, fmeca_rows
from mcpn.report.pictures.boxes import boxes
from mcpn.report.pictures.layout import lay_out
from mcpn.report.templates import environment
from mcpn.report.text import SENTENCES
from mcpn.report.words import in_words, modes_together, skipped_in_words, what_happens
from mcpn.sentences import enumeration

if TYPE_CHECKING:
    from mcpn.check.causes.cutsets import CutSet
    from mcpn.check.causes.find import Causes
    from mcpn.check.causes.fmeca import Row
    from mcpn.check.causes.risk import Risk
    from mcpn.check.verdicts.mission import MissionCheck
    from mcpn.report.findings import Findings


MOST_ROWS = 2000
"""Rows of one table of a page."""


@dataclass(frozen=True)
class Table:
    """A table that can be sorted and filtered.

    Args:
        name: Its caption.
        heads: Of its columns.
        rows: Texts.
        more: Rows that the page has no room for.
    """

    name: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    more: int = 0


def page(findings: Findings) -> str:
    """The report as a page of HTML."""
    mission_net = findings.check.mission_net
    root, keys = boxes(mission_net.mission, mission_net.graph)
    data = json.dumps(_data(findings, keys), separators=(",", ":"))
    script = resources.files("mcpn.report.templates").joinpath("report.js").read_text(encoding="utf-8")
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    return (
        environment()
        .get_template("report.html")
        .render(
            name=mission_net.mission.name,
            description=mission_net.mission.description,
            picture=lay_out(root, mission_net.mission),
            alone=False,
            verdicts=[*_verdicts(findings.check), *_requirements(findings.check)],
            passed=findings.check.passed,
            headline=_headline(findings.check),
            answers=list(_answers(findings)),
            local=findings.local,
            tables=_tables(findings),
            early=int(bool(findings.fmeca)),  # the first table answers what people ask first
            notes=findings.notes,
            warnings=findings.warnings,
            controlled=findings.controller is not None,
            # Data in a script element ends at the first "<" that closes it: there is none.
            data=data.replace("<", "\\u003c"),
            script=script,
            digest=digest,
            version=__version__,
        )
    )


def _data(findings: Findings, keys: Mapping[str, int]) -> dict[str, Any]:
    """What the script needs: the controller, words for its events, boxes of its objectives."""
    if findings.controller is None:
        return {}
    document = dict(findings.controller)
    mission = document["mission"]
    events = {"MISSION_EV_START", *(e for section in document["sections"] for e in section["events"])}
    for hardware in document["hardware"]:
        events |= {f"{hardware}_EV_OOS", f"{hardware}_EV_RD"}
    typed = {text: Event.parse(text) for text in sorted(events)}
    document.pop("objectives")
    document.pop("activities")
    words = {text: [event.what.value, what_happens(event, mission)] for text, event in typed.items()}
    return {"controller": document, "events": words, "boxes": dict(keys)}


def _headline(check: MissionCheck) -> str:
    """Whether the mission may be flown, in a sentence."""
    if check.violated:
        return f"It does not meet what it requires: {enumeration(check.violated)}."
    if not check.passed:
        return "Some required verdicts do not hold."
    met = " It meets what it requires." if any(answer.required for answer in check.requirements) else ""
    return f"All required verdicts hold.{met}"


def _requirements(check: MissionCheck) -> Iterator[dict[str, Any]]:
    """Each requirement in its author's words, with the run that violates it."""
    for answer in check.requirements:
        asked = answer.asked
        state = {True: "holds", False: "fails", None: "unknown"}[answer.met]
        runs, notes = [], [f"{'' if asked.requirement.expected == 'holds' else 'not: '}{asked.text}"]
        if asked.sentence not in ("", asked.words):
            notes.insert(0, asked.sentence)
        if answer.witness is not None and not answer.met:
            steps = [(str(event), words) for event, words in in_words(check.mission_net, answer.witness.run)]
            runs = [{"steps": steps, "events": json.dumps([event for event, _ in steps])}]
            notes += answer.witness.notes
        yield {
            "name": asked.name,
            "sentence": asked.words,
            "state": state if answer.required or answer.met else "note",
            "explanation": "; ".join([*notes, *filter(None, [answer.reason, answer.says_nothing_of])]),
            "runs": runs,
        }


def _verdicts(check: MissionCheck) -> list[dict[str, Any]]:
    """Each verdict as a sentence, with its runs in mission words."""
    found = []
    for name in (*SENTENCES, *(name for name in check.verdicts if name not in SENTENCES)):
        if name not in check.verdicts:
            continue
        verdict = check.verdicts[name]
        sentences = SENTENCES.get(name, (verdict.explanation,) * 3)
        state = {True: "holds", False: "fails", None: "unknown"}[verdict.holds]
        runs = []
        for run in verdict.runs:
            steps = list(in_words(check.mission_net, run))
            events = None if run.tail else json.dumps([str(event) for event, _ in steps])
            runs.append({"steps": [(str(event), words) for event, words in steps], "events": events})
        found.append(
            {
                "name": name,
                "sentence": sentences[{True: 0, False: 1, None: 2}[verdict.holds]],
                "state": state if verdict.required else "note",
                "explanation": "; ".join(
                    [verdict.explanation, *([skipped_in_words(verdict.skipped)] if verdict.skipped else [])]
                ),
                "runs": runs,
            }
        )
    return found


def _answers(findings: Findings) -> Iterator[tuple[str, str]]:
    """What is asked first, each with its state: can it succeed, what makes it fail, what does it survive."""
    verdict = findings.check.verdicts["success_reachable"]
    number = {True: 0, False: 1, None: 2}[verdict.holds]
    yield ("holds", "fails", "unknown")[number], SENTENCES["success_reachable"][number]
    if findings.causes is None:
        return
    mission, safety = findings.causes.mission, findings.causes.safety
    yield from _lost(mission.cut_sets, aborts=safety is not None)
    if safety is not None:
        yield _safety(safety.cut_sets)
    yield from _survived(findings)
    if findings.risk is not None:
        chance = findings.risk
        aborts = "" if chance.abort is None else f", is aborted with {chance.abort:.6g}"
        told = (
            f"it succeeds with probability {chance.success:.6g}{aborts} and fails with {chance.failure:.6g}"
        )
        if chance.unrated:
            told += f"; {without_a_rate(chance)}"
        yield "note", f"With the given rates {told}."


def _lost(cut_sets: Sequence[CutSet], *, aborts: bool) -> Iterator[tuple[str, str]]:
    """What keeps a mission from success."""
    if () in cut_sets:
        yield "fails", f"It {'can never succeed' if aborts else 'fails'} whatever the hardware does."
    elif cut_sets:
        lost = "; ".join(map(_together, cut_sets))
        yield "note", f"It can succeed no more once this hardware is lost and not repaired: {lost}."
    else:
        keeps = "keeps it from success" if aborts else "makes it fail"
        yield "holds", f"No loss of hardware alone {keeps}."


def _survived(findings: Findings) -> Iterator[tuple[str, str]]:
    """Which hardware may be lost alone; giving up safely is no success, and is told apart from it."""
    causes, faulty = findings.causes, [h for h in findings.check.mission_net.mission.hardware if h.faulty]
    if causes is None:
        return

    def left(cut_sets: Sequence[CutSet]) -> list[str]:
        alone = {lost[0] for lost in cut_sets if len(lost) == 1}
        return [] if () in cut_sets else [h.name for h in faulty if h.name not in alone]

    succeeding = left(causes.mission.cut_sets)
    if causes.safety is None:
        if succeeding:
            yield "holds", f"It survives the loss of any one of these alone: {', '.join(succeeding)}."
        return
    if succeeding:
        yield "holds", f"It can succeed after the loss of any one of these alone: {', '.join(succeeding)}."
    aborting = [name for name in left(causes.safety.cut_sets) if name not in succeeding]
    if aborting:
        names = ", ".join(aborting)
        yield "note", f"After the loss of any one of these alone it can only be aborted: {names}."


def _together(lost: CutSet) -> str:
    return enumeration(lost) + (" together" if len(lost) > 1 else "")


def _safety(cut_sets: Sequence[CutSet]) -> tuple[str, str]:
    """What makes a mission that can abort end in neither success nor abort."""
    if () in cut_sets:
        return "fails", "It can never succeed, and never be aborted."
    if not cut_sets:
        return "holds", "Whatever hardware is lost, it can still succeed or be aborted."
    lost = "; ".join(map(_together, cut_sets))
    return (
        "note",
        f"It can neither succeed nor be aborted once this hardware is lost and not repaired: {lost}.",
    )


def _what_if(rows: Sequence[Row]) -> Table:
    """For each objective that may run, what the failure of each hardware resource alone does."""
    hardware = list(dict.fromkeys(row.hardware for row in rows))
    by_objective: dict[str, dict[str, str]] = {}
    for row in rows:
        by_objective.setdefault(row.objective, {})[row.hardware] = _effect(row)
    heads = ("while this runs", *(f"{name} fails" for name in hardware))
    table = [
        (objective, *(found.get(name, "") for name in hardware)) for objective, found in by_objective.items()
    ]
    return Table("What happens when hardware fails", heads, table)


def _effect(row: Row) -> str:
    if row.local_effect == "none":
        return "nothing changes"
    return f"{row.objective_effect} ({row.local_effect}); mission {row.mission_effect}"


def _risk(risk: Risk) -> Table:
    """Numbers of risk: the mission's, then the importance of each hardware resource."""
    said = {end: f"probability of {end}" for end in ("success", "abort", "failure")}
    said["degraded modes"] = "times in a degraded mode, expected"
    rows = [(said.get(name, name), f"{value:.6g}") for name, value in risk_counts(risk)]
    return Table("Risk", ("what", "value"), rows)


def _tables(findings: Findings) -> list[Table]:
    tables = [
        Table(
            "Functioning modes",
            ("objectives", "mode", "alternatives"),
            [
                (", ".join(objectives), str(number), mode or "as written")
                for modes, objectives in modes_together(findings.check).items()
                for number, mode in enumerate(modes, 1)
            ],
        )
    ]
    if findings.fmeca:
        tables.insert(0, _what_if(findings.fmeca))
    if findings.risk is not None:
        tables.append(_risk(findings.risk))
    if findings.causes is not None:
        tables += _cause_tables(findings.causes)
    if findings.fmeca is not None:
        rows = [[row[column] for column in COLUMNS] for row in fmeca_rows(findings.fmeca)]
        heads = [column.replace("_", " ") for column in COLUMNS]
        tables.append(Table("FMECA: what each failure does", heads, rows))
    return [_cut(table) for table in (*tables, _sizes(findings))]


def _cut(table: Table) -> Table:
    """A table as far as a page has room for it."""
    return replace(table, rows=table.rows[:MOST_ROWS], more=max(0, len(table.rows) - MOST_ROWS))


def _cause_tables(causes: Causes) -> list[Table]:
    goals = [(goal.name, goal) for goal in (causes.mission, *causes.objectives.values())]
    if causes.safety is not None:
        goals.insert(1, (f"{causes.safety.name}: its safe ends", causes.safety))
    sets = [
        (name, enumeration(lost or ("nothing: it fails anyway",)), str(len(lost)))
        for name, goal in goals
        for lost in goal.cut_sets
    ]
    critical = [
        (
            what_happens(found.event, causes.mission.name),
            ", ".join(found.objectives) or "no objective",
            ", ".join(f"{a}: {way}" for a, way in found.mode.items() if a != way) or "as written",
        )
        for found in causes.mission.critical or ()
    ]
    return [
        Table("Causes: smallest losses after which it fails", ("what fails", "lost", "how many"), sets),
        Table("Critical events: after them only a repair helps", ("event", "while", "mode"), critical),
    ]


def _sizes(findings: Findings) -> Table:
    check = findings.check
    net = check.mission_net.net
    rows = [("places", str(len(net.places))), ("transitions", str(len(net.transitions)))]
    for sizes, what in ((check.sizes_seen, ("markings", "edges")), (check.stable_sizes, _STABLE)):
        if sizes is not None:
            rows += [(name, str(size)) for name, size in zip(what, sizes, strict=True)]
    if findings.controller is not None:
        types = findings.controller["types"]
        rows.append(("sections of the controller", str(len(findings.controller["sections"]))))
        rows.append(("states of the controller", str(sum(len(t["states"]) for t in types))))
    rows.append(("engine", findings.engine))
    rows += [(f"seconds: {what}", f"{took:.2f}") for what, took in findings.seconds.items()]
    return Table("Sizes and times", ("what", "value"), rows)


_STABLE = ("stable states", "event edges")
