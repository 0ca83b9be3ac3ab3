"""Controllers of missions with large sections: their size is said before anything is listed or written."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from mcpn.controller import generate, sizes
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot
from mcpn.mission.writer import save_mission
from mcpn.robot.targets import TARGETS
from mcpn.spaces.stable import alternatives
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
    folder.mkdir(exist_ok=True)
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
    run = mcpn("controller", path, "-o", out, "--hierarchical", *options)
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr == (
        f"error: section s1 has {states(24):,} states: a machine lists every state, "
        "the limit is 1,000,000 (--max-states); --form modular lists none\n"
    )
    # More states may be allowed; that many entries may not.
    run = mcpn("controller", path, "-o", out, "--max-states", states(24), "--hierarchical", *options)
    assert run.returncode == 2
    assert (
        "section s1: 24 hardware resources that may fail have 2^24 states, the limit on the entries"
        in run.stderr
    )
    assert not out.exists()


def test_a_section_too_large_for_a_table_is_told_by_rules(tmp_path: Path) -> None:
    path, out = save(tmp_path, 2, 24), tmp_path / "out"
    run = mcpn("controller", path, "-o", out)
    assert run.returncode == 0
    assert run.stderr == (
        f"section s1 has {states(24):,} states: a machine lists every state, "
        "the limit is 50,000 (--max-states): a modular controller is made instead\n"
    )
    assert run.stdout.startswith("modular controller of m: 2 sections of 2 types, ")
    assert json.loads((out / "controller.json").read_text())["form"] == "modular"
    for options in (("--form", "minimised"), ("--target", "scxml")):  # these are of tables alone
        run = mcpn("controller", path, "-o", tmp_path / "none", *options)
        assert (run.returncode, run.stdout) == (2, "")
        assert "the limit is 1,000,000" in run.stderr
    run = mcpn("controller", path, "-o", tmp_path / "none", "--form", "modular", "--target", "scxml")
    assert (run.returncode, run.stdout) == (2, "")
    assert "modular" in run.stderr
    assert not (tmp_path / "none").exists()


def test_what_a_mission_gets_is_said_by_check(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Forms as they are made then; sizes are bounds of theirs."""
    small, large = save(tmp_path / "small", 2, 3), save(tmp_path / "large", 2, 24)
    run = mcpn("check", small, "--engine", "local")
    assert f"controller: hierarchical, at most {states(2) + states(3)} states\n" in run.stdout
    run = mcpn("check", large, "--engine", "local")
    many = r"modular, more than 8 rules for each of \d+ events before any is split; section s1 has .*"
    assert re.search(f"^controller: {many}$", run.stdout, re.MULTILINE)
    made = json.loads(mcpn("controller", large, "-o", tmp_path / "a", "--json").stdout)
    assert made["form"] == "modular"
    monkeypatch.setattr(sizes, "MOST_TABLED", 30)
    run = mcpn("check", small, "--engine", "local")
    (line,) = (line for line in run.stdout.splitlines() if line.startswith("controller: "))
    found = re.fullmatch(
        r"controller: modular, at most ([\d,]+) rules before any is split; section s1 has .* states: .*", line
    )
    assert found is not None
    made = json.loads(mcpn("controller", small, "-o", tmp_path / "b", "--json").stdout)
    assert made["form"] == "modular"
    rules = re.search(r", (\d+) rules", made["size"])
    assert rules is not None
    assert 0 < int(rules[1]) <= int(found[1].replace(",", ""))


def test_tables_that_take_a_large_file_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generate, "MOST_UNTOLD", 100)
    monkeypatch.setattr(generate, "MOST_BYTES", 10_000)
    path, out = save(tmp_path, 6, 2, 6), tmp_path / "out"
    run = mcpn("controller", path, "-o", out, "--form", "hierarchical")
    assert run.returncode == 2
    found = re.search(
        r"in a file of more than [\d.]+ MB; the limit is 0 MB, and --max-states (\d+) goes on all the same; "
        r"--form modular takes (\d+) kB\n",
        run.stderr,
    )
    assert found is not None, run.stderr
    assert not out.exists()
    assert mcpn("controller", path, "-o", out, "--form", "minimised").returncode == 0
    run = mcpn("controller", path, "-o", out, "--form", "hierarchical", "--max-states", found[1])
    assert run.returncode == 0
    assert mcpn("controller", path, "-o", tmp_path / "rules", "--form", "modular").returncode == 0
    size = (tmp_path / "rules" / "controller.json").stat().st_size
    assert size / 3 < float(found[2]) * 1e3 < 3 * size


