"""The Python target: one file, which needs no mcpn, does what the runtime does."""

from __future__ import annotations

import ast
import random
import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any, get_args

import pytest
from hypothesis import event as seen
from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import Form, generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Parameter, Robot
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files, python
from mcpn.robot.targets.python import bundle
from mcpn.testing import missions
from tests.controller.traces import Traced, canonical, random_events, tour
from tests.draws import fewer


class Generated:
    """The generated file, run in this process."""

    def __init__(self, text: str) -> None:
        self.module: Any = ModuleType("generated")
        sys.modules["generated"] = self.module  # dataclasses look their module up there
        exec(compile(text, "generated.py", "exec"), self.module.__dict__)

    def controller(self, **options: Any) -> Any:
        """A new controller."""
        return self.module.Controller(self.module.TABLES, **options)

    def lines(self, events: list[str]) -> list[str]:
        controller, found = self.controller(), []
        for event in events:
            if not event:
                controller = self.controller()
                continue
            try:
                actions, status = controller.handle(event), "taken"
            except self.module.Refused as refused:
                actions, status = (), "refused" if refused.known else "unknown"
            mode = " ".join(f"{a}.{w}" for a, w in controller.mode.items())
            rest = f"{mode} | {' '.join(controller.possible)} | {controller.outcome or '-'}"
            found.append(canonical(f"{status}: {'; '.join(map(str, actions))} | {rest}"))
        return found


@pytest.mark.parametrize("form", get_args(Form))
def test_every_edge_of_ulysse(form: Form, ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net, form)
    ((name, text),) = files(document(controller, ulysse_net), "python").items()
    traced = Traced(document(controller, ulysse_net))
    events, edges = tour(traced)
    assert len(edges) == 1332
    events += random_events(traced, random.Random(1), 500)
    traced.restart()
    expected = traced.lines(events)
    assert Generated(text).lines(events) == expected
    (tmp_path / name).write_text(text, encoding="utf-8")
    # Without its site packages, so without mcpn.
    command = [sys.executable, "-I", "-S", str(tmp_path / name), "all"]
    run = subprocess.run(command, input="\n".join(events) + "\n", capture_output=True, text=True, check=True)
    assert [canonical(line) for line in run.stdout.splitlines()] == expected
    assert run.stderr == ""


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
    ((_, text),) = files(document(controller, mission_net), "python").items()
    traced = Traced(document(controller, mission_net))
    events = random_events(traced, random.Random(seed), 60)
    traced.restart()
    assert Generated(text).lines(events) == traced.lines(events)


def test_a_snapshot_of_one_is_one_of_the_other(ulysse_net: MissionNet) -> None:
    controller = generate(ulysse_net)
    ((_, text),) = files(document(controller, ulysse_net), "python").items()
    generated, runtime = Generated(text), Runtime.from_document(document(controller, ulysse_net))
    one, other = generated.controller(), generated.controller()
    one.handle("MISSION_EV_START")
    runtime.restore(one.snapshot())
    assert (runtime.section, runtime.mode) == (one.section, one.mode)
    runtime.handle(runtime.possible[0])
    other.restore(runtime.snapshot())
    assert (other.section, other.mode, other.possible) == (runtime.section, runtime.mode, runtime.possible)
    with pytest.raises(generated.module.SnapshotError):
        other.restore(runtime.snapshot()[:-9])


def test_it_imports_python_alone(ulysse_net: MissionNet) -> None:
    ((_, text),) = files(document(generate(ulysse_net), ulysse_net), "python").items()
    imported = set[str]()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            imported |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.module is not None
            assert not node.level
            imported.add(node.module)
    assert "hashlib" in imported
    assert {name.partition(".")[0] for name in imported} <= sys.stdlib_module_names


@given(st.text() | st.text(st.sampled_from("\"\\'\r\n\u2028a")))
def test_any_text_of_a_mission(said: str) -> None:
    """The tables stand in a raw string, and no text of the mission ends it."""
    told = Parameter(name="depth", value=said, unit=said)
    robot = Robot(name="r", activities=(Activity(name="a", alternatives=(Alternative(name="w"),)),))
    block = Objective(name="x", activities=("a",), parameters=(told,))
    mission_net = compose(Mission(name="m", robots=(robot,), blocks=(block,)))
    ((_, text),) = files(document(generate(mission_net), mission_net), "python").items()
    (select,) = (a for a in Generated(text).controller().handle("MISSION_EV_START") if a.verb == "select")
    assert [(p.name, p.value, p.unit) for p in select.parameters] == [("depth", said, said)]


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("from mcpn.robot.runtime.other import thing as that\n", "gives two names"),
        ("from mcpn.robot.runtime.other import thing\nfree = 2\n", "different things by free"),
        ("from mcpn.robot.runtime.other import thing\nfrom os import free\n", "different things by free"),
        ("from mcpn.robot.runtime.other import thing\nimport free\n", "different things by free"),
    ],
)
def test_modules_that_cannot_be_one(
    source: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "one.py").write_text(source)
    (tmp_path / "other.py").write_text("free = thing = 1\n")
    monkeypatch.setattr(python, "files", lambda package: tmp_path)
    bundle.cache_clear()
    with pytest.raises(ValueError, match=message):
        bundle("one")


def test_modules_in_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "one.py").write_text(
        '"""First.\n\nMore."""\n\nfrom json import (\n    loads,\n    dumps,\n)\n'
        "from mcpn.robot.runtime.two import b\nfrom mcpn.robot.runtime.three import (\n    c,\n)\n\n"
        '# Why.\na = b + c\n\n__all__ = [\n    "a",\n]\n'
    )
    (tmp_path / "two.py").write_text("import sys\nfrom mcpn.robot.runtime.three import c\n\nb = 2 * c\n")
    (tmp_path / "three.py").write_text("import sys\nfrom json import dumps\n\nc = 1\n")
    monkeypatch.setattr(python, "files", lambda package: tmp_path)
    bundle.cache_clear()
    text = bundle("one")
    bundle.cache_clear()
    assert [line for line in text.splitlines() if line] == [
        "import sys",
        "from json import dumps, loads",
        "# --- mcpn.robot.runtime.three ---",
        "#",
        "c = 1",
        "# --- mcpn.robot.runtime.two ---",
        "#",
        "b = 2 * c",
        "# --- mcpn.robot.runtime.one ---",
        "# First.",
        "#",
        "# More.",
        "# Why.",
        "a = b + c",
    ]
