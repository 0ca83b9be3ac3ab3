"""What the script of a page is given: weights of events, a small net, and no more than it needs."""

from __future__ import annotations

import json
import random
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcpn.controller.likelihood import likelihood
from mcpn.drawing.compose import compose
from mcpn.events import Event, What
from mcpn.findings import Findings, findings
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.report.page import page
from mcpn.testing import missions
from tests import small
from tests.conftest import ROOT
from tests.report.tabs import opened, play_tokens


@given(missions(max_objectives=3), st.randoms(use_true_random=False))
@settings(max_examples=20)
def test_successes_are_ten_times_as_likely_as_failures(mission: Mission, rng: random.Random) -> None:
    net = compose(mission)
    weight = likelihood(net)
    for section in net.graph.walk():
        success, failure = (weight(Event(w, section.name)) for w in (What.SUCCESS, What.FAILURE))
        assert success == pytest.approx(10 * failure)
    every = [weight(t.event) for t in net.net.transitions if t.event is not None]
    assert min(every) > 0


def test_rates_that_a_mission_gives_count() -> None:
    net = compose(read_mission(ROOT / "experiments" / "rover" / "mission.xml"))
    weight = likelihood(net)
    given_ = [h for h in net.core.hardware if h.failure_rate]
    assert given_
    for hardware in given_:
        assert weight(Event(What.OUT_OF_SERVICE, hardware.name)) == hardware.failure_rate
    timed = next(s for s in net.graph.walk() if s.duration)
    assert timed.duration is not None
    both = weight(Event(What.SUCCESS, timed.name)) + weight(Event(What.FAILURE, timed.name))
    assert both == pytest.approx(1 / timed.duration)


def test_the_script_is_given_no_more_than_it_needs(ulysse_findings: Findings) -> None:
    text = page(ulysse_findings)
    data = re.search(r'id="data">(.*?)</script>', text)
    assert data is not None
    given_ = json.loads(data[1])
    assert given_["controller"]["form"] == "modular"
    assert given_.keys() == {"controller", "events", "boxes", "losses"}
    assert "<code>mcpn serve <bdi>mission.xml</bdi></code> plays it" in text


def test_a_small_net_is_played_in_the_page(browser: Any, tmp_path: Path) -> None:
    of = small.robot(small.hw("h"), small.activity("a", ("h",)))
    found = findings(compose(small.mission(of, Objective(name="x", activities=("a",)))))
    tab, wrong = opened(browser, page(found), tmp_path)
    play_tokens(tab, found.check.mission_net.net, 1)
    assert wrong == []
