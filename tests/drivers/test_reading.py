"""Files of drivers: what is wrong in them is told with its line, all in one go."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.robot.drivers.known import KNOWN, OF_DRIVERS, OPTIONS
from mcpn.robot.drivers.mapping import check_plan
from mcpn.robot.drivers.reading import lines_of, read_drivers
from mcpn.robot.drivers.skeleton import skeleton
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.testing import missions
from tests.commands import mcpn
from tests.draws import composed
from tests.drivers.robots import MISSION, NEVER
from tests.mutation import at_most
from tests.shares import returns_early
from tests.test_linear import SECONDS

GOOD = f"""never = {json.dumps([*NEVER, "called_back"])}
[activities.lidar_driver]
process = ["true"]
ends.other = "lidar_EV_OOS"
[activities.localisation]
nothing = true
[activities.drive]
process = ["true", "{{room}}"]
ends = {{0 = "success", other = "failure"}}
[activities.hand_over]
python = "hand:over"
ends = {{true = "success", other = "failure"}}
"""


def said(folder: Path, text: str) -> list[str]:
    """What ``mcpn run --check`` says is wrong."""
    (folder / "mission.xml").write_text(MISSION)
    (folder / "hand.py").write_text("def over(call):\n    return True\n")
    (folder / "drivers.toml").write_text(text)
    found = mcpn("run", folder / "mission.xml", "--drivers", folder / "drivers.toml", "--check")
    assert (found.returncode == 0) == (found.stderr == "")
    assert found.returncode in (0, 2)
    start = f"error: {folder / 'drivers.toml'}"
    lines = found.stderr.splitlines()
    assert all(line.startswith(start) for line in lines), found.stderr
    return [line.removeprefix(start) for line in lines]


def test_a_good_one(tmp_path: Path) -> None:
    assert said(tmp_path, GOOD) == []


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("never = [", "never = [[", [":2: not valid TOML"]),
        ("[activities.drive]", "[activities.drive", [":7: not valid TOML"]),
        ("[activities.drive]", "[activities.drve]", [
            ":7: the mission's controller has no activity 'drve' (did you mean drive?)",
            ": no driver for activity drive: expected a table [activities.drive]",
            ": no driver reports the event OBJ_home_EV_FAIL",
        ]),
        ("nothing = true", "nothing = false", [":6: nothing: expected true, found False"]),
        ("nothing = true", "noting = true", [
            ":6: found the key 'noting', expected one of process, python, mqtt", ":5: ",
        ]),
        ("nothing = true", "nothing = true\nstop = 'SIGTERM'", [
            ":7: stop: found it of nothing, expected it of process",
        ]),
        ("nothing = true", "nothing = true\nends = {}", [
            ":7: ends: found it of nothing, expected it of process or python",
        ]),
        ("nothing = true", "nothing = true\npython = 'a:b'", [":5: activities.localisation: expected one"]),
        ("nothing = true", "nothing = true\ngrace = -1", [":7: grace: expected seconds, from 0 to 86400"]),
        ('["true"]', '["true"]\nstop = "SIGHURRY"', [":4: stop: expected the name of a signal"]),
        ('["true"]', "[1]", [":3: process: expected a list of texts, found [1]"]),
        ('["true"]', "[]", [":3: process: expected a command and its arguments"]),
        ('["true"]', '["no such program"]', [":2: process: no program 'no such program' is found"]),
        ('["true"]', '["true", "{room}"]', [":2: {room}: lidar_driver has no such parameter"]),
        ('["true"]', '["true", "{objective}"]', [":2: {objective}: lidar_driver has no such parameter"]),
        ('ends.other = "lidar_EV_OOS"', 'ends.other = "success"', [
            ": no driver reports the event lidar_EV_OOS: name it in one, or in never",
            ":4: success: activities.lidar_driver belongs to no objective",
        ]),
        ('ends.other = "lidar_EV_OOS"', 'ends.other = "lidar_EV_OS"', [
            ": no driver reports",
            ":4: 'lidar_EV_OS' is no event of the mission's controller (did you mean lidar_EV_OOS?)",
        ]),
        ('0 = "success"', '0 = "OBJ_travel_EV_OK"', [": no driver reports the event OBJ_home_EV_OK"]),
        ('{0 = "success"', '{0 = 5', [":9: ends.0: expected a text, found 5"]),
        ('{0 = "success"', '{zero = "success"', [
            ":9: ends: expected an exit status, other or not_started, found zero",
        ]),
        ("{true", "{raised", []),
        ('"hand:over"', '"hand"', [":11: python: expected 'module:function', found 'hand'"]),
        ('"hand:over"', '"hand:under"', [":10: hand:under: AttributeError"]),
        ('"hand:over"', '"no_hands:over"', [":10: no_hands:over: ModuleNotFoundError"]),
        ("called_back", "calledback", [
            ": no driver reports the event called_back",
            ":1: never: 'calledback' is no event",
        ]),
        ("[activities.hand", "[release.wings]\nnothing = true\n[activities.hand", [
            ":10: the mission's controller has no hardware 'wings'",
        ]),
        ("nothing = true", "nothing = true\nalternatives.by_gps.nothing = true", [
            ":7: the mission's controller has no alternative of localisation 'by_gps'",
        ]),
        ("[activities.hand", "[mqtt]\nport = 70000\nhosts = 'a'\n[activities.hand", [
            ":11: port: expected 0 to 65535, found 70000",
            ":12: found the key 'hosts', expected one of host, port, keepalive, qos, version,",
        ]),
        ("[activities.hand", "[sources.x]\nmqtt = {say = 'a'}\n[activities.hand", [
            ":11: mqtt: expected some of start, stop, says, found say",
        ]),
        ("[activities.hand", "[sources.x]\nnothing = true\nlines = {'(' = 'called_back'}\n[activities.hand", [
            ":12: lines: found '(', wrong at column 1, expected a regular expression of Python",
            ":12: lines: found it of nothing, expected it of process or python or mqtt or zenoh",
        ]),
        ("[activities.hand", "[sources.x]\nprocess = ['true', '{room}']\n[activities.hand", [
            ":10: {room}: sources.x belongs to no activity",
        ]),
    ],
)  # fmt: skip
def test_what_is_wrong_is_told(tmp_path: Path, old: str, new: str, expected: list[str]) -> None:
    assert GOOD.count(old) == 1
    found = said(tmp_path, GOOD.replace(old, new))
    if expected or not found:
        assert len(found) >= len(expected)
    for message in expected:
        assert any(line.startswith(message) for line in found), found
    if not expected:
        assert found == []


WHOLE = """never = []
[activities.drive]
process = ["true"]
lines = {}
[activities.look.alternatives.far]
mqtt = {start = "a"}
[activities.look.alternatives.near]
zenoh = {says = "a"}
[sources.clock]
python = "a:b"
[release.wheels]
nothing = true
[mqtt]
port = 1
[zenoh]
multicast = true
"""


@given(data=st.data())
def test_a_key_that_no_table_declares_is_refused_everywhere(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    known = {
        *KNOWN,
        *OF_DRIVERS,
        *(key for of in OPTIONS.values() for key in of),
        "start",
        "says",
        "alternatives",
    }
    key = data.draw(st.from_regex(r"[a-z_]{3,8}", fullmatch=True).filter(lambda key: key not in known))
    lines = WHOLE.splitlines()
    number = data.draw(st.integers(0, len(lines) - 1))
    if lines[number].startswith("["):
        lines.insert(number + 1, f"{key} = 1")
    elif "{" in lines[number] and "lines" not in lines[number]:
        lines[number] = lines[number].replace("}", f', {key} = "b"}}')
    else:
        lines.insert(number, f"{key} = 1")
    path = tmp_path_factory.mktemp("unknown") / "drivers.toml"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=rf"drivers\.toml:\d+: .*{key}.*") as caught:
        read_drivers(path)
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert problem.source.line is not None
    assert key in lines[problem.source.line - 1]
    assert "found" in problem.message
    assert "expected" in problem.message


def test_no_word_of_the_parser_reaches_a_person(tmp_path: Path) -> None:
    path = tmp_path / "drivers.toml"
    wrong = [
        "a",
        "a =",
        "= 1",
        "a = 'x",
        'a = "x',
        "a = [1",
        "a = {b = 1",
        "a = 1\na = 2",
        "[a]\n[a]",
        "[a",
        "[[a]",
    ]
    wrong += [
        "a = 1 2",
        'a = "\\q"',
        "a = 2020-13-01",
        "a = {b = 1, b = 2}",
        "a = {b = 1}\na.c = 1",
        "a = \x01",
        "\x00",
    ]
    wrong += ['a = "\\ud800"', "a = 1" + "0" * 5000, "a = " + "[" * 5000, "a = 'x\ny'"]
    for text in wrong:
        path.write_text(text)
        with pytest.raises(InputError, match=r"not valid TOML: .*(found|limit)") as caught:
            read_drivers(path)
        said = str(caught.value)
        assert "expected" in said or "limit was hit" in said
        for word in ("Invalid", "Expected", "Cannot", "Un", "at line", "document", "namespace", "statement"):
            assert word not in said, said


def test_an_alternative_of_its_own_keeps_what_its_activity_says(tmp_path: Path) -> None:
    own = "[activities.localisation.alternatives.by_odometry]\npython = 'hand:over'"
    text = GOOD.replace("nothing = true", f"process = ['true']\ngrace = 3\n{own}")
    assert said(tmp_path, text) == []
    plan = read_drivers(tmp_path / "drivers.toml")
    one, other = (plan.driver("localisation", way) for way in ("by_odometry", "by_scan"))
    assert one is not None
    assert other is not None
    assert (one.kind, one.function, one.grace) == ("python", "hand:over", 3.0)
    assert (other.kind, other.command, other.grace) == ("process", ("true",), 3.0)


def test_what_the_mission_has_no_use_for_may_be_there(tmp_path: Path) -> None:
    """One file of drivers serves all missions of a robot."""
    (tmp_path / "mission.xml").write_text(
        MISSION.replace('<activity name="hand', '<activity name="dance"/>\n    <activity name="hand')
    )
    (tmp_path / "hand.py").write_text("def over(call):\n    return True\n")
    more = '[activities.dance]\nprocess = ["true", "{tune}", "{objective}"]\nends.other = "failure"\n'
    (tmp_path / "drivers.toml").write_text(GOOD + more)
    found = mcpn("run", tmp_path / "mission.xml", "--drivers", tmp_path / "drivers.toml", "--check")
    assert found.returncode == 0, found.stderr


KEYS = st.lists(st.sampled_from("abc"), min_size=1, max_size=3).map(tuple)
VALUES = st.sampled_from(["1", '"#"', "'''\n[a]\n'''", "[\n 1,\n # c\n 2]", "{x = 1}", '"""\\\n x = 1"""'])


@given(st.lists(st.tuples(KEYS, st.booleans(), VALUES, st.sampled_from(["", "\n", "# c\n"])), max_size=6))
def test_lines_are_those_of_the_keys(rows: list[tuple[tuple[str, ...], bool, str, str]]) -> None:
    """By construction: each value is written with a name of its own, and its line counted."""
    text, expected, head = "", {}, tuple[str, ...]()
    for number, (keys, begins, value, after) in enumerate(rows):
        if begins:
            head = (*keys, f"t{number}")
            expected[head] = text.count("\n") + 1
            text += f"[{'.'.join(head)}]\n"
        place = (*head, *keys, f"k{number}")
        expected[place] = text.count("\n") + 1
        text += f"{'.'.join(place[len(head) :])} = {value}\n{after}"
    found = lines_of(text)
    assert {place: found[place] for place in expected} == expected


@given(st.binary(max_size=200) | st.text("[]{}='\"#a.1\n,", max_size=60).map(str.encode))
def test_any_bytes_are_read_or_refused_with_a_place(data: bytes) -> None:
    with tempfile.NamedTemporaryFile() as file:
        file.write(data)
        file.flush()
        try:
            plan = read_drivers(Path(file.name))
        except InputError as error:
            problems = error.problems
        else:
            problems = ()
            assert plan.specs == () or b"true" in data
    assert all(problem.source is not None for problem in problems)


DIGITS = "9" * 4_300


@pytest.mark.parametrize(
    ("added", "expected"),
    [
        (f"grace = {DIGITS}", ":7: grace: expected seconds, from 0 to 86400, found 999"),
        ("grace = 1e400", ":7: grace: expected seconds, from 0 to 86400, found inf"),
        (f"grace = {DIGITS}9", ": not valid TOML: "),
        (
            f"grace = 0x{DIGITS}",
            ":7: grace: expected seconds, from 0 to 86400, found a number of too many digits",
        ),
        (f"[mqtt]\nport = {DIGITS}", ":8: port: expected 0 to 65535, found 999"),
        (f"[mqtt]\nport = 0x{DIGITS}", ":8: port: expected 0 to 65535, found a number of too many digits"),
        (f"[mqtt]\nhost = [{DIGITS}]", ":8: host: expected a text, found [999"),
    ],
)
def test_numbers_of_many_digits(tmp_path: Path, added: str, expected: str) -> None:
    """They ended in an internal error."""
    before, nothing, behind = GOOD.partition("nothing = true\n")
    (line,) = said(tmp_path, f"{before}{nothing}{added}\n{behind}")
    assert line.startswith(expected)
    assert len(line) < 300


def test_long_lists_are_read_in_linear_time(tmp_path: Path) -> None:
    """A list of 3,000 lines was read once for each of them."""
    long = "never = [\n" + '"lidar_EV_OOS", # [\n' * 30_000 + "]\nmisspelt = 1\n"
    (tmp_path / "drivers.toml").write_text(long)
    with at_most(SECONDS), pytest.raises(InputError, match=":30003: found the key 'misspelt'"):
        read_drivers(tmp_path / "drivers.toml")


def test_statements_of_several_lines(tmp_path: Path) -> None:
    texts = ('"""[\n\\"""]"""""', "'''{\n''''", '"#["', "'\\'", "[ # ]\n[],\n]", "{a = [\n]}")
    text = "".join(f"k{number} = {value}\n" for number, value in enumerate(texts))
    found = lines_of(f"[x]\n{text}[x.y]\nlast = 1\n")
    assert [found["x", f"k{number}"] for number in range(len(texts))] == [2, 4, 6, 7, 8, 11]
    assert (found["x", "y"], found["x", "y", "last"]) == (13, 14)


@pytest.mark.parametrize("name", ["bigint.toml", "list3000.toml"])
def test_files_that_were_slow_or_ended_badly(faults: Path, name: str) -> None:
    with at_most(SECONDS):
        found = mcpn("run", faults / "robot/mission.xml", "--drivers", faults / "robot" / name, "--check")
    assert found.returncode == 2
    assert "internal error" not in found.stderr
    assert "sys." not in found.stderr


@pytest.mark.parametrize(
    ("text", "value", "expected"),
    [
        ('process = ["{room}"]', "true", "a value of the mission would be part of the program that is run"),
        ('process = ["sh", "-c", "echo {room}"]', "$(date)", "would be part of a program's text"),
        ('process = ["/bin/bash", "-euc", "echo {room}"]', "a", "give it as an argument of its own"),
        ('process = ["env", "A=b", "dash", "-c", "echo {room}"]', "a", "would be part of a program's text"),
        ('process = ["{python}", "-c", "print({room})"]', "a", "would be part of a program's text"),
        ('process = ["true", "{room}"]', "--version", "'--version' would be an option of the program"),
        ('process = ["true", "--room={room}"]', "--version", None),
        ('mqtt = { start = "robot/{room}" }', "#", "'robot/#' would add a wildcard"),
        ('mqtt = { start = "robot/{room}" }', "a/+/b", "'robot/a/+/b' would add a wildcard"),
        ('zenoh = { says = "robot/{room}" }', "**", "'robot/**' would add a wildcard"),
        ('mqtt = { start = "robot/{room}", says = "robot/+/{room}" }', "12", None),
    ],
)
def test_values_of_a_mission_are_values(text: str, value: str, expected: str | None, tmp_path: Path) -> None:
    """No value of a parameter becomes an option of a command, or more than one topic."""
    (tmp_path / "mission.xml").write_text(MISSION.replace('value="12"', f'value="{value}"'))
    (tmp_path / "hand.py").write_text("def over(call):\n    return True\n")
    ends = "" if text.startswith("process") else 'lines = { "done" = "success", "no" = "failure" }'
    drivers = GOOD.replace('process = ["true", "{room}"]', f"{text}\n{ends}")
    if ends:
        drivers = drivers.replace('ends = {0 = "success", other = "failure"}\n', "")
    (tmp_path / "drivers.toml").write_text(drivers)
    found = mcpn("run", tmp_path / "mission.xml", "--drivers", tmp_path / "drivers.toml", "--check")
    assert found.returncode == (0 if expected is None else 2), found.stderr
    assert expected is None or expected in found.stderr


def test_a_skeleton_lacks_nothing_but_programs(tmp_path: Path) -> None:
    """Once these are there, the mission runs with it as it is, to its end; a value is no option of theirs."""
    (tmp_path / "mission.xml").write_text(MISSION.replace('"base"', '"-1.5"'))
    drivers = tmp_path / "drivers.toml"
    arguments = ["run", tmp_path / "mission.xml", "--drivers", drivers]
    assert mcpn(*arguments, "--init").stdout == f"{drivers}\n"
    activities = ("lidar_driver", "localisation", "drive", "hand_over")
    lacks = mcpn(*arguments, "--check").stderr.splitlines()
    assert len(lacks) == len(activities)
    assert all(any(f"no program './{name}' is found" in line for line in lacks) for name in activities)
    for name in activities:
        wait = "exec sleep 1000" if name in ("lidar_driver", "localisation") else f'echo "$@" > {name}.told'
        (tmp_path / name).write_text(f"#!/bin/sh\n{wait}\n")
        (tmp_path / name).chmod(0o755)
    found = mcpn(*arguments)
    assert (found.returncode, found.stderr) == (0, "")
    assert "success" in found.stdout
    assert (tmp_path / "drive.told").read_text() == "--room=-1.5\n"
    assert "is not overwritten" in mcpn(*arguments, "--init").stderr


@given(missions(max_events=1))
def test_a_skeleton_of_any_mission_is_read(mission: Mission) -> None:
    """All that is said of it is which programs are not there."""
    found = composed(mission)
    try:
        tables = Tables(document(generate(found, max_states=2000), found))
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "drivers.toml"
        file.write_text(skeleton(tables))
        with pytest.raises(InputError) as wrong:
            check_plan(read_drivers(file), tables)
    assert all("no program './" in problem.message for problem in wrong.value.problems)
