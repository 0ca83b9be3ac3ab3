"""Engines side by side, as a table to read, or one that a paper takes."""

from __future__ import annotations

import csv
import os
import platform
import re
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from importlib.metadata import PackageNotFoundError, version
from io import StringIO
from pathlib import Path
from typing import Any

from mcpn.answers.compare import DIAGRAM, GROWING, SIZES, Disagreement, Measured, Measurement, exponents
from mcpn.report.terminal import Terminal
from mcpn.version import VERSION

COLUMNS = (
    *("name", "size", "places", "transitions", "arcs", "engine", *SIZES),
    *("seconds", "median_seconds", "cpu_seconds", "median_cpu_seconds", "most_cpu_seconds", "megabytes"),
    *(*DIAGRAM, "order", "repeats", "reason"),
)
"""Of tables: one row for each engine and member."""

SPREAD = ("median_seconds", "median_cpu_seconds", "most_cpu_seconds")
"""Columns that say more than the others only where an engine runs several times."""


def machine() -> dict[str, str | int | float]:
    """What measurements depend on: the machine, how busy it is, and versions."""
    cpu = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.exists() and (found := re.search(r"model name\s*: (.*)", information.read_text())):
        cpu = found[1]
    told: dict[str, str | int | float] = {
        "processor": cpu,
        "processors": os.cpu_count() or 1,
        "gibibytes": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1),
        "system": platform.system(),
        "load": round(os.getloadavg()[0], 1),
        "python": platform.python_version(),
        "mcpn": VERSION,
    }
    for package in ("numpy", "pyeda"):
        try:
            told[package] = version(package)
        except PackageNotFoundError:
            told[package] = "none"
    return told


def comparison_object(members: Sequence[Measured], error: Disagreement | None) -> dict[str, Any]:
    """The comparison for programs: of one subject, ``members`` has one."""
    return {
        "engines": [asdict(m) for m in members[0].engines] if len(members) == 1 else [],
        "members": [asdict(member) for member in members],
        "exponents": exponents(members),
        "machine": machine(),
        "agree": error is None,
        "message": str(error or "") or None,
    }


def _rows(members: Sequence[Measured]) -> Iterator[dict[str, Any]]:
    for member in members:
        of_net = {name: getattr(member, name) for name in ("name", "size", "places", "transitions", "arcs")}
        for m in member.engines:
            row = of_net | asdict(m) | dict(m.sizes or {})
            if m.sizes is None:
                row |= dict.fromkeys(name for name in COLUMNS if name.endswith("seconds"))
            yield {name: row.get(name) for name in COLUMNS}


def table(members: Sequence[Measured], form: str) -> str:
    """The comparison as a table, the machine and versions in a comment above it.

    Args:
        members: What was measured.
        form: ``csv``, or ``latex``: a ``tabular`` in the rules of the package booktabs.
    """
    comment = ", ".join(f"{name} {value}" for name, value in machine().items())
    grows = "".join(f"; {told}" for told in _growing(members))
    if form == "csv":
        text = StringIO()
        writer = csv.DictWriter(text, COLUMNS, lineterminator="\n")
        text.write(f"# {comment}{grows}\n")
        writer.writeheader()
        writer.writerows(_rows(members))
        return text.getvalue()
    rows = list(_rows(members))
    once = all(row["repeats"] == 1 for row in rows)
    left_out = {"reason", "repeats", *(SPREAD if once else ())}
    shown = [c for c in COLUMNS if c not in left_out and any(row[c] is not None for row in rows)]
    texts = ("name", "engine", "order")
    repeats = "" if once else f"; runs of each: {max(row['repeats'] for row in rows)}"
    lines = [
        f"% {comment}{repeats}{grows}",
        *(f"% {row['name']}, {row['engine']}: {row['reason']}" for row in rows if row["reason"]),
        rf"\begin{{tabular}}{{{''.join('l' if name in texts else 'r' for name in shown)}}}",
        r"\toprule",
        " & ".join(_escaped(name.replace("_", " ")) for name in shown) + r" \\",
        r"\midrule",
        *(" & ".join(_cell(row[name]) for name in shown) + r" \\" for row in rows),
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(lines) + "\n"


def _cell(value: object) -> str:
    if value is None:
        return "--"
    if isinstance(value, float):
        return f"{value:.3f}"
    return f"{value:,}".replace(",", r"\,") if isinstance(value, int) else _escaped(str(value))


def _escaped(text: str) -> str:
    special = {"\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
    return "".join(special.get(c, "\\" + c if c in "&%$#_{}" else c) for c in text)


def print_comparison(members: Sequence[Measured]) -> None:
    """Prints what each engine found and took, its speed against the slowest, and how its time grows."""
    terminal = Terminal()
    counted = ("states", "edges", "stable_states", "dead_states")
    several = any(m.repeats > 1 for member in members for m in member.engines)
    heads = ["engine", "states", "edges", "stable", "dead", "CPU s", "wall s", "speed", "MB", "nodes", "peak"]
    if several:
        heads[6:6] = ["median"]
    rows: list[tuple[str, ...]] = [(*(["size"] if len(members) > 1 else []), *heads, "order")]
    for member in members:
        ran = [m for m in member.engines if m.sizes is not None]
        slowest = max((m.cpu_seconds for m in ran), default=0.0)
        for m in ran:
            sizes = {name: "" if size is None else str(size) for name, size in (m.sizes or {}).items()}
            first = ([str(member.size)] if len(members) > 1 else []) + [m.engine]
            took = [f"{m.cpu_seconds:.3f}", *([f"{m.median_cpu_seconds:.3f}"] if several else [])]
            took += [f"{m.seconds:.3f}", _speed(slowest, m), "" if m.megabytes is None else str(m.megabytes)]
            diagram = (sizes["nodes"], sizes["peak_nodes"], m.order or "")
            rows.append((*first, *(sizes[name] for name in counted), *took, *diagram))
    terminal.columns(rows)
    for member in members:
        at = "" if member.size is None else f" at size {member.size}"
        for m in member.engines:
            if m.sizes is None and not m.reason.startswith("gave up"):
                terminal.print(f"{m.engine}{at}: {m.reason}")
    for told in _growing(members):
        terminal.print(told)


def _growing(members: Sequence[Measured]) -> list[str]:
    """How what each engine takes grows with the size, in words."""
    return [
        f"{engine}: " + ", ".join(f"{GROWING[what]} grows as size^{slope:.2f}" for what, slope in own.items())
        for engine, own in exponents(members).items()
    ]


def _speed(slowest: float, m: Measurement) -> str:
    return f"{slowest / m.cpu_seconds:.1f} x" if m.cpu_seconds else ""
