"""Fault trees: read back, held against their grammar, and solved by expansion from the top (MOCUS)."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from lxml import etree

from mcpn.answers.causes.minimal_cut_sets import CutSet, Moment
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.report.failures.openpsa import open_psa
from mcpn.spaces.stable.alternatives import direct
from mcpn.testing import missions
from tests.draws import fewer
from tests.logic.asked import Asked
from tests.logic.oracle import coming_home, fragile_missions, minimal
from tests.shares import returns_early
from tests.small import activity, hw, robot
from tests.small import mission as small

# The fault tree layer of the Open-PSA grammar, as far as coherent trees with the laws of rates need it.
GRAMMAR = """
<grammar xmlns="http://relaxng.org/ns/structure/1.0" datatypeLibrary="http://www.w3.org/2001/XMLSchema-datatypes">
<start><element name="opsa-mef">
  <zeroOrMore><element name="define-fault-tree"><ref name="name"/><ref name="label"/>
    <zeroOrMore><ref name="gate"/></zeroOrMore></element></zeroOrMore>
  <element name="model-data"><zeroOrMore><ref name="event"/></zeroOrMore></element>
</element></start>
<define name="name"><attribute name="name">
  <data type="NCName"><param name="pattern">[^\\-.]+(-[^\\-.]+)*</param></data></attribute></define>
<define name="label"><optional><element name="label"><text/></element></optional></define>
<define name="gate"><element name="define-gate"><ref name="name"/><ref name="label"/><ref name="formula"/>
</element></define>
<define name="formula"><choice>
  <ref name="argument"/>
  <element name="and"><oneOrMore><ref name="argument"/></oneOrMore></element>
  <element name="or"><oneOrMore><ref name="argument"/></oneOrMore></element>
</choice></define>
<define name="argument"><choice>
  <element name="gate"><ref name="name"/></element>
  <element name="basic-event"><ref name="name"/></element>
  <element name="constant"><attribute name="value"><choice><value>true</value><value>false</value></choice>
  </attribute></element>
</choice></define>
<define name="event"><element name="define-basic-event"><ref name="name"/><ref name="label"/>
  <optional><element name="attributes"><element name="attribute">
    <attribute name="name"/><attribute name="value"/></element></element></optional>
  <optional><choice>
    <ref name="value"/>
    <element name="exponential"><ref name="value"/><ref name="time"/></element>
    <element name="GLM"><ref name="value"/><ref name="value"/><ref name="value"/><ref name="time"/></element>
  </choice></optional></element></define>
<define name="value"><element name="float"><attribute name="value"><data type="double"/></attribute>
</element></define>
<define name="time"><element name="system-mission-time"><attribute name="unit"><value>hours</value>
</attribute></element></define>
</grammar>
"""

Sets = set[frozenset[str]]
NUMBERED = missions(max_objectives=2, max_sections=5, numbers=True, early=3)


def solve(document: bytes) -> dict[str, list[CutSet]]:
    """Minimal cut sets of every gate of a valid document."""
    root = etree.fromstring(document)
    grammar = etree.RelaxNG(etree.fromstring(GRAMMAR))
    assert grammar.validate(root), grammar.error_log
    gates = {gate.get("name"): gate for gate in root.iter("define-gate")}
    events = {event.get("name") for event in root.iter("define-basic-event")}
    solved: dict[str, Sets] = {}

    def expand(formula: etree._Element) -> Sets:
        name = formula.get("name", "")
        if formula.tag == "gate":
            if name not in solved:
                solved[name] = expand(gates[name][-1])
            return solved[name]
        if formula.tag == "basic-event":
            assert name in events
            return {frozenset({name})}
        if formula.tag == "constant":
            return {frozenset()} if formula.get("value") == "true" else set()
        parts = [expand(part) for part in formula]
        references = [part.get("name") for part in formula if part.get("name")]
        assert len(references) == len(set(references)), "an argument stands twice in a formula"
        if formula.tag == "or":
            return set().union(*parts)
        return {frozenset().union(*chosen) for chosen in product(*parts)}

    return {str(name): minimal(expand(gate[-1])) for name, gate in gates.items()}


def cut_sets(
    found: MissionNet, max_states: int
) -> tuple[list[CutSet], dict[str, list[CutSet]], list[CutSet] | None]:
    direct(found.net, max_states=max_states)
    asked = Asked(found)
    safety = asked.cuts.safety
    safe = None if safety is None else asked.cuts.found(safety).minimal[Moment.START]
    objectives = {name: asked.cut_sets(name, Moment.ENTRY) for name in asked.prospects.objectives}
    return asked.cut_sets(None, Moment.START), objectives, safe


def check(found: MissionNet, max_states: int = 5000) -> bytes:
    mission, objectives, safety = cut_sets(found, max_states)
    document = open_psa(found.usage, mission, objectives, safety)
    solved = solve(document)
    assert solved["mission-lost"] == mission
    assert solved.get("robot-lost") == safety
    for name, expected in objectives.items():
        assert solved[f"objective-{name.replace('.', '-')}"] == expected
    return document


def test_ulysse_follows_the_mission(ulysse_net: MissionNet) -> None:
    document = check(ulysse_net)
    solved = solve(document)
    assert solved["activity-localisation"] == [("GPS_sensor", "IMU_sensor")]
    top = etree.fromstring(document).find(".//define-gate[@name='mission-lost']/gate")
    assert top is not None
    assert top.get("name") == "objective-transect-going_up"


@pytest.mark.parametrize(("most", "lost"), [("1", [("h0", "h1")]), ("2", [])])
def test_the_last_child_to_fail_fails_no_block(most: str, lost: list[CutSet]) -> None:
    """With ``failure_when`` so many children may fail while another runs, and one more as the last."""
    names = "abc"
    of = robot(hw("h0", "h1"), activity("a", ()), activity("b", ("h0",)), activity("c", ("h1",)))
    blocks = tuple(Objective(name=n, activities=(n,), mandatory=n == "a") for n in names)
    found = compose(small(of, Parallel(name="p", blocks=blocks, failure_when=most)))
    document = check(found)
    assert solve(document)["mission-lost"] == lost
    assert b"activity-b" in document  # it follows the mission


@fewer(0.3)
@given(NUMBERED | coming_home() | fragile_missions(max_hardware=3))
def test_cut_sets_read_back_are_ours(mission: Mission) -> None:
    found = compose(mission)
    try:
        check(found, max_states=1000)
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)


@fewer(0.3)
@given(missions(max_sections=8, max_hardware=5))
def test_the_flat_tree_says_what_it_is_given(mission: Mission) -> None:
    found = compose(mission)
    hardware = [h.name for h in found.core.hardware if h.faulty]
    if not hardware:
        returns_early("no hardware that fails")
        return
    # Cut sets that the text of the mission does not have, as contention brings them about.
    given_sets: list[CutSet] = [tuple(sorted(hardware[:2]))]
    objectives: dict[str, list[CutSet]] = {s.name: [] for s in found.graph.walk()}
    solved = solve(open_psa(found.usage, given_sets, objectives))
    assert solved["mission-lost"] == given_sets
