"""The graph of a net that a page has, and firings that a server answers, by the definition of firing."""

from __future__ import annotations

import pytest
from hypothesis import given

from mcpn.nets.petri import PetriNet
from mcpn.report.pages import token_game
from mcpn.report.pages.token_game import fired, position, stored
from tests.draws import fewer
from tests.nets.nets import graph_of, nets
from tests.shares import returns_early

MOST = 40


@fewer(0.5, least=8)
@given(nets(events=True))
def test_the_graph_has_every_firing(net: PetriNet) -> None:
    found = graph_of(net, MOST)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(token_game, "MOST_MARKINGS", MOST)
        graph = stored(net)
    if found is None or graph is None:
        assert (found is None) == (graph is None)
        returns_early("too large")
        return
    assert len(graph["positions"]) == len(found)
    at = {0: net.initial}
    for number, (marked, firings) in enumerate(graph["positions"]):
        asked = position(net, at[number])
        assert asked["marked"] == marked
        pairs = list(zip(firings[::2], firings[1::2], strict=True))
        assert [row[0] for row in asked["enabled"]] == firings[::2]
        assert [(t, at.setdefault(to, net.fire(at[number], t))) for t, to in pairs] == found[at[number]]
        for transition, to in pairs:
            assert fired(net, asked["tokens"], transition) == position(net, at[to])
