"""Claims on missions whose states are too many to list are checked by sets as decision diagrams."""

from __future__ import annotations

import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from mcpn.certificates import certcheck, diagcheck
from mcpn.certificates.checked_claims import verified
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.certificates.files import rewritten
from tests.certificates.test_second_checker import SMALL
from tests.conftest import ROOT, ULYSSE
from tests.draws import fewer
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The certificate of a small mission, by diagrams."""
    path = tmp_path_factory.mktemp("small") / "mission.xml"
    path.write_text(SMALL.lstrip())
    return certificate_of(Study(read_mission(path)).verdicts(), max_states=1).to_bytes()


def found_of(data: bytes, change: Callable[[Any], Any] = lambda document: None) -> dict[str, str]:
    """By key what becomes of each claim of a certificate, after a change."""
    with rewritten(data, "diagrams.json", change) as path:
        return {key: how for how, key, _ in diagcheck.checked(path)}


def test_it_is_checked_alone_beside_the_other_file(small: bytes, tmp_path: Path) -> None:
    for name in ("certcheck", "diagcheck", "diagsets"):
        shutil.copy(ROOT / "mcpn" / "certificates" / f"{name}.py", tmp_path)
    (tmp_path / "mission.cert").write_bytes(small)
    command = [sys.executable, "-E", "diagcheck.py", "mission.cert"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert {line.split()[0] for line in run.stdout.splitlines()} == {"proved"}
    command += ["--max-nodes", "10"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert {line[:11] for line in run.stdout.splitlines()} == {"not checked"}
    assert "--max-nodes" in run.stdout


def test_each_entry_is_parsed_once(small: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path, asked, parsed = tmp_path / "mission.cert", list[str](), certcheck.parsed
    path.write_bytes(small)

    def counted(entries: dict[str, bytes], name: str, *numbers: Any) -> Any:
        asked.append(name)
        return parsed(entries, name, *numbers)

    monkeypatch.setattr(certcheck, "parsed", counted)
    assert {how for how, *_ in diagcheck.checked(str(path))} == {"proved"}
    assert sorted(asked) == ["diagrams.json", "net.json"]


@pytest.mark.slow
def test_ulysse_is_proved_by_diagrams() -> None:
    certificate = certificate_of(Study(read_mission(ULYSSE)).verdicts(), max_states=10)
    assert set(found_of(certificate.to_bytes()).values()) == {"proved"}


@fewer(0.1)
@given(
    missions(max_hardware=2, max_objectives=2, max_sections=2, events=1, timeouts=1)
    | fragile_missions(max_hardware=1, max_objectives=2, max_sections=2)
)
def test_claims_on_drawn_missions_are_proved_by_diagrams(mission: Mission) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=60)
        check = study.verdicts()
        listed, drawn = certificate_of(check), certificate_of(check, max_states=1)
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    assert drawn.diagrams is not None
    found = found_of(drawn.to_bytes())
    assert set(found.values()) == {"proved"}
    # The same claims as with the states listed, but for those that no diagram proves.
    of_listed = {claim["key"]: claim["holds"] for claim in listed.claims}
    for claim in drawn.diagrams["claims"]:
        assert of_listed[claim["key"]] == claim["holds"]
    assert {"safe", "confluent"} <= found.keys()
    assert listed.diagrams is None
    return None


@pytest.fixture(scope="module")
def cuts(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The certificate of the minimal cut sets of a small mission, by diagrams."""
    path = tmp_path_factory.mktemp("cuts") / "mission.xml"
    path.write_text(SMALL.lstrip())
    return certificate_of_causes(Study(read_mission(path)).causes(), max_states=1).to_bytes()


@fewer(0.1)
@given(missions(max_hardware=3, max_objectives=2, max_sections=2, events=1))
def test_cut_sets_of_drawn_missions_are_proved_by_diagrams(mission: Mission) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=60)
        causes = study.causes()
        listed, drawn = certificate_of_causes(causes), certificate_of_causes(causes, max_states=1)
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    assert drawn.diagrams is not None
    assert set(found_of(drawn.to_bytes()).values()) == {"proved"}
    stated = {claim["key"]: claim["statement"] for claim in drawn.diagrams["claims"]}
    of_listed = {c["key"]: c["statement"] for c in listed.claims if c["kind"] == "cut_sets"}
    left = {key: why for key, (_, why) in drawn.trusted.items() if key in of_listed}
    assert all("repaired" in why for why in left.values())
    assert {key: stated[key] for key in of_listed.keys() - left.keys()} == {
        key: said for key, said in of_listed.items() if key not in left
    }
    return None


