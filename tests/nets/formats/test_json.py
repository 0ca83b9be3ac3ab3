"""The JSON of nets: exact round trips, and every expectation told with the way to the value."""

from __future__ import annotations

import copy
import json
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import InputError, Source
from mcpn.events import Event
from mcpn.nets.formats.json import read_json, write_json
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.provenance import Provenance
from mcpn.report.documents import FORMATS, json_schema
from tests.nets.nets import odd_nets

HERE = Path("n.json")


@given(net=odd_nets(line_breaks=True))
def test_written_nets_are_read_back_equal(net: PetriNet) -> None:
    assert read_json(HERE, write_json(net).encode()) == net


def small() -> PetriNet:
    builder = NetBuilder("n", priorities=True)
    origin = Provenance("activity", "a", Source("robot.xml", 7))
    builder.place("p", initial=1, provenance=origin)
    builder.place("q", provenance=Provenance("mission", "m"))
    builder.transition("t", consume={"p": 2}, read=["q"], event=Event.parse("EV"), provenance=origin)
    builder.unit(["p", "q"])
    return builder.build()


def test_the_document_is_as_documented() -> None:
    assert json.loads(write_json(small())) == {
        "format": "mcpn-net",
        "version": 1,
        "name": "n",
        "priorities": True,
        "places": [
            {
                "name": "p",
                "initial": 1,
                "from": {"kind": "activity", "name": "a", "file": "robot.xml", "line": 7},
            },
            {
                "name": "q",
                "initial": 0,
                "from": {"kind": "mission", "name": "m", "file": None, "line": None},
            },
        ],
        "transitions": [
            {
                "name": "t",
                "event": "EV",
                "consume": {"p": 2},
                "produce": {},
                "read": {"q": 1},
                "from": {"kind": "activity", "name": "a", "file": "robot.xml", "line": 7},
            }
        ],
        "units": [["p", "q"]],
    }


def test_provenance_and_units_are_kept() -> None:
    back = read_json(HERE, write_json(small()).encode())
    assert back.units == ((0, 1),)
    assert back.places[0].provenance == Provenance("activity", "a")
    assert back.transitions[0].provenance is not None
    assert back.transitions[0].provenance.source == Source("robot.xml", 7)
    assert back.places[1].provenance is not None
    assert back.places[1].provenance.source is None


def broken(*way: str | int, value: Any) -> bytes:
    document = json.loads(write_json(small()))
    target = document
    for step in way[:-1]:
        target = target[step]
    target[way[-1]] = value
    return json.dumps(document).encode()


BROKEN = {
    "places[0].initial: found -1": broken("places", 0, "initial", value=-1),
    "places[1].initial: found 1.5": broken("places", 1, "initial", value=1.5),
    "places[1].initial: found true": broken("places", 1, "initial", value=True),
    'found "extra", expected one of the keys format, version': broken("extra", value=1),
    'places[1]: found "capacity", expected one of the keys name, initial': broken(
        "places", 1, "capacity", value=1
    ),
    'transitions[0]: found "inhibit"': broken("transitions", 0, "inhibit", value={"q": 1}),
    'places[0].from: found "column"': broken("places", 0, "from", "column", value=1),
    "places[0].label: found 1, expected a text": broken("places", 0, "label", value=1),
    "places[0].name: found null": broken("places", 0, "name", value=None),
    "places: found {}, expected a list": broken("places", value={}),
    "places[0]: found 3, expected an object": broken("places", 0, value=3),
    "transitions[0].consume.p: found 0": broken("transitions", 0, "consume", value={"p": 0}),
    'transitions[0].read: found ["p"], expected an object': broken("transitions", 0, "read", value=["p"]),
    "transitions[0].event: found 1": broken("transitions", 0, "event", value=1),
    'transitions[0]: found ["name"], expected the key event': broken("transitions", 0, value={"name": "t"}),
    'transitions[0].produce: found "z", expected the name of a place': broken(
        "transitions", 0, "produce", value={"z": 1}
    ),
    'units[0]: found "z", expected the name of a place': broken("units", 0, value=["z"]),
    'places[1].name: found "p", expected a name that no other place has': broken(
        "places", 1, "name", value="p"
    ),
    'priorities: found "yes", expected true or false': broken("priorities", value="yes"),
    "places[0].from.line: found 0": broken("places", 0, "from", "line", value=0),
    "places[0].from.kind: found 1": broken("places", 0, "from", "kind", value=1),
    "version: found 2, expected 1": broken("version", value=2),
    "found [], expected the key format": b"{}",
    'found ["format", "version"], expected the key name': b'{"format": "mcpn-net", "version": 1}',
    "found the key 'a' twice in an object": b'{"a": 1, "a": 2}',
    "expected an object": b"[]",
    "n.json:2: not JSON: found the key 'b' twice in an object, expected": b'{"a":\n{"b": 1, "b": 2}}',
    'transitions[0].event: found "", expected a name': broken("transitions", 0, "event", value=""),
    "transitions[0].rank: found -1, expected an integer from 0": broken("transitions", 0, "rank", value=-1),
    "transitions[0].rank: found 1, expected none: events come after all ranks": broken(
        "transitions", 0, "rank", value=1
    ),
    "transitions[0].rank: found 2, expected none: the net has no priorities": json.dumps(
        {
            **json.loads(write_json(small())),
            "priorities": False,
            "transitions": [{**json.loads(write_json(small()))["transitions"][0], "event": None, "rank": 2}],
        }
    ).encode(),
    "version: found true, expected 1": broken("version", value=True),
    "n.json:2: not JSON: column 6: found '}', expected a value": b'{\n"a": }',
    "not JSON: column 10: found 'oops', expected the end of the file": b'{"a": 1} oops',
    "not JSON: column 2: found 'a:', expected a key in double quotes": b"{a: 1}",
    "not JSON: column 2: found the end of the file, expected a value": b"[",
    "n.json:2: not JSON: found bytes that are not UTF-8": b'\n"\xff"',
    "not JSON: found lists or objects too deep in each other": b"[" * 100_000,
    "not JSON: found a number of more digits, expected at most 4000": b"9" * 10_000,
}


