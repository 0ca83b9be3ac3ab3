#!/usr/bin/env bash
# Guess: take() of a reader of Cyclone DDS gives all samples that have come since the last one.
# Package: PyPI cyclonedds 11.0.1
# Seen: One, whatever the history: its argument N is 1 by default. And of three samples written with the default quality of
#   service only the last is there, since a topic keeps one; the two before are lost without a word. With KeepAll
#   and Reliable they are there, one for each take().
# Source: cyclonedds/sub.py, read and take (N=1); OMG DDS 1.4, HISTORY is KEEP_LAST of depth 1 by default; found by running it
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv venv
venv/bin/pip install -q cyclonedds==11.0.1 2>pip.log || { cat pip.log; exit 1; }
venv/bin/python - <<'PYTHON'
import os
import time
from dataclasses import dataclass

loopback = '<Interfaces><NetworkInterface name="lo"/></Interfaces>'
os.environ["CYCLONEDDS_URI"] = f"<CycloneDDS><Domain><General>{loopback}</General></Domain></CycloneDDS>"

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic


@dataclass
class Command(IdlStruct):
    number: int


def taken(name, qos, times):
    participant = DomainParticipant(0)
    topic = Topic(participant, name, Command, qos=qos)
    reader, writer = DataReader(participant, topic, qos=qos), DataWriter(participant, topic, qos=qos)
    for number in range(3):
        writer.write(Command(number))
    time.sleep(0.5)
    return [[sample.number for sample in reader.take()] for _ in range(times)]


every = Qos(Policy.History.KeepAll, Policy.Reliability.Reliable(1_000_000_000))
found = taken("plain", None, 2), taken("every", every, 4)
print(*found)
assert found == ([[2], []], [[0], [1], [2], []]), "the behaviour has changed"
PYTHON
