"""Another program that plays core missions, in C++, written from the page alone, agrees with corecheck.

What the two first said differently of changed missions were sentences that the page lacked.
"""

from __future__ import annotations

import json
import random
import subprocess
import zipfile
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.faults.template_faults import FAULTS, Fault, Faulty
from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import McpnError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.testing import elements
from tests.certificates.test_corecheck import EVERYTHING, MISSION, WRONG, of_text
from tests.certificates.test_second_checker import SMALL, changed, compiled, paths_in
from tests.draws import campaign, composed, fewer
from tests.shares import returns_early

ALL = st.one_of(
    elements.ANY,
    elements.COMMON_CAUSES,
    elements.CRASHING,
    elements.EARLY,
    elements.GUARDED,
    elements.INTERRUPTED,
    elements.IN_ROUNDS,
    elements.IN_TIME,
    elements.LATE,
    elements.LED,
    elements.LEFT_BY_FACTS,
    elements.NAMED,
    elements.PAUSING,
    elements.PAUSING_APART,
    elements.PAUSING_FACTS,
    elements.PAUSING_IN_TIME,
    elements.RECOVERING,
    elements.SHARING_FACTS,
    elements.WORLD_ABORTED,
)
MOST = 2_000
"""Markings of drawn nets that are compared here."""


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("core_checker", tmp_path_factory.mktemp("checker"))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where certificates are written, one after the other."""
    return tmp_path_factory.mktemp("certificate") / "certificate"


def entries_of(net: MissionNet) -> dict[str, Any]:
    """The certificate of a net that claims nothing."""
    claims = {"format": "mcpn-certificate", "version": 1, "mission": "m", "claims": [], "trusted": []}
    return {"net.json": net_entry(net), "claims.json": claims, "core.json": core_entry(net)}


def of_both(entries: dict[str, Any], checker: Path, file: Path, most: int = 1_000_000) -> str:
    """What both say of the net of a certificate."""
    expected, found = verdicts(entries, checker, file, most)
    assert found == expected
    return found


def verdicts(entries: dict[str, Any], checker: Path, file: Path, most: int) -> tuple[str, str]:
    """What each of them says; both that it is large, if corecheck keeps more markings than these."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, document in entries.items():
            archive.writestr(name, json.dumps(document))
    try:
        corecheck.checked(str(file), most=most)
        expected = "proved"
    except certcheck.Refuted:
        expected = "refuted"
    except certcheck.Malformed:
        expected = "malformed"
    except certcheck.Limit:
        return "large", "large"
    run = subprocess.run([checker, file], check=False, capture_output=True, text=True, timeout=60)
    found = run.stdout.removesuffix(" net\n")
    if found == "not checked" and ": malformed: " in run.stderr:
        found = "malformed"
    assert run.returncode == {"proved": 0, "refuted": 1, "malformed": 2}[found], run.stderr
    return expected, found


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(SMALL, id="small"),
        pytest.param(MISSION, id="round"),
        pytest.param(EVERYTHING, id="everything", marks=pytest.mark.slow),
    ],
)
def test_both_prove_the_net_of_a_mission(checker: Path, file: Path, tmp_path: Path, text: str) -> None:
    assert of_both(entries_of(compose(of_text(text, tmp_path))), checker, file) == "proved"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["courier", "drone", "ulysse"])
def test_both_prove_the_net_of_a_worked_mission(checker: Path, file: Path, name: str) -> None:
    path = Path(__file__).parents[2] / "experiments" / name / "mission.xml"
    assert of_both(entries_of(compose(read_mission(path))), checker, file) == "proved"


@pytest.mark.may_leave(0.8)
@fewer(0.2)
@given(mission=ALL)
def test_both_say_the_same_of_drawn_missions(checker: Path, file: Path, mission: Mission) -> None:
    try:
        if of_both(entries_of(composed(mission)), checker, file, MOST) == "large":
            returns_early("large")
    except McpnError as error:
        returns_early(type(error).__name__)


@pytest.mark.slow
def test_both_say_the_same_of_many_drawn_missions(checker: Path, file: Path) -> None:
    def judge(mission: Mission) -> str:
        try:
            return of_both(entries_of(composed(mission)), checker, file, MOST)
        except McpnError as error:
            return type(error).__name__

    found = campaign(ALL, judge, 500)
    assert found["proved"] > found["drawn"] // 4


def wrong(mission: Mission, fault: Fault) -> dict[str, Any] | None:
    """The certificate of a net that faulty templates draw, if they draw another one than right ones."""
    templates = Faulty(*fault)
    net = compose(mission, templates)
    return entries_of(net) if templates.changed else None


@pytest.mark.parametrize(
    "name", [*WRONG[-2:], *(pytest.param(name, marks=pytest.mark.slow) for name in WRONG[:-2])]
)
def test_both_refute_the_net_of_wrong_templates(checker: Path, file: Path, tmp_path: Path, name: str) -> None:
    entries = wrong(of_text(EVERYTHING, tmp_path), FAULTS[name])
    assert entries is not None
    assert of_both(entries, checker, file) == "refuted"


@pytest.mark.slow
def test_both_say_the_same_of_all_faults_of_templates(checker: Path, file: Path, tmp_path: Path) -> None:
    mission, kinds = of_text(EVERYTHING, tmp_path), Counter[str]()
    for fault in FAULTS.values():
        try:
            entries = wrong(mission, fault)
        except (McpnError, ValueError):  # ValueError: no place says that the mission has not begun
            continue
        kinds.update([of_both(entries, checker, file)] if entries else [])
    assert kinds["refuted"] > 20


@pytest.mark.parametrize("count", [12, pytest.param(2000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_core_missions(
    checker: Path, file: Path, tmp_path: Path, fresh_seed: int, count: int
) -> None:
    original = json.dumps(entries_of(compose(of_text(MISSION, tmp_path))))
    kinds = Counter[str]()
    for number in range(count):
        drawn = random.Random(f"{fresh_seed} {number}")
        entries = json.loads(original)
        *way, last = drawn.choice(list(paths_in(entries["core.json"])))
        at = entries["core.json"]
        for key in way:
            at = at[key]
        at[last] = changed(at[last], drawn, entries["core.json"])
        expected, found = verdicts(entries, checker, file, 1_000_000)
        alike = (expected == "proved") == (found == "proved")  # what is malformed may be refuted first
        assert alike, f"mutant {number} of --seed {fresh_seed}, {way} {last}"
        kinds.update((expected, found))
    assert {"malformed", "refuted"} & kinds.keys()