@pytest.mark.parametrize("message", BROKEN)
def test_broken_documents_are_told(message: str) -> None:
    with pytest.raises(InputError) as caught:
        read_json(HERE, BROKEN[message])
    assert message in str(caught.value)
    assert str(caught.value).startswith("n.json")


@pytest.mark.parametrize(
    ("begin", "way", "key"),
    [
        ('"format"', (), "other"),
        ('"name": "q"', ("places", 1), "capacity"),
        ('"name": "t"', ("transitions", 0), "inhibit"),
        ('"file": "robot.xml"', ("places", 0, "from"), "column"),
    ],
)
def test_the_line_is_that_of_the_object(begin: str, way: tuple[str | int, ...], key: str) -> None:
    data = json.dumps(json.loads(broken(*way, key, value=0)), indent=1).encode()
    lines = data.decode().splitlines()
    where = next(number for number, line in enumerate(lines, 1) if begin in line)
    opening = max(number for number, line in enumerate(lines[:where], 1) if line.rstrip().endswith("{"))
    with pytest.raises(InputError) as caught:
        read_json(HERE, data)
    assert str(caught.value).startswith(f"n.json:{opening}: ")
    assert f'found "{key}", expected one of the keys' in str(caught.value)


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "utf-32"])
def test_an_error_has_its_line_in_any_encoding_of_json(encoding: str) -> None:
    text = broken("places", 0, value={"extra": 1}).replace(b'[{"e', b'[\n{"e').decode()
    with pytest.raises(InputError, match=r"n\.json:2: places\[0\]: found \[.extra"):
        read_json(HERE, text.encode(encoding))


def test_an_error_in_a_deep_document_is_told() -> None:
    deep = b'{"format": "mcpn-net", "version": 1, "extra": ' + b"[" * 900 + b"]" * 900 + b"}"
    with pytest.raises(InputError, match=r"expected the key name|too deep"):
        read_json(HERE, deep)


def test_what_the_schema_allows_is_read() -> None:
    """Places of unknown origin, and numbers of any size: JSON has no largest integer."""
    document = json.loads(write_json(small()))
    del document["places"][0]["from"]["file"], document["places"][0]["from"]["line"]
    document["places"][1] = {"name": "q", "initial": 10**30, "label": None}
    document["transitions"][0]["consume"] = {"p": 10**19}
    document["transitions"][0]["label"] = "take off"
    jsonschema.Draft202012Validator(json_schema(FORMATS["net"])).validate(document)
    net = read_json(HERE, json.dumps(document).encode())
    assert net.places[0].provenance == Provenance("activity", "a")
    assert net.initial == (1, 10**30)
    assert net.transitions[0].consume == ((0, 10**19),)
    assert net.transitions[0].label == "take off"
    again = read_json(HERE, write_json(net).encode())
    assert (again, again.transitions[0].label) == (net, "take off")


@given(data=st.data())
def test_no_document_is_a_traceback(data: st.DataObject) -> None:
    document: Any = copy.deepcopy(json.loads(write_json(small())))
    values = st.recursive(
        st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=3),
        lambda inner: st.lists(inner, max_size=2) | st.dictionaries(st.text(max_size=3), inner, max_size=2),
        max_leaves=4,
    )
    target = document
    while True:
        keys = sorted(target) if isinstance(target, dict) else list(range(len(target)))
        key = data.draw(st.sampled_from(keys))
        if isinstance(target[key], dict | list) and target[key] and data.draw(st.booleans()):
            target = target[key]
            continue
        target[key] = data.draw(values)
        break
    sources = [Source("n.json")]
    try:
        read_json(HERE, json.dumps(document).encode())
    except InputError as error:
        sources = [problem.source for problem in error.problems if problem.source]
    assert [source.file for source in sources] == ["n.json"]
