"""Another checker of controllers by types of sections, in C++, says what sectionctl says."""

from __future__ import annotations

import copy
import json
import random
import subprocess
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from experiments.faults import core_mutants
from experiments.faults.section_mutants import study_of
from mcpn.certificates import certcheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.sections import sectionctl
from mcpn.controller.document import document
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.study import Study
from mcpn.testing import elements, missions
from tests.certificates.programs import compiled
from tests.certificates.test_sectionctl import CHANGES, files, made, plain
from tests.draws import fewer
from tests.shares import returns_early

DRAWN = (
    missions(max_hardware=3, max_objectives=2, max_sections=3, events=2, timeouts=2)
    | elements.PAUSING
    | elements.CRASHING
    | elements.IN_TIME
)


@pytest.fixture(scope="module")
def checker(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    return compiled("section_controller_checker", tmp_path_factory)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where certificates and controllers are written, one after the other."""
    return tmp_path_factory.mktemp("files")


def of_both(checker: Path, folder: Path, core: Any, controller: Any) -> tuple[str, str]:
    """What sectionctl and the program say of a controller: where it is proved also what was walked."""
    asked = files(folder, core, controller)
    try:
        ((first, _, said),) = sectionctl.checked(*asked)
    except (certcheck.Malformed, certcheck.Limit):
        first, said = "not checked", ""
    run = subprocess.run([checker, *asked], check=False, capture_output=True, text=True, timeout=60)
    other = next((how for how in ("proved", "refuted") if run.stdout.startswith(how)), "not checked")
    assert run.returncode == ["proved", "refuted", "not checked"].index(other), run.stderr
    if first == "proved":
        first += f": {said}"
    if other == "proved":
        other = run.stdout.strip().replace(" controller", "").replace(" of states", "")
    return first, other


@pytest.mark.parametrize("form", ["hierarchical", "modular"])
def test_both_walk_the_same_of_a_row_of_sites(checker: Path, folder: Path, form: str) -> None:
    study = study_of(60)
    first, other = of_both(checker, folder, plain(core_entry(study.mission_net)), made(study, form))
    assert first == other
    assert other.startswith("proved: 61 sections, 3 of them walked: ")


def test_a_flat_controller_has_no_sections(checker: Path, folder: Path) -> None:
    study = study_of(2)
    both = of_both(checker, folder, plain(core_entry(study.mission_net)), made(study, "flat"))
    assert both == ("not checked", "not checked")


@pytest.fixture(scope="module")
def sites() -> tuple[Any, Any]:
    study = study_of(45)
    return plain(core_entry(study.mission_net)), made(study, "modular")


@pytest.mark.parametrize("change", [change for change, _ in CHANGES])
def test_one_section_of_many_is_enough(
    checker: Path, folder: Path, sites: tuple[Any, Any], change: Any
) -> None:
    core, controller = copy.deepcopy(sites)
    change(controller)
    assert of_both(checker, folder, core, controller) == ("refuted", "refuted")


@fewer(0.2, least=3)
@given(mission=DRAWN, form=st.sampled_from(["hierarchical", "modular"]), seed=st.integers(0, 1 << 32))
def test_both_say_the_same_of_drawn_missions(
    checker: Path, folder: Path, mission: Mission, form: str, seed: int
) -> None:
    """Of their controllers, and of changed ones; what is malformed one alone may refute."""
    study = Study(mission)
    try:
        direct(study.mission_net.net, max_states=1_000)
        controller = json.loads(json.dumps(document(study.controller(form), study.mission_net)))  # type: ignore[arg-type]
    except (LimitError, ConfluenceError) as error:
        return returns_early(type(error).__name__)
    draw, core = random.Random(seed), plain(core_entry(study.mission_net))
    for number in range(3):
        changed = copy.deepcopy(controller)
        if number:
            core_mutants.change_controller(changed, draw)
        first, other = of_both(checker, folder, core, changed)
        assert first == other or (
            number and "not checked" in (first, other) and "proved" not in first + other
        )
        event(("changed: " if number else "") + other.partition(":")[0])
    return None


CRASHES = """<mission xmlns="urn:mcpn:mission:1" name="m">
  <robot name="r">
    <hardware name="wheels"/>
    <activity name="drive" faulty="true" recovers="false">
      <alternative name="on" consumes="wheels"/>
    </activity>
  </robot>
  <objective name="first" activities="drive"/>
</mission>"""


@pytest.mark.parametrize("form", ["hierarchical", "modular"])
def test_crashes_are_not_held(checker: Path, folder: Path, form: str) -> None:
    study = core_mutants.study_of(CRASHES)
    first, other = of_both(checker, folder, plain(core_entry(study.mission_net)), made(study, form))
    assert first == other
    assert other.startswith("proved: 1 sections, 1 of them walked: ")


@pytest.mark.parametrize("count", [12, pytest.param(1000, marks=pytest.mark.slow)])
def test_both_prove_the_same_changed_controllers(
    checker: Path, folder: Path, fresh_seed: int, count: int
) -> None:
    mission = core_mutants.original(core_mutants.ROUND, ("hierarchical", "modular"))
    for number in range(count):
        draw = random.Random(f"{fresh_seed} {number}")
        changed = copy.deepcopy(draw.choice(mission.controllers))
        core_mutants.change_controller(changed, draw)
        first, other = of_both(checker, folder, mission.core, changed)
        assert first == other or "proved" not in first + other, f"mutant {number} of --seed {fresh_seed}"
