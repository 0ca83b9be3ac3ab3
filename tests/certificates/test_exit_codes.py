"""All checkers end alike: 0 where all is proved, 1 where something is refuted, 2 where something is open."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from experiments.faults import campaigns
from mcpn.certificates import certcheck, corecheck, ctlcheck, diagcheck, furthercheck
from mcpn.certificates.sections import sectioncheck
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from tests.conftest import ROOT

PROGRAMS = [certcheck, corecheck, ctlcheck, diagcheck, furthercheck, sectioncheck]
ONE = [("proved", "a", "A.")]


@pytest.mark.parametrize("program", PROGRAMS)
@pytest.mark.parametrize(
    ("report", "code"),
    [
        (ONE, 0),
        ([], 2),
        ([*ONE, ("not checked", "b", "no time")], 2),
        ([*ONE, ("not checked", "b", "no time"), ("refuted", "c", "wrong")], 1),
    ],
)
def test_a_report_has_one_exit_code(
    program: ModuleType,
    report: certcheck.Report,
    code: int,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    asked = list[dict[str, Any]]()

    def checked(*paths: str, **limits: Any) -> certcheck.Report:
        asked.append(limits)
        return report

    monkeypatch.setattr(program, "checked", checked)
    files = ["cert", "controller"] if program is ctlcheck else ["cert"]
    limit = "--max-nodes" if program is diagcheck else "--max-states"
    assert program.main(files) == program.main([*files, limit, "7", "--seconds", "2"]) == code
    assert asked == [{}, {"most": 7, "seconds": 2.0}]
    assert capsys.readouterr().out.count("\n") == 2 * len(report)


@pytest.mark.parametrize("error", [certcheck.Malformed, certcheck.Limit, RecursionError, MemoryError])
def test_who_gives_up_has_checked_nothing(
    error: type[Exception], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def gives_up(path: str) -> certcheck.Report:
        raise error

    monkeypatch.setattr(certcheck, "checked", gives_up)
    assert certcheck.main(["cert"]) == 2
    assert capsys.readouterr().out == "not checked  cert: there is not enough memory\n"


def _without_hardware(kind: str) -> dict[str, Any]:
    texts = {"key": "cuts", "kind": kind, "subject": [], "sentence": "s"}
    return {**texts, "holds": True, "statement": {"ends": ["success"], "cuts": []}, "evidence": {}}


@pytest.mark.parametrize(
    ("program", "entry", "kind"),
    [
        (certcheck, "claims", "cut_sets"),
        (diagcheck, "diagrams", "cut_sets"),
        (furthercheck, "further", "cut_sets_at_start"),
    ],
)
def test_cut_sets_of_no_hardware_are_malformed(
    program: ModuleType, entry: str, kind: str, tmp_path: Path
) -> None:
    from mcpn.certificates.writing import certificate_of

    study = Study(read_mission(ROOT / "experiments" / "ulysse" / "mission.xml"))
    made = certificate_of(study.verdicts(), max_states=1 if entry == "diagrams" else None)
    with zipfile.ZipFile(tmp_path / "cert", "w") as archive:
        claims: Any = {**certcheck.FORMAT, "claims": [_without_hardware(kind)]}
        if entry == "diagrams":
            claims = {**(made.diagrams or {}), "claims": claims["claims"]}
        if entry == "claims":
            claims |= {"mission": "m", "trusted": []}
        archive.writestr("net.json", json.dumps(made.net))
        archive.writestr(f"{entry}.json", json.dumps(claims))
    with pytest.raises(certcheck.Malformed, match="hardware"):
        program.checked(str(tmp_path / "cert"))


def test_what_cannot_be_understood_is_not_so() -> None:
    judges: list[Callable[[dict[str, Any]], bool]] = [
        lambda claim: bool(claim["hardware"]),
        lambda claim: True,
    ]
    assert [campaigns.is_so(judge, {}) for judge in judges] == [False, True]


def test_a_mission_that_comes_to_no_end_is_refuted(monkeypatch: pytest.MonkeyPatch) -> None:
    from mcpn.certificates.writing import certificate_of

    study = Study(read_mission(ROOT / "experiments" / "ulysse" / "mission.xml"))
    made = certificate_of(study.verdicts())
    plain: Any = json.loads(json.dumps([made.net, made.core]))
    mission = corecheck.CoreMission(plain[1])
    monkeypatch.setattr(mission.robot, "settled", lambda start, facts: set())
    graph = certcheck.Listing(certcheck.Net(plain[0]), 10_000, float("inf"))
    with pytest.raises(certcheck.Refuted, match="the mission comes to no end"):
        corecheck.walked(graph, mission)
