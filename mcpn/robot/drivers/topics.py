"""Drivers that are reached by messages, MQTT (paho-mqtt) or zenoh (eclipse-zenoh), and their connections."""

from __future__ import annotations

import asyncio
import json
import logging
import secrets
import threading
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

from mcpn.errors import InputError, LimitError, Source
from mcpn.robot.drivers.mapping import Plan, Topics

SECONDS = 10.0
"""How long a connection, a subscription and the last message may take."""
KEPT = 3600
"""Seconds for which a broker keeps events of a connection that is lost."""

_log = logging.getLogger("mcpn.robot.drivers")


class Bus(Protocol):
    """What carries messages."""

    def publish(self, topic: str, text: str) -> None:
        """Sends a message."""

    def subscribe(self, topic: str, heard: Callable[[str], None]) -> Callable[[], None]:
        """Has a function called with each message, on a thread of its own.

        Returns:
            Ends it.
        """

    def close(self) -> None:
        """Ends the connection, when what was published is sent."""


class Mqtt:
    """A connection to a broker, by MQTT 5: what is told while it is lost arrives when it is there again.

    Args:
        plan: Its options are those of ``[mqtt]``.

    Raises:
        InputError: The broker does not answer, or refuses.
    """

    def __init__(self, plan: Plan) -> None:
        try:
            from paho.mqtt import client as paho
            from paho.mqtt.enums import CallbackAPIVersion
            from paho.mqtt.packettypes import PacketTypes
            from paho.mqtt.properties import Properties
            from paho.mqtt.subscribeoptions import SubscribeOptions
        except ImportError as error:
            raise LimitError("drivers by MQTT need paho-mqtt: pip install 'mcpn[mqtt]'") from error
        said = plan.mqtt
        host, port = str(said.get("host", "localhost")), int(said.get("port", 1883))
        self._qos = int(said.get("qos", 1))
        self._five = int(said.get("version", 5)) == 5
        self._heard: dict[str, list[Callable[[str], None]]] = {}
        self._lock = threading.Lock()
        self._answered, self._why = threading.Event(), "no answer"
        self._confirmed: dict[int | None, threading.Event] = {}
        self._last: Any = None
        # A session is found again by the client's name; one that the broker gives is another each time.
        name, protocol = f"mcpn-{secrets.token_hex(8)}", paho.MQTTv5 if self._five else paho.MQTTv311
        self._client = paho.Client(CallbackAPIVersion.VERSION2, name, protocol=protocol)
        properties_of: Any = Properties  # which has no types
        self._session = properties_of(PacketTypes.CONNECT)
        self._over = properties_of(PacketTypes.DISCONNECT)
        self._session.SessionExpiryInterval, self._over.SessionExpiryInterval = KEPT, 0
        # What is retained was heard, where the broker still has the subscription.
        options = SubscribeOptions(self._qos, retainHandling=SubscribeOptions.RETAIN_SEND_IF_NEW_SUB)
        self._how: dict[str, Any] = {"options": options} if self._five else {"qos": self._qos}
        if "username" in said:
            self._client.username_pw_set(str(said["username"]), str(said.get("password", "")))
        self._client.on_connect = self._connected
        self._client.on_message = self._message
        self._client.on_subscribe = self._subscribed
        try:
            properties = self._session if self._five else None
            self._client.connect(host, port, int(said.get("keepalive", 60)), properties=properties)
            self._client.loop_start()
            if not self._answered.wait(SECONDS) or self._why:
                self._client.loop_stop()
                raise OSError(self._why)
        except (OSError, ValueError) as error:
            at = Source(str(plan.file), plan.line(("mqtt",)))
            older = "; of a broker without MQTT 5 say version = 3" if "protocol" in str(error) else ""
            raise InputError.at(at, f"no connection to the broker {host}:{port}: {error}{older}") from None

    def _connected(self, _client: Any, _data: Any, _flags: Any, reason: Any, _properties: Any) -> None:
        self._why = str(reason) if reason.is_failure else ""
        self._answered.set()
        with self._lock:
            for topic in self._heard:  # the connection was lost and is there again
                self._client.subscribe(topic, **self._how)

    def _subscribed(self, _client: Any, _data: Any, mid: int, _reasons: Any, _properties: Any) -> None:
        with self._lock:
            self._confirmed.setdefault(mid, threading.Event()).set()

    def _message(self, client: Any, _data: Any, message: Any) -> None:
        from paho.mqtt.client import topic_matches_sub

        text = message.payload.decode(errors="replace")
        with self._lock:
            matching = [
                some for topic, some in self._heard.items() if topic_matches_sub(topic, message.topic)
            ]
            heard = [each for some in matching for each in some]
        for each in heard:
            each(text)

    def publish(self, topic: str, text: str) -> None:
        """Sends a message, which waits while the connection is lost."""
        self._last = self._client.publish(topic, text, self._qos)

    def subscribe(self, topic: str, heard: Callable[[str], None]) -> Callable[[], None]:
        """Hears a topic from when the broker has confirmed it."""
        with self._lock:
            first = topic not in self._heard
            self._heard.setdefault(topic, []).append(heard)
        if first:
            _, mid = self._client.subscribe(topic, **self._how)
            with self._lock:
                confirmed = self._confirmed.setdefault(mid, threading.Event())
            confirmed.wait(SECONDS)
            with self._lock:
                self._confirmed.pop(mid, None)

        def end() -> None:
            with self._lock:
                self._heard[topic].remove(heard)
                last = not self._heard[topic]
                if last:
                    del self._heard[topic]
            if last:
                self._client.unsubscribe(topic)

        return end

    def close(self) -> None:
        """Ends the connection, when what was published is sent."""
        if self._last is not None and self._client.is_connected():
            self._last.wait_for_publish(SECONDS)
        self._client.disconnect(properties=self._over if self._five else None)
        self._client.loop_stop()


