"""Timers that are over in one millisecond: one order in runtime, generated Python, C and a plain model."""

from __future__ import annotations

import random
import subprocess
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any, get_args

import pytest
from hypothesis import HealthCheck, Phase, event, given, settings
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.robot.runtime import Action, Controller
from mcpn.robot.targets import files
from tests.controller.test_c import SANITIZE, build
from tests.controller.test_python import Generated
from tests.controller.test_timers import HARNESS, START, Clock, one
from tests.draws import fewer
from tests.small import activity, mission, robot

FORMS: tuple[Form, ...] = get_args(Form)
STEP = 100
"""Milliseconds that all times are multiples of, and all waits: ties are usual."""


class Ends:
    """When timers are over, in whole milliseconds: the plainest model that there is."""

    def __init__(self) -> None:
        self.now = 0
        self.ends: dict[str, int] = {}

    def follow(self, actions: tuple[Action, ...]) -> None:
        for action in actions:
            if action.verb == "disarm":
                self.ends.pop(str(action.objective), None)
            elif action.verb == "arm":
                assert action.seconds is not None
                self.ends[str(action.objective)] = self.now + round(1000 * action.seconds)

    def over(self) -> list[str]:
        """The events of what is over, in the order in which they are to come."""
        late = [
            (end, f"OBJ_{name}_EV_TIMEOUT".encode()) for name, end in self.ends.items() if end <= self.now
        ]
        return [told.decode() for _, told in sorted(late)]


NAMES = ("a", "B", "c", "cC", "c_", "Z", "cc", "z")
"""The order of their bytes is neither that of the alphabet nor that in which they are armed."""
times = st.sampled_from((0.1, 0.2, 0.3)) | st.sampled_from((0.4, 0.6))


@st.composite
def rings(draw: st.DrawFn) -> Mission:
    """Branches of objectives whose times lead from one to the next, all beside each other, for ever."""
    names = iter(draw(st.permutations(NAMES)))
    branches: list[Objective | Recursive] = []
    for number, length in enumerate(draw(st.lists(st.integers(1, 3), min_size=2, max_size=2))):
        ring = list(islice(names, length))
        blocks = (
            one(name, draw(times), timeout_goto=after, success=after, failure=after)
            for name, after in zip(ring, ring[1:] + ring[:1], strict=True)
        )
        branches.append(
            Recursive(name=f"r{number}", blocks=tuple(blocks), timeout=draw(st.none() | st.just(1.2)))
        )
    last = next(names)
    return mission(
        robot((), *(activity(name, ()) for name in NAMES)),
        Parallel(name="all", blocks=tuple(branches), success=last, failure=last),
        one(last, draw(times), success="all", failure="all", timeout_goto="all"),
    )


def made_of(mission: Mission, form: Form) -> dict[str, Any]:
    """The document of a controller."""
    net = compose(replace(mission, name="m"))
    return document(generate(net, form), net)


def walk(made: dict[str, Any], rng: random.Random, steps: int) -> tuple[list[str], list[str]]:
    """Lines of events and waits, and what the runtime says to each."""
    clock, model = Clock(), Ends()
    controller = Controller.from_document(made, clock=clock)
    lines, said, ties = list[str](), list[str](), 0

    def take(told: str) -> None:
        lines.append(told)
        said.append("taken")
        model.follow(controller.handle(told))

    take(START)
    for _ in range(steps):
        possible = [told for told in controller.possible if not told.endswith("_EV_TIMEOUT")]
        if possible and rng.random() < 0.3:
            take(rng.choice(possible))
            continue
        wait = STEP * rng.randint(1, 4)
        clock.time += wait
        model.now += wait
        lines.append(f"+{wait}")
        while over := model.over():
            ties += len(over) > 1
            assert controller.overdue == over[0]
            said.append(over[0])
            take(over[0])
            lines.append("+0")
        assert controller.overdue is None
        said.append("-")
    event("ties" if ties else "no ties")
    return lines, said


def of_python(made: dict[str, Any], lines: list[str]) -> list[str]:
    """What generated Python says."""
    ((_, text),) = files(made, "python").items()
    generated, clock, found = Generated(text), Clock(), list[str]()
    controller = generated.controller(clock=clock)
    for line in lines:
        if line.startswith("+"):
            clock.time += int(line)
            found.append(controller.overdue or "-")
        else:
            controller.handle(line)
            found.append("taken")
    return found


def of_c(made: dict[str, Any], lines: list[str], folder: Path) -> list[str]:
    """What generated C says, under sanitizers."""
    texts = {name: text for name, text in files(made, "c").items() if not name.endswith("_main.c")}
    program = build(texts | {"harness.c": HARNESS}, folder, *SANITIZE)
    run = subprocess.run([program], input="\n".join(lines) + "\n", capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout.split()


drawn = given(rings(), st.sampled_from(FORMS), st.integers(0, 2**32))


@fewer(0.5)
@drawn
def test_ties_come_in_one_order(of: Mission, form: Form, seed: int) -> None:
    made = made_of(of, form)
    lines, said = walk(made, random.Random(seed), 60)
    assert of_python(made, lines) == said


@pytest.mark.slow
@settings(
    max_examples=60,
    deadline=None,
    suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.reuse, Phase.generate),  # each example is compiled: shrinking takes minutes
)
@drawn
def test_ties_come_so_in_c(
    tmp_path_factory: pytest.TempPathFactory, of: Mission, form: Form, seed: int
) -> None:
    made = made_of(of, form)
    lines, said = walk(made, random.Random(seed), 200)
    assert of_c(made, lines, tmp_path_factory.mktemp("c")) == said
