"""``mcpn run`` over messages: a robot behind a real broker (mosquitto), and in a session of zenoh."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from pathlib import Path
from socket import SHUT_RDWR, create_server
from typing import Any
from unittest.mock import patch

import pytest

from mcpn.errors import InputError
from mcpn.robot.drivers.reading import read_drivers
from mcpn.robot.drivers.topics import Mqtt, Zenoh
from tests.commands import mcpn, output
from tests.drivers.robots import MISSION, NEVER, until
from tests.drivers.runs import free_port


def drivers(kind: str, options: str) -> str:
    """Each activity behind topics of its own; what they say is behind the number of the start."""
    topics = ", ".join(
        f'{key} = "robot/{{activity}}/{text}"'
        for key, text in (("start", "start"), ("stop", "stop"), ("says", "{run}/result"))
    )
    ends = 'lines = {"done.*" = "success", "failed" = "failure"}'
    return f"""
never = {json.dumps([*NEVER, "called_back"])}
[{kind}]
{options}
[activities.lidar_driver]
{kind} = {{ {topics} }}
[activities.localisation]
{kind} = {{ {topics} }}
[activities.drive]
{kind} = {{ {topics} }}
{ends}
[activities.hand_over]
{kind} = {{ {topics} }}
{ends}
[sources.health]
{kind} = {{ says = "robot/health" }}
lines = {{ "lidar lost" = "lidar_EV_OOS" }}
"""


class Robot:
    """What it is told, and what it answers: its lidar fails once it drives, then it arrives.

    Args:
        publish: Sends a message.
    """

    def __init__(self, publish: Callable[[str, str], object]) -> None:
        self.publish = publish
        self.told: list[tuple[str, str, str]] = []
        self.runs: set[str] = set()

    def hear(self, topic: str, text: str) -> None:
        """Takes one message."""
        _, activity, verb = topic.split("/")
        message = json.loads(text)
        assert message["activity"] == activity
        self.told.append((verb, activity, message["alternative"]))
        (self.runs.add if verb == "start" else self.runs.discard)(activity)
        if verb == "stop":
            return
        result = f"robot/{activity}/{message['run']}/result"
        if activity == "drive" and message["parameters"] == {"room": "12"}:
            self.publish("robot/health", "lidar lost")
        elif activity == "localisation" and message["alternative"] == "by_odometry":
            drives = f"robot/drive/{message['run'] - 1}/result"
            self.publish(drives, "nothing that ends it")
            self.publish(drives, "done, at 12")
        elif activity in ("drive", "hand_over"):
            self.publish(result, "done")


def ran(folder: Path, robot: Robot, in_order: bool = True) -> None:
    """The mission succeeds without its lidar, and the robot is told so, perhaps in another order."""
    kept = list if in_order else sorted
    (folder / "mission.xml").write_text(MISSION)
    arguments = ["run", folder / "mission.xml", "--drivers", folder / "drivers.toml"]
    said = output(*arguments, "--journal", folder / "log.jsonl")
    assert (said["outcome"], said["refused"]) == ("success", 0)
    events = [json.loads(line)["event"] for line in (folder / "log.jsonl").read_text().splitlines()]
    assert events[:3] == ["MISSION_EV_START", "lidar_EV_OOS", "OBJ_travel_EV_OK"]
    until(lambda: not robot.runs, 10)
    assert kept(robot.told[:6]) == kept(
        [
            ("start", "lidar_driver", "lidar_driver"),
            ("start", "localisation", "by_scan"),
            ("start", "drive", "drive"),
            ("stop", "lidar_driver", "lidar_driver"),
            ("stop", "localisation", "by_scan"),
            ("start", "localisation", "by_odometry"),
        ]
    )
    assert [told for told in robot.told if told[1] == "hand_over"] == [
        ("start", "hand_over", "hand_over"),
        ("stop", "hand_over", "hand_over"),
    ]


def test_over_mqtt(broker: int, tmp_path: Path) -> None:
    pytest.importorskip("paho.mqtt", reason="needs mcpn[mqtt]")
    from paho.mqtt import client as paho
    from paho.mqtt.enums import CallbackAPIVersion

    client = paho.Client(CallbackAPIVersion.VERSION2)
    robot = Robot(lambda topic, text: client.publish(topic, text, 1))
    ready = threading.Event()
    client.on_message = lambda _client, _data, message: robot.hear(message.topic, message.payload.decode())
    client.on_subscribe = lambda *_: ready.set()
    client.connect("127.0.0.1", broker)
    client.subscribe([("robot/+/start", 1), ("robot/+/stop", 1)])
    client.loop_start()
    assert ready.wait(20)
    (tmp_path / "drivers.toml").write_text(drivers("mqtt", f'host = "127.0.0.1"\nport = {broker}'))
    try:
        ran(tmp_path, robot)
    finally:
        client.disconnect()
        client.loop_stop()


@pytest.mark.parametrize(
    ("version", "qos", "expected"),
    [
        (5, 1, ["retained", "retained", "lidar lost", "lidar back"]),  # at least once: unacknowledged
        (5, 2, ["retained", "lidar lost", "lidar back"]),
        (3, 1, ["retained", "retained", "lidar back"]),
    ],
)
def test_what_is_told_while_a_connection_is_lost(
    version: int, qos: int, expected: list[str], broker: int, tmp_path: Path
) -> None:
    """It is heard over MQTT 5, and by QoS 2 what is retained once; before that, it is lost."""
    pytest.importorskip("paho.mqtt", reason="needs mcpn[mqtt]")
    from paho.mqtt import publish

    options = f'host = "127.0.0.1"\nport = {broker}\nqos = {qos}\nversion = {version}'
    (tmp_path / "drivers.toml").write_text(drivers("mqtt", options))
    bus, heard, lost = Mqtt(read_drivers(tmp_path / "drivers.toml")), list[str](), threading.Event()

    def tell(text: str, retain: bool = False) -> None:
        publish.single("robot/health", text, qos, retain, "127.0.0.1", broker)

    def hear(text: str) -> None:
        heard.append(text)
        lost.wait(60)  # the client acknowledges when this returns, when it cannot

    tell("retained", retain=True)
    bus.subscribe("robot/health", hear)
    until(lambda: heard == ["retained"])
    client: Any = bus._client
    client.on_disconnect = lambda *_: tell("lidar lost")  # it connects again when this returns
    client.socket().shutdown(SHUT_RDWR)
    lost.set()
    until(lambda: len(heard) >= len(expected) - 1)
    client.on_disconnect = None
    tell("lidar back")
    until(lambda: len(heard) >= len(expected))
    assert heard == expected
    bus.close()


def test_a_broker_without_mqtt_5_is_told_how_to_reach(tmp_path: Path) -> None:
    """It answers as MQTT 3.1.1 has it: the version of the protocol is refused."""
    pytest.importorskip("paho.mqtt", reason="needs mcpn[mqtt]")
    with create_server(("127.0.0.1", 0)) as server:

        def answer() -> None:
            with server.accept()[0] as client:
                client.recv(1000)
                client.sendall(b"\x20\x02\x00\x01")

        threading.Thread(target=answer, daemon=True).start()
        port = server.getsockname()[1]
        (tmp_path / "drivers.toml").write_text(drivers("mqtt", f'host = "127.0.0.1"\nport = {port}'))
        with pytest.raises(InputError, match="of a broker without MQTT 5 say version = 3"):
            Mqtt(read_drivers(tmp_path / "drivers.toml"))


@pytest.mark.parametrize("version", ["4", "31", "true", '"5"'])
def test_a_version_of_mqtt_that_is_not_known(version: str, tmp_path: Path) -> None:
    (tmp_path / "drivers.toml").write_text(drivers("mqtt", f"version = {version}"))
    with pytest.raises(InputError, match=r"drivers\.toml:4: version: expected .*, found"):
        read_drivers(tmp_path / "drivers.toml")


def test_over_zenoh(tmp_path: Path) -> None:
    zenoh = pytest.importorskip("zenoh", reason="needs mcpn[zenoh]")
    config, port = zenoh.Config(), free_port()
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/127.0.0.1:{port}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    with zenoh.open(config) as session:
        robot = Robot(session.put)

        def hear(sample: Any) -> None:
            robot.hear(str(sample.key_expr), sample.payload.to_bytes().decode())

        heard = [session.declare_subscriber(f"robot/*/{verb}", hear) for verb in ("start", "stop")]
        (tmp_path / "drivers.toml").write_text(
            drivers("zenoh", f'mode = "client"\nconnect = ["tcp/127.0.0.1:{port}"]')
        )
        ran(tmp_path, robot, in_order=False)
        for each in heard:
            each.undeclare()


def test_without_a_broker_it_is_said_where(tmp_path: Path) -> None:
    pytest.importorskip("paho.mqtt", reason="needs mcpn[mqtt]")
    (tmp_path / "mission.xml").write_text(MISSION)
    (tmp_path / "drivers.toml").write_text(drivers("mqtt", f'host = "127.0.0.1"\nport = {free_port()}'))
    found = mcpn("run", tmp_path / "mission.xml", "--drivers", tmp_path / "drivers.toml")
    assert found.returncode == 2
    assert "drivers.toml:3: no connection to the broker 127.0.0.1:" in found.stderr


@pytest.mark.parametrize(("said", "looks"), [("", "false"), ("multicast = true", "true")])
def test_peers_are_looked_for_by_multicast_only_where_that_is_asked_for(
    said: str, looks: str, tmp_path: Path
) -> None:
    zenoh = pytest.importorskip("zenoh", reason="needs mcpn[zenoh]")
    (tmp_path / "drivers.toml").write_text(f"[zenoh]\n{said}\n")
    plan, opened = read_drivers(tmp_path / "drivers.toml"), list[Any]()
    with patch.object(zenoh, "open", opened.append):
        Zenoh(plan)
    assert opened[0].get_json("scouting/multicast/enabled") == looks
