"""The symbolic engine, against the explicit one, the contest and closed forms."""

from __future__ import annotations

from math import comb
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, UnsafeError
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.nets.formats import read_net
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.diagrams.order import candidates
from mcpn.spaces.diagrams.reached_markings import SymbolicSpace
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.testing import missions
from tests.nets.nets import nets, reachable
from tests.shares import returns_early
from tests.spaces.test_explicit import check_unsafe_run, switches

# Safe nets of the contest that some order makes small at once.
QUICK = (
    "Philosophers-PT-000100",
    "Dekker-PT-015",
    "SharedMemory-PT-000005",
    "RwMutex-PT-r0010w0010",
    "Railroad-PT-005",
    "Eratosthenes-PT-010",
    "ResAllocation-PT-R003C003",
    "Raft-PT-02",
    "NQueens-PT-05",
    "TokenRing-PT-005",
    "SmartHome-PT-01",
    "Referendum-PT-0010",
    "AirplaneLD-PT-0010",
    "CircadianClock-PT-000001",
)


def plain(net: PetriNet) -> tuple[int, int, int, int]:
    """States, edges, dead states and most tokens by the net's own rule."""
    markings, edges, _ = reachable(net)
    dead = sum(not net.enabled(m) for m in markings)
    return len(markings), edges, dead, max(sum(m) for m in markings)


def counted(space: SymbolicSpace) -> tuple[int, int, int, int]:
    return space.states, space.edges, space.dead_states, space.max_tokens


@given(nets(max_weight=2, max_places=7, max_transitions=8))
def test_the_same_counts_as_by_the_plain_rule(net: PetriNet) -> None:
    _, _, safe = reachable(net)
    if safe:
        for _, order in candidates(net):
            assert counted(reach(net, order=order)) == plain(net)
        return
    with pytest.raises(UnsafeError) as caught:
        reach(net)
    check_unsafe_run(net, caught.value)


@given(missions())
def test_missions_have_the_counts_of_the_explicit_engine(mission: Mission) -> None:
    net = compose(mission).net
    try:
        graph = explore(net, max_states=20_000)
    except LimitError as error:
        returns_early(type(error).__name__)
        return
    space = reach(net)
    assert (space.states, space.edges) == (graph.states, graph.edges)
    assert space.dead_states == int(graph.dead.sum())
    assert space.stable is not None


def test_the_reference_net_has_the_markings_that_others_counted(reference: Path) -> None:
    # Counted by two independent explorers before this program was written.
    space = reach(read_net(reference / "ulysse_reference.net"))
    assert (space.states, space.edges) == (44299, 124078)
    assert space.stable is not None
    assert space.stable.count() == 260


def test_the_contest_s_answers(mcc: Path, mcc_oracles: dict[str, dict[str, str]]) -> None:
    for model in QUICK:
        row = mcc_oracles[model]
        space = reach(read_net(mcc / model / "model.pnml"))
        assert space.states == int(row["states"]), model
        assert space.edges == int(row["edges"]), model
        assert (space.dead_states > 0) == (row["deadlock_exists"] == "TRUE"), model
        assert space.max_tokens == int(row["max_tokens_per_marking"]), model


def test_the_contest_s_unsafe_nets_are_found_unsafe(
    mcc: Path, mcc_oracles: dict[str, dict[str, str]]
) -> None:
    for model, row in mcc_oracles.items():
        if row["safe"] != "1-safe":
            with pytest.raises(UnsafeError):
                reach(read_net(mcc / model / "model.pnml"))


def test_an_unsafe_firing_far_away_has_a_shortest_run() -> None:
    builder = NetBuilder("far")
    for i in range(30):
        builder.place(f"p{i}", initial=int(i == 0))
        builder.place(f"free{i}", initial=1)
        builder.place(f"taken{i}")
        builder.transition(f"take{i}", consume=[f"free{i}"], produce=[f"taken{i}"])
    for i in range(29):
        builder.transition(f"t{i}", consume=[f"p{i}"], produce=[f"p{i + 1}"])
    builder.place("twice", initial=1)
    builder.transition("unsafe", consume=["p29"], produce=["twice"])
    with pytest.raises(UnsafeError) as caught:
        reach(builder.build())  # about 3 * 10^10 markings before that firing
    assert caught.value.run == tuple(f"t{i}" for i in range(29))
    assert (caught.value.transition, caught.value.place) == ("unsafe", "twice")


