"""Controllers are walked beside a certificate's net, by a program that imports nothing of mcpn."""

from __future__ import annotations

import json
import random
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.certificates import certcheck, ctlcheck, ctlforms
from mcpn.certificates.net_entry import net_entry
from mcpn.controller.document import document
from mcpn.errors import ConfluenceError, LimitError, PremiseError, UnsafeError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Hardware
from mcpn.mission.writer import save_mission
from mcpn.mission.xml import read_mission
from mcpn.study import Study
from mcpn.testing import missions
from tests.commands import mcpn, output
from tests.conftest import ULYSSE
from tests.draws import fewer
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

Document = dict[str, Any]


def judged(study: Study, controller: Document) -> tuple[int, int]:
    net = certcheck.Net(json.loads(json.dumps(net_entry(study.mission_net))))
    return ctlcheck.walked(
        certcheck.Listing(net, 100_000, float("inf")), ctlforms.WalkedController(controller)
    )


def made(study: Study, form: str) -> Document:
    found = study.controller(form)  # type: ignore[arg-type]
    text: Document = json.loads(json.dumps(document(found, study.mission_net)))
    return text


@pytest.mark.parametrize("form", ["hierarchical", "flat", "modular"])
def test_the_controller_of_ulysse_does_what_its_net_does(form: str) -> None:
    study = Study(read_mission(ULYSSE))
    assert judged(study, made(study, form)) == (260, 1332)


@fewer(0.1)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=3, events=2)
    | missions(max_hardware=2, max_objectives=2, max_sections=3, events=2, facts=1),
    st.sampled_from(["hierarchical", "flat", "modular"]),
)
def test_controllers_of_drawn_missions(mission: Mission, form: str) -> None:
    study = Study(mission)
    try:
        controller = made(study, form)
    except (LimitError, ConfluenceError, UnsafeError, PremiseError) as error:
        return returns_early(type(error).__name__)
    pairs, taken = judged(study, controller)
    assert pairs == study.alternatives().everything.count()
    assert taken >= pairs - 1
    return None


def _goal(controller: Document, draw: random.Random) -> None:
    kind = draw.choice([each for each in controller["types"] if len(each["states"]) > 1])
    edge = draw.choice([each for each in kind["edges"] if isinstance(each["to"], int)])
    edge["to"] = draw.choice([at for at in range(len(kind["states"])) if at != edge["to"]])


def _forget(controller: Document, draw: random.Random) -> None:
    kind = draw.choice(controller["types"])
    draw.choice([each for each in kind["edges"] if each["actions"]])["actions"].pop()


def _lose(controller: Document, draw: random.Random) -> None:
    kind = draw.choice(controller["types"])
    kind["edges"].pop(draw.randrange(len(kind["edges"])))


def _route(controller: Document, draw: random.Random) -> None:
    section = draw.choice(controller["sections"])
    exits = sorted(section["routes"])
    section["routes"][exits[0]] = "fail" if section["routes"][exits[0]] != "fail" else "succeed"


@pytest.mark.parametrize("change", [_goal, _forget, _lose, _route])
def test_a_controller_that_does_something_else_is_refuted(change: Callable[..., None]) -> None:
    study, refuted = Study(read_mission(ULYSSE)), 0
    net = certcheck.Net(json.loads(json.dumps(net_entry(study.mission_net))))
    graph = certcheck.Listing(net, 100_000, float("inf"))
    whole = json.dumps(made(study, "hierarchical"))
    for seed in range(5):
        controller = json.loads(whole)
        change(controller, random.Random(seed))
        try:
            ctlcheck.walked(graph, ctlforms.WalkedController(controller))
        except certcheck.Refuted:
            refuted += 1
    assert refuted >= 4  # an edge may be one that no run takes


def test_the_command_says_what_it_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "m.xml"
    save_mission(
        mission(robot(hw("arm"), activity("work", ("arm",))), Objective(name="o", activities=("work",))), path
    )
    asked = ["controller", path, "--form", "modular", "-o", tmp_path, "--certificate", tmp_path / "m.cert"]
    # the arm in and out of service, before and after either end; as "o" runs it works, is out, or is back
    assert "\nctlcheck: proved: 9 pairs of states, " in mcpn(*asked).stdout
    assert output(*asked, "--target", "c")["walked"].startswith("not checked: it walks controller.json")
    monkeypatch.setattr(ctlcheck, "checked", lambda *_, **__: [("refuted", "controller", "why")])
    assert output(*asked, code=1)["walked"].startswith("refuted: why")


def test_the_files_alone_check_a_controller(tmp_path: Path) -> None:
    from mcpn.certificates.writing import certificate_of

    study = Study(read_mission(ULYSSE))
    for program in (certcheck, ctlcheck, ctlforms):
        shutil.copy(str(program.__file__), tmp_path)
    (tmp_path / "cert").write_bytes(certificate_of(study.verdicts()).to_bytes())
    (tmp_path / "controller.json").write_text(json.dumps(made(study, "flat")))
    ways = [
        ["certcheck.py", "cert"],
        ["ctlcheck.py", "cert", "controller.json"],
        ["ctlcheck.py", "cert", "cert"],
    ]
    ran = [
        subprocess.run(
            [sys.executable, "-E", "-S", *way], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        for way in [[str(tmp_path / way[0]), *way[1:]] for way in ways]
    ]
    assert [run.returncode for run in ran] == [0, 0, 2], ran
    assert "260 pairs of states, 1332 events" in ran[1].stdout
    assert all(run.stderr == "" for run in ran)


def test_a_controller_does_not_choose_of_what_hardware_the_net_is_heard() -> None:
    """What it does not list is out of service all the same where the net says so."""
    of = robot((Hardware(name="radio", initial="oos"),), activity("tell", ("radio",), ()))
    study = Study(mission(of, Objective(name="told", activities=("tell",))))
    controller = made(study, "flat")
    assert judged(study, controller)[0] > 3
    controller["hardware"] = []
    controller["out_of_service"] = []
    for kind in controller["types"]:
        for state in kind["states"]:
            state["out_of_service"] = []
    with pytest.raises(certcheck.Refuted, match="hardware is out of service"):
        judged(study, controller)
