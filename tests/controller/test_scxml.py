"""The SCXML target, run by interpreters that know nothing of mcpn."""

from __future__ import annotations

import json
import random
import re
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from lxml import etree

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import TableController
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files
from mcpn.robot.targets.identifiers import identifiers
from mcpn.robot.targets.scxml import NAMESPACE, event_name
from mcpn.testing import missions
from tests.controller.interpreters import Answers, python_statemachine, qt, qt_rows, scion
from tests.controller.test_timers import TIMED
from tests.controller.traces import Traced, random_events, tour

TIMES = {
    ("OBJ_a_try1_EV_TIMEOUT", "1009ms"),
    ("OBJ_a_try2_EV_TIMEOUT", "1009ms"),
    ("OBJ_b_EV_TIMEOUT", "1717ms"),
    ("OBJ_d_EV_TIMEOUT", "2323ms"),
}
INTERPRETERS = {"Qt": qt, "python-statemachine": python_statemachine, "SCION": scion}


def expected(controller: TableController, traced: Traced, events: list[str]) -> Answers:
    """What the runtime does, in the words of SCXML."""
    sections = identifiers([s.name for s in controller.sections], prefix="section_")
    hardware = identifiers(controller.hardware, prefix="hardware_")
    handlers = (s.names["once"].get(h, h) for s in controller.sections for h in controller.types[s.type].once)
    once = identifiers(dict.fromkeys(handlers), prefix="once_")
    facts = identifiers(sorted(traced.tables.of_facts), prefix="fact_")
    traced.restart()
    found: Answers = []
    for event in events:
        if not event:
            traced.restart()
            continue
        said = traced.line(event).split(" | ")[0].partition(":")[2].strip()
        section, state, gone, outcome, happened = traced.place
        inside = f"{sections[section]}.{state}" if section else outcome or "before"
        regions = {f"{i}.{'out' if name in gone else 'ready'}" for name, i in hardware.items()}
        regions |= {f"{i}.{'happened' if name in happened else 'open'}" for name, i in once.items()}
        values = traced.controller.facts.items()
        true = {said for name, value in values for said in traced.tables.facts[name][value]}
        known_out = gone - traced.controller.unnoticed
        true |= {known for name, known in traced.tables.late.items() if name in known_out}
        regions |= {f"{i}.{'on' if name in true else 'off'}" for name, i in facts.items()}
        found.append((said.split("; ") if said else [], {inside, *regions}))
    return found


def check(name: str, path: Path, controller: TableController, traced: Traced, events: list[str]) -> None:
    answers = INTERPRETERS[name](path, [event_name(event) for event in events])
    assert answers == expected(controller, traced, events)


@pytest.mark.parametrize("name", list(INTERPRETERS))
@pytest.mark.parametrize("form", ["flat", "hierarchical"])
def test_scxml_of_ulysse_does_the_same_in_each_interpreter(
    name: str, form: str, ulysse_net: MissionNet, tmp_path: Path
) -> None:
    controller = generate(ulysse_net, "flat" if form == "flat" else "hierarchical")
    ((file, text),) = files(document(controller, ulysse_net), "scxml").items()
    (tmp_path / file).write_text(text)
    traced = Traced(document(controller, ulysse_net))
    if name != "python-statemachine":
        events, edges = tour(traced)
        assert len(edges) == 1332
        events += random_events(traced, random.Random(1), 500)
    else:  # a hundred times slower
        events = random_events(traced, random.Random(1), 200)
    check(name, tmp_path / file, controller, traced, events)


DRAWN = st.tuples(
    missions(max_objectives=3, max_depth=1, events=1, reasons=3, awkward_names=True)
    | missions(max_objectives=3, max_depth=1, max_sections=6, events=1, facts=2)
    | missions(max_objectives=3, max_depth=1, max_sections=6, faults=1, lasting=True, crashes=True)
    | missions(max_objectives=2, max_depth=1, max_sections=5, late=True, lasting=True, facts=1),
    st.integers(0, 2**32),
    st.booleans(),
)
"""A mission, a seed of events, and whether its controller is flat."""


def answers_as_the_runtime(
    name: str, folder: Path, drawn: tuple[Mission, int, bool], steps: int
) -> Counter[str]:
    """Has an interpreter take random events beside the runtime; says how many, and of how many states."""
    mission, seed, flat = drawn
    mission_net = compose(mission)
    try:
        controller = generate(mission_net, "flat" if flat else "hierarchical", max_states=300)
    except (SemanticsError, LimitError):
        return Counter()
    ((file, text),) = files(document(controller, mission_net), "scxml").items()
    (folder / file).write_text(text)
    traced = Traced(document(controller, mission_net))
    events = random_events(traced, random.Random(seed), steps)
    check(name, folder / file, controller, traced, events)
    return Counter({"events": sum(map(bool, events)), "states": controller.states})


