"""Controllers of many sections are proved by types of sections, and only where ctlcheck would prove them."""

from __future__ import annotations

import copy
import json
import random
import zipfile
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from experiments.faults import core_mutants
from experiments.faults.section_mutants import study_of
from mcpn.certificates import certcheck, ctlcheck, ctlforms
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.sections import sectionctl
from mcpn.controller.document import document
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.writer import save_mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import missions
from tests.commands import mcpn, output
from tests.draws import fewer
from tests.shares import returns_early

Document = dict[str, Any]


def plain(value: Any) -> Any:
    return json.loads(json.dumps(value))


def made(study: Study, form: str) -> Document:
    found: Document = plain(document(study.controller(form), study.mission_net))  # type: ignore[arg-type]
    return found


def files(folder: Path, core: Document, controller: Document) -> list[str]:
    """A certificate with nothing but a core mission, and a controller."""
    with zipfile.ZipFile(folder / "cert", "w") as archive:
        archive.writestr("core.json", json.dumps(core))
    (folder / "controller.json").write_text(json.dumps(controller))
    return [str(folder / "cert"), str(folder / "controller.json")]


@pytest.fixture(scope="module")
def sixty() -> Study:
    return study_of(60)


@pytest.fixture(scope="module")
def cases(sixty: Study) -> tuple[Document, Document]:
    return plain(core_entry(sixty.mission_net)), made(sixty, "modular")


@pytest.mark.parametrize("form", ["hierarchical", "modular"])
def test_sixty_sites_are_walked_as_three(sixty: Study, form: str, tmp_path: Path) -> None:
    """The first sites are of one type; the last one leads home by each route, and home is of its own."""
    asked = files(tmp_path, plain(core_entry(sixty.mission_net)), made(sixty, form))
    ((how, _, said),) = sectionctl.checked(*asked)
    assert (how, said.split(":")[0]) == ("proved", "61 sections, 3 of them walked")
    assert sectionctl.main(asked) == 0
    assert sectionctl.main([*asked, "--max-states", "20"]) == 2


def _is_gone(controller: Document) -> None:
    controller["sections"] = [each for each in controller["sections"] if each["name"] != "site40"]


def _leads_past_one(controller: Document) -> None:
    section = next(each for each in controller["sections"] if each["name"] == "site40")
    section["routes"]["success"] = "site42"


def _begins_later(controller: Document) -> None:
    controller["initial"] = "site1"


def _waits_for_other_hardware(controller: Document) -> None:
    home = next(each for each in controller["sections"] if each["name"] == "home")
    home["events"].append("gps_EV_OOS")


def _repairs_too_much(controller: Document) -> None:
    controller["unrepairable"] = []


def _has_a_timer(controller: Document) -> None:
    controller["objectives"]["site40"]["timeout"] = 5.0


def _runs_something_else(controller: Document) -> None:
    controller["objectives"]["site40"]["activities"] = ["rest"]


def _uses_something_else(controller: Document) -> None:
    controller["activities"]["locate"]["alternatives"]["by_imu"]["consumes"] = ["gps"]


def _names_another_objective(controller: Document) -> None:
    section = next(each for each in controller["sections"] if each["name"] == "site40")
    section["names"]["objectives"] = dict.fromkeys(section["names"]["objectives"], "site41")


def _leaves_an_activity_running(controller: Document) -> None:
    for type_ in controller["types"]:
        for effect in type_["effects"]:
            effect["actions"] = [each for each in effect["actions"] if each["do"] != "stop"]


def _asks_for_a_fact(controller: Document) -> None:
    controller["changing"] = {"call": {"true": ["x"], "false": []}}


CHANGES: list[tuple[Callable[[Document], None], str]] = [
    (_is_gone, "the controller has no such section"),
    (_leads_past_one, "the controller leads elsewhere"),
    (_begins_later, "another section is the first one"),
    (_waits_for_other_hardware, "waits for hardware that the section cannot use"),
    (_repairs_too_much, "hardware is never repaired"),
    (_has_a_timer, "the objective site40"),
    (_runs_something_else, "the objective site40"),
    (_uses_something_else, "the activity locate"),
    (_names_another_objective, "other objectives"),
    (_leaves_an_activity_running, "other activities run after it"),
    (_asks_for_a_fact, "asks facts"),
]


