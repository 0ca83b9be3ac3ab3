"""Composition: the composite of local graphs is the alternatives graph of the whole mission."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import event, given

from mcpn.errors import ConfluenceError, DivergenceError
from mcpn.mission.model import Mission
from mcpn.net.compose import MissionNet, compose
from mcpn.space.alternatives import AlternativesGraph, by_reduction, direct
from mcpn.space.composite import Composite
from mcpn.space.expand import expand
from mcpn.space.explicit import explore
from mcpn.space.graph import Mask
from mcpn.space.local import OUTCOMES, Outcome, local_graphs
from mcpn.testing import missions


def composed(mission_net: MissionNet) -> Composite:
    graph, usage = mission_net.graph, mission_net.usage
    return Composite(usage, graph, tuple(local_graphs(usage, graph)))


def check_equal(found: AlternativesGraph, expected: AlternativesGraph) -> None:
    for name in ("markings", "offsets", "targets", "labels"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name


def test_ulysse(ulysse: Mission, ulysse_net: MissionNet) -> None:
    composite = composed(ulysse_net)
    # Table 1 of the paper.
    assert (composite.states, composite.edges) == (260, 1332)
    assert len({id(placed.local) for placed in composite.sections}) == 2
    check_equal(expand(composite, ulysse_net), direct(ulysse_net.net))


@given(missions())
def test_the_composite_is_the_whole(mission: Mission) -> None:
    mission_net = compose(mission)
    usage = mission_net.usage
    try:
        whole = by_reduction(explore(mission_net.net, max_states=50_000))
    except (ConfluenceError, DivergenceError):
        event("not confluent")
        assert usage.contentions or usage.exchanges
        with pytest.raises((ConfluenceError, DivergenceError)):
            composed(mission_net)
        return
    composite = composed(mission_net)
    event(f"{len(composite.sections)} sections, {len({id(p.local) for p in composite.sections})} types")
    assert (composite.states, composite.edges) == (whole.states, whole.edges)
    check_equal(expand(composite, mission_net), whole)
    success, failure = whole.marked(mission_net.success), whole.marked(mission_net.failure)
    assert ("success" in composite.ends) == success.any()
    assert ("failure" in composite.ends) == failure.any()
    wanted: list[tuple[set[Outcome], Mask]] = [
        ({"success"}, success),
        ({"failure"}, failure),
        (set(OUTCOMES), success | failure),
    ]
    for goals, ends in wanted:
        assert _losing(composite, goals) == int((~whole.reaching(ends)).sum())


def _losing(composite: Composite, goals: set[Outcome]) -> int:
    """States of the whole from which no goal is reached, by the composite's arithmetic."""
    count = len(composite.faulty)
    losing = composite.losing(goals)
    inside = sum(int(mask.sum()) << count - len(composite.by_name[n].faulty) for n, mask in losing.items())
    first = composite.by_name[composite.graph.entry]
    wins = composite.leading_to(goals)[composite.graph.entry][first.local.entry]
    before = 0 if wins.any() else 1 << count
    return inside + before + (len(composite.ends - goals) << count)
