"""The option ``-o FOLDER``: what a script measured as a CSV file and a plot."""

from __future__ import annotations

import argparse
import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from mcpn.errors import McpnError
from mcpn.files import write_folder
from mcpn.report.pictures.plots import Bars, Curves, plotted, ready


def parsed(parser: argparse.ArgumentParser, name: str) -> argparse.Namespace:
    """The script's arguments, with ``output`` among them.

    What would keep the files from being written ends the script before it measures.

    Args:
        parser: The script's other options.
        name: What the files are called.
    """
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="FOLDER",
        help=f"write {name}.csv and {name}.svg there (needs mcpn[experiments])",
    )
    arguments = parser.parse_args()
    if arguments.output:
        try:
            ready(Path(f"{name}.svg"))
            arguments.output.mkdir(parents=True, exist_ok=True)
        except (McpnError, OSError) as error:
            parser.error(str(error))
    return arguments


def save(folder: Path, name: str, lines: Sequence[Mapping[str, Any]], plots: Sequence[Curves | Bars]) -> None:
    """Writes the CSV file and the plot.

    Args:
        folder: Where.
        name: What the files are called.
        lines: The rows by column; what a row lacks is empty.
        plots: What is drawn.
    """
    text = io.StringIO()
    writer = csv.DictWriter(text, list(dict.fromkeys(column for line in lines for column in line)))
    writer.writeheader()
    writer.writerows(lines)
    write_folder(folder, {f"{name}.csv": text.getvalue(), f"{name}.svg": plotted(plots)})
