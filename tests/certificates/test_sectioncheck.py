"""Claims about many sections are proved by their types, and only where the whole mission bears them out."""

from __future__ import annotations

import copy
import json
import random
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from experiments.faults.section_mutants import MOST, claim, core_of, mutated, played, study_of
from mcpn.answers.claims import claims_of
from mcpn.certificates import certcheck, corecheck, coregraph, corerobot
from mcpn.certificates.checked_claims import verified
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.sections import sectioncheck, sectionforms
from mcpn.certificates.writing import certificate_of
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.shares import returns_early


def proved(core: dict[str, Any]) -> dict[str, bool]:
    """What sectioncheck proves of a core mission; raises Malformed and Limit."""
    sections = sectioncheck.PlayedSections(core, sectioncheck.Budget(MOST, float("inf")))
    found = dict[str, bool]()
    for kind in sorted(sectioncheck.KINDS):
        for holds in (True, False):
            try:
                sectioncheck.judge(sections, claim(kind, holds))
            except certcheck.Refuted:
                continue
            assert kind not in found, "it proves a claim and its contrary"
            found[kind] = holds
    return found


@fewer(0.5)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=5)
    | missions(max_hardware=2, max_objectives=3, max_sections=4, events=2, timeouts=1)
    | missions(max_hardware=2, max_objectives=2, max_sections=4, early=1)
)
def test_what_sections_prove_the_whole_bears_out(mission: Mission) -> None:
    """The judges are the listed states of the net, by mcpn, and those of the core mission, played whole."""
    study = Study(mission)
    core = json.loads(json.dumps(core_entry(study.mission_net)))
    try:
        direct(study.mission_net.net, max_states=MOST)
        found = proved(core)
        whole = played(core)
    except (LimitError, ConfluenceError, certcheck.Limit) as error:
        returns_early(type(error).__name__)
        return
    of_net = {each.kind: each.holds for each in claims_of(study.verdicts(engine="explicit"))}
    for kind, holds in found.items():
        assert whole[kind] == holds, kind
        assert of_net.get(kind, holds) == holds, kind
    event(f"proved: {len(found)} of {len(whole)}")


@fewer(1.0)
@given(st.integers(1, 4), st.sampled_from(["home", "abort", "succeed", "site0"]), st.integers(0, 10_000))
def test_of_changed_missions_nothing_false_is_proved(sites: int, failure: str, seed: int) -> None:
    core = mutated(core_of(sites, failure), random.Random(seed))
    try:
        found = proved(core)
    except (certcheck.Malformed, certcheck.Limit) as error:
        event(type(error).__name__)
        return
    whole = played(core)
    for kind, holds in found.items():
        assert whole[kind] == holds, kind
    event(f"proved: {len(found)} of {len(whole)}")


FILES = (certcheck, corecheck, coregraph, corerobot, sectioncheck, sectionforms)


def certified(sites: int, file: Path, change: Callable[[dict[str, Any]], object] = len) -> Path:
    """Writes a certificate of many sites, whose core mission has a change."""
    core = copy.deepcopy(core_of(sites))
    claims = [claim(kind, holds) for kind, holds in proved(core).items()]
    change(core)
    document = {"format": "mcpn-certificate", "version": 1, "mission": "row", "claims": claims, "trusted": []}
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("core.json", json.dumps(core))
        archive.writestr("sections.json", json.dumps(document))
    return file


def test_the_files_alone_check_a_row_of_sites(tmp_path: Path) -> None:
    """Beside each other, without mcpn: this is how a certificate is checked elsewhere."""
    for module in FILES:
        shutil.copy(str(module.__file__), tmp_path)
    certificate = certified(60, tmp_path / "row.cert")
    done = subprocess.run(
        [sys.executable, "sectioncheck.py", str(certificate)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
        env={},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert {line.split()[0] for line in done.stdout.splitlines()} == {"proved"}
    assert done.stdout.count("\n") == 6


def test_a_site_without_a_way_out_refutes_what_it_breaks(tmp_path: Path) -> None:
    """The last site leads back to itself whatever happens: of sixty, this one alone is of another type."""

    def trapped(core: dict[str, Any]) -> None:
        site = next(each for each in core["graph"]["sections"] if each["name"] == "site59")
        for lead in (*site["routes"].values(), *(each["to"] for each in site["handlers"])):
            lead[-1]["to"] = "site59"

    report = sectioncheck.checked(str(certified(60, tmp_path / "row.cert", trapped)))
    refuted = {key.split()[0] for how, key, _ in report if how == "refuted"}
    assert {"can_always_end", "can_always_end_safely"} <= refuted


def test_a_site_that_only_some_losses_keep_from_ending_refutes_it(tmp_path: Path) -> None:
    """The last site goes on by success alone, and nothing is repaired: all that it can lead to is fine."""

    def stubborn(core: dict[str, Any]) -> None:
        site = next(each for each in core["graph"]["sections"] if each["name"] == "site59")
        site["handlers"] = []
        site["routes"]["failure"][-1]["to"] = "site59"
        for hardware in core["robot"]["hardware"]:
            hardware["repairable"] = False

    report = sectioncheck.checked(str(certified(60, tmp_path / "row.cert", stubborn)))
    refuted = {key.split()[0] for how, key, _ in report if how == "refuted"}
    assert refuted == {"can_always_end", "can_always_end_safely"}


def test_what_happens_once_in_a_mission_is_not_checked(tmp_path: Path) -> None:
    def once(core: dict[str, Any]) -> None:
        core["graph"]["sections"][1]["handlers"][0]["once"] = "call"

    with pytest.raises(certcheck.Limit, match="not apart"):
        sectioncheck.checked(str(certified(3, tmp_path / "row.cert", once)))


def test_what_sections_share_beyond_hardware_is_not_checked(tmp_path: Path) -> None:
    def late(core: dict[str, Any]) -> None:
        core["robot"]["hardware"][0]["late"] = True

    certificate = certified(3, tmp_path / "row.cert", late)
    with pytest.raises(certcheck.Limit, match="not apart"):
        sectioncheck.checked(str(certificate))
    assert sectioncheck.main([str(certificate)]) == 2


def test_a_mission_too_large_to_list_is_certified_by_its_sections(tmp_path: Path) -> None:
    """What the check says of it is what is claimed; what sections do not show is only trusted, by name."""
    check = study_of(51).verdicts()
    certificate = certificate_of(check, max_states=100)
    file = tmp_path / "row.cert"
    file.write_bytes(certificate.to_bytes())
    found = verified(certificate, file)
    said = {each.key: each.holds for each in claims_of(check)}
    assert {each["key"]: each["holds"] for each in certificate.claims}.items() <= said.items()
    assert {"can_succeed", "can_always_end", "can_always_go_on"} <= {*found.keys("proved")}
    assert found.of("can_succeed") == "checked by sectioncheck"
    assert "trusted" in found.of("confluent")
    assert found.programs == ["sections.sectioncheck"]
