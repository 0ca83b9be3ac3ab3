"""The main job by an installed mcpn alone: a mission is written, checked, run and explained.

``python .ci/main_job.py`` needs the package and nothing else: no compiler, no checkout, no network.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

EXAMPLES = ("courier", "drone", "glider", "rover", "ulysse")
COMMAND = [sys.executable, "-P", "-m", "mcpn.cli"]


def mcpn(*arguments: str) -> object:
    """The JSON value of one command, which must end with 0."""
    run = subprocess.run([*COMMAND, *arguments, "--json"], capture_output=True, text=True, check=False)
    if run.returncode:
        sys.exit(f"mcpn {' '.join(arguments)}: exit code {run.returncode}\n{run.stdout}{run.stderr}")
    return json.loads(run.stdout)


def drive() -> None:
    """The controller, from the file, through a whole mission in which everything succeeds."""
    from mcpn.robot.runtime import Controller

    controller = Controller.load("build/controller.json")
    event = "MISSION_EV_START"
    orders = [str(action) for action in controller.handle(event)]
    while controller.outcome is None:
        event = next(name for name in controller.possible if name.endswith("_EV_OK"))
        orders += [str(action) for action in controller.handle(event)]
    assert controller.outcome == "success", controller.outcome
    assert any(order.startswith("start ") for order in orders), orders


def main() -> None:
    """Every step, in a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for example in EXAMPLES:
            mcpn("init", example, "--example", example)
            mcpn("convert", str(Path(example, "mission.xml")), f"{example}.net")
        mcpn("init", "first_one")
        mission = str(Path("first_one", "mission.xml"))
        sizes = set()
        for engine in ("explicit", "symbolic", "local"):
            found = mcpn("check", mission, "--engine", engine)
            assert isinstance(found, dict)
            assert found["verdicts"]["success_reachable"] is True
            sizes.add(tuple(found["alternatives"].values()))
        assert len(sizes) == 1, sizes
        ran = mcpn("run", mission, "--drivers", str(Path("first_one", "drivers.toml")))
        assert isinstance(ran, dict)
        assert (ran["outcome"], ran["refused"]) == ("success", 0), ran
        causes = mcpn("causes", mission)
        assert isinstance(causes, dict)
        assert causes["mission"]["cut_sets"]
        mcpn("controller", mission, "-o", "build")
        drive()
        mcpn("report", mission, "-o", "report.html")
        mcpn("convert", mission, "mission.net")
        mcpn("states", "mission.net", "--engine", "symbolic")
    print("the main job is done by", sys.version.split()[0], "on", sys.platform)


if __name__ == "__main__":
    main()
