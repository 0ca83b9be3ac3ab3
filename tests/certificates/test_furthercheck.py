"""Cut sets at every moment, and probabilities, are checked beside the states of a certificate."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, cast

import pytest
from hypothesis import given

from mcpn.certificates import furthercheck
from mcpn.certificates.writing import certificate_of_causes
from mcpn.errors import ConfluenceError, LimitError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.certificates.files import rewritten
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early


@pytest.fixture(scope="module")
def ulysse() -> bytes:
    """The certificate of the cut sets of the mission of the paper."""
    return certificate_of_causes(Study(read_mission(ULYSSE)).causes()).to_bytes()


def further_of(data: bytes, change: Callable[[Any], Any] = lambda document: None) -> dict[str, str]:
    """By key what becomes of each further claim of a certificate, after a change."""
    with rewritten(data, "further.json", change) as path:
        return {key: how for how, key, _ in furthercheck.checked(path)}


def claim_of(document: dict[str, Any], key: str) -> dict[str, Any]:
    """The claim with a key."""
    (found,) = (claim for claim in document["claims"] if claim["key"] == key)
    return cast("dict[str, Any]", found)


def test_every_moment_of_ulysse_is_proved(ulysse: bytes) -> None:
    found = further_of(ulysse)
    assert set(found.values()) == {"proved"}
    assert {"cut_sets_whenever: success", "cut_sets_at_worst: success"} <= found.keys()
    kinds = {key.partition(":")[0] for key in found}
    assert kinds == {"cut_sets_at_start", "cut_sets_at_entry", "cut_sets_whenever", "cut_sets_at_worst"}


def test_it_is_checked_alone_beside_the_other_file(ulysse: bytes, tmp_path: Path) -> None:
    for name in ("certcheck", "furthercheck"):
        shutil.copy(ROOT / "mcpn" / "certificates" / f"{name}.py", tmp_path)
    (tmp_path / "mission.cert").write_bytes(ulysse)
    command = [sys.executable, "-E", "furthercheck.py", "mission.cert"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert {line.split()[0] for line in run.stdout.splitlines()} == {"proved"}


@fewer(0.1)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=3, events=2, timeouts=2, early=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1)
    | fragile_missions(max_hardware=2, max_objectives=2, max_sections=3, crashes=True)
)
def test_cut_sets_of_drawn_missions_are_proved_at_every_moment(mission: Mission) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=300)
        certificate = certificate_of_causes(study.causes())
    except (LimitError, ConfluenceError, UnsafeError) as error:
        return returns_early(type(error).__name__)
    if not certificate.further:
        assert any("cut_sets_whenever" in key for key in certificate.trusted)
        return returns_early("all of it is trusted")
    assert set(further_of(certificate.to_bytes()).values()) == {"proved"}
    return None


def _drop(claim: dict[str, Any]) -> None:
    claim["statement"]["cuts"].pop()


def _enlarge(claim: dict[str, Any]) -> None:
    cut = claim["statement"]["cuts"][-1]
    cut.append(next(name for name in claim["statement"]["hardware"] if name not in cut))


def _lessen(claim: dict[str, Any]) -> None:
    claim["statement"]["cuts"][0].pop()


@pytest.mark.parametrize("change", [_drop, _enlarge, _lessen])
@pytest.mark.parametrize(
    "key",
    [
        "cut_sets_at_start: success of {}",
        "cut_sets_at_entry: success of {0}: {0}",
        "cut_sets_at_worst: success",
    ],
)
def test_cut_sets_that_are_not_all_and_minimal_are_refuted(
    ulysse: bytes, change: Callable[[dict[str, Any]], None], key: str
) -> None:
    key = key.format("transect.diving")
    found = further_of(ulysse, lambda document: change(claim_of(document, key)))
    assert [other for other, how in found.items() if how == "refuted"] == [key]


def test_a_loss_at_another_moment_is_refuted(ulysse: bytes) -> None:
    """What is lost before the start is no loss at the entry of a section, and the other way round."""

    def move(document: dict[str, Any]) -> None:
        claim = claim_of(document, "cut_sets_at_entry: success of transect.diving: transect.diving")
        for each in claim["evidence"]["survived"]:
            each["by"] = 0

    assert "refuted" in further_of(ulysse, move).values()


def test_a_kind_that_is_not_known_is_malformed(ulysse: bytes, capsys: pytest.CaptureFixture[str]) -> None:
    def rename(document: dict[str, Any]) -> None:
        document["claims"][0]["kind"] = "cut_sets_some_day"

    with rewritten(ulysse, "further.json", rename) as path:
        assert furthercheck.main([path]) == 2
    assert "cut_sets_some_day" in capsys.readouterr().out
