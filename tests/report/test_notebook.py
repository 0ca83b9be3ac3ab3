"""Notebooks show pictures and tables; a repr is short."""

from __future__ import annotations

from typing import Any

import pytest
from lxml import etree

import mcpn
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.drawing.local_nets import local_net
from mcpn.drawing.sections import section_part
from mcpn.mission.model import Objective
from mcpn.mission.xml import read_mission
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import direct_with_proof
from mcpn.testing.nets import philosophers
from tests.conftest import ULYSSE
from tests.report.test_pictures import HOSTILE, hostile
from tests.small import activity, hw, mission, robot

pytest.importorskip("pygraphviz", reason="needs pygraphviz: the extra pictures")
MOST_CHARACTERS = 400


def shown() -> dict[str, Any]:
    net = compose(read_mission(ULYSSE))
    part = local_net(section_part(net.usage, net.graph.sections[0]))
    return {
        "mission": net.mission,
        "graph": net.graph,
        "net": net,
        "small net": part.net,
        "small alternatives": direct_with_proof(part.net),
        "controller": generate(net),
    }


def test_pictures() -> None:
    for name, what in shown().items():
        text = what._repr_svg_()
        assert text is not None, name
        assert etree.fromstring(text.encode()).tag.endswith("svg"), name


def test_what_is_too_large_is_not_drawn() -> None:
    net = compose(read_mission(ULYSSE))
    assert direct_with_proof(net.net)._repr_svg_() is None


def test_tables_are_texts() -> None:
    found = mcpn.open(hostile()).verdicts()
    table = etree.fromstring(found._repr_html_() or "")
    assert [row[2].text for row in table.iter("tr")][1:] == [*found.verdicts]
    causes = mcpn.open(ULYSSE).causes()
    table = etree.fromstring(causes._repr_html_() or "")
    assert [row[0].text for row in table.iter("tr")][1] == (
        "The loss of thruster_actuator, or of GPS_sensor and IMU_sensor together before the start, not "
        "repaired, leaves no way to success."
    )
    from mcpn.report.notebook import _table

    text = _table(HOSTILE, (HOSTILE,), [(HOSTILE,)])
    assert "<script" not in text
    assert text.count("<td>") == 1


def test_answers_verdicts_and_causes_are_tables() -> None:
    study = mcpn.open(ULYSSE)
    answer = study.ctl("EF (failure & oos(GPS_sensor))")
    table = etree.fromstring(answer._repr_html_() or "")
    assert table.findtext("caption") == "EF (failure & oos(GPS_sensor)) holds"
    events = [row[2].text for row in table.iter("tr")][1:]
    assert [event for event in events if event] == [str(event) for event in answer.witness.run.events]
    verdict = study.verdicts().verdicts["success_reachable"]
    table = etree.fromstring(verdict._repr_html_() or "")
    assert (table.findtext("caption") or "").startswith("The mission can succeed.")
    told = [row[2].text for row in table.iter("tr")][1:]
    assert told == [str(event) for event in verdict.runs_of_events[0].events]
    goal = study.causes().mission
    table = etree.fromstring(goal._repr_html_() or "")
    assert [row[0].text for row in table.iter("tr")][1:] == ["thruster_actuator", "GPS_sensor and IMU_sensor"]
    assert "thruster_actuator_EV_OOS" in ([row[1].text for row in table.iter("tr")][1] or "")
    net = mcpn.open(philosophers(2)).ctl("EF deadlock")
    text = net._repr_html_() or ""
    assert net.holds
    assert [row[1].text for row in etree.fromstring(text).iter("tr")][1] in {"wake0", "wake1"}


def test_a_mission_that_can_never_succeed() -> None:
    of = robot(hw("H"), activity("use", ("H",)))
    never = mission(of, Objective(name="go", activities=("use",), success="fail"))
    table = etree.fromstring(mcpn.open(never).causes()._repr_html_() or "")
    assert [row[0].text for row in table.iter("tr")][1] == "The mission can never succeed."


def test_reprs_are_short() -> None:
    net = compose(read_mission(ULYSSE))
    found: list[object] = [
        net.mission,
        net.net,
        net,
        net.graph,
        generate(net),
        direct_with_proof(net.net),
        explore(net.net),
    ]
    study = mcpn.open(net)
    found += [study.check(), study.causes(), study.ctl("EF success"), study.picture()]
    for what in found:
        assert len(repr(what)) <= MOST_CHARACTERS, type(what)
        assert repr(what).startswith("<")