_ZENOH = {"mode": "mode", "multicast": "scouting/multicast/enabled"}
"""Keys of ``[zenoh]`` that are no endpoints, by their names in zenoh's own configuration."""


class Zenoh:
    """A session of zenoh.

    Args:
        plan: Its options are those of ``[zenoh]``.

    Raises:
        InputError: It cannot be opened.
    """

    def __init__(self, plan: Plan) -> None:
        try:
            import zenoh
        except ImportError as error:
            raise LimitError("drivers by zenoh need eclipse-zenoh: pip install 'mcpn[zenoh]'") from error
        try:
            config = zenoh.Config()
            for key, value in ({"multicast": False} | dict(plan.zenoh)).items():
                config.insert_json5(_ZENOH.get(key, f"{key}/endpoints"), json.dumps(value))
            self._session: Any = zenoh.open(config)
        except Exception as error:  # zenoh.ZError, which is no narrower
            at = Source(str(plan.file), plan.line(("zenoh",)))
            raise InputError.at(at, f"no session of zenoh: {error}") from None

    def publish(self, topic: str, text: str) -> None:
        """Sends a message."""
        self._session.put(topic, text)

    def subscribe(self, topic: str, heard: Callable[[str], None]) -> Callable[[], None]:
        """Hears a key expression."""
        subscriber = self._session.declare_subscriber(
            topic, lambda sample: heard(sample.payload.to_bytes().decode(errors="replace"))
        )
        return lambda: subscriber.undeclare()

    def close(self) -> None:
        """Ends the session."""
        self._session.close()


class StopMessage(NamedTuple):
    """What tells something behind a broker to stop.

    Args:
        kind: What carries it.
        topic: Where it is published.
        text: What is.
    """

    kind: str
    topic: str
    text: str


def tell_to_stop(buses: Mapping[str, Bus], message: StopMessage) -> None:
    """Tells to stop what a run before has begun."""
    try:
        buses[message.kind].publish(message.topic, message.text)
    except Exception as error:  # of what carries messages; the others are to be told all the same
        _log.error("%s: what the previous run began cannot be told to stop: %r", message.topic, error)


def buses_of(plan: Plan) -> dict[str, Bus]:
    """The connections that a file of drivers needs, by kind.

    Raises:
        InputError: One cannot be made.
        LimitError: What it needs is not installed.
    """
    kinds = {spec.kind for spec in plan.specs}
    found: dict[str, Bus] = {}
    if "mqtt" in kinds:
        found["mqtt"] = Mqtt(plan)
    if "zenoh" in kinds:
        found["zenoh"] = Zenoh(plan)
    return found


class TopicDriver:
    """One run of a driver that is reached by messages.

    Args:
        bus: What carries them.
        topics: Where to publish that it starts and that it stops, and what to subscribe to while it runs.
        text: What is published, at the start and at the stop.
        said: Told each message.
    """

    def __init__(self, bus: Bus, topics: Topics, text: str, said: Callable[[str], None]) -> None:
        self._bus, self._topics = bus, topics
        self._text, self._said = text, said
        self._end: Callable[[], None] | None = None

    async def start(self) -> None:
        """Subscribes, then publishes that it starts."""
        if self._topics.says is not None:
            self._end = await asyncio.to_thread(self._bus.subscribe, self._topics.says, self._said)
        if self._topics.start is not None:
            self._bus.publish(self._topics.start, self._text)

    def kill(self) -> None:
        """Nobody can be killed by a message."""

    async def stop(self, _grace: float) -> bool:
        """Publishes that it stops; nobody says when it has."""
        if self._end is not None:
            await asyncio.to_thread(self._end)
        if self._topics.stop is not None:
            self._bus.publish(self._topics.stop, self._text)
        return True
