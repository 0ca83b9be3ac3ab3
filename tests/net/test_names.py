"""A mission means the same whatever its elements are called."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.machine import Machine, controller
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.renaming import renamed
from mcpn.mission.validate import find_errors
from mcpn.net.compose import MissionNet, compose
from mcpn.space.alternatives import direct
from mcpn.testing import missions


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
    """The edges of a controller with each activity by its place in the mission."""
    number = {a.name: i for i, a in enumerate(found.mission.activities)}
    ways = {a.name: {w.name: i for i, w in enumerate(a.alternatives)} for a in found.mission.activities}
    return [
        (
            e.source,
            e.target,
            [
                (a.verb, number[a.activity], a.alternative and ways[a.activity][a.alternative])
                for a in e.actions
            ],
        )
        for e in machine.edges
    ]
