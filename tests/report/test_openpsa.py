"""Fault trees: read back, held against their grammar, and solved by expansion from the top (MOCUS)."""

from __future__ import annotations

from itertools import product

from hypothesis import given, settings
from lxml import etree

from mcpn.check.availability import Availability
from mcpn.check.cutsets import CutSet, Losses, Moment
from mcpn.check.losing import Outlook
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.report.openpsa import open_psa
from mcpn.space.alternatives import direct
from mcpn.testing import missions
from tests.check.oracle import fragile_missions, minimal

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
  <element name="gate"><ref name="name"/></element>
  <element name="basic-event"><ref name="name"/></element>
  <element name="constant"><attribute name="value"><choice><value>true</value><value>false</value></choice>
  </attribute></element>
  <element name="and"><oneOrMore><ref name="formula"/></oneOrMore></element>
  <element name="or"><oneOrMore><ref name="formula"/></oneOrMore></element>
</choice></define>
<define name="event"><element name="define-basic-event"><ref name="name"/><ref name="label"/>
  <optional><choice>
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
        if formula.tag == "or":
            return set().union(*parts)
        return {frozenset().union(*chosen) for chosen in product(*parts)}

    return {str(name): minimal(expand(gate[-1])) for name, gate in gates.items()}


def cut_sets(found: MissionNet, max_states: int) -> tuple[list[CutSet], dict[str, list[CutSet]]]:
    losses = Losses(Outlook(found, direct(found.net, max_states=max_states)))
    mission = losses.listed(losses.cut_sets(losses.outlook.mission, Moment.START))
    objectives = losses.outlook.objectives
    return mission, {n: losses.listed(losses.cut_sets(g, Moment.ENTRY, n)) for n, g in objectives.items()}


def check(found: MissionNet, max_states: int = 5000) -> bytes:
    mission, objectives = cut_sets(found, max_states)
    document = open_psa(found.usage, mission, objectives)
    solved = solve(document)
    assert solved["mission-lost"] == mission
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


@settings(max_examples=60)
@given(missions(max_objectives=2, max_sections=5, numbers=True) | fragile_missions(max_hardware=3))
def test_cut_sets_read_back_are_ours(mission: Mission) -> None:
    found = compose(mission)
    try:
        check(found, max_states=1000)
    except (LimitError, SemanticsError):
        return


@settings(max_examples=60)
@given(missions(max_sections=8, max_hardware=5))
def test_the_flat_tree_says_what_it_is_given(mission: Mission) -> None:
    found = compose(mission)
    text = Availability(found.usage)
    if not text.hardware:
        return
    # Cut sets that the text of the mission does not have, as contention brings them about.
    given_sets: list[CutSet] = [tuple(sorted(text.hardware[:2]))]
    objectives: dict[str, list[CutSet]] = {s.name: [] for s in found.graph.walk()}
    solved = solve(open_psa(found.usage, given_sets, objectives))
    assert solved["mission-lost"] == given_sets
