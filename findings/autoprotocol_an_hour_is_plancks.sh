#!/usr/bin/env bash
# Guess: "1:h" in a protocol for a laboratory is an hour, as "1:min" is a minute and "1:s" a second; or a duration that is no time is
#   refused.
# Package: PyPI autoprotocol 10.3.0 (with pint 0.9)
# Seen: "1:h" is one of Planck's constants. An incubation of that is taken and written into the protocol as "1:h". "1:hour" is an
#   hour. A temperature cannot be converted: Unit("20:celsius").to("kelvin") is a TypeError of decimals and floats.
# Source: pint's table of units (h is the constant); Autoprotocol's specification, which writes hour; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q autoprotocol==10.3.0 'setuptools<81' 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python -W ignore - <<'PYTHON'
from autoprotocol.protocol import Protocol
from autoprotocol.unit import Unit

kinds = {text: str(Unit(text).dimensionality) for text in ("1:s", "1:min", "1:h", "1:hour")}
protocol = Protocol()
protocol.incubate(protocol.ref("plate", None, "96-flat", discard=True), "warm_37", "1:h")
written = protocol.instructions[-1].data["duration"]
try:
    kelvin = str(Unit("20:celsius").to("kelvin"))
except TypeError as error:
    kelvin = type(error).__name__
print(kinds, written, kelvin)
assert kinds.pop("1:h") == "[length] ** 2 * [mass] / [time]" and set(kinds.values()) == {"[time]"}, "the behaviour has changed"
assert str(written) == "1:h" and kelvin == "TypeError", "the behaviour has changed"
PYTHON
