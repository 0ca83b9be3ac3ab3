"""The contest's verdicts on formulas on paths."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from mcpn.check.engines import Asked
from mcpn.check.logic.contest import read_properties
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.verdicts import answer_all
from mcpn.net.formats import read_net

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
    compared = 0
    for file in ("LTLFireability", "LTLCardinality"):
        path = mcc / model / f"{file}.xml"
        asked = read_properties(path, questions.names) if path.exists() else []
        known = [each for each in asked if verdicts.get(each.name, "?") != "?"]
        answers = {found.name: found.value for found in answer_all(questions, known)}
        assert answers == {each.name: verdicts[each.name] for each in known}
        compared += len(answers)
    assert compared >= 16
