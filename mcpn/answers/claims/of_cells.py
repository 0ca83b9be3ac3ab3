"""Claims in the cells of the FMECA table, and the formulas of those that have one."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

from mcpn.answers.claims.claim import Assumes, Claim
from mcpn.answers.claims.late import open_run
from mcpn.answers.claims.of_check import MOST_PAIRS
from mcpn.answers.claims.parts import FormulaParts
from mcpn.answers.kinds.by_name import KINDS
from mcpn.events import What

if TYPE_CHECKING:
    from mcpn.answers.causes.effects import Cell, Column
    from mcpn.answers.causes.fmeca import Row

ALONE = Assumes(repairs="all")


def claim_of_cell(row: Row, cell: Cell, formula: str = "") -> Claim:
    """The claim in a cell of a row."""
    given = (cell.given.removeprefix(" for "),) if cell.given else ()
    subject = (row.hardware, row.objective, *cell.names)
    return Claim(cell.kind, subject, True, ALONE._replace(given=given), formula)


def keys_of_column(row: Row, column: Column) -> list[str]:
    """The keys of the claims in one cell."""
    return list(dict.fromkeys(claim_of_cell(row, cell).key for told in column for cell in told))


def claims_of_cells(rows: Sequence[Row], parts: FormulaParts[Any]) -> Iterator[Claim]:
    """The claims in all cells, with their formulas; those of many rows stand in the table alone."""
    if len(rows) > MOST_PAIRS:
        return
    said = _Said(parts)
    for row in rows:
        cells = {claim_of_cell(row, cell).key: cell for cell in row.cells}
        for cell in cells.values():
            yield claim_of_cell(row, cell, said.formula(row, cell))
        if not any(cell.kind in ("objective_lost", "lost_unseen") for cell in row.cells):
            subject = row.hardware, row.objective
            formula = said.of_kind("objective_lost", row, subject, ())
            if formula:
                yield Claim("objective_lost", subject, False, ALONE, formula)


class _Said:
    """The formulas of the cells of one mission."""

    def __init__(self, parts: FormulaParts[Any]) -> None:
        self.parts, self.mission = parts, parts.prospects.mission
        safety = parts.prospects.safety
        self.said = {
            "sound": parts.sound,
            "wins": parts.reaches(self.mission),
            "unrepaired": parts.reaches(self.mission, parts.repairs),
            "safe": "" if safety is None else parts.reaches(safety),
            "safe_unrepaired": "" if safety is None else parts.reaches(safety, parts.repairs),
        }
        self._open = dict[str, str]()

    def formula(self, row: Row, cell: Cell) -> str:
        """The formula of a cell; empty where none says it."""
        others = [cell.names[-1]] if cell.kind.endswith("_elsewhere") else []
        if cell.given or not self.parts.mean_one(others):
            return ""
        return self.of_kind(cell.kind, row, (row.hardware, row.objective, *cell.names), cell.ways)

    def of_kind(self, kind: str, row: Row, subject: Sequence[str], ways: Sequence[tuple[str, str]]) -> str:
        """The formula of a kind."""
        name, template = row.objective, KINDS[kind].formula
        if not template or not self.parts.mean_one([name]):
            return ""
        if name not in self._open:
            self._open[name] = open_run(self.parts, name)
        chosen = " & ".join(f"alternative({activity})={way}" for activity, way in ways)
        repaired = self.parts.prospects.carrying(What.REPAIRED, row.hardware)
        repair = f"event({row.hardware}_EV_RD)" if repaired else "false"
        said = {**self.said, "open": self._open[name], "ways": chosen, "repair": repair}
        if any(f"{{{part}}}" in template and not text for part, text in said.items()):
            return ""
        return template.format(*subject, **said)
