"""Transitions that may fire on a cycle of markings."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.repeatable import repeatable
from tests.nets.nets import counter, graph_of, nets, token_nets


def test_a_counter_never_comes_back() -> None:
    assert repeatable(counter(12), range(12)) == frozenset()


def test_what_a_loop_needs_may_repeat_and_what_leads_into_it_may_not() -> None:
    builder = NetBuilder("loop")
    for place in ("begin", "a", "b"):
        builder.place(place, initial=int(place == "begin"))
    for name, source, target in (("enter", "begin", "a"), ("on", "a", "b"), ("back", "b", "a")):
        builder.transition(name, consume=[source], produce=[target])
    builder.transition("look", read=["a"])
    net = builder.build()
    assert repeatable(net, range(4)) == {1, 2, 3}
    assert repeatable(net, (0, 1, 3)) == {3}
    assert repeatable(net, ()) == frozenset()


def test_weights_beyond_the_solver_exclude_nothing() -> None:
    builder = NetBuilder("heavy")
    builder.place("p", initial=10**18)
    builder.transition("t", consume={"p": 10**18 - 1})
    assert repeatable(builder.build(), (0,)) == {0}


@given(nets(events=False) | token_nets(), st.data())
def test_what_fires_on_a_cycle_is_among_them(net: PetriNet, data: st.DataObject) -> None:
    graph = graph_of(net, limit=60)
    if graph is None or not net.transitions:
        return
    wanted = data.draw(st.sets(st.sampled_from(range(len(net.transitions)))))
    found = repeatable(net, wanted)
    assert found <= wanted
    ahead = {marking: {after for t, after in edges if t in wanted} for marking, edges in graph.items()}
    for marking, edges in graph.items():
        for t, after in edges:
            if t in wanted - found:  # then there is no way back
                reached, stack = {after}, [after]
                while stack:
                    new = ahead[stack.pop()] - reached
                    reached |= new
                    stack += new
                assert marking not in reached
