"""Firing, priorities and building."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given

from mcpn.errors import InputError
from mcpn.events import Event
from mcpn.nets.petri import NetBuilder, PetriNet, Place, Transition
from tests.nets.nets import nets


def test_internal_transitions_come_before_events() -> None:
    builder = NetBuilder("n", priorities=True)
    builder.place("p", initial=1)
    builder.transition("internal", consume=["p"])
    builder.transition("event", consume=["p"], event=Event.parse("EV"))
    assert builder.build().enabled((1,)) == [0]
    builder = NetBuilder("n", priorities=False)
    builder.place("p", initial=1)
    builder.transition("internal", consume=["p"])
    builder.transition("event", consume=["p"], event=Event.parse("EV"))
    assert builder.build().enabled((1,)) == [0, 1]


def test_read_arcs_ask_and_leave() -> None:
    builder = NetBuilder("n")
    builder.place("p", initial=2)
    builder.place("q")
    builder.transition("t", read={"p": 2}, produce=["q"])
    builder.transition("u", read={"p": 3})
    net = builder.build()
    assert net.enabled(net.initial) == [0]
    assert net.fire(net.initial, 0) == (2, 1)


def test_builders_refuse_what_makes_no_sense() -> None:
    builder = NetBuilder("n")
    builder.place("p")
    with pytest.raises(InputError, match="place p is declared twice"):
        builder.place("p")
    builder.transition("t", consume=["q"])
    with pytest.raises(InputError, match="transition t is declared twice"):
        builder.transition("t")
    with pytest.raises(InputError, match="transition t names the place q"):
        builder.build()


@pytest.mark.parametrize("number", [-1, 0.5, 2.0, True, "1", None])
def test_tokens_and_weights_are_whole_numbers(number: Any) -> None:
    """Else an engine would count with them, and a file be written that no reader takes."""
    builder = NetBuilder("n")
    with pytest.raises(InputError, match=f"place p: found {number!r}, expected a whole number from 0"):
        builder.place("p", initial=number)
    builder.place("p")
    arcs: list[dict[str, Any]] = [{side: {"p": number}} for side in ("consume", "produce", "read")]
    for side in arcs:
        with pytest.raises(InputError, match=f"transition t, place p: found {number!r}, expected a whole"):
            builder.transition("t", **side)
    assert builder.build().transitions == ()


def safe_at_first(net: PetriNet) -> PetriNet:
    """The net with at most one token in each place."""
    return replace(net, places=tuple(replace(p, initial=min(p.initial, 1)) for p in net.places))


@given(nets(max_weight=3).map(safe_at_first))
def test_the_safe_view_fires_like_the_net_where_it_is_safe(net: PetriNet) -> None:
    marked = {p for p, tokens in enumerate(net.initial) if tokens}
    for number, safe in enumerate(net.safe_transitions):
        enabled = not safe.blocked and marked >= {*safe.consume, *safe.read}
        assert enabled == net.covers(net.initial, number)
        if enabled:
            after = net.fire(net.initial, number)
            doubled = (marked - set(safe.consume)) & set(safe.produce) or set(safe.overflow)
            assert bool(doubled) == (max(after) > 1)
            if not doubled:
                kept = (marked - set(safe.consume)) | set(safe.produce)
                assert {p for p, tokens in enumerate(after) if tokens} == kept


@given(nets(max_weight=3))
def test_what_is_enabled_is_what_has_its_tokens(net: PetriNet) -> None:
    covered = [t for t in range(len(net.transitions)) if net.covers(net.initial, t)]
    least = min((net.ranks[t] for t in covered), default=0)
    assert net.enabled(net.initial) == [t for t in covered if not net.priorities or net.ranks[t] == least]


def test_the_hash_of_a_net_asks_none_of_its_nodes(monkeypatch: pytest.MonkeyPatch) -> None:
    def made() -> PetriNet:
        builder = NetBuilder("n")
        builder.place("p", initial=1)
        builder.transition("t", consume=["p"])
        return builder.build()

    one, other = made(), made()
    assert one == other
    for node in (Place, Transition):
        monkeypatch.setattr(node, "__hash__", None)
    assert hash(one) == hash(other)
