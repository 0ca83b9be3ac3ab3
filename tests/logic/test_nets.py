"""What is said of nets of no mission: by the definitions on every marking."""

from __future__ import annotations

from collections import deque

from hypothesis import assume, given

from mcpn.events import Event
from mcpn.logic.behaviour import NetCheck, check_net
from mcpn.logic.structure import Structure
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.report.nets import marking_after
from tests.nets.nets import graph_of, nets, pt_nets, state_machines, token_nets

Graph = dict[Marking, list[tuple[int, Marking]]]


def ahead(graph: Graph, start: Marking) -> dict[Marking, int]:
    """What a marking leads to, with the fewest firings."""
    found, queue = {start: 0}, deque([start])
    while queue:
        marking = queue.popleft()
        for _, after in graph[marking]:
            if after not in found:
                found[after] = found[marking] + 1
                queue.append(after)
    return found


def replay(net: PetriNet, run: tuple[str, ...]) -> Marking:
    marking = net.initial
    for name in run:
        assert net.transition_index[name] in net.enabled(marking)
        marking = net.fire(marking, net.transition_index[name])
    return marking


def confirm_reached(found: NetCheck, graph: Graph) -> None:
    """What every engine says of a bounded net."""
    net, distance = found.net, ahead(graph, found.net.initial)
    most = max((tokens for marking in graph for tokens in marking), default=0)
    assert found.bounded.bounded is True
    assert (found.bound, found.safe, found.states) == (
        most if most > 1 else found.bound,
        most <= 1,
        len(graph),
    )
    if not found.safe:
        assert found.bounded.bounds == tuple(max(of) for of in zip(*graph, strict=True))
    dead = [marking for marking in graph if not graph[marking]]
    assert found.deadlock_free == (not dead)
    if found.deadlock is None:
        assert not dead
    else:
        assert not net.enabled(replay(net, found.deadlock))
        assert len(found.deadlock) == min(distance[marking] for marking in dead)
        marked = {p.name: n for p, n in zip(net.places, replay(net, found.deadlock), strict=True) if n}
        assert marking_after(net, found.deadlock) == marked
    fired = {t for after in graph.values() for t, _ in after}
    assert found.dead_transitions == tuple(t.name for i, t in enumerate(net.transitions) if i not in fired)


@given(token_nets() | nets(max_weight=2, events=False) | state_machines().map(lambda drawn: drawn[0]))
def test_a_bounded_net_is_checked_by_the_definitions(net: PetriNet) -> None:
    graph = graph_of(net)
    assume(graph is not None)
    assert graph is not None
    found = check_net(net)
    confirm_reached(found, graph)
    later = {marking: ahead(graph, marking) for marking in graph}
    fired = {marking: {t for at in later[marking] for t, _ in graph[at]} for marking in graph}
    not_live = {t for t in range(len(net.transitions)) if any(t not in those for those in fired.values())}
    assert found.not_live == tuple(t.name for i, t in enumerate(net.transitions) if i in not_live)
    assert found.reversible == all(net.initial in those for those in later.values())
    assert found.home_markings == sum(all(m in those for those in later.values()) for m in graph)


@given(pt_nets())
def test_priorities_are_kept_where_places_hold_many_tokens(net: PetriNet) -> None:
    graph = graph_of(net)
    assume(net.priorities and graph is not None)
    assert graph is not None
    confirm_reached(check_net(net), graph)


def hurried(*, back: bool) -> PetriNet:
    """Two tokens that an event lets through one by one, unless what is internal takes them first."""
    builder = NetBuilder("hurried", priorities=True)
    for name, tokens in (("in", 2), ("gate", 1), ("out", 0), ("lost", 0)):
        builder.place(name, initial=tokens)
    builder.transition(
        "open", consume=["gate"], produce={"gate": 1, "out": 1}, read=["in"], event=Event.parse("GO")
    )
    builder.transition("pass", consume=["in", "out"], produce=["lost"])
    builder.transition("never", consume=["in"], read=["out"], event=Event.parse("LATE"))
    if back:
        builder.transition("back", consume={"lost": 2}, produce={"in": 2}, event=Event.parse("BACK"))
    return builder.build()


