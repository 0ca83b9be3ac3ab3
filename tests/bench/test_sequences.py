"""Sequences of events on drawn missions: beside the runtime, and beside a plain search of its places."""

from __future__ import annotations

from hypothesis import given

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError
from mcpn.mission.model import Mission
from mcpn.robot.bench.controller_places import Places
from mcpn.robot.bench.runs import edge_of
from mcpn.robot.bench.sequences import sequences
from mcpn.robot.runtime import Controller
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.testing import missions
from tests.draws import fewer

DRAWN = missions(hardware=2, objectives=2, sections=3) | missions(
    hardware=2, objectives=2, sections=3, producers=1, late=True
)


def tables_of(mission: Mission) -> Tables | None:
    """The tables of a drawn mission's controller, if it has one."""
    mission_net = compose(mission)
    try:
        return Tables(document(generate(mission_net), mission_net))
    except ConfluenceError:
        return None


@fewer(0.4)
@given(DRAWN)
def test_sequences_are_the_runtime_s_and_take_what_any_run_takes(mission: Mission) -> None:
    tables = tables_of(mission)
    if tables is None:
        return
    found = sequences(tables)
    taken = set()
    for each in found.each:
        controller = Controller(tables, clock=lambda: 0.0)
        for step in each:
            section = controller.section
            if section is not None and step.event in tables.sections[section].number:
                taken.add((section, controller.where.state, step.event))
            assert tuple(map(str, controller.handle(step.event))) == step.actions
            assert controller.outcome == step.outcome
    assert len(taken) == found.edges
    places, every = Places(tables), set()
    open_, known = [places.start], {id(places.start)}
    while open_:
        place = open_.pop()
        for event in place.possible if place.outcome is None else ():
            every.add(edge_of(tables, place, event))
            step_to = places.after(place, event)
            assert step_to is not None
            if id(step_to[0]) not in known:
                known.add(id(step_to[0]))
                open_.append(step_to[0])
    assert taken == every - {None}
