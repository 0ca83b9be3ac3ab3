"""Where an answer and its own evidence disagree no certificate is written, and the claim is named."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mcpn.answers.causes import risk as risk_module
from mcpn.certificates import evidence, moments_entry, writing
from mcpn.certificates.diagrams_entry import DiagramWriter
from mcpn.certificates.entries import EvidenceError, supported
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from tests.certificates.test_furthercheck import RATED
from tests.commands import mcpn
from tests.conftest import ULYSSE

UNSUPPORTED = "mcpn's own evidence does not support its claim"


def refused(tmp_path: Path, *words: object) -> str:
    """What the command says of a fault, which writes nothing and ends with 2."""
    out = tmp_path / "out.cert"
    found = mcpn(*words, "--certificate", out)
    said = found.stderr
    assert found.returncode == 2, said
    assert UNSUPPORTED in said
    assert "please report" in said
    assert "Traceback" not in said
    assert not out.exists()
    return said


def test_a_run_that_a_check_implies_is_not_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "run", lambda *_: None)
    assert '"The mission can succeed."' in refused(tmp_path, "check", ULYSSE)


def test_numbers_that_fall_are_not_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(evidence, "falling", lambda *_: None)
    assert '"While nothing fails, the mission succeeds."' in refused(tmp_path, "check", ULYSSE)


@pytest.mark.parametrize("module", [writing, moments_entry])
def test_no_state_shows_that_a_loss_is_survived(
    module: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nowhere(*_: object) -> object:
        return int(np.flatnonzero(np.zeros(3))[0])

    monkeypatch.setattr(module, "survived", nowhere)
    assert "cut sets" in refused(tmp_path, "causes", ULYSSE)


def test_diagrams_have_no_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> object:
        raise AssertionError("the check has found one")

    monkeypatch.setattr(DiagramWriter, "run", none)
    check = Study(read_mission(ULYSSE)).verdicts()
    with pytest.raises(EvidenceError, match=UNSUPPORTED):
        writing.certificate_of(check, max_states=1)


@pytest.mark.parametrize("error", [AssertionError, IndexError, KeyError, StopIteration])
def test_every_way_to_miss_evidence_is_told(error: type[Exception]) -> None:
    with pytest.raises(EvidenceError, match=error.__name__), supported("It holds."):
        raise error


@pytest.mark.parametrize("by", [-1e-6, 1e-6])
def test_a_probability_outside_of_what_is_proved_is_told(
    by: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mission = tmp_path / "mission.xml"
    mission.write_text(RATED.lstrip())
    right = risk_module.risk

    def wrong(*asked: Any) -> risk_module.Risk:
        numbers = right(*asked)
        return dataclasses.replace(numbers, success=numbers.success + by)

    assert mcpn("causes", mission, "--rates", "--certificate", tmp_path / "right.cert").returncode == 0
    monkeypatch.setattr(risk_module, "risk", wrong)
    assert "The mission ends in success with a probability from" in refused(
        tmp_path, "causes", mission, "--rates"
    )
