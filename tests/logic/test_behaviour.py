"""Liveness, reversibility and home markings, against their definitions on plain sets."""

from __future__ import annotations

from typing import Any

from hypothesis import assume, given

from mcpn.events import Event
from mcpn.logic.behaviour import Behaviour, check_net
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from tests.logic.formulas import Edges, edges_of
from tests.nets.nets import nets, reachable, state_machines


def ahead(edges: Edges, start: Marking) -> set[Marking]:
    found, stack = {start}, [start]
    while stack:
        for _, after in edges[stack.pop()]:
            if after not in found:
                found.add(after)
                stack.append(after)
    return found


@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]))
def test_behaviour_by_its_definitions(net: PetriNet) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    from_each = {marking: ahead(edges, marking) for marking in edges}
    fired = {marking: {t for at in found for t, _ in edges[at]} for marking, found in from_each.items()}
    spaces: tuple[Space[Any], ...] = ArraySpace(explore(net)), DiagramMarkings(reach(net))
    for space in spaces:
        found = Behaviour(space)
        everything = range(len(net.transitions))
        assert found.deadlock == any(not after for after in edges.values())
        assert found.quasi_live == fired[net.initial]
        assert found.live == {t for t in everything if all(t in later for later in fired.values())}
        assert found.all_live == (found.live == {*everything})
        assert found.reversible == all(net.initial in later for later in from_each.values())
        assert found.home_markings == sum(all(m in later for later in from_each.values()) for m in edges)
        constant = {p for p in range(len(net.places)) if len({m[p] for m in edges}) == 1}
        assert found.constant_places == constant


def test_one_component_that_lacks_a_transition_refutes_liveness() -> None:
    builder = NetBuilder("choice")
    for place in ("begin", *(f"{side}{n}" for side in "lmr" for n in (0, 1))):
        builder.place(place, initial=int(place == "begin"))
    for side in "lmr":
        builder.transition(f"go_{side}", consume=["begin"], produce=[f"{side}0"])
        for n in (0, 1):
            builder.transition(f"turn_{side}{n}", consume=[f"{side}{n}"], produce=[f"{side}{1 - n}"])

    class Looking(Behaviour[Any]):
        looked = 0

        def _bottom(self, within: Any) -> Any:
            self.looked += 1
            return super()._bottom(within)

    found = Looking(ArraySpace(explore(builder.build())))
    assert not found.all_live
    assert found.looked == 1
    assert found.live == frozenset()


def test_nets_with_priorities_and_several_tokens_are_told_alike() -> None:
    builder = NetBuilder("pairs", priorities=True)
    for place, tokens in (("free", 2), ("taken", 0), ("lost", 0)):
        builder.place(place, initial=tokens)
    for name, before, after in (("take", "free", "taken"), ("return", "taken", "free")):
        builder.transition(name, consume=[before], produce=[after], event=Event.parse(name))
    # Both are given back before anything else may happen: none is ever lost.
    builder.transition("both", consume={"taken": 2}, produce={"free": 2})
    builder.transition("lose", consume={"taken": 2}, produce=["lost"], event=Event.parse("lose"))
    found = check_net(builder.build())
    assert (found.safe, found.bounded.bounded, found.bound, found.states) == (False, True, 2, 3)
    assert (found.deadlock, found.deadlock_free) == (None, True)
    assert found.dead_transitions == found.not_live == ("lose",)
    assert (found.reversible, found.home_markings) == (True, 3)
