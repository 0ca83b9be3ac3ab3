"""Missions for the worlds of the ROS deliberation workshop: verified always, run where the worlds are."""

from __future__ import annotations

import importlib
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from tests.commands import mcpn, output
from tests.conftest import ROOT

FOLDER = ROOT / "experiments" / "roscon"
DRIVERS = FOLDER / "drivers.toml"
OURS = ["problem1", "problem2", "problem3", "problem4"]


@pytest.mark.parametrize("name", OURS)
def test_our_missions_are_verified_and_have_their_drivers(name: str) -> None:
    found = mcpn("run", FOLDER / f"{name}.xml", "--drivers", DRIVERS, "--check")
    assert found.returncode == 0, found.stderr


def test_the_published_steps_leave_the_dumpster_open() -> None:
    found = mcpn("check", FOLDER / "problem2_published.xml")
    assert found.returncode == 1
    assert "FAIL The dumpster is closed at the end (shut)" in found.stdout
    assert "ok   All waste is in the dumpster (thrown)" in found.stdout


def test_success_is_as_probable_as_its_steps() -> None:
    """Every step succeeds within its tries: 1 - p^n, with what the mission says; none depends on another."""
    steps = {"navigate": 1 - 0.1**2, "pick": 1 - 0.5**3, "place": 1 - 0.5**3}
    said = output("causes", FOLDER / "problem1.xml", "--rates")
    assert said["risk"]["success"] == pytest.approx(steps["navigate"] ** 2 * steps["pick"] * steps["place"])


@pytest.fixture
def world(roscon: Path) -> dict[str, str]:
    """The environment in which PyRoboSim runs."""
    pytest.importorskip("pyrobosim", reason="needs mcpn[worlds]")
    environment = {**os.environ, "MCPN_ROSCON": str(roscon), "MCPN_SEED": "0"}
    environment.pop("PYTHONSAFEPATH", None)
    return environment


def test_a_mission_runs_in_a_world(world: dict[str, str], tmp_path: Path) -> None:
    arguments = ["run", FOLDER / "problem1.xml", "--drivers", DRIVERS, "--json", "--monitors", "--journal"]
    command = [sys.executable, "-m", "mcpn.cli", *map(str, arguments), "log.jsonl"]
    found = subprocess.run(command, cwd=tmp_path, env=world, capture_output=True, text=True, check=False)
    said = json.loads(found.stdout)
    assert (said["refused"], said["violated"]) == (0, [])
    assert found.returncode == (0 if said["outcome"] == "success" else 1), found.stderr
    replayed = output("simulate", FOLDER / "problem1.xml", "--events", tmp_path / "log.jsonl")
    assert replayed["outcome"] == said["outcome"]


def test_what_a_run_does_is_of_its_seed_and_not_of_the_machine(
    roscon: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A way is found however long the machine takes for it, and the same one again."""
    planner = pytest.importorskip("pyrobosim.navigation.rrt", reason="needs mcpn[worlds]")
    monkeypatch.syspath_prepend(FOLDER)
    actions = importlib.import_module("actions")
    clock = itertools.count(0.0, 10.0)  # ten seconds between any two looks at it
    monkeypatch.setattr(planner, "time", SimpleNamespace(time=lambda: next(clock)))
    ways = []
    for seed in (0, 0, 1):
        world = actions.begin(roscon / "worlds" / "world4.yaml", seed)
        way = world.robots[0].plan_path(goal="desk")
        ways.append([(pose.x, pose.y) for pose in way.poses])
        actions.end()
    assert len(ways[0]) > 2
    assert ways[0] == ways[1] != ways[2]


@pytest.mark.slow
def test_shares_are_those_of_risk_and_the_published_run_shows_the_open_dumpster(
    world: dict[str, str], tmp_path: Path
) -> None:
    """It ends with 1 where a share lies outside of its interval, a run is not replayed, or a goal missed."""
    script = ROOT / "experiments" / "robots" / "roscon.py"
    command = [sys.executable, str(script), "--runs", "8", "--only", "problem1", "--jobs", "1"]
    found = subprocess.run(command, cwd=tmp_path, env=world, capture_output=True, text=True, check=False)
    assert found.returncode == 0, found.stdout + found.stderr
    assert "the waste is in dumpster_disposal, dumpster_disposal, the dumpster open." in found.stdout