def test_a_dead_end_of_a_net_with_priorities() -> None:
    found = check_net(hurried(back=False))
    # Each GO puts a token out, and the net takes it with one that waits, before LATE may happen.
    assert found.deadlock == ("open", "pass", "open", "pass")
    assert (found.deadlock_free, found.dead_transitions, found.states) == (False, ("never",), 5)
    assert (found.safe, found.bound, found.bounded.bounds) == (False, 2, (2, 1, 1, 2))
    found = check_net(hurried(back=True))
    assert (found.deadlock_free, found.deadlock, found.states) == (True, None, 5)


def test_a_net_with_priorities_that_grows() -> None:
    builder = NetBuilder("grows", priorities=True)
    builder.place("on", initial=1)
    builder.place("heap")
    builder.transition("grow", read=["on"], produce=["heap"])
    found = check_net(builder.build())
    assert (found.bounded.bounded, found.safe, found.states, found.deadlock_free) == (
        False,
        False,
        None,
        None,
    )
    assert found.bounded.pump == ("grow",)


@given(token_nets() | nets(max_places=5, max_transitions=5) | state_machines().map(lambda drawn: drawn[0]))
def test_what_the_arcs_prove_is_so(net: PetriNet) -> None:
    found = Structure(net)
    graph = graph_of(net)
    words = " ".join(found.proves)
    if found.conservative:
        assert "bounded" in words
        for marking, after in (graph or {}).items():
            for _, target in after:
                for flow in found.parts.get("p_semiflows", ()):
                    assert sum(w * (target[p] - marking[p]) for p, w in flow.items()) == 0
    assume(graph is not None)
    assert graph is not None
    if "1-safe" in words:
        assert all(max(marking) <= 1 for marking in graph)
    fired = [{t for at in ahead(graph, marking) for t, _ in graph[at]} for marking in graph]
    live = all(len(those) == len(net.transitions) for those in fired)
    if "not live" in words:
        assert not live
    elif "live" in words:
        assert live


def ring(*tokens: int, shared: bool = False) -> PetriNet:
    """A token game round a ring, with a choice after the last place; ``shared`` makes it no free one."""
    builder = NetBuilder("ring")
    names = [builder.place(f"p{i}", initial=n) for i, n in enumerate(tokens)]
    for i, name in enumerate(names):
        builder.transition(f"t{i}", consume=[name], produce=[names[(i + 1) % len(names)]])
    more = [builder.place("key", initial=1)] if shared else []
    builder.transition("choice", consume=[names[-1], *more], produce=[names[0], *more])
    return builder.build()


def test_a_free_choice_net_is_live_exactly_if_its_siphons_hold_marked_traps() -> None:
    live, dead = Structure(ring(0, 1, 0)), Structure(ring(0, 0, 0))
    assert live.covered is dead.covered is True
    assert live.proves == [
        "bounded, whatever the initial marking: every place is in a P-semiflow",
        "1-safe: every place is in a state machine component with one token",
        "live: free choice, and every minimal siphon contains a marked trap",
    ]
    assert dead.proves == [
        "bounded, whatever the initial marking: every place is in a P-semiflow",
        "not live: free choice, and a minimal siphon does not contain a marked trap",
    ]
    # Two tokens are not 1-safe; a choice that is not free says nothing of liveness.
    assert not any(text.startswith("1-safe") for text in Structure(ring(1, 1)).proves)
    assert not any("live" in text for text in Structure(ring(0, 1, shared=True)).proves)


def test_a_part_of_the_structure_whose_limit_is_hit_is_left_out_and_named() -> None:
    pairs = 10
    builder = NetBuilder("wide")
    for i in range(pairs):
        for side in "ab":
            builder.place(f"{side}{i}", initial=1)
    for i in range(pairs):
        after = [f"{side}{(i + 1) % pairs}" for side in "ab"]
        builder.transition(f"t{i}", consume=[f"a{i}", f"b{i}"], produce=after)
    found = Structure(builder.build())
    # A place of each pair is a siphon, and a ring of tokens: too many rings, but not too many siphons.
    assert len(found.parts["siphons"]) == 2**pairs
    assert found.left_out.keys() == {"p_semiflows", "components"}
    assert all("limit on P-semiflows was hit" in text for text in found.left_out.values())
    assert not {"p_semiflows", "components"} & found.parts.keys()
    assert (found.conservative, found.covered) == (None, None)
    assert not any("bounded" in text or "safe" in text for text in found.proves)
