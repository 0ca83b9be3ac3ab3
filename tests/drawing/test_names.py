"""A mission means the same whatever its elements are called."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.machine import Machine, PlannedAction, controller
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.sections import section_part
from mcpn.drawing.templates.net_names import NetNames
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.validate import find_errors
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from mcpn.testing.awkward_names import renamed


def twins(draw: st.DataObject, **bounds: int | bool) -> tuple[Mission, Mission]:
    """A mission with awkward names, and the same with numbers for names."""
    awkward = draw.draw(missions(None, awkward_names=True, **bounds))
    numbers: dict[tuple[str, str], str] = {}
    plain = renamed(awkward, lambda kind, name: numbers.setdefault((kind, name), f"{kind}{len(numbers)}x"))
    return awkward, plain


@given(st.data())
def test_nets_differ_in_names_alone(data: st.DataObject) -> None:
    awkward, plain = twins(data)
    assert not find_errors(awkward)
    assert not find_errors(plain)
    one, other = compose(awkward), compose(plain)
    assert len(one.net.place_index) == len(one.net.places)
    assert len(one.net.transition_index) == len(one.net.transitions)
    assert one.net.initial == other.net.initial
    assert [(t.consume, t.produce, t.read) for t in one.net.transitions] == [
        (t.consume, t.produce, t.read) for t in other.net.transitions
    ]
    assert [t.event and t.event.what for t in one.net.transitions] == [
        t.event and t.event.what for t in other.net.transitions
    ]
    assert {p: kind for p, (kind, _) in one.roles.items()} == {
        p: kind for p, (kind, _) in other.roles.items()
    }


@given(st.data())
def test_controllers_do_the_same(data: st.DataObject) -> None:
    awkward, plain = (compose(m) for m in twins(data, max_objectives=2, max_depth=1))
    try:
        machines = [controller(found, direct(found.net, max_states=1000)) for found in (awkward, plain)]
    except (LimitError, SemanticsError):
        return
    assert numbered(awkward, machines[0]) == numbered(plain, machines[1])


def numbered(found: MissionNet, machine: Machine) -> list[tuple[object, ...]]:
    """The edges of a controller with each element by its place in the mission."""
    activities = {a.name: i for i, a in enumerate(found.core.activities)}
    ways = {(a.name, w.name): i for a in found.core.activities for i, w in enumerate(a.alternatives)}
    hardware = {h.name: i for i, h in enumerate(found.core.hardware)}
    objectives = {section.name: i for i, section in enumerate(found.graph.walk())}

    def told(action: PlannedAction) -> tuple[object, ...]:
        return (
            action.verb,
            activities.get(action.activity or ""),
            ways.get((action.activity or "", action.alternative or "")),
            hardware.get(action.hardware or ""),
            objectives.get(action.objective or ""),
        )

    return [(e.source, e.target, e.event.what, [told(a) for a in e.actions]) for e in machine.edges]


@given(missions(awkward_names=True))
def test_parts_are_called_as_in_the_whole(mission: Mission) -> None:
    whole = compose(mission)
    for section in whole.graph.sections:
        part = local_net(section_part(whole.usage, section))
        for one in part.net.places:
            place = whole.net.places[whole.net.place_index[one.name]]
            assert place.provenance == one.provenance
        assert {t.name for t in part.net.transitions} <= whole.net.transition_index.keys()


def test_what_may_coincide_is_written_with_its_kind() -> None:
    elements = [("hardware", "camera"), ("software", "a"), ("software", "b"), ("software", "a_b")]
    elements += [("activity", "camera"), ("activity", "film"), ("activity", "film_err1")]
    elements += [("objective", "x"), ("objective", "x_ok"), ("objective", "OBJ_x")]
    names = NetNames(elements)
    assert names.of("hardware", "camera", "error") == "camera_error"
    assert names.of("activity", "camera", "error") == "activity:camera:error"
    assert names.of("activity", "film", "wait1") == "film_wait1"
    assert names.of("activity", "film", "err2", "a") == "film_err2_a"
    assert names.of("activity", "film", "err2", "a", "b") == "activity:film:err2:a:b"
    assert names.of("activity", "film", "err2", "a_b") == "activity:film:err2:a_b"
    assert names.of("activity", "film", "err1", "a") == "activity:film:err1:a"
    assert names.of("activity", "film_err1", "a") == "film_err1_a"
    assert names.of("objective", "x") == "OBJ_x"
    assert names.of("objective", "x", "ok") == "objective:x:ok"
    assert names.of("objective", "x", "fail") == "OBJ_x_fail"
    assert names.of("objective", "x_ok") == "OBJ_x_ok"