@pytest.mark.parametrize(("change", "why"), CHANGES, ids=[change.__name__ for change, _ in CHANGES])
def test_one_section_of_sixty_is_enough(
    cases: tuple[Document, Document], change: Callable[[Document], None], why: str, tmp_path: Path
) -> None:
    core, controller = copy.deepcopy(cases)
    change(controller)
    asked = files(tmp_path, core, controller)
    ((how, _, said),) = sectionctl.checked(*asked)
    assert how == "refuted"
    assert why in said
    assert sectionctl.main(asked) == 1


def test_a_flat_controller_has_no_sections(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = study_of(2)
    asked = files(tmp_path, plain(core_entry(study.mission_net)), made(study, "flat"))
    with pytest.raises(certcheck.Limit, match="no sections"):
        sectionctl.checked(*asked)
    with pytest.raises(SystemExit):
        sectionctl.main(["--help"])
    assert "hierarchical or modular" in capsys.readouterr().out


def test_what_is_no_controller_is_not_checked(cases: tuple[Document, Document], tmp_path: Path) -> None:
    asked = files(tmp_path, cases[0], {"form": "modular"})
    with pytest.raises(certcheck.Malformed, match="not as mcpn writes it"):
        sectionctl.checked(*asked)


@fewer(0.2)
@given(
    missions(max_hardware=3, max_objectives=2, max_sections=3, events=2, timeouts=2),
    st.sampled_from(["hierarchical", "modular"]),
    st.integers(0, 1 << 32),
)
def test_what_types_prove_states_bear_out(mission: Mission, form: str, seed: int) -> None:
    """Of drawn missions, and of changed controllers: whatever sectionctl proves, ctlcheck proves."""
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=1_000)
        controller = made(study, form)
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    graph = certcheck.Listing(certcheck.Net(plain(net_entry(study.mission_net))), 100_000, float("inf"))
    draw, core = random.Random(seed), plain(core_entry(study.mission_net))
    for number in range(5):
        changed = copy.deepcopy(controller)
        how = core_mutants.change_controller(changed, draw) if number else "nothing"
        by_types = core_mutants.by_sections(core, changed)
        if by_types == "proved":
            ctlcheck.walked(graph, ctlforms.WalkedController(changed))
        if number == 0:
            assert by_types != "refuted"
        event(f"{how if number == 0 else 'changed'}: {by_types}")
    return None


def test_no_changed_controller_is_proved_by_its_types() -> None:
    found, wrong = core_mutants.campaign("sections", 60, 3)
    assert wrong == []
    ends = Counter(how.rpartition(": ")[2] for how in found.elements())
    assert ends["accepted"] > 3
    assert ends["not accepted"] > 20


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_no_changed_controller_is_proved_by_its_types_of_many() -> None:
    assert core_mutants.campaign("sections", 2_000, 5)[1] == []


def test_a_walk_of_types_that_believes_everything_is_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sectionctl.WalkedAlone, "walked", lambda alone: (1, 1))
    assert core_mutants.campaign("sections", 30, 4)[1]


def test_the_command_walks_types_where_states_are_too_many(sixty: Study, tmp_path: Path) -> None:
    save_mission(sixty.mission, tmp_path / "row.xml")
    asked = ["controller", tmp_path / "row.xml", "--form", "modular", "-o", tmp_path / "made"]
    asked += ["--certificate", tmp_path / "row.cert", "--max-states", "100"]
    assert "\nsectionctl: proved: 61 sections, 3 of them walked: " in mcpn(*asked).stdout
    walked = output(*asked)["walked"]
    assert walked.startswith("proved: 61 sections")
    assert "python -m mcpn.certificates.sections.sectionctl" in walked
