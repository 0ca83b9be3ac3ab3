#!/usr/bin/env bash
# Guess: a client that subscribes to r/x gets the message retained for r/x, once, and one that subscribes to nothing gets none.
# Package: PyPI amqtt 0.12.1 (its broker), with paho-mqtt 2.1.0 as the clients
# Seen: Whoever connects is sent what is retained for the filters of all clients, before it subscribes to anything. With one
#   other client on r/x the second hears r/x without a subscription, and twice once it has subscribed to r/x itself.
# Source: MQTT 3.1.1, 3.3.1.3 (retained messages go to matching subscriptions); amqtt/broker.py, which goes through the
#   subscriptions of all sessions behind the comment on a session that is not new; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q amqtt==0.12.1 paho-mqtt==2.1.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import asyncio
import logging
import socket
import threading
import time

import paho.mqtt.client as mqtt
from amqtt.broker import Broker

logging.disable(logging.CRITICAL)
with socket.socket() as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
ready, done = threading.Event(), threading.Event()


async def serve():
    anonymous = {"amqtt.plugins.authentication.AnonymousAuthPlugin": {"allow_anonymous": True}}
    broker = Broker({"listeners": {"default": {"type": "tcp", "bind": f"127.0.0.1:{port}"}}, "plugins": anonymous})
    await broker.start()
    ready.set()
    while not done.is_set():
        await asyncio.sleep(0.1)
    await broker.shutdown()


server = threading.Thread(target=lambda: asyncio.run(serve()), daemon=True)
server.start()
ready.wait(10)


def client(name, *filters):
    made = mqtt.Client(mqtt.CallbackAPIVersion.VERSION2, client_id=name)
    made.heard = []
    made.on_message = lambda one, _, message: one.heard.append(message.topic)
    made.connect("127.0.0.1", port)
    made.loop_start()
    time.sleep(0.7)
    for text in filters:
        made.subscribe(text, 0)
    time.sleep(0.7)
    return made


robot = client("robot")
for topic in ("r/x", "r/y"):
    robot.publish(topic, b"1", qos=1, retain=True).wait_for_publish(5)
first, silent, second = client("first", "r/x"), client("silent"), client("second", "r/x")
print("first:", first.heard, "without a subscription:", silent.heard, "second:", second.heard)
assert first.heard == ["r/x"], "the behaviour has changed"
assert silent.heard == ["r/x"], "the behaviour has changed"
assert second.heard == ["r/x", "r/x"], "the behaviour has changed"
for one in (robot, first, silent, second):
    one.disconnect()
    one.loop_stop()
done.set()
server.join(10)
PYTHON
