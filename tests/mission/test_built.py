"""Missions built in Python: what is wrong is told as it is of files, whoever is given them."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from math import inf, nan
from pathlib import Path
from typing import Any, TypeVar

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from lxml import etree

import mcpn
from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.mission import validate
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Block, Each, Handler, Mission, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.robot import Activity, Alternative, Hardware, Parameter, Robot, Software
from mcpn.mission.static.warnings import find_warnings
from mcpn.mission.writer import write_mission, written
from mcpn.mission.xml import read_mission
from mcpn.report.failures.openpsa import open_psa
from mcpn.testing import missions
from tests.small import activity, hw, mission, robot

ENTRIES: dict[str, Callable[[Mission], object]] = {
    "compose": compose,
    "flatten": flatten,
    "states": lambda m: mcpn.open(m).states(),
    "ctl": lambda m: mcpn.open(m).ctl("EF success"),
    "causes": lambda m: mcpn.open(m).causes(),
    "picture": lambda m: mcpn.open(m).picture(),
    "write_mission": write_mission,
    "find_warnings": find_warnings,
}

GO, LOOK = activity("go", ("h",)), activity("look", ("s",))
SEE = activity("see", ("h",), produces=("s",))
FIRST = Objective(name="first", activities=("go",))


def of(*blocks: Block, more: tuple[Activity, ...] = (), **rest: Any) -> Mission:
    whole = robot(hw("h"), GO, LOOK, SEE, *more, events=("leak",))
    return replace(mission(whole, *(blocks or (FIRST,))), **rest)


def robots(**changed: Any) -> Mission:
    sound = of()
    return replace(sound, robots=(replace(sound.robots[0], **changed),))


def rated(**rates: Any) -> Mission:
    return robots(hardware=(Hardware(name="h", **rates),))


NOTHING: Any = None


def other(value: object) -> Any:
    """A value of a type that the model does not allow where it stands."""
    return value


BAD: dict[str, tuple[Mission, str]] = {
    "unknown activity": (of(replace(FIRST, activities=("fly",))), "first runs fly, which is not declared"),
    "unknown resource": (of(more=(activity("a", ("x",)),)), "consumes x, which is not declared"),
    "unknown product": (robots(activities=(GO, activity("a", (), produces=("x",)))), "a produces x, which"),
    "unknown protocol": (of(Use(name="u", protocol="p")), "u uses the protocol p, which is not declared"),
    "unknown event": (of(handlers=(Handler(event="fire", goto="fail"),)), "m handles the event fire"),
    "an event handled twice": (of(handlers=(Handler(event="leak", goto="fail"),) * 2), "leak twice"),
    "the same block twice": (of(FIRST, FIRST), "block first is declared twice"),
    "the same hardware twice": (robots(hardware=hw("h", "h")), "resource h is declared twice"),
    "the same robot twice": (of(robots=of().robots * 2), "robot r is declared twice"),
    "an activity twice": (of(more=(GO,)), "activity go is declared twice"),
    "a cycle of resources": (
        of(more=(activity("a", ("t",), produces=("u",)), activity("b", ("u",), produces=("t",)))),
        "activities need each other's resources: a -> b -> a",
    ),
    "what an activity makes itself": (
        of(more=(activity("a", ("t",), produces=("t",)),)),
        "activities need each other's resources: a -> a",
    ),
    "a producer started": (of(replace(FIRST, activities=("see",))), "first runs see, which produces s"),
    "two producers": (of(more=(activity("b", (), produces=("s",)),)), "needs exactly one activity"),
    "no producer": (robots(activities=(GO,)), "needs exactly one activity that produces it, found none"),
    "no alternatives": (of(more=(Activity(name="a", alternatives=()),)), "activity a has no alternative"),
    "no activities": (of(replace(FIRST, activities=())), "objective first names no activity"),
    "no blocks": (of(Recursive(name="r", blocks=())), "r has no blocks"),
    "no values": (of(Each(name="e", values=(), blocks=(FIRST,))), "each e names no value"),
    "all optional": (of(Parallel(name="p", blocks=(replace(FIRST, mandatory=False),))), "no mandatory child"),
    "a route to nowhere": (of(replace(FIRST, failure="home")), "failure of first leads to home; expected"),
    "a protocol in itself": (
        of(protocols=(Protocol(name="p", blocks=(Use(name="u", protocol="p"),)),)),
        "protocols use each other: p -> p",
    ),
    "too many rounds": (of(replace(FIRST, repeat=10**9)), "repeat of first is 1000000000, expected"),
    "no rounds": (of(replace(FIRST, repeat=0)), "repeat of first is 0, expected a whole number from 1"),
    "negative retries": (of(replace(FIRST, retries=-1)), "retries of first is -1, expected a whole number"),
    "a rate that is no number": (rated(failure_rate=nan), "failure_rate of h is nan, expected a finite"),
    "an infinite rate": (rated(repair_rate=inf), "repair_rate of h is inf, expected a finite number"),
    "a negative rate": (rated(failure_rate=-1.0), "failure_rate of h is -1, expected a finite number"),
    "no duration": (of(replace(FIRST, duration=nan)), "duration of first is nan, expected a finite"),
    "no probability": (of(replace(FIRST, failure_probability=nan)), "first is nan, expected a number from"),
    "a parameter not declared": (
        of(
            Use(name="u", protocol="p", parameters=(Parameter(name="x", value="1"),)),
            protocols=(Protocol(name="p", blocks=(FIRST,)),),
        ),
        "u overrides the parameter x, which protocol p does not have",
    ),
    # What no file can say.
    "a name that is none": (of(replace(FIRST, name=NOTHING)), "name of Objective is None, expected a text"),
    "a number for a name": (of(replace(FIRST, activities=(NOTHING,))), "activities of Objective first holds"),
    "one name for several": (
        of(replace(FIRST, activities=other("go"))),
        "activities of Objective first is",
    ),
    "a list": (of(blocks=[FIRST]), "blocks of Mission m is a list, expected a tuple of Objective"),
    "no block": (of(NOTHING), "blocks of Mission m holds None, expected a tuple of Objective objects or"),
    "a robot for a block": (of(Robot(name="r")), "blocks of Mission m holds a Robot"),  # type: ignore[arg-type]
    "a text for a rate": (rated(failure_rate="1"), "failure_rate of Hardware h is '1', expected a number"),
    "a huge rate": (rated(failure_rate=10**400), "failure_rate of Hardware h is a huge number, expected"),
    "a number for a truth": (rated(shared=1), "shared of Hardware h is 1, expected True or False"),
    "a truth for a number": (of(replace(FIRST, retries=True)), "retries of Objective first is True"),
    "half a round": (
        of(replace(FIRST, repeat=other(1.5))),
        "repeat of Objective first is 1.5",
    ),
    "a source that is none": (
        of(replace(FIRST, source=other("here"))),
        "source of Objective first is",
    ),
    "a handler that is none": (of(handlers=(NOTHING,)), "handlers of Mission m holds None, expected"),
} | {
    f"the name {name!r}": (robots(hardware=hw("h", name)), f"the name {name!r} is not allowed")
    for name in ('a"b', "a'b", "a\nb", "<a>", "a&b", "", "a b", "1", "a" * 300, "é")
}


@pytest.mark.parametrize("entry", ENTRIES)
@pytest.mark.parametrize("name", BAD)
def test_whoever_is_given_a_bad_mission_tells_the_same(name: str, entry: str) -> None:
    bad, message = BAD[name]
    with pytest.raises(InputError) as told:
        ENTRIES[entry](bad)
    assert message in str(told.value)
    assert all(problem.source is None for problem in told.value.problems)


def test_a_mission_of_these_parts_is_sound() -> None:
    for entry in ENTRIES.values():
        entry(of())


@pytest.mark.parametrize("what", [None, 1, "mission.xml", [of()]])
def test_what_is_no_mission_is_told(what: Any) -> None:
    with pytest.raises(InputError, match=f"expected a mission, found {type(what).__name__}"):
        mcpn.Study(what).causes()


def test_a_mission_is_checked_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    looked: list[str] = []
    checks = validate._Checks.errors

    def counted(self: Any) -> Any:
        looked.append(self.mission.name)
        return checks(self)

    monkeypatch.setattr(validate._Checks, "errors", counted)
    whole = of()
    for entry in ENTRIES.values():
        entry(whole)
    assert looked == ["m"]
    (tmp_path / "m.xml").write_bytes(write_mission(whole))
    read = read_mission(tmp_path / "m.xml")
    for entry in ENTRIES.values():
        entry(read)
    assert looked == ["m", "m"]
    with pytest.raises(InputError):  # a copy is another mission
        compose(replace(read, blocks=()))


def test_a_description_that_no_xml_holds_is_escaped_in_fault_trees() -> None:
    bad = rated(description='a \0 <b> "c"')
    found = compose(bad)
    tree = etree.fromstring(open_psa(found.usage, [("h",)], {}))
    assert 'a \\x00 <b> "c"' in {label.text for label in tree.iter("label")}
    with pytest.raises(InputError, match="mission m cannot be written"):
        write_mission(bad)


Node = TypeVar("Node")
Break = Callable[[Any, Any], Any]


def nodes(within: Any, kind: type[Node]) -> Iterator[Node]:
    """Every element of a kind."""
    if isinstance(within, kind):
        yield within
    for member in members(within):
        yield from nodes(member, kind)


def members(element: Any) -> Iterator[Any]:
    for field in fields(element):
        value = getattr(element, field.name)
        if isinstance(value, tuple):
            yield from (member for member in value if is_dataclass(member))


def put(within: Any, old: Any, new: Any) -> Any:
    """An element with another in the place of one inside, the first that is this very object."""
    if within is old:
        return new
    changed = {}
    for field in fields(within):
        value = getattr(within, field.name)
        if isinstance(value, tuple):
            made = tuple(put(m, old, new) if is_dataclass(m) else m for m in value)
            if any(a is not b for a, b in zip(made, value, strict=True)):
                changed[field.name] = made
    return replace(within, **changed) if changed else within


BREAKS: dict[str, tuple[type, Break]] = {
    "unknown resource": (Alternative, lambda e, m: replace(e, consumes=(*e.consumes, "nothing"))),
    "hardware made": (Activity, lambda e, m: replace(e, produces=(*e.produces, m.hardware[0].name))),
    "consumed twice": (Alternative, lambda e, m: replace(e, consumes=(m.hardware[0].name,) * 2)),
    "hardware twice": (Robot, lambda e, m: replace(e, hardware=(*e.hardware, e.hardware[-1]))),
    "activity twice": (Robot, lambda e, m: replace(e, activities=(*e.activities, e.activities[0]))),
    "software of nobody": (Robot, lambda e, m: replace(e, software=(*e.software, Software(name="nobody_s")))),
    "alternative twice": (Activity, lambda e, m: replace(e, alternatives=e.alternatives[:1] * 2)),
    "needs what it makes": (
        Robot,
        lambda e, m: replace(
            e,
            software=(*e.software, Software(name="own_s")),
            activities=(*e.activities, activity("own_a", ("own_s",), produces=("own_s",))),
        ),
    ),
    "a producer started": (
        Objective,
        lambda e, m: replace(e, activities=tuple(a.name for a in m.activities if a.produces)[:1] or ("no",)),
    ),
    "unknown activity": (Objective, lambda e, m: replace(e, activities=(*e.activities, "nothing"))),
    "duration": (Objective, lambda e, m: replace(e, duration=0.0)),
    "probability": (Objective, lambda e, m: replace(e, failure_probability=2.0)),
    "parameter twice": (Objective, lambda e, m: replace(e, parameters=(Parameter(name="p", value=""),) * 2)),
    "unknown protocol": (Use, lambda e, m: replace(e, protocol="nothing")),
    "unknown parameter": (Use, lambda e, m: replace(e, parameters=(Parameter(name="not_of_it", value=""),))),
    "protocol in itself": (
        Protocol,
        lambda e, m: replace(e, blocks=(*e.blocks, Use(name="again_p", protocol=e.name))),
    ),
    "protocol twice": (Mission, lambda e, m: replace(e, protocols=(*e.protocols, *e.protocols[:1]))),
    "block twice": (Mission, lambda e, m: replace(e, blocks=(*e.blocks, e.blocks[0]))),
    "block called as a route": (Objective, lambda e, m: replace(e, name="succeed")),
    "route to nowhere": (Objective, lambda e, m: replace(e, success="nowhere")),
    "unknown event": (Objective, lambda e, m: replace(e, handlers=(Handler(event="no", goto="fail"),))),
    "unknown target": (Mission, lambda e, m: replace(e, handlers=(Handler(event="no", goto="no"),) * 2)),
    "no rounds": (Objective, lambda e, m: replace(e, repeat=0)),
    "too many tries": (Objective, lambda e, m: replace(e, retries=999_999)),
    "value twice": (Each, lambda e, m: replace(e, values=e.values[:1] * 2)),
    "rate of what cannot fail": (Hardware, lambda e, m: replace(e, faulty=False, failure_rate=1.0)),
    "switch back to nothing": (
        Activity,
        lambda e, m: replace(e, switch_back=True, alternatives=e.alternatives[:1]),
    ),
}
"""By name, what is broken: valid for the schema, so that a file can say it."""
NOT_IN_FILES: dict[str, tuple[type, Break]] = {
    "name": (Objective, lambda e, m: replace(e, name='a"b')),
    "name of hardware": (Hardware, lambda e, m: replace(e, name="<a>\n")),
    "no activities": (Objective, lambda e, m: replace(e, activities=())),
    "no blocks": (Recursive, lambda e, m: replace(e, blocks=())),
    "negative tries": (Objective, lambda e, m: replace(e, retries=-1)),
    "rate": (Hardware, lambda e, m: replace(e, faulty=True, failure_rate=nan)),
    "text for a tuple": (Alternative, lambda e, m: replace(e, consumes="h0")),
    "nothing for a name": (Activity, lambda e, m: replace(e, name=None)),
    "no robots": (Mission, lambda e, m: replace(e, robots=None)),
}


def sentences(error: InputError) -> set[str]:
    """What is told, without the places in a file that sentences themselves name."""
    said = (problem.message for problem in error.problems)
    return {re.sub(r", first declared at .*| \([^()]*:\d+\)$", "", message) for message in said}


def broken(data: st.DataObject, sound: Mission, breaks: dict[str, tuple[type, Break]]) -> Mission:
    kind, change = breaks[data.draw(st.sampled_from(sorted(breaks)), label="broken")]
    found: list[Any] = list(nodes(sound, kind))
    assume(found)
    old = data.draw(st.sampled_from(found), label="where")
    new = change(old, sound)
    assume(new != old)
    return new if old is sound else put(sound, old, new)  # type: ignore[no-any-return]


SOUND = missions(max_sections=5, max_events=1) | missions(text=True, max_sections=5)


@given(SOUND, st.data())
def test_what_is_broken_is_told_as_of_a_file(
    tmp_path_factory: pytest.TempPathFactory, sound: Mission, data: st.DataObject
) -> None:
    bad = broken(data, sound, BREAKS)
    with pytest.raises(InputError) as built:
        compose(bad)
    path = tmp_path_factory.mktemp("broken") / "m.xml"
    path.write_bytes(written(bad))
    with pytest.raises(InputError) as read:
        read_mission(path)
    assert sentences(built.value) == sentences(read.value)


@given(SOUND, st.data())
def test_what_no_file_can_say_is_told_too(sound: Mission, data: st.DataObject) -> None:
    bad = broken(data, sound, NOT_IN_FILES)
    entry = data.draw(st.sampled_from(sorted(ENTRIES)))
    with pytest.raises(InputError):
        ENTRIES[entry](bad)
