"""The tables of a page, each with a line on how to read it; equal rows of rounds and tries are merged."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from mcpn.answers.causes.effects import NOT_HERE
from mcpn.answers.mission_names import MissionNames
from mcpn.report.failures.fmeca_table import ALONE, COLUMNS, fmeca_rows
from mcpn.report.failures.sentences import IMPORTANCE, risk_counts
from mcpn.report.words import MOST_NAMED, modes_in_words, modes_together, what_happens
from mcpn.sentences import enumeration, shortened

if TYPE_CHECKING:
    from mcpn.answers.causes.find import Causes
    from mcpn.answers.causes.fmeca import Row
    from mcpn.answers.causes.risk import Risk
    from mcpn.answers.verdicts.mission import MissionCheck
    from mcpn.drawing.compose import MissionNet
    from mcpn.findings import Findings

_NAME = re.compile(r"\w(?:[\w.-]*\w)?")
"""Matches words in a text that may be names of objectives."""

MOST_ROWS = 2000
"""Rows of one table of a page."""

MOST_COLUMNS = 6
"""Columns of a matrix that a sheet has room for."""

MOST_BITS = 10_000
"""Of a count that is written in full."""

UNCHANGED = "–"
"""Says that a failure changes nothing."""

Texts = Sequence[str]


@dataclass(frozen=True)
class Table:
    """A table that can be sorted and filtered.

    Args:
        name: Its caption.
        reading: How to read it, in a line.
        heads: Of its columns.
        rows: Texts.
        needs: By row the hardware that it needs, where the page strikes out what is lost; else nothing.
        tools: Whether it is for those who look after mcpn, and not printed.
        more: Rows that the page has no room for.
    """

    name: str
    reading: str
    heads: Texts
    rows: Sequence[Texts]
    needs: Sequence[Texts] = ()
    tools: bool = False
    more: int = 0


def tables(findings: Findings) -> list[Table]:
    """All tables of a page, those that people ask for first in front."""
    check = findings.check
    mission_net = check.mission_net
    found = [_modes(check)]
    if findings.fmeca:
        found.insert(0, _what_if(findings.fmeca, mission_net))
    if findings.risk is not None:
        found.append(_risk(findings.risk))
    if findings.causes is not None:
        found += _cause_tables(findings.causes, mission_net)
    if findings.fmeca is not None:
        found.append(_fmeca(findings.fmeca, mission_net))
    return [_cut(table) for table in (*found, _sizes(findings))]


def fold_rows(mission_net: MissionNet, rows: Iterable[Texts], column: int = 0) -> list[Texts]:
    """Merges rows of rounds and tries of one objective where they are equal but for its name.

    Rows of all of them may differ in the names of their own rounds and tries, those of some may not. Rows
    that are equal throughout are one.

    Args:
        mission_net: The mission's net.
        rows: Texts.
        column: Which of them names an objective.

    >>> from mcpn.mission.xml import read_mission
    >>> from mcpn.drawing.compose import compose
    >>> from pathlib import Path
    >>> drone = compose(read_mission(Path("experiments/drone/mission.xml")))
    >>> fold_rows(drone, [(f"stock_{aisle}.leave", "no way") for aisle in ("A1", "A2", "B1")])
    [('stock.leave (all 3)', 'no way')]
    >>> fold_rows(drone, [("stock_A1.leave", "no way"), ("stock_A2.leave", ""), ("stock_B1.leave", "")])
    [('stock_A1.leave', 'no way'), ('stock_A2.leave', ''), ('stock_B1.leave', '')]
    """
    names, copies = MissionNames(mission_net), mission_net.graph.copies
    every = [objective.name for objective in mission_net.graph.walk()]
    whole = names.folded(every)
    plain = {copy: name for name, copies in whole.items() if len(copies) > 1 for copy in copies}
    groups: dict[tuple[str, ...], dict[tuple[str, ...], None]] = {}
    for row in map(tuple, rows):
        said = (_NAME.sub(lambda name: plain.get(name[0], name[0]), cell) for cell in row)
        groups.setdefault(tuple(said), {})[row] = None
    found: list[Texts] = []
    for key, same in groups.items():
        if len(same) > 1 and {row[column] for row in same} == {*whole.get(key[column], ())}:
            found.append(tuple(f"{c} (all {len(same)})" if i == column else c for i, c in enumerate(key)))
            continue
        alike: dict[tuple[str, ...], list[str]] = {}
        for row in same:
            alike.setdefault((*row[:column], *row[column + 1 :]), []).append(row[column])
        for rest, these in alike.items():
            told = these if len(these) == 1 else copies.told(these, every)
            found += ((*rest[:column], name, *rest[column:]) for name in told)
    return found


def _what_if(rows: Sequence[Row], mission_net: MissionNet) -> Table:
    """For each objective that may run, what the failure of each hardware resource alone does."""
    hardware = list(dict.fromkeys(row.hardware for row in rows))
    by_objective: dict[str, dict[str, str]] = {}
    for row in rows:
        by_objective.setdefault(row.objective, {})[row.hardware] = _effect(row)
    heads = ("while this runs", *(f"{name} fails" for name in hardware))
    table = [
        (objective, *(found.get(name, "") for name in hardware)) for objective, found in by_objective.items()
    ]
    effects = [effect for found in by_objective.values() for effect in found.values()]
    if len(hardware) > MOST_COLUMNS or sum(e == UNCHANGED for e in effects) * 2 > len(effects):
        return _differences(by_objective, mission_net)
    return Table(
        "What happens when hardware fails",
        f"A row is what the robot is doing, a column what fails then; the cell is what follows ({UNCHANGED}: "
        f"nothing changes). {ALONE}",
        heads,
        fold_rows(mission_net, table),
    )


def _differences(effects: Mapping[str, Mapping[str, str]], mission_net: MissionNet) -> Table:
    """What failures change, as a list: hardware with one effect together, objectives with equal rows too."""
    rows = list[Texts]()
    for objective, found in effects.items():
        together: dict[str, list[str]] = {}
        for hardware, effect in found.items():
            together.setdefault(effect, []).append(hardware)
        rows += ((objective, ", ".join(h), e) for e, h in together.items() if e != UNCHANGED)
    return Table(
        "What happens when hardware fails",
        f"While an objective runs one hardware resource fails. What is not listed changes nothing. {ALONE}",
        ("while this runs", "one of these fails", "what follows"),
        merged(fold_rows(mission_net, rows)),
    )


def merged(rows: Iterable[Texts], column: int = 0, by: str = ", ", most: int | None = None) -> list[Texts]:
    """Rows that are equal but for one column as one row, which lists what stands in it.

    Args:
        rows: Texts.
        column: Which one.
        by: Stands between what it lists.
        most: How many it lists; it says how many more there are.

    >>> merged([("dive", "fails"), ("climb", "fails"), ("wait", "goes on")])
    [('dive, climb', 'fails'), ('wait', 'goes on')]
    """
    same: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        same.setdefault((*row[:column], *row[column + 1 :]), []).append(row[column])

    def told(names: list[str]) -> str:
        left = 0 if most is None else max(0, len(names) - most)
        return by.join(names[: len(names) - left]) + (f"{by}{left} more" if left else "")

    return [(*rest[:column], told(names), *rest[column:]) for rest, names in same.items()]


def _effect(row: Row) -> str:
    if row.local_effect == "none":
        return UNCHANGED
    elsewhere = row.local_effect.removeprefix(NOT_HERE)
    if row.objective_effect == "none" and elsewhere != row.local_effect:
        return f"{elsewhere}; mission {row.mission_effect}"
    return f"{row.objective_effect} ({row.local_effect}); mission {row.mission_effect}"


def _fmeca(rows: Sequence[Row], mission_net: MissionNet) -> Table:
    """The table of failure modes, effects and criticality; severity stands in front."""
    order = (
        "hardware",
        "objective",
        "severity",
        *(c for c in COLUMNS[2:] if c not in ("severity", "section")),
    )
    worst = sorted((row for row in rows if _changes(row)), key=lambda row: row.worst, reverse=True)
    texts = [tuple(row[column] for column in order) for row in fmeca_rows(worst)]
    return Table(
        "FMECA: what each failure does",
        "One row for each hardware resource that fails while an objective runs: how bad it is, what changes "
        "at once, for the objective and for the mission, and what makes up for it. A failure that changes "
        f"nothing, with whatever else is out of service, has no row. {ALONE}",
        [column.replace("_", " ") for column in order],
        merged(merged(fold_rows(mission_net, texts, 1), 1)),
    )


def _changes(row: Row) -> bool:
    """Whether a failure changes anything, with whatever else is out of service."""
    return row.local_effect != "none" or bool(row.with_others)


def _modes(check: MissionCheck) -> Table:
    """Functioning modes; each with the hardware that its alternatives take."""
    taken = {
        f"{activity.name}.{alternative.name}": alternative.consumes
        for activity in check.mission_net.usage.activities.values()
        for alternative in activity.alternatives
    }
    hardware = {h.name for h in check.mission_net.core.hardware if h.faulty}
    needed: dict[str, set[str]] = {}  # of modes with equal words, what all of them need
    for modes in check.modes.values():
        for mode, words in ((mode, modes_in_words([mode])[0]) for mode in modes):
            needs = {name for a, way in mode.items() for name in taken.get(f"{a}.{way}", ())} & hardware
            needed[words] = needs & needed.get(words, needs)
    rows, needs_of = [], []
    for ways, objectives in modes_together(check).items():
        for number, way in enumerate(ways, 1):
            rows.append((shortened(objectives, MOST_NAMED), str(number), way or "as written"))
            needs_of.append(sorted(needed.get(way, ())))
    return Table(
        "Functioning modes",
        "The ways in which the robot runs these objectives, the preferred one first; 'as written' is with "
        "the alternatives that are named like their activities.",
        ("objectives", "mode", "alternatives"),
        rows,
        needs_of,
    )


def _risk(risk: Risk) -> Table:
    """Numbers of risk: the mission's, then the importance of each hardware resource."""
    said = {end: f"probability of {end}" for end in ("success", "abort", "failure")}
    said["degraded modes"] = "times in a degraded mode, expected"
    rows = [(said.get(name, name), f"{value:.6g}") for name, value in risk_counts(risk)]
    reading = "From the rates and durations that the mission's files give; what has none never fails there. "
    return Table("Risk", f"{reading}{IMPORTANCE[0].upper()}{IMPORTANCE[1:]}.", ("what", "value"), rows)