def test_switches_have_the_closed_form() -> None:
    space = reach(switches(200))
    assert (space.states, space.edges) == (2**200, 200 * 2**200)
    assert space.max_tokens == 200
    assert len(space.encoding.places) == 200  # of each pair of complements one has a level


def ring(components: int) -> PetriNet:
    """Components of 8 states in a ring, half of them with a token to hand on: C(n, n/2) * 4^n markings."""
    builder = NetBuilder("ring")
    for i in range(components):
        for s in range(8):
            builder.place(f"c{i}s{s}", initial=int(s == (4 if i % 2 else 0)))
    for i in range(components):
        for s in range(8):
            if s % 4 != 3:
                builder.transition(f"c{i}on{s}", consume=[f"c{i}s{s}"], produce=[f"c{i}s{s + 1}"])
            else:
                builder.transition(f"c{i}back{s}", consume=[f"c{i}s{s}"], produce=[f"c{i}s{s - 3}"])
        j = (i + 1) % components
        builder.transition(f"hand{i}", consume=[f"c{i}s4", f"c{j}s0"], produce=[f"c{i}s0", f"c{j}s4"])
    return builder.build()


@pytest.mark.parametrize("components", [4, 16, 32])
def test_rings_have_the_closed_form(components: int) -> None:
    assert reach(ring(components)).states == comb(components, components // 2) * 4**components


def test_every_order_holds_every_place_once(reference: Path) -> None:
    net = read_net(reference / "ulysse_reference.net")
    orders = dict(candidates(net))
    assert {"file", "force", "force-rcm", "file-reversed"} <= orders.keys()
    for order in orders.values():
        assert sorted(order) == list(range(133))
    assert orders == dict(candidates(net))
    drawn = dict(candidates(net, 7))
    assert drawn.keys() > orders.keys()
    assert drawn == dict(candidates(net, 7))
    assert drawn["force-seed-7"] != dict(candidates(net, 8))["force-seed-8"]


def test_the_memory_limit_is_an_error_that_says_so() -> None:
    with pytest.raises(LimitError, match="memory limit of 100000 bytes"):
        reach(switches(4000), memory_limit=100_000)


def test_the_run_to_a_second_token_has_what_is_internal_in_its_place() -> None:
    builder = NetBuilder("hurried", priorities=True)
    for place, tokens in (("a", 1), ("b", 0), ("c", 1), ("d", 0), ("e", 1)):
        builder.place(place, initial=tokens)
    builder.transition("slow", consume=["e"], event=Event.parse("SLOW"))
    builder.transition("go", consume=["a"], produce=["b"], event=Event.parse("GO"))
    builder.transition("at once", consume=["b"], produce=["d"])
    builder.transition("too much", consume=["d"], produce=["c"], event=Event.parse("MORE"))
    net = builder.build()
    for explored in (reach, explore):
        with pytest.raises(UnsafeError) as caught:
            explored(net)
        error = caught.value
        assert (list(error.run), error.transition, error.place) == (["go", "at once"], "too much", "c")
        check_unsafe_run(net, error)


def test_the_run_to_a_second_token_respects_priorities() -> None:
    # From "hurried" the goal is one event away, too; but what is internal comes first there.
    builder = NetBuilder("two ways", priorities=True)
    for place, tokens in (("start", 1), ("hurried", 0), ("calm", 0), ("goal", 0), ("gone", 0), ("full", 1)):
        builder.place(place, initial=tokens)
    steps = (("start", "hurried"), ("hurried", "goal"), ("start", "calm"), ("calm", "goal"), ("goal", "full"))
    for source, target in steps:
        name = f"{source} {target}"
        builder.transition(name, consume=[source], produce=[target], event=Event.parse(name))
    builder.transition("at once", consume=["hurried"], produce=["gone"])
    for explored in (reach, explore):
        with pytest.raises(UnsafeError) as caught:
            explored(builder.build())
        assert list(caught.value.run) == ["start calm", "calm goal"]
        check_unsafe_run(builder.build(), caught.value)