@pytest.mark.long
@settings(
    max_examples=10,
    suppress_health_check=list(HealthCheck),
    deadline=None,
    phases=(Phase.explicit, Phase.reuse, Phase.generate),
)
@given(DRAWN)
def test_any_mission(tmp_path_factory: pytest.TempPathFactory, drawn: tuple[Mission, int, bool]) -> None:
    answers_as_the_runtime("Qt", tmp_path_factory.mktemp("scxml"), drawn, 60)


@pytest.mark.parametrize("form", ["flat", "hierarchical"])
@pytest.mark.parametrize("timed", [False, True])
def test_the_document_is_what_the_recommendation_wants(
    form: str, timed: bool, ulysse_net: MissionNet
) -> None:
    """Each rule that the XML schema of W3C has for the elements used: content, attributes, their types."""
    mission_net = compose(TIMED) if timed else ulysse_net
    controller = generate(mission_net, "flat" if form == "flat" else "hierarchical")
    ((_, text),) = files(document(controller, mission_net), "scxml").items()
    root = etree.fromstring(text.encode())
    children = {
        "scxml": {"parallel"},
        "parallel": {"state"},
        "state": {"state", "final", "transition", "onentry", "onexit"},
        "transition": {"log", "raise"},
        "onentry": {"send"},
        "onexit": {"cancel"},
        "raise": set(),
        "send": set(),
        "cancel": set(),
        "final": set(),
        "log": set(),
    }
    attributes = {
        "scxml": {"version", "datamodel", "initial", "name"},
        "parallel": {"id"},
        "state": {"id", "initial"},
        "transition": {"event", "cond", "target"},
        "final": {"id"},
        "log": {"label", "expr"},
        "onentry": set(),
        "onexit": set(),
        "raise": {"event"},
        "send": {"event", "id", "delay"},
        "cancel": {"sendid"},
    }
    assert (root.get("version"), root.get("datamodel")) == ("1.0", "ecmascript")
    assert re.fullmatch(r"[\w.:-]+", root.get("name") or "", re.A)  # NMTOKEN
    ids = [e.get("id") for e in root.iter("{*}state", "{*}parallel", "{*}final", "{*}send")]
    assert len(ids) == len(set(ids))
    assert all(re.fullmatch(r"[A-Za-z_][\w.-]*", i or "", re.A) for i in ids)  # NCName
    for element in root.iter(etree.Element):
        name = etree.QName(element)
        assert name.namespace == NAMESPACE
        assert {etree.QName(c).localname for c in element.iterchildren(etree.Element)} <= children[
            name.localname
        ]
        assert set(map(str, element.attrib)) <= attributes[name.localname]
        for key in ("target", "initial"):
            assert element.get(key) is None or element.get(key) in ids
        if name.localname == "state" and element.get("initial"):
            assert element.get("initial") in {c.get("id") for c in element.iterdescendants()}
        if name.localname == "transition":
            event = element.get("event")
            assert event is None or re.fullmatch(r"[\w:-]+(\.[\w:-]+)*", event, re.A)  # EventTypes.datatype
            # No descriptor of an event may match another one: none has a dot, a blank or a star.
            assert not set(element.get("event") or "") & set(". *")
            assert element.get("event") or element.get("target")
    heard = {e.get("event") for e in root.iter("{*}transition")}
    sent = {(e.get("id"), e.get("event"), e.get("delay")) for e in root.iter("{*}send")}
    assert {e.get("sendid") for e in root.iter("{*}cancel")} == {name for name, _, _ in sent}
    assert {e.get("event") for e in root.iter("{*}raise", "{*}send")} <= heard
    assert {(late, delay) for _, late, delay in sent} == (TIMES if timed else set())


@pytest.mark.parametrize("form", ["flat", "hierarchical"])
def test_parameters_travel_with_the_selection(form: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    controller = generate(ulysse_net, "flat" if form == "flat" else "hierarchical")
    ((file, text),) = files(document(controller, ulysse_net), "scxml").items()
    (tmp_path / file).write_text(text)
    runtime = Runtime.from_document(document(controller, ulysse_net))
    events = ["MISSION_EV_START", "OBJ_coral_head.manual_moving_EV_FAIL", "OBJ_transect.diving_EV_OK"]
    carried = 0
    for event, (labels, _, said) in zip(
        events, qt_rows(tmp_path / file, [event_name(event) for event in events]), strict=True
    ):
        actions = runtime.handle(event)
        assert labels == [str(action) for action in actions]
        for action, told in zip(actions, said, strict=True):
            wanted = {p.name: {"value": p.value, "unit": p.unit} for p in action.parameters}
            assert (json.loads(told) if told else {}) == wanted
            carried += bool(wanted)
    assert carried


def test_events_whose_names_begin_alike_are_told_apart() -> None:
    assert event_name("OBJ_a.b_EV_OK") == "OBJ_a-b_EV_OK"