def _of_cuts(claim: dict[str, Any]) -> dict[str, Any]:
    """Its statement and evidence."""
    return {**claim["statement"], **claim["evidence"]}


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("cuts", lambda cuts: cuts.pop()),
        ("cuts", lambda cuts: cuts[0].pop()),
        ("cuts", lambda cuts: cuts.append([])),
        ("hardware", lambda names: names.pop()),
        ("ends", lambda ends: ends.clear()),
        ("closed", lambda nodes: nodes.__setitem__(0, 0)),
        ("closed", lambda nodes: nodes.pop()),
        ("layers", lambda nodes: nodes.pop()),
        ("layers", lambda nodes: nodes.pop(0)),
        ("layers", lambda nodes: nodes.clear()),
    ],
)
def test_other_cut_sets_and_other_evidence_are_refuted(
    cuts: bytes, key: str, change: Callable[[Any], Any]
) -> None:
    def changed(document: dict[str, Any]) -> None:
        (claim,) = [each for each in document["claims"] if each["key"] == "cut_sets: success"]
        change(_of_cuts(claim)[key])

    assert found_of(cuts)["cut_sets: success"] == "proved"
    assert found_of(cuts, changed)["cut_sets: success"] == "refuted"


def test_what_is_reached_too_much_does_not_make_sets_survived(cuts: bytes) -> None:
    def no_losses(net: dict[str, Any]) -> None:
        for each in net["transitions"]:
            if each["event"][:1] == ["out of service"]:
                each["read"].append(each["produce"][0])

    with rewritten(cuts, "net.json", no_losses) as path:
        found = {key: how for how, key, _ in diagcheck.checked(path)}
    assert found["cut_sets: success"] == "refuted"


def _fewer_reached(document: dict[str, Any]) -> None:
    document["reached"] = document["nodes"][document["reached"] - 2][1]


def _no_weights(document: dict[str, Any]) -> None:
    document["weights"] = [0] * len(document["weights"])


def _no_pairs(document: dict[str, Any]) -> None:
    document["ends"] = 0


def _another_order(document: dict[str, Any]) -> None:
    order = document["order"]
    order[0], order[-1] = order[-1], order[0]


@pytest.mark.parametrize(
    ("change", "kept"),
    [
        (_fewer_reached, set()),
        (_another_order, set()),
        (_no_weights, {"safe", "can_always_go_on", "can_succeed", "can_fail"}),
        (_no_pairs, {"safe", "can_always_go_on", "can_succeed", "can_fail", "can_always_end"}),
    ],
)
def test_sets_that_prove_no_more_are_refuted(
    small: bytes, change: Callable[[dict[str, Any]], None], kept: set[str]
) -> None:
    try:
        found = found_of(small, change)
    except certcheck.Malformed:
        assert not kept
        return
    assert "refuted" in found.values()
    assert {key for key, how in found.items() if how == "proved"} >= kept & found.keys()


def test_a_layer_that_is_left_out_is_missed(small: bytes) -> None:
    def drop(document: dict[str, Any]) -> None:
        for claim in document["claims"]:
            if claim["kind"] == "can_always_end":
                claim["evidence"]["layers"].pop(1)

    found = found_of(small, drop)
    assert {key for key, how in found.items() if how == "refuted"} == {"can_always_end"}


def test_a_claim_turned_round_is_refuted(small: bytes) -> None:
    def turn(document: dict[str, Any]) -> None:
        for claim in document["claims"]:
            if claim["kind"] == "can_succeed":
                claim["holds"], claim["evidence"] = False, {}

    assert found_of(small, turn)["can_succeed"] == "refuted"


def test_the_command_says_who_has_checked(small: bytes, tmp_path: Path) -> None:
    path = tmp_path / "mission.xml"
    path.write_text(SMALL.lstrip())
    certificate = certificate_of(Study(read_mission(path)).verdicts(), max_states=1)
    (tmp_path / "cert").write_bytes(certificate.to_bytes())
    assert verified(certificate, tmp_path / "cert").of("safe") == "checked by diagcheck"


def test_nodes_that_are_none_are_malformed(small: bytes) -> None:
    draw = random.Random(1)
    for _ in range(20):

        def change(document: dict[str, Any]) -> None:
            row = draw.choice(document["nodes"])
            row[draw.randrange(3)] += draw.choice([-1, 1]) * 10**6

        with pytest.raises(certcheck.Malformed):
            found_of(small, change)
