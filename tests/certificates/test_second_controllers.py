"""Another checker of controllers, in C++, written from the page alone, says what ctlcheck says."""

from __future__ import annotations

import copy
import json
import random
import re
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from experiments.faults.core_mutants import change_controller, originals, plain
from mcpn.certificates import certcheck, ctlcheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.controller.document import document
from mcpn.errors import McpnError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from tests.certificates.programs import compiled
from tests.certificates.test_modular_controllers import DRAWN, EXPERIMENTS, FEW, listed, made
from tests.conftest import ULYSSE
from tests.draws import campaign
from tests.small import activity, hw, mission, robot

Document = dict[str, Any]
WORDS = {0: "proved", 1: "refuted", 2: "not checked"}


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("controller_checker", tmp_path_factory)


def certificate(net: Document, folder: Path, core: Document | None = None) -> Path:
    """A certificate of a net that claims nothing, with a core mission beside it if one is given."""
    claims = {"format": "mcpn-certificate", "version": 1, "mission": "m", "claims": [], "trusted": []}
    with zipfile.ZipFile(folder / "cert", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("net.json", json.dumps(net))
        archive.writestr("claims.json", json.dumps(claims))
        if core is not None:
            archive.writestr("core.json", json.dumps(core))
    return folder / "cert"


def both(checker: Path, cert: Path, controller: Document) -> tuple[str, str, str]:
    """What ctlcheck and the program say, and the program's own words."""
    path = cert.with_name("controller.json")
    path.write_text(json.dumps(controller))
    try:
        ((first, _, said),) = ctlcheck.checked(str(cert), str(path), most=1_000_000, seconds=60.0)
    except certcheck.Malformed as error:
        first, said = "not checked", str(error)
    run = subprocess.run([checker, cert, path], check=False, capture_output=True, text=True, timeout=60)
    found = WORDS[run.returncode]
    assert found == "not checked" or run.stdout.startswith(found)
    if found == first == "proved":
        assert re.findall(r"\d+", said) == re.findall(r"\d+", run.stdout)
    return first, found, run.stdout + run.stderr


def of_study(study: Study, form: str) -> Document:
    made: Document = plain(document(study.controller(form), study.mission_net))  # type: ignore[arg-type]
    return made


def later(*paths: Path) -> list[Any]:
    """Missions that are asked of in the nightly profile alone."""
    return [pytest.param(each, marks=pytest.mark.slow, id=each.parent.name) for each in paths]


@pytest.mark.parametrize("form", ["hierarchical", "flat", "modular"])
@pytest.mark.parametrize(
    "mission", [ULYSSE, *later(*(EXPERIMENTS / name / "mission.xml" for name in ("courier", "drone")))]
)
def test_both_prove_the_controller_of_a_mission(
    checker: Path, tmp_path: Path, mission: Path, form: str
) -> None:
    study = Study(read_mission(mission))
    cert = certificate(plain(net_entry(study.mission_net)), tmp_path)
    assert both(checker, cert, of_study(study, form))[:2] == ("proved", "proved")


@pytest.mark.slow
@pytest.mark.parametrize("mission", later(*sorted(EXPERIMENTS.glob("natural/*/mission.xml"))))
def test_both_prove_the_rules_of_a_natural_mission(checker: Path, tmp_path: Path, mission: Path) -> None:
    study = Study(read_mission(mission))
    cert = certificate(plain(net_entry(study.mission_net)), tmp_path)
    try:
        controller = of_study(study, "modular")
    except McpnError as error:
        pytest.skip(f"it has no such controller: {error}")
    assert both(checker, cert, controller)[:2] == ("proved", "proved")


@pytest.mark.parametrize("few", FEW.values(), ids=FEW)
@pytest.mark.parametrize("drawn", [4, pytest.param(150, marks=pytest.mark.slow)])
def test_both_prove_the_rules_of_drawn_missions(checker: Path, tmp_path: Path, few: int, drawn: int) -> None:
    def judge(mission: Mission) -> str:
        study = Study(mission)
        try:
            listed(study, 500)
            controller = made(study, few)
        except (McpnError, certcheck.Limit, certcheck.Refuted) as error:
            return type(error).__name__
        cert = certificate(plain(net_entry(study.mission_net)), tmp_path)
        assert both(checker, cert, controller)[:2] == ("proved", "proved")
        return "proved"

    assert campaign(DRAWN, judge, drawn)["proved"] > drawn // 5


@pytest.mark.parametrize(
    ("activity", "produces", "expected"),
    [
        ("drive", ["map", "wheels"], ("proved", "proved")),  # what it alone makes it needs of nobody
        ("locate", [], ("not checked", "not checked")),  # "map", which is consumed, is nothing then
    ],
)
def test_products_of_activities_are_read_alike(
    checker: Path, tmp_path: Path, activity: str, produces: list[str], expected: tuple[str, str]
) -> None:
    home = originals()[0]
    cert, controller = certificate(home.net, tmp_path), copy.deepcopy(home.controllers[0])
    controller["activities"][activity]["produces"] = produces
    assert both(checker, cert, controller)[:2] == expected


def actions_of(controller: Document) -> list[list[Document]]:
    """The actions of each entry and each edge of a controller of tables."""
    taken = (each for row in controller["types"] for each in (*row["edges"], *row["entries"]) if each)
    return [each["actions"] for each in taken]


def _never_releases_the_wheels(controller: Document) -> None:
    """The activity that uses them is said to use them no more."""
    controller["activities"]["drive"]["alternatives"]["mapped"]["consumes"].remove("wheels")
    for actions in actions_of(controller):
        actions[:] = [each for each in actions if each.get("hardware") != "wheels"]


def _drives_without_a_map(controller: Document) -> None:
    controller["activities"]["drive"]["alternatives"]["mapped"]["consumes"].remove("map")


@pytest.mark.parametrize(
    "change",
    [_never_releases_the_wheels, _drives_without_a_map],
)
def test_what_activities_use_is_what_the_core_mission_says(
    checker: Path, tmp_path: Path, change: Callable[[Document], None]
) -> None:
    home = originals()[0]
    cert = certificate(home.net, tmp_path, home.core)
    controller = copy.deepcopy(home.controllers[0])
    assert both(checker, cert, controller)[:2] == ("proved", "proved")
    change(controller)
    assert both(checker, cert, controller)[:2] == ("refuted", "refuted")


def test_hardware_that_is_released_is_no_crash(checker: Path, tmp_path: Path) -> None:
    tool = mission(
        robot(hw("tool", faulty=False), activity("work", ("tool",))),
        Objective(name="o", activities=("work",)),
    )
    study = Study(tool)
    controller, core = of_study(study, "flat"), plain(core_entry(study.mission_net))
    cert = certificate(plain(net_entry(study.mission_net)), tmp_path, core)
    assert both(checker, cert, controller)[:2] == ("proved", "proved")
    controller["crashing"].append("tool")
    for actions in actions_of(controller):
        actions[:] = [each for each in actions if each["do"] != "release"]
    assert both(checker, cert, controller)[:2] == ("refuted", "refuted")


def test_a_timer_that_the_net_waits_for_is_not_left_out(checker: Path, tmp_path: Path) -> None:
    home = originals()[0]
    cert, controller = certificate(home.net, tmp_path), copy.deepcopy(home.controllers[0])
    controller["objectives"]["go"]["timeout"] = None
    for actions in actions_of(controller):
        actions[:] = [each for each in actions if each["do"] not in ("arm", "disarm")]
    assert both(checker, cert, controller)[:2] == ("refuted", "refuted")


def test_an_activity_that_the_net_never_runs_is_not_started(checker: Path, tmp_path: Path) -> None:
    home = originals()[0]
    cert, controller = certificate(home.net, tmp_path), copy.deepcopy(home.controllers[0])
    controller["activities"]["dig"] = copy.deepcopy(controller["activities"]["drive"])
    row = next(each for each in controller["types"] if len(each["states"]) > 1)
    for state in row["states"]:
        state["mode"]["dig"] = "blind"
    dig = {"activity": "dig", "objective": None}
    added: list[list[Document]] = [[], []]
    for each in (*row["edges"], *filter(None, row["entries"])):
        inside = "from" in each
        if inside == isinstance(each["to"], str):  # it is started at entry, and stopped at the exit
            kinds = ["stop"] if inside else ["select", "start"]
            for do in kinds:
                more = {**dig, "do": do} | ({"alternative": "blind"} if do == "select" else {})
                each["actions"].append(more)
            each["actions"].sort(key=lambda action: ctlcheck.ORDER.index(action["do"]))
            added[inside].append(each["actions"])
    assert all(added)
    first, second, words = both(checker, cert, controller)
    assert (first, second) == ("refuted", "refuted"), words


def test_a_fact_that_the_net_does_not_say_is_missed(checker: Path, tmp_path: Path) -> None:
    day = originals()[1]
    net = copy.deepcopy(day.net)
    place = next(each for each in net["places"] if ["fact", "light=false"] in each["roles"])
    place["roles"] = []
    passing = next(each for each in net["places"] if each["name"] == "PAR_noon_enter")  # in no stable state
    passing["roles"] = [["fact", "light=false"]]
    assert both(checker, certificate(net, tmp_path), day.controllers[0])[:2] == ("refuted", "refuted")


def test_what_waits_is_a_text_also_where_nothing_ever_does(checker: Path, tmp_path: Path) -> None:
    tool = mission(robot(hw("tool"), activity("work", ("tool",))), Objective(name="o", activities=("work",)))
    study = Study(tool)
    cert, controller = certificate(plain(net_entry(study.mission_net)), tmp_path), of_study(study, "flat")
    for state in controller["types"][0]["states"]:
        state["waiting"] = {"never": {}}
    assert both(checker, cert, controller)[:2] == ("not checked", "not checked")


def test_what_is_shown_is_of_a_known_kind_also_where_it_never_is(checker: Path, tmp_path: Path) -> None:
    home = originals()[0]
    cert = certificate(home.net, tmp_path)
    controller = copy.deepcopy(next(c for c in home.controllers if c["form"] == "modular"))
    of = controller["types"][0]
    of["shown"].append({"kind": "objectives", "name": "none", "when": 2 * of["bits"] + 1})
    of["bits"] += 1  # of which no effect sets the last
    assert both(checker, cert, controller)[:2] == ("proved", "proved")
    of["shown"][-1]["kind"] = "colours"
    assert both(checker, cert, controller)[:2] == ("not checked", "not checked")


@pytest.mark.parametrize("count", [40, pytest.param(2000, marks=pytest.mark.slow)])
def test_both_say_the_same_of_changed_controllers(
    checker: Path, tmp_path: Path, fresh_seed: int, count: int
) -> None:
    said, apart = set(), []
    for number in range(count):
        draw = random.Random(f"{fresh_seed} {number}")
        original = draw.choice(originals())
        controller = copy.deepcopy(draw.choice(original.controllers))
        how = change_controller(controller, draw)
        first, second, words = both(checker, certificate(original.net, tmp_path), controller)
        said.add(second)
        if (first == "proved") != (second == "proved"):
            apart.append((number, how, first, words))
    assert not apart
    assert {"proved", "refuted"} <= said


def _leads_to_nothing(controller: Document) -> None:
    for section in controller["sections"]:
        section["routes"] = dict.fromkeys(section["routes"], "nowhere")


def _has_no_routes(controller: Document) -> None:
    for section in controller["sections"]:
        section["routes"] = {}


@pytest.mark.parametrize("change", [_leads_to_nothing, _has_no_routes])
def test_routes_to_nothing_are_of_no_controller(
    checker: Path, tmp_path: Path, change: Callable[[Document], None]
) -> None:
    home = originals()[0]
    controller = copy.deepcopy(home.controllers[0])
    change(controller)
    assert both(checker, certificate(home.net, tmp_path), controller)[:2] == ("not checked", "not checked")
