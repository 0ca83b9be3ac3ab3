"""CTL of the Model Checking Contest: verdicts of its files."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import pytest

from mcpn.logic.answering import answer_all
from mcpn.logic.contest import read_properties
from mcpn.logic.questions import Questions
from mcpn.nets.formats import read_net
from mcpn.spaces.engine_names import Asked

QUICK = (
    "AirplaneLD-PT-0010",
    "AutoFlight-PT-01a",
    "Dekker-PT-010",
    "Eratosthenes-PT-010",
    "LamportFastMutEx-PT-2",
    "NQueens-PT-05",
    "Peterson-PT-2",
    "Philosophers-PT-000010",
    "Raft-PT-02",
    "Railroad-PT-005",
    "RwMutex-PT-r0010w0010",
    "SharedMemory-PT-000005",
    "SmartHome-PT-01",
    "TokenRing-PT-005",
)


SEVERAL_TOKENS = (
    "FMS-PT-00005",
    "HouseConstruction-PT-00002",
    "Kanban-PT-00005",
    "RobotManipulation-PT-00001",
    "Szymanski-PT-a02",
)


FILES = (
    "CTLFireability",
    "CTLCardinality",
    "ReachabilityFireability",
    "ReachabilityCardinality",
    "UpperBounds",
)


@pytest.fixture(scope="module")
def verdicts(mcc: Path) -> dict[str, str]:
    with (mcc / "formulas.tsv").open(newline="") as file:
        return {row["formula"]: row["verdict"] for row in csv.DictReader(file, delimiter="\t")}


def compare(
    mcc: Path, model: str, questions: Questions, verdicts: dict[str, str], files: Sequence[str] = FILES
) -> int:
    compared = 0
    for file in files:
        path = mcc / model / f"{file}.xml"
        asked = read_properties(path, questions.names) if path.exists() else []
        known = [each for each in asked if verdicts.get(each.name, "?") != "?"]
        answers = {found.name: found.value for found in answer_all(questions, known)}
        assert answers == {each.name: verdicts[each.name] for each in known}
        compared += len(answers)
    return compared


@pytest.mark.parametrize(
    ("engine", "model"),
    [
        *(("auto", model) for model in (*QUICK, *SEVERAL_TOKENS)),
        *(("symbolic", model) for model in (*QUICK[::2], *SEVERAL_TOKENS)),
        *(pytest.param("symbolic", model, marks=pytest.mark.slow) for model in QUICK[1::2]),
    ],
)
def test_the_contest_s_properties(mcc: Path, model: str, engine: Asked, verdicts: dict[str, str]) -> None:
    questions = Questions(read_net(mcc / model / "model.pnml"), engine=engine)
    assert compare(mcc, model, questions, verdicts) >= 16


@pytest.mark.parametrize("model", ["Dekker-PT-010", "Eratosthenes-PT-010", "Raft-PT-02", "Railroad-PT-005"])
def test_the_contest_s_properties_by_arrays(mcc: Path, model: str, verdicts: dict[str, str]) -> None:
    questions = Questions(read_net(mcc / model / "model.pnml"), engine="explicit")
    assert compare(mcc, model, questions, verdicts) >= 16


@pytest.mark.parametrize(
    ("examination", "column"),
    [
        ("ReachabilityDeadlock", "deadlock_exists"),
        ("QuasiLiveness", "quasi_live"),
        ("Liveness", "live"),
        ("OneSafe", "safe"),
        ("StableMarking", "stable_marking_exists"),
    ],
)
def test_the_contest_s_examinations(
    mcc: Path, mcc_oracles: dict[str, dict[str, str]], examination: str, column: str
) -> None:
    for model in (*QUICK, "IBM703-PT-none", "Ring-PT-none", *SEVERAL_TOKENS):
        expected = mcc_oracles[model][column]
        questions = Questions(read_net(mcc / model / "model.pnml"))
        wanted = str(expected == "1-safe").upper() if examination == "OneSafe" else expected
        (answer,) = answer_all(questions, examinations=[examination])
        assert answer.value == wanted, model
