"""What a Python user types first: it is there, it is loaded when it is used, its examples are true."""

from __future__ import annotations

import doctest
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, assert_type

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import mcpn
from mcpn.check.causes.find import Causes
from mcpn.check.logic.questions import Answer
from mcpn.check.verdicts.mission import MissionCheck
from mcpn.check.verdicts.nets import NetCheck
from mcpn.controller.hierarchy import TableController
from mcpn.controller.modular import AnyController
from mcpn.mission.model import Mission
from mcpn.report.pictures.drawing import Drawing
from mcpn.space.summary import SpaceSummary
from mcpn.testing import missions
from tests.conftest import ROOT, ULYSSE
from tests.net.nets import pt_nets


@pytest.mark.parametrize("name", ["mcpn", "mcpn.face", "mcpn.study", "mcpn.check", "mcpn.controller"])
def test_the_examples_are_true(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(import_module(name))
    assert found.attempted >= 3
    assert found.failed == 0


def test_every_name_is_there_and_can_be_called() -> None:
    for name in mcpn.__all__:
        assert name in dir(mcpn)
        assert callable(getattr(mcpn, name))
    with pytest.raises(AttributeError, match="no attribute 'verify'"):
        mcpn.verify  # noqa: B018


@pytest.mark.parametrize("name", mcpn.__all__)
def test_every_name_has_an_example(name: str) -> None:
    found = getattr(mcpn, name)
    if isinstance(found, ModuleType):
        found = type(found).__call__
    assert doctest.DocTestFinder(recurse=False).find(found)[0].examples, name


def test_a_users_type_checker_sees_what_they_give() -> None:
    """Mypy reads this: py.typed, and the names that are loaded when they are used."""
    mission = mcpn.read_mission(Path(ULYSSE))
    assert_type(mission, Mission)
    assert_type(mcpn.check(mission, engine="local"), MissionCheck)
    assert_type(mcpn.states(mission), SpaceSummary)
    assert_type(mcpn.ctl(mission, "EF success"), Answer)
    assert_type(mcpn.causes(mission), Causes)
    assert_type(mcpn.controller(mission), TableController)
    assert_type(mcpn.picture(mission), Drawing)
    study = mcpn.open(ULYSSE)
    assert_type(study, mcpn.Study)
    assert_type(study.check(), MissionCheck | NetCheck)
    assert_type(study.verdicts(), MissionCheck)
    assert_type(study.controller(), TableController)
    assert_type(study.controller("modular"), AnyController)
    assert (Path(mcpn.__file__).parent / "py.typed").is_file()


def test_rooms_can_be_called_whatever_was_imported_first() -> None:
    first = "import mcpn.check.logic.syntax, mcpn.controller.machine, mcpn"
    second = "print(callable(mcpn.check), callable(mcpn.controller), callable(mcpn.ctl))"
    run = subprocess.run(
        [sys.executable, "-c", f"{first}\n{second}"], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == ["True"] * 3


def test_the_package_itself_loads_nothing() -> None:
    script = "import sys, mcpn\nprint(*sorted(m for m in sys.modules if m[:4] == 'mcpn' or m == 'numpy'))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["mcpn"]


@pytest.mark.parametrize(("drawn", "parts"), [(missions(), ("blocks", "robots")), (pt_nets(), ("places",))])
def test_a_failing_property_shows_its_example_whole(
    drawn: st.SearchStrategy[object], parts: tuple[str, ...]
) -> None:
    """The repr is short, what hypothesis prints of a failure is not."""
    seen: list[Any] = []

    @settings(max_examples=1, database=None, phases=[Phase.generate])
    @given(drawn)
    def fails(example: object) -> None:
        seen.append(example)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as failed:
        fails()
    told = "\n".join(failed.value.__notes__)
    for part in parts:
        assert f"{part}=" in told
        assert all(f"name={each.name!r}" in told for each in getattr(seen[-1], part))
    assert repr(seen[-1]) not in told