def test_the_size_of_what_is_listed_is_said_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generate, "MOST_UNTOLD", 100)
    path, out = save(tmp_path, 6, 2, 6), tmp_path / "out"
    run = mcpn("controller", path, "-o", out, "--json")
    assert run.returncode == 0
    every = states(6) + states(2)
    found = json.loads(run.stdout)
    text = Path(found["files"][0]).read_text()
    edges = sum(len(type_["edges"]) for type_ in json.loads(text)["types"])
    told = re.fullmatch(
        rf"2 machines of sections list {every} states, the largest, of section s0, {states(6)}, and ([\d,]+) "
        r"edges, in a file of more than ([\d.]+) MB; --form modular has at most [\d,]+ rules instead, .*\n",
        run.stderr,
    )
    assert told is not None, run.stderr
    assert int(told[1].replace(",", "")) == edges
    assert float(told[2]) * 1e6 <= len(text)
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


BROKEN = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="h"/><activity name="a" consumes="h"/></robot>
  <requirement name="never" formula="G !objective(x)"/>
  <objective name="x" activities="a"/>
</mission>
"""


@pytest.mark.parametrize("target", TARGETS)
def test_a_mission_that_fails_gets_no_controller_unasked(target: str, tmp_path: Path) -> None:
    path, out = tmp_path / "m.xml", tmp_path / "out"
    path.write_text(BROKEN)
    run = mcpn("controller", path, "-o", out, "--target", target)
    assert run.returncode == 1
    assert "G !objective(x) fails" in run.stdout
    assert run.stderr.endswith("not written: mcpn check says no (--unverified writes it all the same)\n")
    assert output("controller", path, "-o", out, code=1) == {"mission": "m", "failed": [], "unmet": ["never"]}
    assert not out.exists()
    (*_, last) = output("controller", path, "-o", out, "--target", target, "--unverified")["files"]
    texts = [file.read_text() for file in out.iterdir()]
    marks = ('"unverified": true', "UNVERIFIED: written without asking")
    said = [text for text in texts if any(mark in text for mark in marks)]
    assert said
    assert all("Generated by mcpn" not in text or text in said for text in texts)
    path.write_text(BROKEN.replace("!objective(x)", "true"))
    output("controller", path, "-o", out, "--target", target)
    assert not any(mark in file.read_text() for file in out.iterdir() for mark in marks)
    assert Path(last).exists()


def test_large_tables_name_the_form_of_rules(tmp_path: Path) -> None:
    """A table of more than 2 MB; where no form is named, one of many edges is none in the first place."""
    path, out = save(tmp_path, 10), tmp_path / "out"
    run = mcpn("controller", path, "-o", out, "--form", "hierarchical")
    assert len((out / "controller.json").read_bytes()) > 2_000_000
    assert re.search(r"^note: \d+ MB; --form modular has rules in place of tables", run.stderr, re.MULTILINE)
    assert "note: " not in mcpn("controller", path, "-o", out, "--form", "modular").stderr


def test_many_edges_are_rules_by_themselves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sizes, "MOST_TABLED_EDGES", 100)
    run = mcpn("controller", save(tmp_path, 4), "-o", tmp_path / "out")
    assert run.stdout.startswith("modular controller of m")
    assert "edges, the limit of --form auto is 100: a modular controller is made instead" in run.stderr


def test_a_certificate_is_not_written_over_its_controller(tmp_path: Path) -> None:
    """It was, and the command ended well: what was verified was lost."""
    mission, build = save(tmp_path / "m", 1), tmp_path / "build"
    run = mcpn("controller", mission, "-o", build, "--certificate", build / "controller.json")
    assert run.returncode == 2
    assert "controller.json: cannot be written: something else is written there" in run.stderr
    assert not build.exists()
