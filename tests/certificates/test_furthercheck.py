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
from hypothesis import strategies as st

from mcpn.certificates import furthercheck
from mcpn.certificates.writing import certificate_of_causes
from mcpn.errors import ConfluenceError, LimitError, SemanticsError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.answers.dense import any_missions, interrupted_missions
from tests.answers.test_interval_bounds import with_intervals
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


# Probabilities.

RATED = """
<mission xmlns="urn:mcpn:mission:1" name="rated">
  <robot name="boat">
    <event name="recall" rate="0.05"/>
    <hardware name="gps" failure_rate="0.02" repair_rate="0.5"/>
    <hardware name="sonar" failure_rate="0.01 .. 0.04" repairable="false"/>
    <activity name="navigate"><alternative name="by_gps" consumes="gps"/></activity>
    <activity name="look"><alternative name="by_sonar" consumes="sonar"/></activity>
  </robot>
  <objective name="go" activities="navigate" duration="1.5" failure_probability="0.1">
    <on event="recall" goto="abort"/>
  </objective>
  <objective name="see" activities="look" duration="2"/>
</mission>
"""


@pytest.fixture(scope="module")
def rated(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The certificate of the numbers of a small mission."""
    path = tmp_path_factory.mktemp("rated") / "mission.xml"
    path.write_text(RATED.lstrip())
    return certificate_of_causes(Study(read_mission(path)).causes(), chances=True).to_bytes()


def test_chances_are_proved_within_a_billionth(rated: bytes) -> None:
    found = further_of(rated)
    assert {how for key, how in found.items() if key.startswith(("chance", "bounds"))} == {"proved"}
    assert {
        f"{key}: {end}" for key in ("chance", "bounds") for end in ("success", "failure", "abort")
    } <= set(found)

    def narrow(document: dict[str, Any]) -> None:
        widths = {}
        for claim in document["claims"]:
            if claim["kind"] == "chance":
                said = claim["statement"]
                widths[claim["key"]] = float(said["high"]) - float(said["low"])
        assert max(widths[f"chance: {end}"] for end in ("success", "failure", "abort")) < 1e-9
        assert widths["bounds: success"] > 1e-3

    further_of(rated, narrow)


def _higher(claim: dict[str, Any]) -> None:
    claim["statement"]["low"] = claim["statement"]["high"]
    claim["statement"]["high"] = "1"


def _lower(claim: dict[str, Any]) -> None:
    claim["statement"]["high"] = claim["statement"]["low"]


def _worse(claim: dict[str, Any]) -> None:
    claim["statement"]["hardware"][0]["fails"] = ["0.03", "0.03"]


def _slower(claim: dict[str, Any]) -> None:
    claim["statement"]["objectives"][0]["duration"] = "1.6"


def _oftener(claim: dict[str, Any]) -> None:
    claim["statement"]["events"][0]["rate"] = ["0.04", "0.04"]


def _certain(claim: dict[str, Any]) -> None:
    claim["evidence"]["above"] = [0] * len(claim["evidence"]["above"])


def _other(claim: dict[str, Any]) -> None:
    claim["statement"]["end"] = "failure"


@pytest.mark.parametrize("change", [_higher, _lower, _worse, _slower, _oftener, _certain, _other])
def test_another_probability_is_refuted(rated: bytes, change: Callable[[dict[str, Any]], None]) -> None:
    found = further_of(rated, lambda document: change(claim_of(document, "chance: success")))
    assert [key for key, how in found.items() if how == "refuted"] == ["chance: success"]


@fewer(0.1)
@given(any_missions() | interrupted_missions(), st.sampled_from([1.0, 10.0]))
def test_chances_of_drawn_missions_are_proved(mission: Mission, share: float) -> None:
    study = Study(with_intervals(mission, share))
    try:
        direct(study.mission_net.net, max_states=300)
        certificate = certificate_of_causes(study.causes(), chances=True)
    except (LimitError, SemanticsError) as error:
        return returns_early(type(error).__name__)
    if not any(claim["kind"] == "chance" for claim in certificate.further):
        assert "chance: success" in certificate.trusted
        return returns_early("trusted")
    assert set(further_of(certificate.to_bytes()).values()) == {"proved"}
    return None
