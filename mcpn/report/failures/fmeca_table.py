"""The FMECA table as rows of texts, and as a file."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcpn.answers.causes.effects import Severity
from mcpn.answers.causes.fmeca import Row
from mcpn.answers.claims.of_cells import keys_of_column
from mcpn.errors import InputError, Source
from mcpn.files import write_atomically
from mcpn.sentences import enumeration

Classes = Mapping[Severity, str]
"""A user's own names of the severity classes."""

STANDARD: Classes = {severity: severity.words for severity in Severity}

ALONE = (
    "All other hardware is in service: what failed before is repaired, and objectives may have failed. "
    "Declared events and timeouts may help."
)
"""What each row assumes."""

COLUMNS = (
    "hardware",
    "objective",
    "section",
    "local_effect",
    "objective_effect",
    "mission_effect",
    "detection",
    "compensation",
    "recovery",
    "severity",
    "with_others",
)


def fmeca_rows(rows: Sequence[Row], classes: Classes = STANDARD) -> list[dict[str, str]]:
    """The table as texts, by column.

    Args:
        rows: The table.
        classes: Names of severities.
    """
    return [
        {
            **{column: str(getattr(row, column)) for column in COLUMNS[:-2]},
            "severity": classes[row.severity],
            "with_others": "; ".join(
                f"{classes[severity]} with {' or with '.join(map(enumeration, sets))}"
                for severity, sets in row.with_others
            ),
        }
        for row in rows
    ]


def check_table_name(path: Path) -> None:
    """Whether a table can be written to a file of this name.

    Raises:
        InputError: Its suffix is neither ``.csv`` nor ``.json``.
    """
    if path.suffix.lower() not in (".csv", ".json"):
        raise InputError.at(Source(str(path)), f"found the suffix {path.suffix!r}, expected .csv or .json")


def save_fmeca(rows: Sequence[Row], path: Path, classes: Classes = STANDARD) -> None:
    """Writes the table, whole or not at all.

    Args:
        rows: The table.
        path: A file ``.csv`` or ``.json``.
        classes: Names of severities.

    Raises:
        InputError: Another suffix, or the file cannot be written.
    """
    check_table_name(path)
    told: list[dict[str, Any]] = [*fmeca_rows(rows, classes)]
    if path.suffix.lower() == ".csv":
        text = io.StringIO(newline="")
        writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(told)
        write_atomically(path, text.getvalue())
    else:
        for row, each in zip(rows, told, strict=True):
            each["claims"] = {name: keys_of_column(row, column) for name, column in row.columns.items()}
        write_atomically(path, json.dumps(told, ensure_ascii=False, indent=1) + "\n")
