"""Claims about many sections are proved by their types, and only where the whole mission bears them out."""

from __future__ import annotations

import copy
import json
import random
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.claims import claims_of
from mcpn.certificates import certcheck, corecheck, coregraph, corerobot
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.coregraph import ENDS
from mcpn.certificates.sections import sectioncheck
from mcpn.certificates.verified import verified
from mcpn.certificates.writing import certificate_of
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.draws import fewer
from tests.shares import returns_early

MOST = 4_000
HEAD = """<mission xmlns="urn:mcpn:mission:1" name="row">
  <robot name="r">
    <hardware name="wheels"/><hardware name="gps"/><hardware name="imu" repairable="false"/>
    <event name="call"/>
    <software name="place"/>
    <activity name="locate" produces="place">
      <alternative name="by_gps" consumes="gps"/><alternative name="by_imu" consumes="imu"/>
    </activity>
    <activity name="drive"><alternative name="mapped" consumes="wheels place"/></activity>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <on event="call" goto="home"/>
"""
SITE = '<objective name="site{}" activities="drive" success="site{}" failure="{}"/>\n'
LAST = '<objective name="home" activities="rest" success="succeed" failure="home"/>\n</mission>\n'


def row(sites: int, failure: str = "home") -> str:
    """A mission of many sites of one type."""
    text = "".join(SITE.format(i, i + 1, failure) for i in range(sites))
    return HEAD + text.replace(f"site{sites}", "home") + LAST


@cache
def core_of(sites: int, failure: str = "home") -> dict[str, Any]:
    """The core mission of many sites, as a certificate holds it."""
    found: dict[str, Any] = json.loads(json.dumps(core_entry(study_of(sites, failure).mission_net)))
    return found


def study_of(sites: int, failure: str = "home") -> Study:
    """Many sites, to be asked."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "row.xml")
        path.write_text(row(sites, failure))
        return Study(read_mission(path))


def claim(kind: str, holds: bool) -> dict[str, Any]:
    return {
        "key": f"{kind} {holds}",
        "kind": kind,
        "subject": [],
        "holds": holds,
        "sentence": kind,
        "statement": {},
        "evidence": {},
    }


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


def played(core: dict[str, Any]) -> dict[str, bool]:
    """What is so of a core mission, all states of which are played one by one, without sections."""
    mission = corecheck.CoreMission(core)
    states, numbers = [mission.first], {mission.first: 0}
    edges = list[list[int]]()
    for state in states:  # grows while it is walked
        edges.append([])
        for happens in mission.possible(state):
            for after in mission.after(state, happens):
                if after not in numbers:
                    numbers[after] = len(states)
                    states.append(after)
                edges[-1].append(numbers[after])
        if len(states) > 20 * MOST:
            raise certcheck.Limit("too many states")
    before = list[list[int]]([] for _ in states)
    for number, targets in enumerate(edges):
        for target in targets:
            before[target].append(number)
    ended = [ENDS.get(state.at, "") if isinstance(state.at, str) else "" for state in states]
    found = {"can_always_go_on": all(targets or end for targets, end in zip(edges, ended, strict=True))}
    for kind, goals in sectioncheck.GOALS.items():
        there = [number for number, end in enumerate(ended) if end in goals]
        always = len(certcheck.grown(there, before.__getitem__)) == len(states)
        found[kind] = always if kind.startswith("can_always") else bool(there)
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


def mutated(core: dict[str, Any], seed: int) -> dict[str, Any]:
    """The core mission with one change."""
    changed, of = copy.deepcopy(core), random.Random(seed)
    sections, robot = changed["graph"]["sections"], changed["robot"]
    one = of.choice(sections)
    names = [each["name"] for each in sections]
    match of.randrange(8):
        case 0:
            sections.remove(one)
        case 1:
            sections.append({**copy.deepcopy(one), "name": of.choice([one["name"], "another"])})
        case 2:
            outcome = of.choice(sorted(one["routes"]))
            one["routes"][outcome][-1]["to"] = of.choice([*names, *ENDS, "nowhere"])
        case 3:
            changed["graph"]["entry"] = of.choice([*names, "nowhere"])
        case 4:
            hardware = of.choice(robot["hardware"])
            key = of.choice(["faulty", "shared", "repairable", "out", "late", "crash"])
            hardware[key] = not hardware[key]
        case 5:
            ways = of.choice(robot["activities"])["alternatives"]
            del ways[of.randrange(len(ways))]
        case 6:
            of.choice(robot["activities"])["alternatives"][0]["consumes"] = [
                of.choice(robot["hardware"])["name"]
            ]
        case _:
            inner = list(sectioncheck.objectives_of(one))
            of.choice(inner)["activities"] = [of.choice(robot["activities"])["name"]]
    return changed


@fewer(1.0)
@given(st.integers(1, 4), st.sampled_from(["home", "abort", "succeed", "site0"]), st.integers(0, 10_000))
def test_of_changed_missions_nothing_false_is_proved(sites: int, failure: str, seed: int) -> None:
    core = mutated(core_of(sites, failure), seed)
    try:
        found = proved(core)
    except (certcheck.Malformed, certcheck.Limit) as error:
        event(type(error).__name__)
        return
    whole = played(core)
    for kind, holds in found.items():
        assert whole[kind] == holds, kind
    event(f"proved: {len(found)} of {len(whole)}")


FILES = (certcheck, corecheck, coregraph, corerobot, sectioncheck)


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
