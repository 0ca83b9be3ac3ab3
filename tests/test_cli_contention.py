"""What commands say of a mission that is not confluent, in the words of the mission."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from mcpn.answers.verdicts.mission import REQUIRED
from mcpn.drawing.compose import compose
from mcpn.mission.xml import read_mission
from tests.commands import mcpn, output

CONTENDED = """<mission name="m" xmlns="urn:mcpn:mission:1">
  <robot name="r"><hardware name="camera"/>
    <activity name="film" consumes="camera"/><activity name="photo" consumes="camera"/></robot>
  <parallel name="census">
    <objective name="filming" activities="film"/><objective name="photos" activities="photo"/>
  </parallel>
</mission>"""

COMMANDS = [
    ("check",),
    ("check", "--engine", "symbolic"),
    ("check", "--engine", "local"),
    ("alternatives",),
    ("alternatives", "--method", "reduction"),
    ("alternatives", "--engine", "local"),
    ("states", "--engine", "local"),
    *(("causes", "--engine", engine) for engine in ("explicit", "symbolic", "local")),
    *(
        ("ask", "--on", "alternatives", "--engine", engine, "EF success")
        for engine in ("explicit", "symbolic", "local")
    ),
    ("controller", "--flat", "-o", "OUT"),
    ("controller", "--hierarchical", "-o", "OUT"),
]


@pytest.fixture
def contended(tmp_path: Path) -> Path:
    path = tmp_path / "m.xml"
    path.write_text(CONTENDED)
    return path


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_the_message_names_resource_activities_objectives_and_remedy(
    command: tuple[str, ...], contended: Path, tmp_path: Path
) -> None:
    name, *options = command
    arguments = [name, contended, *(str(tmp_path / "out") if o == "OUT" else o for o in options)]
    run = mcpn(*arguments)
    assert run.returncode == 1
    said = run.stdout + run.stderr
    for words in (
        "film (objective filming) and photo (objective photos), both in parallel block census,",
        "ask for camera at the same moment",
        'declare camera with shared="true"',
        "MISSION_EV_START",
    ):
        assert words in said, words
    in_json = mcpn(*arguments, "--json")
    assert in_json.returncode == 1
    assert json.loads(in_json.stdout)
    # Names of places and transitions are nothing that a designer knows.
    net = compose(read_mission(contended)).net
    inside = {p.name for p in net.places} | {t.name for t in net.transitions if t.internal}
    for text in (said, in_json.stdout):
        assert "interleaving" not in text
        assert not inside & set(re.findall(r"\w+", text))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("engine", ["explicit", "symbolic"])
def test_other_engines_decide_what_composition_cannot(engine: str, contended: Path) -> None:
    found = output("check", contended, "--engine", engine, code=1)
    assert found["undecided"] == {}
    assert [name for name in REQUIRED if not found["verdicts"][name]] == ["confluent"]


def test_what_is_not_decided_is_not_said_to_fail(contended: Path) -> None:
    found = output("check", contended, "--engine", "local", code=1)
    assert found["verdicts"].pop("confluent") is False
    assert set(found["verdicts"].values()) == {None}
    assert set(found["undecided"]) == set(found["verdicts"])
    assert all("the mission is not confluent" in reason for reason in found["undecided"].values())
    run = mcpn("check", contended, "--engine", "local")
    assert run.returncode == 1
    fails, undecided = run.stdout.splitlines()[1:3]
    assert fails == "verdicts fail: confluent"
    assert undecided.startswith(
        "not decided: nominal_success, safe, bounded, deadlock_free, success_reachable, "
    )


def test_an_objective_behind_a_gate_asks_last(contended: Path) -> None:
    """With other tries it begins last; of two that have some chance decides again."""
    contended.write_text(CONTENDED.replace('activities="film"', 'activities="film" retries="1"'))
    assert json.loads(mcpn("check", contended, "--json").stdout)["verdicts"]["confluent"] is True
    run = mcpn("simulate", contended, "--nominal")
    (first,) = (line for line in run.stdout.splitlines() if "mission m starts" in line)
    assert first.endswith("film waits")
    both = contended.read_text().replace('activities="photo"', 'activities="photo" retries="1"')
    contended.write_text(both)
    assert mcpn("check", contended).returncode == 1
