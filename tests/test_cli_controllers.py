"""Controllers of missions with large sections: their size is said before anything is listed or written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from mcpn.controller import generate
from mcpn.mission.model import Activity, Alternative, Hardware, Mission, Objective, Robot
from mcpn.mission.writer import save_mission
from mcpn.space.stable import alternatives
from tests.commands import mcpn, output


def save(folder: Path, *hardware: int) -> Path:
    """Objectives in a row, each with an activity that may use any of so many resources of its own."""
    names = [[f"s{i}_h{k}" for k in range(count)] for i, count in enumerate(hardware)]
    activities = tuple(
        Activity(name=f"a{i}", alternatives=tuple(Alternative(name=f"by_{h}", consumes=(h,)) for h in own))
        for i, own in enumerate(names)
    )
    robot = Robot(
        name="r", hardware=tuple(Hardware(name=h) for own in names for h in own), activities=activities
    )
    blocks = tuple(Objective(name=f"s{i}", activities=(f"a{i}",)) for i in range(len(hardware)))
    path = folder / "m.xml"
    save_mission(Mission(name="m", robots=(robot,), blocks=blocks), path)
    return path


def states(hardware: int) -> int:
    """Of one section: before it and after either end any status; inside who is held, or none is."""
    return (4 << hardware) + (hardware << hardware) // 2


@pytest.mark.parametrize("options", [(), ("--json",)], ids=["text", "json"])
def test_a_section_too_large_is_refused_before_any_is_listed(
    options: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("nothing is listed before the sizes are known to fit")

    monkeypatch.setattr(alternatives, "direct", never)
    path, out = save(tmp_path, 2, 24), tmp_path / "out"
    run = mcpn("controller", path, "-o", out, *options)
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr == (
        f"error: section s1 has {states(24):,} states: a machine lists every state, "
        "the limit is 1,000,000 (--max-states)\n"
    )
    # More states may be allowed; that many entries may not.
    run = mcpn("controller", path, "-o", out, "--max-states", states(24), *options)
    assert run.returncode == 2
    assert (
        "section s1: 24 hardware resources that may fail have 2^24 states, the limit on the entries"
        in run.stderr
    )
    assert not out.exists()


def test_the_size_of_what_is_listed_is_said_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generate, "MOST_UNTOLD", 100)
    path, out = save(tmp_path, 6, 2, 6), tmp_path / "out"
    run = mcpn("controller", path, "-o", out, "--json")
    assert run.returncode == 0
    every = states(6) + states(2)
    assert run.stderr == (
        f"2 machines of sections list {every} states, the largest, of section s0, {states(6)}\n"
    )
    found = json.loads(run.stdout)
    assert (found["form"], found["mission"]) == ("hierarchical", "m")
    assert found["size"].startswith("3 sections of 2 types, ")
    assert [Path(name).exists() for name in found["files"]] == [True] * len(found["files"])


def test_a_long_mission_is_written_section_by_section(tmp_path: Path) -> None:
    # 40 resources: a flat controller would have more than 2^40 states.
    path = save(tmp_path, *([2] * 20))
    found = output("controller", path, "-o", tmp_path / "out")
    assert found["size"].startswith("20 sections of 1 types, ")
    flat = mcpn("controller", path, "--flat", "-o", tmp_path / "flat", "--json")
    assert flat.returncode == 2
    assert flat.stdout == ""
    assert "40 hardware resources that may fail have 2^40 states" in flat.stderr
    assert not (tmp_path / "flat").exists()
