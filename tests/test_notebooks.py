"""Notebooks of the docs: each is run as a notebook runs it, and answers what stands in it.

Run: ``python -m tests.test_notebooks`` writes the answers anew.
"""

from __future__ import annotations

import ast
import contextlib
import io
import json
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import pytest

from tests.conftest import ROOT

NOTEBOOKS = sorted((ROOT / "docs").glob("*.ipynb"))


def answers(source: str, names: dict[str, Any]) -> list[dict[str, Any]]:
    """What a cell prints, and the value of its last line, as outputs of the notebook format."""
    tree, last = ast.parse(source), None
    if tree.body and isinstance(tree.body[-1], ast.Expr):
        last = ast.Expression(tree.body.pop().value)  # type: ignore[attr-defined]
    said, value = io.StringIO(), None
    with contextlib.redirect_stdout(said):
        exec(compile(tree, "<cell>", "exec"), names)
        if last is not None:
            value = eval(compile(last, "<cell>", "eval"), names)
    outputs: list[dict[str, Any]] = []
    if text := said.getvalue():
        outputs.append({"name": "stdout", "output_type": "stream", "text": text.splitlines(keepends=True)})
    if value is not None:
        data = {"text/plain": [repr(value)]}
        outputs.append({"data": data, "metadata": {}, "output_type": "execute_result"})
    return outputs


def run(notebook: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The notebook with the answers of today, run in a folder that holds the mission."""
    for path in (ROOT / "experiments" / "ulysse").glob("*.xml"):
        shutil.copy(path, folder)
    names: dict[str, Any] = {"__name__": "__main__"}
    cells, before = [], Path.cwd()
    os.chdir(folder)
    try:
        for number, cell in enumerate(notebook["cells"], 1):
            if cell["cell_type"] == "code":
                outputs = answers("".join(cell["source"]), names)
                for output in outputs:
                    if output["output_type"] == "execute_result":
                        output["execution_count"] = number
                cell = {**cell, "execution_count": number, "outputs": outputs}
            cells.append(cell)
    finally:
        os.chdir(before)
    return {**notebook, "cells": cells}


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_answers_what_stands_in_it(path: Path, tmp_path: Path) -> None:
    notebook = json.loads(path.read_text())
    assert sum(bool(cell.get("outputs")) for cell in notebook["cells"]) > 5
    found = run(notebook, tmp_path)
    for cell, today in zip(notebook["cells"], found["cells"], strict=True):
        assert today == cell, "".join(cell["source"])


if __name__ == "__main__":
    for path in NOTEBOOKS:
        with tempfile.TemporaryDirectory() as folder:
            path.write_text(json.dumps(run(json.loads(path.read_text()), Path(folder)), indent=1) + "\n")
