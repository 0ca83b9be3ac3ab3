"""Certificates of missions are checked by a program that imports nothing of mcpn."""

from __future__ import annotations

import ast
import json
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from hypothesis import given

from mcpn.certificates import certcheck, ctlcheck, ctlforms
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.errors import ConfluenceError, LimitError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.certificates.files import entries_of, rewritten
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early


@pytest.fixture(scope="module")
def ulysse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The certificate of the mission of the paper."""
    path = tmp_path_factory.mktemp("certificate") / "ulysse"
    path.write_bytes(certificate_of(Study(read_mission(ULYSSE)).verdicts()).to_bytes())
    return path


@pytest.mark.parametrize("program", [certcheck, ctlcheck, ctlforms])
def test_checkers_import_python_alone(program: ModuleType) -> None:
    nodes = list(ast.walk(ast.parse(Path(str(program.__file__)).read_text())))
    names = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    names |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    names -= {"mcpn.certificates", "certcheck", "ctlforms"}  # one of the others, wherever it stands
    assert {name.partition(".")[0] for name in names} <= sys.stdlib_module_names


def test_every_claim_on_ulysse_is_proved(ulysse: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert certcheck.main([str(ulysse)]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(entries_of(ulysse.read_bytes())["claims.json"]["claims"]) > 15
    assert all(line.startswith("proved") for line in lines)


@fewer(0.1)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=4, events=2, timeouts=2, early=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=3, crashes=True)
)
def test_every_claim_on_drawn_missions_is_proved(mission: Mission) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=400)
        certificate = certificate_of(study.verdicts())
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    with rewritten(certificate.to_bytes()) as path:
        report = certcheck.checked(path)
    assert [line for line in report if line[0] != "proved"] == []
    assert len(report) == len(certificate.claims) >= 7
    return None


@pytest.mark.parametrize(
    ("entry", "change", "said"),
    [
        ("claims.json", lambda d: d.update(version=2), "version: found 2"),
        ("claims.json", lambda d: d["claims"][0].update(more=1), "expected an object with key, kind"),
        ("claims.json", lambda d: d["claims"].append(d["claims"][0]), "two claims have one key"),
        ("claims.json", lambda d: d["claims"][2]["evidence"].update(run=["1"]), "found"),
        ("claims.json", lambda d: d["claims"][-1]["evidence"].update(numbers=[0.5]), "the number 0.5"),
        ("claims.json", lambda d: d["claims"][-1]["evidence"].update(numbers=[10**30]), "at most 18 digits"),
        ("net.json", lambda d: d["places"][0].update(initial=2), "2 tokens, expected 0 or 1"),
        ("net.json", lambda d: d["transitions"][0].update(consume=[10**6]), "a place that there is not"),
        ("net.json", lambda d: d["places"][0].update(name=d["places"][1]["name"]), "have one name"),
    ],
)
def test_what_is_malformed_is_said(
    ulysse: Path, capsys: pytest.CaptureFixture[str], entry: str, change: Callable[[Any], Any], said: str
) -> None:
    with rewritten(ulysse.read_bytes(), entry, change) as path:
        assert certcheck.main([path]) == 2
    assert said in capsys.readouterr().out


def test_what_is_no_certificate_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "not"
    assert certcheck.main([str(path)]) == 2
    path.write_bytes(b"PK\x03\x04 no zip")
    assert certcheck.main([str(path)]) == 2
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("net.json", "[" * 100_000)
        archive.writestr("claims.json", "{}")
    assert certcheck.main([str(path)]) == 2
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("net.json", b" " * (certcheck.MOST_BYTES + 1))
    assert certcheck.main([str(path)]) == 2
    out = capsys.readouterr().out.splitlines()
    assert [line.startswith("not checked") for line in out] == [True] * 4
    assert "more than" in out[3]


def test_limits_name_what_is_missing(ulysse: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert certcheck.main([str(ulysse), "--max-states", "100"]) == 2
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == len(entries_of(ulysse.read_bytes())["claims.json"]["claims"]) > 15
    assert all(line.startswith("not checked") and "--max-states" in line for line in lines)


@pytest.mark.parametrize("kind", ["can_succeed", "can_always_end", "requirement", "nominal_success"])
def test_a_claim_turned_round_is_refuted(ulysse: Path, kind: str) -> None:
    def turn(document: dict[str, Any]) -> None:
        for claim in document["claims"]:
            if claim["kind"] == kind:
                claim["holds"] = not claim["holds"]
                if kind == "can_succeed":
                    claim["evidence"] = {}
                elif kind == "can_always_end":
                    claim["evidence"] = {"run": []}

    with rewritten(ulysse.read_bytes(), "claims.json", turn) as path:
        report = certcheck.checked(path)
    claims = json.loads(zipfile.ZipFile(ulysse).read("claims.json"))["claims"]
    turned = {claim["key"] for claim in claims if claim["kind"] == kind}
    assert {key for how, key, _ in report if how == "refuted"} == turned


@fewer(0.1)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=3, events=1)
    | fragile_missions(max_hardware=3, max_objectives=2, max_sections=3)
)
def test_cut_sets_of_drawn_missions_are_proved(mission: Mission) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=400)
        certificate = certificate_of_causes(study.causes())
    except (LimitError, ConfluenceError, UnsafeError) as error:
        return returns_early(type(error).__name__)
    with rewritten(certificate.to_bytes()) as path:
        report = certcheck.checked(path)
    assert [line for line in report if line[0] != "proved"] == []
    assert "cut_sets: success" in {key for _, key, _ in report}
    return None


def _drop(claim: dict[str, Any]) -> None:
    claim["statement"]["cuts"].pop()


def _enlarge(claim: dict[str, Any]) -> None:
    cut = claim["statement"]["cuts"][-1]
    cut.append(next(name for name in claim["statement"]["hardware"] if name not in cut))


def _lessen(claim: dict[str, Any]) -> None:
    claim["statement"]["cuts"][0].pop()


def _forget(claim: dict[str, Any]) -> None:
    claim["evidence"]["survived"].pop()


def _repair(claim: dict[str, Any]) -> None:
    claim["evidence"]["survived"][0]["by"] = 0


@pytest.mark.parametrize("change", [_drop, _enlarge, _lessen, _forget, _repair])
def test_cut_sets_that_are_not_all_minimal_and_proved_are_refuted(
    change: Callable[[dict[str, Any]], None],
) -> None:
    data = certificate_of_causes(Study(read_mission(ULYSSE)).causes()).to_bytes()
    with rewritten(data, change=lambda d: change(d["claims"][-1])) as path:
        report = certcheck.checked(path)
    assert [key for how, key, _ in report if how != "proved"] == ["cut_sets: success"]


@pytest.mark.parametrize("name", ["courier", "drone", "glider", "rover"])
def test_worked_missions_write_certificates_that_are_proved(name: str, tmp_path: Path) -> None:
    checked = Study(read_mission(ROOT / "experiments" / name / "mission.xml")).verdicts()
    path = tmp_path / name
    path.write_bytes(certificate_of(checked).to_bytes())
    assert {how for how, _, _ in certcheck.checked(str(path))} == {"proved"}
