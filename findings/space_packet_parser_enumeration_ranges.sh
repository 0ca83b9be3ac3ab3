#!/usr/bin/env bash
# Guess: An Enumeration of XTCE with value 1 and maxValue 5 labels the raw values 1 to 5, and a value outside of ValidRange is told.
# Package: PyPI space-packet-parser 6.2.0
# Seen: The label is that of 1 alone: 3 is an error, "Failed to find the value 3 in enum lookup list". A ValidRange from 0 to 10 lets 50
#   pass without a word, and bitOrder leastSignificantBitFirst is passed by, so that 1 stays 1 and is not 128.
# Source: OMG XTCE 1.2, ValueEnumerationType (maxValue), ValidRange, bitOrder; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q space-packet-parser==6.2.0 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import space_packet_parser

HEADER = {"VERSION": 3, "TYPE": 1, "SECONDARY": 1, "APID": 11, "FLAGS": 2, "COUNT": 14, "LENGTH": 16}


def integer(name, bits, more="", order=""):
    encoding = f'<xtce:IntegerDataEncoding sizeInBits="{bits}" encoding="unsigned"{order}/>'
    return f'<xtce:IntegerParameterType name="{name}" signed="false">{encoding}{more}</xtce:IntegerParameterType>'


RANGE = '<xtce:ValidRange minInclusive="0" maxInclusive="10"/>'
KINDS = {
    "ranged": integer("X_t", 8, RANGE),
    "backwards": integer("X_t", 8, order=' bitOrder="leastSignificantBitFirst"'),
    "labelled": '<xtce:EnumeratedParameterType name="X_t"><xtce:IntegerDataEncoding sizeInBits="8" '
    'encoding="unsigned"/><xtce:EnumerationList><xtce:Enumeration value="0" label="OFF"/>'
    '<xtce:Enumeration value="1" maxValue="5" label="ON"/></xtce:EnumerationList></xtce:EnumeratedParameterType>',
}


def read(kind, raw):
    types = "".join(integer(f"{name}_t", bits) for name, bits in HEADER.items()) + KINDS[kind]
    names = [*HEADER, "X"]
    parameters = "".join(f'<xtce:Parameter name="{name}" parameterTypeRef="{name}_t"/>' for name in names)
    entries = "".join(f'<xtce:ParameterRefEntry parameterRef="{name}"/>' for name in names)
    with open("packets.xml", "w") as file:
        file.write(
            '<xtce:SpaceSystem name="s" xmlns:xtce="http://www.omg.org/spec/XTCE/20180204"><xtce:TelemetryMetaData>'
            f"<xtce:ParameterTypeSet>{types}</xtce:ParameterTypeSet><xtce:ParameterSet>{parameters}</xtce:ParameterSet>"
            f'<xtce:ContainerSet><xtce:SequenceContainer name="CCSDSPacket"><xtce:EntryList>{entries}</xtce:EntryList>'
            "</xtce:SequenceContainer></xtce:ContainerSet></xtce:TelemetryMetaData></xtce:SpaceSystem>"
        )
    packet = bytes([0, 1, 0xC0, 0, 0, 0, raw])
    try:
        return space_packet_parser.load_xtce("packets.xml").parse_bytes(packet)["X"]
    except ValueError as error:
        return str(error).split(" in ")[0]


found = [read("labelled", raw) for raw in (0, 1, 3)] + [read("ranged", 50), read("backwards", 1)]
print(*found, sep=", ")
assert found == ["OFF", "ON", "Failed to find the value 3", 50, 1], "the behaviour has changed"
PYTHON
