"""Fault trees: read back, held against their grammar, and solved by expansion from the top (MOCUS)."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections import Counter
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import pytest
from hypothesis import given
from lxml import etree

from mcpn.answers.causes.cutsets import CutSet, Moment
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Hardware
from mcpn.mission.xml import read_mission
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
    hardware = [h.name for h in mission.hardware if h.faulty]
    if not hardware:
        returns_early("no hardware that fails")
        return
    # Cut sets that the text of the mission does not have, as contention brings them about.
    given_sets: list[CutSet] = [tuple(sorted(hardware[:2]))]
    objectives: dict[str, list[CutSet]] = {s.name: [] for s in found.graph.walk()}
    solved = solve(open_psa(found.usage, given_sets, objectives))
    assert solved["mission-lost"] == given_sets


# --- a reader of others: SCRAM ----------------------------------------------------------------------------

needs_scram = pytest.mark.skipif(shutil.which("scram") is None, reason="needs SCRAM (apt-get install scram)")
HOURS = 8760.0


@dataclass(frozen=True)
class Reading:
    """What SCRAM finds of one top gate."""

    cut_sets: list[CutSet]
    probability: float | None


def scram(document: bytes, folder: Path, *, probability: bool) -> dict[str, Reading]:
    """Has SCRAM read and solve a document.

    Args:
        document: A fault tree.
        folder: Where to put files.
        probability: Whether probabilities are asked for, exact by binary decision diagrams.
    """
    tree, told = folder / "tree.xml", folder / "report.xml"
    tree.write_bytes(document)
    options = ["--bdd", "--limit-order", "30", "--mission-time", str(HOURS), "-o", str(told)]
    run = subprocess.run(
        ["scram", str(tree), *options, "--probability", "true" if probability else "false"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert (run.returncode, run.stderr) == (0, ""), run.stderr + document.decode()
    found = {}
    for top in etree.parse(told).iter("sum-of-products"):
        products = [tuple(e.get("name", "") for e in product) for product in top.iter("product")]
        value = top.get("probability")
        found[top.get("name", "")] = Reading(
            minimal({frozenset(p) for p in products}), None if value is None else float(value)
        )
    return found


def out_of_service(hardware: Hardware) -> float:
    """The probability that a resource, in service at first, is out of service after the mission's time."""
    rate, repair = hardware.failure_rate or 0.0, hardware.repair_rate or 0.0
    if not rate:
        return 0.0
    return rate / (rate + repair) * -math.expm1(-(rate + repair) * HOURS)


def lost(cut_sets: list[CutSet], mission: Mission) -> float:
    """The probability that some cut set is out of service, by all states of the hardware."""
    chances = {h.name: out_of_service(h) for h in mission.hardware if h.faulty}
    total = 0.0
    for states in product((False, True), repeat=len(chances)):
        out = {name for name, state in zip(chances, states, strict=True) if state}
        if any(set(names) <= out for names in cut_sets):
            total += math.prod(c if name in out else 1 - c for name, c in chances.items())
    return total


def _without_mission(document: bytes) -> bytes:
    root = etree.fromstring(document)
    for tree in root.iter("define-fault-tree"):
        for gate in tree.findall("define-gate"):
            if gate.get("name", "").startswith(("mission-lost", "robot-lost")):  # and the gates within
                tree.remove(gate)
    return etree.tostring(root)


def compare_with_scram(mission: Mission, folder: Path) -> Counter[str]:
    """Has SCRAM solve the export; says how many cut sets and probabilities were compared."""
    found, compared = compose(mission), Counter[str]()
    ours, objectives, safety = cut_sets(found, 1000)
    document = open_psa(found.usage, ours, objectives, safety)
    faulty = [h for h in mission.hardware if h.faulty]
    quantitative = any(h.failure_rate is not None for h in faulty)
    tops = {"mission-lost": ours} | {f"objective-{n.replace('.', '-')}": c for n, c in objectives.items()}
    tops |= {} if safety is None else {"robot-lost": safety}
    # SCRAM solves top gates, those that no other gate uses: without the mission's, the objectives' are.
    read = scram(document, folder, probability=quantitative)
    read |= scram(_without_mission(document), folder, probability=quantitative)
    assert tops.keys() <= read.keys()
    for name, expected in tops.items():
        assert read[name].cut_sets == expected, name
        compared["cut sets"] += len(expected)
        if quantitative and expected not in ([], [()]):
            found_by_scram = read[name].probability  # printed with six digits
            assert found_by_scram == pytest.approx(lost(expected, mission), rel=6e-6, abs=1e-12), name
            compared["probabilities"] += 1
    stated = {
        event.get("name")
        for event in etree.fromstring(document).iter("define-basic-event")
        if event.find("attributes/attribute[@name='failure-rate'][@value='not given']") is not None
    }
    assert stated == {h.name for h in faulty if h.failure_rate is None}
    compared["gates"] += len(tops)
    return compared


FOR_SCRAM = NUMBERED | coming_home() | fragile_missions(max_hardware=3)


@needs_scram
@fewer(0.4)
@given(mission=FOR_SCRAM)
def test_scram_reads_every_export_as_it_is_meant(
    tmp_path_factory: pytest.TempPathFactory, mission: Mission
) -> None:
    try:
        compare_with_scram(mission, tmp_path_factory.mktemp("scram"))
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)


@needs_scram
def test_scram_reads_ulysse(ulysse: Mission, tmp_path: Path) -> None:
    compare_with_scram(ulysse, tmp_path)


@pytest.mark.parametrize(
    ("ways", "rates"),
    [
        ('<alternative name="x" consumes="h"/><alternative name="y" consumes="h"/>', 'failure_rate="0.1"'),
        ('<alternative name="x" consumes="h"/>', 'failure_rate="0" repair_rate="1"'),
        ('<alternative name="x" consumes="h g"/><alternative name="y" consumes="g h"/>', ""),
    ],
    ids=["same resource twice", "rate zero", "same resources twice"],
)
def test_formulas_name_an_argument_once_and_laws_are_laws(ways: str, rates: str, tmp_path: Path) -> None:
    path = tmp_path / "m.xml"
    path.write_text(
        f"""<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="R"><hardware name="h" {rates}/>
        <hardware name="g"/><activity name="a">{ways}</activity></robot>
        <objective name="o" activities="a" duration="1"/></mission>"""
    )
    mission = read_mission(path)
    found = compose(mission)
    document = check(found)
    assert b'<float value="0.0"/>' in document or 'failure_rate="0"' not in rates
    if shutil.which("scram"):
        compare_with_scram(mission, tmp_path)
