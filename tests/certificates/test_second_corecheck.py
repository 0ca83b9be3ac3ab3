"""Another program that plays core missions, in C++, written from the page alone, agrees with corecheck.

What the two first said differently of changed missions were sentences that the page lacked.
"""

from __future__ import annotations

import json
import random
import subprocess
import zipfile
from collections import Counter
from collections.abc import Callable
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
from tests.certificates.programs import compiled
from tests.certificates.test_corecheck import EVERYTHING, MISSION, WRONG, of_text
from tests.certificates.test_second_checker import SMALL, changed, paths_in
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
    return compiled("core_checker", tmp_path_factory)


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
        ((expected, _, _),) = corecheck.checked(str(file), most=most)
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
@fewer(0.2, least=3)
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
        assert found == expected, f"mutant {number} of --seed {fresh_seed}, {way} {last}"
        kinds[found] += 1
    assert {"malformed", "refuted"} & kinds.keys()


def _objective(core: Any) -> Any:
    """An objective of a core mission."""
    return next(each for each in core["graph"]["sections"] if "activities" in each)


def _block(core: Any) -> Any:
    """A block of a core mission."""
    return next(each for each in core["graph"]["sections"] if "branches" in each)


NEVER_SO = {"when": [["nowhere", "yes"]], "to": "succeed"}
HANDLED = {"event": "shift", "once": "", "to": [{"when": [], "to": "succeed"}], "pauses": 0}
SHIFTS = {"name": "shift", "changes": [["day", "yes", "no"]]}


def _robot(key: str, **values: Any) -> Callable[[Any], Any]:
    """Other values of the first object of a list of the robot."""
    return lambda core: core["robot"][key][0].update(values)


MALFORMED: dict[str, Callable[[Any], Any]] = {
    "a condition on no fact": lambda core: _objective(core)["routes"]["success"].insert(0, NEVER_SO),
    "a way that requires no fact": lambda core: core["robot"]["activities"][0]["alternatives"][0].update(
        requires=[["nowhere", "yes"]]
    ),
    "no route for failure": lambda core: _objective(core)["routes"].pop("failure"),
    "no route for an abort in a block": lambda core: _block(core)["branches"][0]["graph"]["sections"][0][
        "routes"
    ].update(failure=[{"when": [], "to": "abort"}]),
    "a route for no end": lambda core: _objective(core)["routes"].update(
        late=_objective(core)["routes"]["success"]
    ),
    "what is detected is no hardware": _robot("activities", detects=["nothing"]),
    "a fact that changes at no time": lambda core: _objective(core)["sets"].append(["day", "no", "noon"]),
    "a fact that changes twice": lambda core: _objective(core).update(
        sets=[["day", "no", "start"], ["day", "yes", "start"]]
    ),
    "an activity that produces": lambda core: (
        core["robot"]["activities"][0]["produces"].append("plan"),
        _objective(core).update(activities=[core["robot"]["activities"][0]["name"]]),
    ),
    "an activity twice": lambda core: _objective(core)["activities"].append(
        _objective(core)["activities"][0]
    ),
    "two sections of one name": lambda core: _block(core)["branches"][0]["graph"]["sections"][0].update(
        name=_block(core)["name"]
    ),
    "two branches of one name": lambda core: _block(core)["branches"].append(_block(core)["branches"][0]),
    "an event that changes facts is handled": lambda core: (
        core["robot"]["events"].append(SHIFTS),
        _objective(core)["handlers"].append(HANDLED),
    ),
    "an event that changes a fact twice": lambda core: core["robot"]["events"].append(
        {"name": "shift", "changes": [["day", "no", "yes"], ["day", "no", "late"]]}
    ),
    "an event that changes nothing of a fact": lambda core: core["robot"]["events"].append(
        {"name": "shift", "changes": [["day", "no", "no"]]}
    ),
    "a change without the value before": lambda core: core["robot"]["events"].append(
        {"name": "shift", "changes": [["day", "no"]]}
    ),
    "hardware that is produced": lambda core: core["robot"]["activities"][0]["produces"].append(
        core["robot"]["hardware"][0]["name"]
    ),
    "a handler that pauses and leads away": lambda core: _objective(core)["handlers"].append(
        {**HANDLED, "pauses": 1}
    ),
}


@pytest.mark.parametrize("why", MALFORMED)
def test_both_read_a_core_mission_as_a_whole(checker: Path, file: Path, tmp_path: Path, why: str) -> None:
    """Also where the net is refuted: it draws another mission, which has not this part."""
    entries = json.loads(json.dumps(entries_of(compose(of_text(SMALL, tmp_path)))))
    entries["core.json"]["robot"]["facts"].append({"name": "day", "initial": "yes"})
    assert of_both(entries, checker, file) == "refuted"
    MALFORMED[why](entries["core.json"])
    assert of_both(entries, checker, file) == "malformed"
