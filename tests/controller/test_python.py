"""The Python target: one file, whose code is not the runtime's, does what the runtime does."""

from __future__ import annotations

import ast
import random
import subprocess
import sys
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import event as seen
from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.generate import Form, generate
from mcpn.controller.targets import files
from mcpn.controller.targets.json import document
from mcpn.controller.targets.python import quoted
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.testing import missions
from tests.controller.traces import Traced, canonical, random_events, tour
from tests.draws import fewer


class Generated:
    """The generated file, run in this process."""

    def __init__(self, text: str) -> None:
        self.module: dict[str, object] = {"__name__": "generated"}
        exec(compile(text, "generated.py", "exec"), self.module)

    def lines(self, events: list[str]) -> list[str]:
        make: type = self.module["Controller"]  # type: ignore[assignment]
        refused: type[Exception] = self.module["EventRefused"]  # type: ignore[assignment]
        controller, found = make(), []
        for event in events:
            if not event:
                controller = make()
                continue
            try:
                actions, status = controller.handle(event), "taken"
            except refused:
                actions = []
                status = "refused" if event in self.module["EVENTS"] else "unknown"  # type: ignore[operator]
            said = "; ".join(" ".join(part for part in action[:3] if part) for action in actions)
            mode = " ".join(f"{a}.{w}" for a, w in controller.mode.items())
            rest = f"{mode} | {' '.join(controller.possible())} | {controller.outcome or '-'}"
            found.append(canonical(f"{status}: {said} | {rest}"))
        return found


@pytest.mark.parametrize("form", get_args(Form))
def test_every_edge_of_ulysse(form: Form, ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net, form)
    ((name, text),) = files(controller, ulysse_net, "python").items()
    traced = Traced(document(controller, ulysse_net))
    events, edges = tour(traced)
    assert len(edges) == 1332
    events += random_events(traced, random.Random(1), 500)
    traced.restart()
    expected = traced.lines(events)
    assert Generated(text).lines(events) == expected
    (tmp_path / name).write_text(text)
    command = [sys.executable, "-I", str(tmp_path / name), "all"]
    run = subprocess.run(command, input="\n".join(events) + "\n", capture_output=True, text=True, check=True)
    assert [canonical(line) for line in run.stdout.splitlines()] == expected
    assert '"depth": ("10", "m")' in text


@fewer(0.4)
@given(
    missions(max_objectives=3, max_depth=1, events=1, timeouts=3, awkward_names=True, text=True)
    | missions(max_objectives=3, max_depth=1, max_sections=6, facts=2, events=1)
    | missions(max_objectives=3, max_depth=1, max_sections=6, faults=1, lasting=True, crashes=True)
    | missions(max_objectives=2, max_depth=1, max_sections=5, late=True, lasting=True, facts=1),
    st.integers(0, 2**32),
    st.sampled_from(get_args(Form)),
)
def test_any_mission(mission: Mission, seed: int, form: Form) -> None:
    mission_net = compose(mission)
    try:
        controller = generate(mission_net, form, max_states=2000)
    except (SemanticsError, LimitError):
        return
    seen(f"{form}, facts: {bool(mission_net.usage.world.facts)}")
    ((_, text),) = files(controller, mission_net, "python").items()
    traced = Traced(document(controller, mission_net))
    events = random_events(traced, random.Random(seed), 60)
    traced.restart()
    assert Generated(text).lines(events) == traced.lines(events)


@given(st.text())
def test_texts_are_read_back(text: str) -> None:
    assert quoted(text).isascii()
    assert ast.literal_eval(quoted(text)) == text
