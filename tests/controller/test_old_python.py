"""What runs on the robot runs on Python 3.10, which ROS 2 Humble has: the generated file and the runtime.

mcpn itself needs a later Python. The interpreter is that of ``--python310``, on the path, or one that pyenv
keeps.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from random import Random
from typing import get_args

import pytest

import mcpn.robot.runtime
from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet
from mcpn.files import write_folder
from mcpn.robot.targets import files
from mcpn.robot.targets.json import write_json
from tests.controller.traces import Traced, canonical, random_events


@pytest.fixture(scope="module")
def old(request: pytest.FixtureRequest) -> str:
    """A CPython 3.10."""
    asked = "import sys; sys.exit(sys.version_info[:2] != (3, 10))"
    named = request.config.getoption("--python310")
    kept = sorted(Path.home().glob(".pyenv/versions/3.10.*/bin/python"))
    for python in (named, shutil.which("python3.10"), *map(str, kept)):
        if python and subprocess.run([python, "-c", asked], check=False, capture_output=True).returncode == 0:
            return str(python)
    if named:
        pytest.fail(f"--python310 {named} is no Python 3.10")
    pytest.skip("needs Python 3.10: on the path, or as --python310")


@pytest.mark.parametrize("form", get_args(Form))
def test_the_generated_file(form: Form, old: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net, form)
    ((name, text),) = files(document(controller, ulysse_net), "python").items()
    (tmp_path / name).write_text(text, encoding="utf-8")
    traced = Traced(document(controller, ulysse_net))
    events = random_events(traced, Random(1), 500)
    traced.restart()
    command = [old, "-I", "-S", str(tmp_path / name), "all"]
    run = subprocess.run(command, input="\n".join(events) + "\n", capture_output=True, text=True, check=False)
    assert run.stderr == ""
    assert [canonical(line) for line in run.stdout.splitlines()] == traced.lines(events)


FAILING = """
import mcpn.robot.runtime as runtime
for name in runtime.__all__:
    getattr(runtime, name)
controller = runtime.Controller.load("controller.json")
def failing(action):
    raise KeyError(action.verb)
controller.on(None, failing)
try:
    controller.handle("MISSION_EV_START")
except runtime.HookErrors as errors:
    print(len(errors.exceptions), errors.failed[0].event, errors)
print(controller.possible[0])
"""


def test_the_runtime_by_itself(old: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    """Its folder alone is enough; hooks that fail are told together there, too, as Python 3.11 words it."""
    whole = Path(mcpn.robot.runtime.__file__).parent
    shutil.copytree(
        whole, tmp_path / "mcpn" / "robot" / "runtime", ignore=shutil.ignore_patterns("__pycache__")
    )
    controller = generate(ulysse_net)
    (tmp_path / "controller.json").write_text(write_json(document(controller, ulysse_net)), encoding="utf-8")
    run = subprocess.run(
        [old, "-E", "-S", "-c", FAILING], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert run.stderr == ""
    started = mcpn.robot.runtime.Controller.load(tmp_path / "controller.json")
    actions = len(started.handle("MISSION_EV_START"))
    told = f"hooks have failed; the event has been taken ({actions} sub-exceptions)"
    assert run.stdout.splitlines() == [f"{actions} MISSION_EV_START {told}", started.possible[0]]


def test_the_package_for_ros(old: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    """Every file of it is Python of that version."""
    write_folder(tmp_path, files(document(generate(ulysse_net), ulysse_net), "ros2"))
    assert len([*tmp_path.glob("*.py")]) == 4
    command = [old, "-m", "compileall", "-q", "-f", str(tmp_path)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
