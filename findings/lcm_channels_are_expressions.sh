#!/usr/bin/env bash
# Guess: subscribe("a+b") of LCM hears the channel of that name; a pattern a|b, where patterns are taken, hears a and b.
# Package: PyPI lcm 1.5.3
# Seen: Names are regular expressions: a+b hears aab and not a+b, robot.pose hears robotXpose, too. They are anchored by
#   a ^ and a $ around the text, which bind more tightly than |: depth|pose hears depth2 and xpose, (depth|pose) does not.
# Source: https://lcm-proj.github.io/lcm (lcm_subscribe: a GLib regular expression); lcm.c; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q lcm==1.5.3 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
from lcm import LCM

bus = LCM("memq://")


def heard(pattern, *channels):
    seen = []
    subscription = bus.subscribe(pattern, lambda channel, data: seen.append(channel))
    for channel in channels:
        bus.publish(channel, b"x")
        bus.handle_timeout(50)
    bus.unsubscribe(subscription)
    print(pattern, "hears", seen)
    return seen


assert heard("a+b", "a+b", "aab") == ["aab"], "the behaviour has changed"
assert heard("robot.pose", "robot.pose", "robotXpose", "robot.pose2") == ["robot.pose", "robotXpose"], (
    "the behaviour has changed"
)
names = ("depth", "pose", "depth2", "xpose")
assert heard("depth|pose", *names) == list(names), "the behaviour has changed"
assert heard("(depth|pose)", *names) == ["depth", "pose"], "the behaviour has changed"
PYTHON
