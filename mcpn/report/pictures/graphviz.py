"""Runs Graphviz in a process of its own: it crashes on some graphs, and can be stopped where it takes long.

It gets sizes and numbers only, no text. Run as a program, this module answers a list of questions on
standard input with a list of layouts on standard output.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Any, TypeAlias

from mcpn.errors import LimitError

Size: TypeAlias = tuple[float, float]
Question: TypeAlias = dict[str, Any]
"""Sizes and numbers.

- ``sideways``;
- ``nodes``: each a size;
- ``clusters``: each with ``parent`` (a number or null), ``members`` and the size of its ``label``;
- ``edges``: each with ``ends``, ``label`` (a size or null), ``both``, ``arrow`` and ``weight``.
"""

Layout: TypeAlias = dict[str, Any]
"""As Graphviz writes it: ``bb``, ``objects``, ``edges``."""

SECONDS = 60
"""How long one layout may take."""

POINTS = 72.0
"""Graphviz measures boxes in inches, everything else in points."""

CURVES, STRAIGHT = "true", "line"


def laid_out(questions: Sequence[Question], name: str) -> list[Layout]:
    """Lays out graphs, one after the other; where Graphviz fails with curves, with straight lines.

    Args:
        questions: The graphs.
        name: What they show, for errors.

    Raises:
        LimitError: Graphviz is not there, fails or takes too long.
    """
    from mcpn.report.pictures.drawing import needed

    needed("pygraphviz", "a drawing of a graph")
    layouts = _answers([{**question, "splines": CURVES} for question in questions])
    if not isinstance(layouts, str):
        return layouts
    singly = []
    for question in questions:
        for splines in (CURVES, STRAIGHT):
            layouts = _answers([{**question, "splines": splines}])
            if not isinstance(layouts, str):
                singly += layouts
                break
        else:
            raise LimitError(f"{name}: Graphviz finds no layout: {layouts}")
    return singly


def _answers(questions: Sequence[Question]) -> list[Layout] | str:
    """Layouts, or in words why there are none: Graphviz fails with one of the graphs or takes too long."""
    try:
        run = subprocess.run(
            [sys.executable, "-m", "mcpn.report.pictures.graphviz"],
            input=json.dumps(questions),
            capture_output=True,
            text=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return f"it takes longer than {SECONDS} seconds"
    if run.returncode < 0:
        return f"its process was ended by signal {-run.returncode}"
    if run.returncode:
        said = run.stderr.strip().splitlines()
        return f"its process ended with {said[-1] if said else f'exit code {run.returncode}'}"
    layouts: list[Layout] = json.loads(run.stdout)
    whole = all(
        sum("pos" in edge for edge in layout.get("edges", ())) == len(question["edges"])
        for layout, question in zip(layouts, questions, strict=True)
    )
    return layouts if whole else "it leaves edges out"


def layout(question: Question) -> Layout:
    """The layout of one graph, in this process."""
    graph = import_module("pygraphviz").AGraph(
        directed=True,
        strict=False,
        rankdir="LR" if question["sideways"] else "TB",
        nodesep="0.3",
        ranksep="0.45",
        splines=question["splines"],
    )
    graph.node_attr.update(shape="box", fixedsize="true", label="")
    for number, (width, height) in enumerate(question["nodes"]):
        graph.add_node(f"n{number}", width=f"{width / POINTS:.3f}", height=f"{height / POINTS:.3f}")
    inside: dict[int | None, Any] = {None: graph}
    for number, cluster in enumerate(question["clusters"]):
        inside[number] = inside[cluster["parent"]].add_subgraph(
            [f"n{member}" for member in cluster["members"]],
            name=f"cluster_{number}",
            label=_space(*cluster["label"]),
            margin="10",
        )
    for number, edge in enumerate(question["edges"]):
        label = {"label": _space(*edge["label"])} if edge["label"] else {}
        graph.add_edge(
            *(f"n{end}" for end in edge["ends"]),
            key=f"e{number}",
            dir="both" if edge["both"] else "forward" if edge["arrow"] else "none",
            weight=str(edge["weight"]),
            **label,
            **{"class": f"e{number}"},
        )
    answer: Layout = json.loads(graph.draw(format="json0", prog="dot"))
    return answer


def _space(width: float, height: float) -> str:
    """A label of a size and without a text."""
    size = f'WIDTH="{width:.0f}" HEIGHT="{height:.0f}"'
    return f'<<TABLE FIXEDSIZE="TRUE" BORDER="0" CELLPADDING="0" {size}><TR><TD></TD></TR></TABLE>>'


if __name__ == "__main__":
    json.dump([layout(question) for question in json.load(sys.stdin)], sys.stdout)
