"""Fault trees read by others: SCRAM finds the same cut sets and probabilities."""

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

from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.mission.passes import core
from mcpn.mission.robot import Hardware
from mcpn.mission.xml import read_mission
from mcpn.report.failures.openpsa import open_psa
from tests.draws import fewer
from tests.logic.oracle import coming_home, fragile_missions, minimal
from tests.report.test_openpsa import NUMBERED, check, cut_sets
from tests.shares import returns_early

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
    chances = {h.name: out_of_service(h) for h in core(mission).hardware if h.faulty}
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
    faulty = [h for h in found.core.hardware if h.faulty]
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
@fewer(0.4, least=6)
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
