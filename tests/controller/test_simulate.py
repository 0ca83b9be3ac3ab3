"""The simulator: computed by the net, in words of a person, from a prompt, a pipe, a file or at random."""

from __future__ import annotations

import json
import os
import pty
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from hypothesis import given
from hypothesis import strategies as st

from mcpn.cli.line import command_line
from mcpn.controller.simulator import Simulation, resources
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, InputError, LimitError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.conftest import ULYSSE
from tests.controller.oracle import NetRobot


def simulate(*arguments: object, typed: str = "") -> Result:
    return CliRunner().invoke(command_line, ["simulate", str(ULYSSE), *map(str, arguments)], input=typed)


def shown(*arguments: object, typed: str = "") -> str:
    result = simulate(*arguments, typed=typed)
    assert result.exit_code == 0, result.output
    assert "--json" in arguments or all(len(line) <= 80 for line in result.stdout.splitlines())
    assert "\x1b" not in result.stdout
    return result.stdout


def test_events_by_number_name_and_beginning() -> None:
    by_number = shown(typed="4\n1\n")
    by_name = shown(typed="MISSION_EV_START\nGPS_sensor_EV_OOS\n")
    by_beginning = shown(typed="M\nG\n")
    tails = [
        [line for line in text.splitlines() if not line.startswith(">")] for text in (by_number, by_name)
    ]
    assert tails[0] == tails[1] == [line for line in by_beginning.splitlines() if not line.startswith(">")]
    assert "localisation changes from gps_localisation to" in by_number
    assert "  stop      gps_driver\n  release   GPS_sensor\n" in by_number
    assert "GPS_sensor out of service; IMU_sensor used by imu_driver" in by_number


def test_a_person_at_a_prompt_has_completion_and_may_err() -> None:
    pytest.importorskip("readline")
    leader, follower = pty.openpty()
    command = [sys.executable, "-m", "mcpn.cli", "simulate", str(ULYSSE)]
    environment = {**os.environ, "TERM": "dumb"}
    session = subprocess.Popen(
        command, stdin=follower, stdout=follower, stderr=follower, env=environment, start_new_session=True
    )
    os.close(follower)
    told = ""

    def until(wanted: str) -> None:
        nonlocal told
        while wanted not in told:
            told += os.read(leader, 65536).decode()
        told = told.partition(wanted)[2]

    try:
        until("help shows what else")
        until("\r\n> ")
        os.write(leader, b"MISS\t\n")
        until("MISSION_EV_START")
        until("  start     gps_driver")
        until("\r\n> ")
        os.write(leader, b"fly\n")  # said, and the session goes on
        until("expected a possible event")
        until("\r\n> ")
        os.write(leader, b"goto c\t\n")
        until("> thruster_actuator_EV_OOS")
        until("\r\n> ")
        os.write(leader, b"quit\n")
        assert session.wait(timeout=60) == 0
    finally:
        session.kill()
        session.wait()
        os.close(leader)


def test_undo_goto_run_and_restart() -> None:
    text = shown(typed="goto success\nrun\nundo\nrestart\ngoto failure\n")
    assert "the mission ends in success" in text
    assert "    MISSION_EV_START\n" in text
    assert "taken back: OBJ_transect.going_up_EV_OK" in text
    assert text.rstrip().splitlines()[-5] == "the mission has ended in failure"


def test_goto_cut_set() -> None:
    text = shown(typed="M\ngoto cut set\n")
    assert "> thruster_actuator_EV_OOS" in text
    assert "manual_moving has no way to run" in text
    text = shown(typed="M\ngoto cut set GPS_sensor IMU_sensor\nhelp\n")
    assert "no way for  manual_moving" in text
    assert "goto cut set A B" in text


@pytest.mark.parametrize(
    ("typed", "told"),
    [
        ("7\n", "expected one from 1 to 4"),
        ("M\nOBJ\n", "is the beginning of several"),
        ("fly\n", "expected a possible event"),
        ("fly away\n", "expected an event or a command"),
        ("undo\n", "nothing to undo"),
        ("goto heaven\n", "expected success, failure, abort or cut set"),
        ("goto cut set no_such_sensor\n", "expected hardware in service"),
        ("²\n", "expected a possible event"),
        ("goto success\ngoto success\n", "the mission has ended"),
        ("goto success\ngoto cut set\n", "the mission has ended"),
        ("M\ngoto cut set\ngoto cut set\n", "success is ruled out already"),
    ],
)
def test_what_is_wrong_in_a_pipe_is_an_error(typed: str, told: str) -> None:
    result = simulate(typed=typed)
    assert isinstance(result.exception, InputError)
    assert "standard input:" in str(result.exception)
    assert told in str(result.exception)


