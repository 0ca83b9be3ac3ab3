"""What all targets share: the same bytes for the same mission."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from mcpn.controller.document import document
from mcpn.controller.modular import ModularController
from mcpn.errors import InputError
from mcpn.robot.targets import OF_RULES, TARGETS, files
from mcpn.study import open_study
from tests.conftest import ROOT, ULYSSE

PROGRAM = """
import hashlib, sys
from pathlib import Path
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.minimise import minimise
from mcpn.robot.targets import TARGETS, files
from mcpn.mission.xml import read_mission
from mcpn.drawing.compose import compose
for path in sys.argv[1:]:
    net = compose(read_mission(Path(path)))
    for form in ("flat", "hierarchical"):
        controller = generate(net, form)
        for found in (controller, minimise(controller)):
            for target in TARGETS:
                for name, text in files(document(found, net), target).items():
                    print(form, found.minimised, name, hashlib.sha256(text.encode()).hexdigest())
"""


def test_the_files_are_the_same_byte_for_byte_in_every_process() -> None:
    """Sets and dictionaries of strings are walked in another order in each process."""
    missions = [str(ULYSSE), str(Path(__file__).with_name("watch.xml"))]
    said = []
    for number in ("0", "1"):
        run = subprocess.run(
            [sys.executable, "-c", PROGRAM, *missions],
            capture_output=True,
            text=True,
            check=True,
            cwd=ROOT,
            env={**os.environ, "PYTHONHASHSEED": number},
        )
        said.append(run.stdout.splitlines())
    assert len(said[0]) >= 2 * 2 * 2 * len(TARGETS)  # missions, forms, minimised or not
    assert said[0] == said[1]


WRITTEN = (
    "natural/dumpster",
    "natural/greenhouse",
    "natural/hospital",
    "natural/sewer",
)
LONG = ("natural/portboat",)
WORKED = ("drone/mission", "rover/mission", "roscon/problem3", "roscon/problem4")


@pytest.mark.parametrize(
    "path",
    [
        *(f"tests/{name}.xml" for name in WRITTEN),
        *(pytest.param(f"tests/{name}.xml", marks=pytest.mark.slow) for name in LONG),
        *(f"experiments/{name}.xml" for name in WORKED),
    ],
)
def test_a_mission_that_passes_gets_every_target(path: str) -> None:
    """In the form that is taken by itself; the modular form has those of rules."""
    study = open_study(ROOT / path)
    net = study.mission_net
    controller, modular = study.controller("auto"), study.controller("modular")
    assert isinstance(modular, ModularController)
    for target in TARGETS:
        assert all(files(document(controller, net), target).values())
        if target not in OF_RULES:
            with pytest.raises(InputError, match=f"the target {target} of a modular controller"):
                files(document(modular, net), target)
        else:
            assert all(files(document(modular, net), target).values())
