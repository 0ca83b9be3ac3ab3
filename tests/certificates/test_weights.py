"""Certificates of missions in whose nets an arc has a weight."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from mcpn.certificates import certcheck, corecheck
from mcpn.certificates.net_entry import ALWAYS, NEVER, net_entry
from mcpn.certificates.writing import certificate_of
from mcpn.drawing.compose import MissionNet
from mcpn.errors import LimitError
from mcpn.mission.xml import read_mission
from mcpn.study import Study

OF = """
<mission xmlns="urn:mcpn:mission:1" name="m">
  <robot name="r">
    <hardware name="arm"/><fact name="order" values="none some"/><event name="leak"/>
    <activity name="work" consumes="arm"/><activity name="talk"/>
  </robot>
  <parallel name="both">
    <objective name="one" activities="work">
      <sets fact="order" to="some" on="success"/><on event="leak" goto="succeed"/>
    </objective>
    <objective name="beside">
      <objective name="other" activities="talk" success="succeed">
        <route goto="late" when="order=some"/>
      </objective>
      <objective name="late" activities="work"><on event="leak" goto="succeed"/></objective>
    </objective>
  </parallel>
</mission>
"""
"""``one`` and ``late`` never run together; an event that stopped both would have an arc of weight 2."""


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    path = tmp_path_factory.mktemp("weights") / "m.xml"
    path.write_text(OF.lstrip())
    return Study(read_mission(path))


@pytest.fixture(scope="module")
def net(study: Study) -> MissionNet:
    found = study.mission_net
    assert any(weight == 2 for t in found.net.transitions for _, weight in t.produce)
    return found


def test_every_claim_is_proved(
    tmp_path: Path, study: Study, net: MissionNet, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "m.cert"
    path.write_bytes(certificate_of(study.verdicts()).to_bytes())
    assert certcheck.main([str(path)]) == 0, capsys.readouterr()
    assert corecheck.main([str(path)]) == 0, capsys.readouterr()
    said = json.loads(certcheck.unpacked(str(path))["net.json"])
    assert [place["name"] for place in said["places"][-2:]] == [ALWAYS, NEVER]
    with pytest.raises(LimitError, match="has an arc with a weight"):
        net_entry(net, diagrams=True)


def states(net: MissionNet, t: int, side: str = "read", weight: int = 1) -> int:
    """How many states there are, where the arcs of a transition to one side have a weight."""
    transitions = list(net.net.transitions)
    arcs: Any = {side: tuple((place, weight) for place, _ in getattr(transitions[t], side))}
    transitions[t] = replace(transitions[t], **arcs)
    changed = replace(net, net=replace(net.net, transitions=tuple(transitions)))
    said = json.loads(json.dumps(net_entry(changed)))
    return len(certcheck.Listing(certcheck.Net(said), 10_000, float("inf")).stable)


def test_a_weight_makes_a_firing_unsafe_or_impossible(net: MissionNet) -> None:
    start = next(t for t, each in enumerate(net.net.transitions) if str(each.event) == "MISSION_EV_START")
    before = 2  # the arm may fail before the start
    assert states(net, start) > before
    assert states(net, start, "consume", 2) == before
    with pytest.raises(certcheck.Refuted, match="second token"):
        states(net, start, "produce", 2)