def test_what_check_prints_is_replayed(tmp_path: Path) -> None:
    for command in ("check", "causes"):
        printed = CliRunner().invoke(command_line, [command, str(ULYSSE)]).stdout.splitlines()
        heading = next(
            i for i, line in enumerate(printed) if "nominal_success" in line or "a run with the loss" in line
        )
        run = [printed[heading].split("  ")[0].rstrip(":") + ":"]
        for line in printed[heading + 1 :]:
            if not re.match(r" +\d+\. ", line):
                break
            run.append(line)
        told = [re.fullmatch(r" +\d+\. (.*)  \[(\S+)\]", line) for line in run[1:]]
        path = tmp_path / "run.txt"
        path.write_text("\n".join(["# a comment", "", *run]) + "\n")
        said = json.loads(shown("--events", path, "--json"))
        assert [step["event"] for step in said["steps"]] == [step and step[2] for step in told]
        assert said["outcome"] == ("success" if command == "check" else "failure")
        # What changes, in words, is what the other command said of its own graph.
        assert [step["words"] for step in said["steps"]] == [step and step[1] for step in told]


def test_events_as_json(tmp_path: Path) -> None:
    path = tmp_path / "run.json"
    path.write_text('["MISSION_EV_START", "GPS_sensor_EV_OOS"]')
    said = json.loads(shown("--events", path, "--json"))
    assert said["steps"][-1]["mode"]["localisation"] == "imu_localisation"
    assert said["steps"][-1]["actions"][0] == {"do": "stop", "activity": "gps_driver"}
    assert said["steps"][-1]["out_of_service"] == ["GPS_sensor"]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("MISSION_EV_START\nGPS_sensor_EV_RD\n", ":2: found GPS_sensor_EV_RD, which is not possible here"),
        ("hello\n", ":1: found hello, which is not possible here; expected one of"),
        ("hello there\n", ":1: found 'hello', expected an event"),
        ("[1]", "expected a JSON list of events"),
        ('["a"', "no JSON"),
        ("\xff", "expected text in UTF-8"),
    ],
)
def test_files_that_hold_no_run_are_told(text: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "run.txt"
    path.write_bytes(text.encode("latin-1"))
    result = simulate("--events", path)
    assert isinstance(result.exception, InputError)
    assert told in str(result.exception)
    assert str(path) in str(result.exception)


def test_what_can_only_fail_is_told() -> None:
    told = shown(typed="MISSION_EV_START\nthruster_actuator_EV_OOS\n")
    assert "; coral_head.manual_moving cannot succeed now" in " ".join(told.split())
    # Filming needs no thruster.
    events = "MISSION_EV_START\nOBJ_coral_head.manual_moving_EV_FAIL\nOBJ_transect.diving_EV_OK\n"
    told = " ".join(shown(typed=f"{events}thruster_actuator_EV_OOS\n").split())
    assert "; transect.advancing cannot succeed now" in told


def test_random_walks_are_repeatable() -> None:
    one = shown("--random", 30, "--seed", 5)
    assert one == shown("--random", 30, "--seed", 5)
    assert one != shown("--random", 30, "--seed", 6)


@given(missions(max_objectives=3, max_depth=2), st.integers(0, 2**32))
def test_it_does_what_the_net_does(mission: Mission, seed: int) -> None:
    mission_net = compose(mission)
    try:
        direct(mission_net.net, max_states=3000)
    except (ConfluenceError, LimitError):
        return
    rng = random.Random(seed)
    robot, simulation = NetRobot(mission_net, rng), Simulation(mission_net)
    names = {h.name for h in mission_net.core.hardware}
    for _ in range(40):
        assert sorted(map(str, simulation.possible)) == sorted(robot.possible)
        assert simulation.situation.mode == robot.mode
        told = dict(resources(mission_net, simulation.situation))
        assert names <= told.keys()
        if not robot.possible:
            break
        event = rng.choice(sorted(robot.possible))
        change = simulation.take(Event.parse(event))
        assert change is not None
        parts = ((a.verb, a.activity or a.hardware, a.alternative) for a in change.actions)
        actions = sorted(tuple(part for part in action if part is not None) for action in parts)
        assert actions == robot.handle(event)


def test_undo_leads_back_through_every_state(ulysse_net: MissionNet) -> None:
    simulation = Simulation(ulysse_net)
    rng = random.Random(3)
    states = [simulation.marking]
    for _ in range(50):
        simulation.take(rng.choice(simulation.possible))
        states.append(simulation.marking)
    for state in reversed(states[:-1]):
        assert simulation.undo() is not None
        assert simulation.marking == state
    assert simulation.undo() is None
    assert simulation.take(Event.parse("no_such_EV_OOS")) is None


def test_searches_are_bounded(ulysse_net: MissionNet) -> None:
    with pytest.raises(LimitError, match="limit was hit"):
        Simulation(ulysse_net, max_states=2).way_to("failure")
