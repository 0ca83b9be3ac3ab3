"""A campaign: generated missions through every engine and both controllers, which must all say the same.

``MCPN_CAMPAIGN`` says how many missions (if not set 2,000, and 10,000 in the profile nightly),
``MCPN_CAMPAIGN_SEED`` which ones. 500 took 56 s of one core (x86-64, CPython 3.11), so 10,000 take some 19
minutes::

    MCPN_CAMPAIGN=20000 python -m pytest -m slow -s tests/test_campaign.py
"""

from __future__ import annotations

import os
import random
import sys
import time
import zlib
from collections import Counter

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from mcpn.composite.composing import composite_space
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.hierarchy import flat_controller
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.writer import write_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction
from mcpn.spaces.stable.confluence_by_sets import prove_confluent
from mcpn.spaces.stable.written_out import written_out
from mcpn.testing import missions
from mcpn.testing.stacked import stacked_missions
from tests.controller.test_lockstep import walk
from tests.drawing.promises import check_each_is_one_thing, check_promises

MISSIONS = st.one_of(
    missions(),
    missions(sections=6, producers=2, alternatives=2, awkward_names=True),
    missions(sections=5, producers=2, events=2),
    missions(own_hardware=True, shared_activities=False, sections=5),
    stacked_missions(),
)
LIMIT = 20_000
EVENTS = 200
NET_TOO = 0.05
"""Share of missions on which the net is fired beside both controllers."""


def test_a_few_missions_agree_in_every_engine_and_controller() -> None:
    run_campaign(20, random.randrange(2**32))


@pytest.mark.slow
def test_campaign() -> None:
    nightly = os.environ.get("HYPOTHESIS_PROFILE") == "nightly"
    number = os.environ.get("MCPN_CAMPAIGN", "10000" if nightly else "2000")
    run_campaign(int(number), int(os.environ.get("MCPN_CAMPAIGN_SEED", "1")))


def run_campaign(number: int, first: int) -> None:
    """Draws missions and judges each; prints how many were of which kind."""
    found: Counter[str] = Counter()
    began = time.monotonic()

    @seed(first)
    @settings(
        max_examples=number,
        phases=[Phase.generate, Phase.shrink],
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )
    @given(MISSIONS)
    def judged(mission: Mission) -> None:
        found["drawn"] += 1
        found[judge(mission, random.Random(zlib.crc32(write_mission(mission))))] += 1  # the same each time

    try:
        judged()
    finally:
        took = time.monotonic() - began
        kinds = ", ".join(f"{n} {what} ({n / found['drawn']:.1%})" for what, n in found.items())
        sys.stdout.write(f"\nseed {first}: {kinds} in {took:.0f} s\n")


def judge(mission: Mission, choice: random.Random) -> str:
    """Holds every engine and both controllers against one another on a mission; says of what kind it is."""
    mission_net = compose(mission)
    net, usage = mission_net.net, mission_net.usage
    try:
        markings = explore(net, max_states=LIMIT)  # 1-safety is checked at each firing
    except LimitError:
        return "too large"
    check_promises(mission_net, markings)
    space = reach(net)
    assert space.reachable.count() == markings.states
    try:
        whole = by_reduction(markings)
    except (ConfluenceError, DivergenceError):
        assert usage.contentions
        with pytest.raises((ConfluenceError, DivergenceError)):  # where it has both faults either is told
            prove_confluent(net, space=space)
        with pytest.raises((ConfluenceError, DivergenceError)):
            composite_space(mission_net)
        return "not confluent"
    prove_confluent(net, space=space)
    assert space.stable is not None
    assert space.stable.count() == whole.states
    written = written_out(composite_space(mission_net), "local", LIMIT)
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(written, name), getattr(whole, name)), name
    lockstep(mission_net, whole, choice)
    return "confluent, may contend" if usage.contentions else "confluent, cannot contend"


def lockstep(mission_net: MissionNet, whole: AlternativesGraph, choice: random.Random) -> None:
    """Drives both controllers by the same random events; the net itself, which is slow, on some missions."""
    controllers = [flat_controller(mission_net, whole), generate(mission_net)]
    if choice.random() < NET_TOO:
        walk(mission_net, controllers, choice, EVENTS)
        return
    documents = [document(c, mission_net) for c in controllers]
    one, other = (Runtime.from_document(d) for d in documents)
    for _ in range(EVENTS):
        assert one.possible == other.possible
        assert (one.mode, one.outcome) == (other.mode, other.outcome)
        assert one.state.objectives == other.state.objectives
        assert one.state.waiting == other.state.waiting
        assert set(one.state.refused) == set(other.state.refused)
        check_each_is_one_thing(mission_net, one.state)
        if not one.possible or (one.outcome and choice.random() < 0.3):
            one, other = (Runtime.from_document(d) for d in documents)
            continue
        happened = choice.choice(one.possible)
        assert one.handle(happened) == other.handle(happened)