def _cause_tables(causes: Causes, mission_net: MissionNet) -> Iterator[Table]:
    goals = [(causes.mission.name, causes.mission)]
    if causes.safety is not None:
        goals.append((f"{causes.safety.name}: its safe ends", causes.safety))
    sets, of_objectives = (
        [
            (name, enumeration(lost or ("nothing: it fails anyway",)), str(len(lost)))
            for name, goal in some
            for lost in goal.cut_sets
        ]
        for some in (goals, causes.objectives.items())
    )
    critical = [
        (
            what_happens(found.event, causes.mission.name),
            ", ".join(found.objectives) or "no objective",
            ", ".join(f"{a}: {way}" for a, way in found.mode.items() if a != way) or "as written",
        )
        for found in causes.mission.critical or ()
    ]
    yield Table(
        "Causes: smallest losses that leave no way to success",
        "Each row is enough by itself: lost before the mission starts, of an objective before it begins, and "
        "not repaired. Declared events may help.",
        ("what fails", "lost", "how many"),
        [*sets, *merged(fold_rows(mission_net, of_objectives), most=MOST_NAMED)],
    )
    yield Table(
        "Critical events: after them nothing but a repair may help",
        "The last events of runs without repairs that lose the mission, in some states: what happens, and "
        "what the robot was doing.",
        ("event", "while", "mode"),
        merged(fold_rows(mission_net, critical, 1), 1, "; or ", MOST_NAMED),
    )


