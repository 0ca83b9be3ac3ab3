"""One suite over every engine: the same sizes, whoever counts."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import example, given

from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet, Place
from mcpn.spaces.sizes import summarise
from mcpn.spaces.summary import ENGINES, SpaceSummary
from mcpn.testing import missions
from mcpn.testing.nets import queens
from tests.draws import fewer
from tests.nets.nets import nets, reachable
from tests.shares import returns_early
from tests.spaces.test_explicit import ring, switches

# What each engine reaches in a few seconds, by places and by states.
REACH = {"explicit": (10**9, 130_000), "symbolic": (10**9, 10**50), "pyeda": (60, 100_000)}


def sizes(summary: SpaceSummary) -> SpaceSummary:
    """A summary without what may differ between engines."""
    return replace(summary, nodes=None, peak_nodes=None, order=None, engine="", seconds=0)


OWN = ("tests.spaces.plain:PlainSets", "experiments.nets.dd_engine:DdSets")
"""Engines as a caller may bring them: sets of Python, and the diagrams of the package dd."""


def overfilling() -> PetriNet:
    """A transition that would put two tokens in a place, and waits for two that are never both marked."""
    builder = NetBuilder("overfilling")
    for place, tokens in (("p", 1), ("q", 0), ("r", 0)):
        builder.place(place, initial=tokens)
    builder.transition("there", consume=["p"], produce=["q"])
    builder.transition("back", consume=["q"], produce=["p"])
    builder.transition("never", consume=["p", "q"], produce=["r", "r"])
    return builder.build()


def present(engine: str) -> None:
    """Skips where an engine needs a package that is not there."""
    if "dd_engine" in engine:
        pytest.importorskip("dd", reason="needs dd: the extra experiments")


@pytest.mark.parametrize("engine", [*ENGINES, *OWN])
@fewer(0.25)
@given(net=nets(max_weight=2))
@example(net=PetriNet("nothing_fires", (Place("p0", 0),), ()))
@example(net=PetriNet("nothing_fires", (Place("p0", 0),), (), priorities=True))
@example(net=overfilling())
def test_nets_have_the_sizes_of_the_plain_rule(engine: str, net: PetriNet) -> None:
    present(engine)
    markings, edges, safe = reachable(net)
    if not safe and engine in ("explicit", "symbolic") and not net.priorities:
        return  # tests/spaces/test_bounded.py
    if not safe:
        with pytest.raises(UnsafeError):
            summarise(net, engine)
        return
    found = summarise(net, engine)
    assert (found.states, found.edges) == (len(markings), edges)
    assert found.dead_states == sum(not net.enabled(m) for m in markings)
    if engine in ENGINES:
        assert found.max_tokens == max(sum(m) for m in markings)
    if net.priorities:
        unstable = [m for m in markings if any(net.transitions[t].internal for t in net.enabled(m))]
        assert found.stable_states == len(markings) - len(unstable)
    else:
        assert found.stable_states is None


@fewer(0.25)
@given(missions())
def test_missions_have_the_same_sizes_by_both_large_engines(mission: Mission) -> None:
    net = compose(mission).net
    try:
        explicit = summarise(net, "explicit", max_states=20_000)
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    assert sizes(summarise(net, "symbolic")) == sizes(explicit)


@pytest.mark.parametrize("engine", [*ENGINES, *OWN])
def test_closed_forms(engine: str) -> None:
    present(engine)
    found = summarise(switches(4), engine)
    assert (found.states, found.edges, found.dead_states) == (2**4, 4 * 2**4, 0)
    assert found.max_tokens == (4 if engine in ENGINES else None)
    found = summarise(ring(7), engine)
    assert (found.states, found.edges, found.dead_states) == (7, 7, 0)
    assert found.max_tokens == (1 if engine in ENGINES else None)


@pytest.mark.parametrize("engine", ENGINES)
def test_the_contest_s_answers(engine: str, mcc: Path, mcc_oracles: dict[str, dict[str, str]]) -> None:
    most_places, most_states = REACH[engine]
    checked = 0
    for model, row in mcc_oracles.items():
        if row["safe"] != "1-safe" or int(row["places"]) > most_places or int(row["states"]) > most_states:
            continue
        if model in SLOW:
            continue
        found = summarise(read_net(mcc / model / "model.pnml"), engine)
        assert found.states == int(row["states"]), model
        assert found.edges == int(row["edges"]), model
        assert bool(found.dead_states) == (row["deadlock_exists"] == "TRUE"), model
        assert found.max_tokens == int(row["max_tokens_per_marking"]), model
        checked += 1
    assert checked >= {"explicit": 20, "symbolic": 30, "pyeda": 15}[engine]


# Left to experiments/nets/mcc.py, which gives each net a minute.
SLOW = {
    "Solitaire-PT-SqrNC5x5",
    "Dekker-PT-050",
    "Peterson-PT-3",
    "NQueens-PT-08",
    "LamportFastMutEx-PT-4",
    "Eratosthenes-PT-100",
}


def test_the_reference_engine_refuses_the_contest_s_unsafe_nets(
    mcc: Path, mcc_oracles: dict[str, dict[str, str]]
) -> None:
    for model, row in mcc_oracles.items():
        if row["safe"] != "1-safe" and int(row["places"]) <= 24:
            with pytest.raises(UnsafeError):
                summarise(read_net(mcc / model / "model.pnml"), "pyeda")


@pytest.mark.parametrize(
    ("limits", "named"),
    [({"max_nodes": 1000}, "the limit is 1000 nodes"), ({"seconds": 0}, "the limit is 0 s")],
)
def test_the_reference_engine_names_the_limit_that_it_hit(limits: dict[str, int], named: str) -> None:
    pytest.importorskip("pyeda", reason="needs pyeda: the extra pyeda")
    from mcpn.spaces.pyeda_reference import count

    with pytest.raises(LimitError, match=rf"^pyeda holds \d+ nodes after \d+ s of CPU time: {named}$"):
        count(queens(6), **limits)
