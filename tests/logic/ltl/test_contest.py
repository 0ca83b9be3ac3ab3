"""The contest's verdicts on formulas on paths."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from mcpn.logic.questions import Questions
from mcpn.nets.formats import read_net
from mcpn.spaces.engine_names import Asked
from tests.logic.test_ctl_contest import compare

QUICK = (
    "AutonomousCar-PT-01a",
    "Dekker-PT-010",
    "Eratosthenes-PT-010",
    "LamportFastMutEx-PT-2",
    "NQueens-PT-05",
    "Peterson-PT-2",
    "Raft-PT-02",
    "SmartHome-PT-01",
)


@pytest.fixture(scope="module")
def verdicts(mcc: Path) -> dict[str, str]:
    with (mcc / "formulas_ltl.tsv").open(newline="") as file:
        return {row["formula"]: row["verdict"] for row in csv.DictReader(file, delimiter="\t")}


@pytest.mark.parametrize("model", QUICK)
@pytest.mark.parametrize("engine", ["auto", "symbolic", "explicit"])
def test_the_contest_s_formulas_on_paths(
    mcc: Path, model: str, engine: Asked, verdicts: dict[str, str]
) -> None:
    questions = Questions(read_net(mcc / model / "model.pnml"), engine=engine)
    assert compare(mcc, model, questions, verdicts, ("LTLFireability", "LTLCardinality")) >= 16