def _cut(table: Table) -> Table:
    """A table as far as a page has room for it."""
    more = max(0, len(table.rows) - MOST_ROWS)
    return replace(table, rows=table.rows[:MOST_ROWS], needs=table.needs[:MOST_ROWS], more=more)


def _sizes(findings: Findings) -> Table:
    check = findings.check
    net = check.mission_net.net
    rows = [("places", str(len(net.places))), ("transitions", str(len(net.transitions)))]
    for sizes, what in ((check.sizes_seen, ("markings", "edges")), (check.stable_sizes, _STABLE)):
        if sizes is not None:
            rows += [(name, _count(size)) for name, size in zip(what, sizes, strict=True)]
    if findings.controller is not None:
        form, sections = findings.controller["form"], findings.controller["sections"]
        rows.append((f"sections of the controller of this page, {form}", str(len(sections))))
    rows.append(("engine", findings.engine))
    return Table("Sizes", "For those who maintain mcpn.", ("what", "value"), rows, tools=True)


def _count(number: int) -> str:
    """A count in full; of one with thousands of digits, which Python may refuse to write, how many it has."""
    if number.bit_length() < MOST_BITS:
        return str(number)
    return f"a number of some {int(number.bit_length() * 0.30103)} digits"


_STABLE = ("stable states", "event edges")
