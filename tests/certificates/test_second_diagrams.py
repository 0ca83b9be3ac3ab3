"""Another checker of claims by diagrams, in C++, written from the page alone, agrees with diagcheck."""

from __future__ import annotations

import json
import random
import tempfile
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.certificates import certcheck, diagcheck
from mcpn.certificates.writing import certificate_of, certificate_of_causes
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.certificates.files import entries_of
from tests.certificates.programs import compiled
from tests.certificates.test_second_checker import SMALL, Claims, mutant, of_the_other
from tests.draws import fewer
from tests.logic.oracle import fragile_missions
from tests.shares import returns_early


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("diagram_checker", tmp_path_factory)


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The certificate of a small mission, by diagrams."""
    path = tmp_path_factory.mktemp("small") / "mission.xml"
    path.write_text(SMALL.lstrip())
    return entries_of(certificate_of(Study(read_mission(path)).verdicts(), max_states=1).to_bytes())


@pytest.fixture(scope="module")
def cuts(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """The certificate of its minimal cut sets."""
    path = tmp_path_factory.mktemp("cuts") / "mission.xml"
    path.write_text(SMALL.lstrip())
    return entries_of(certificate_of_causes(Study(read_mission(path)).causes(), max_states=1).to_bytes())


def of_diagcheck(path: str) -> Claims | str:
    try:
        return [(how, key) for how, key, _ in diagcheck.checked(path)]
    except certcheck.Malformed:
        return "malformed"


def agreed(checker: Path, entries: dict[str, Any]) -> set[str]:
    """What becomes of the claims of a certificate, of which both say the same."""
    with tempfile.NamedTemporaryFile() as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, document in entries.items():
                archive.writestr(name, json.dumps(document))
        file.flush()
        expected = of_diagcheck(file.name)
        assert of_the_other(checker, Path(file.name)) == expected
    return {"malformed"} if isinstance(expected, str) else {each[0] for each in expected}


def other(entries: dict[str, Any], drawn: random.Random) -> dict[str, Any]:
    """A certificate of which a value or two are others: half of the time none of a row of nodes."""
    if drawn.random() < 0.5:
        return mutant(entries, drawn, ("net.json", *["diagrams.json"] * 3))
    nodes = {key: entries["diagrams.json"][key] for key in ("nodes", "pairs")}
    rest = {key: value for key, value in entries["diagrams.json"].items() if key not in nodes}
    return {**entries, "diagrams.json": {**mutant({"rest": rest}, drawn, ("rest",))["rest"], **nodes}}


def test_both_prove_each_claim_of_a_small_mission(checker: Path, small: dict[str, Any]) -> None:
    assert len(small["diagrams.json"]["claims"]) > 8
    assert agreed(checker, small) == {"proved"}


def test_both_prove_minimal_cut_sets(checker: Path, cuts: dict[str, Any]) -> None:
    assert {claim["kind"] for claim in cuts["diagrams.json"]["claims"]} >= {"safe", "cut_sets"}
    assert agreed(checker, cuts) == {"proved"}


@pytest.mark.parametrize("count", [8, pytest.param(2000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_cut_sets(
    checker: Path, cuts: dict[str, Any], fresh_seed: int, count: int
) -> None:
    for number in range(count):
        drawn, entries = random.Random(f"{fresh_seed} {number}"), cuts
        claims = [claim for claim in cuts["diagrams.json"]["claims"] if claim["kind"] == "cut_sets"]
        changed = mutant({"claims": claims}, drawn, ("claims",))["claims"]
        entries = {**cuts, "diagrams.json": {**cuts["diagrams.json"], "claims": changed}}
        agreed(checker, entries)


@pytest.mark.parametrize("number", [-1, 10**12])
def test_what_is_no_transition_is_malformed(checker: Path, small: dict[str, Any], number: int) -> None:
    document = small["diagrams.json"]
    entries = {**small, "diagrams.json": {**document, "again": [*document["again"], number]}}
    assert agreed(checker, entries) == {"malformed"}


def test_evidence_of_another_shape_is_malformed_whatever_is_reached(
    checker: Path, small: dict[str, Any]
) -> None:
    document = small["diagrams.json"]
    claims = [{**each, "evidence": {**each["evidence"], "more": 1}} for each in document["claims"]]
    nothing = {**small, "diagrams.json": {**document, "reached": 0}}
    assert agreed(checker, nothing) == {"refuted"}
    assert agreed(checker, {**small, "diagrams.json": {**nothing["diagrams.json"], "claims": claims}}) == {
        "malformed"
    }


@pytest.mark.parametrize("count", [12, pytest.param(3000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_certificates(
    checker: Path, small: dict[str, Any], fresh_seed: int, count: int
) -> None:
    kinds = Counter[str]()
    for number in range(count):
        kinds.update(agreed(checker, other(small, random.Random(f"{fresh_seed} {number}"))))
    assert {"malformed", "refuted"} & kinds.keys()


@fewer(0.05, least=3)
@given(
    missions(max_hardware=2, max_objectives=2, max_sections=2, events=1, timeouts=1)
    | fragile_missions(max_hardware=1, max_objectives=2, max_sections=2),
    st.randoms(use_true_random=False),
)
def test_both_say_the_same_of_drawn_missions(checker: Path, mission: Mission, drawn: random.Random) -> None:
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=60)
        data = certificate_of(study.verdicts(), max_states=1).to_bytes()
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    entries = entries_of(data)
    assert agreed(checker, entries) == {"proved"}
    agreed(checker, other(entries, drawn))
    return None
