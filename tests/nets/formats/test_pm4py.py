"""Nets that pm4py has written are read with the same markings, and what is written is read by pm4py so.

pm4py brings pandas, scipy and more: of the extras ``test-all`` alone has it.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest

from mcpn.nets.formats import read_net, save_net
from mcpn.nets.petri import NetBuilder, PetriNet
from tests.nets.nets import reachable

MOST = 300
"""Markings of a drawn net."""
pytestmark = pytest.mark.filterwarnings("ignore:the Petri net has been imported without")
COUNTS = [30, pytest.param(300, marks=pytest.mark.slow)]


@pytest.fixture(scope="module")
def pm4py() -> Any:
    return pytest.importorskip("pm4py", reason="pm4py is not installed")


def drawn(rng: random.Random) -> PetriNet:
    """A net of a few places, with weights, several tokens and isolated nodes, and few markings."""
    while True:
        builder = NetBuilder("drawn")
        places = [f"p{n}" for n in range(rng.randint(1, 5))]
        for place in places:
            builder.place(place, initial=rng.choice([0, 0, 1, 1, 2]), label=f"place {place}")
        for number in range(rng.randint(1, 6)):
            consume, produce = (
                {
                    place: rng.choice([1, 1, 1, 2])
                    for place in rng.sample(places, min(len(places), rng.randint(0, 2)))
                }
                for _ in range(2)
            )
            read = {p: 1 for p in rng.sample(places, 1) if p not in consume and p not in produce}
            builder.transition(
                f"t{number}", consume=consume, produce=produce, read=read if number % 3 == 0 else {}
            )
        net = builder.build()
        if counted(net) is not None:
            return net


def counted(net: PetriNet, most: int = MOST) -> tuple[int, int] | None:
    """How many markings and firings a net has; ``None`` where there are more markings than so many."""
    found, todo, edges = {net.initial}, [net.initial], 0
    while todo:
        marking = todo.pop()
        for t in net.enabled(marking):
            edges += 1
            after = net.fire(marking, t)
            if after not in found:
                found.add(after)
                todo.append(after)
        if len(found) > most:
            return None
    return len(found), edges


def counted_by_pm4py(pm4py: Any, net: Any, initial: Any) -> tuple[int, int]:
    """How many markings and firings pm4py finds, by its own definition of firing."""
    from pm4py.objects.petri_net import semantics

    found, todo, edges = {frozenset(initial.items())}, [initial], 0
    while todo:
        marking = todo.pop()
        for transition in semantics.enabled_transitions(net, marking):
            edges += 1
            after = semantics.execute(transition, net, marking)
            if (key := frozenset(after.items())) not in found:
                found.add(key)
                todo.append(after)
    return len(found), edges


def of_pm4py(net: PetriNet) -> tuple[Any, Any]:
    """The same net as an object of pm4py; a read arc is a consuming and a producing arc."""
    from pm4py.objects.petri_net.obj import Marking
    from pm4py.objects.petri_net.obj import PetriNet as Net
    from pm4py.objects.petri_net.utils.petri_utils import add_arc_from_to

    made, initial = Net(net.name), Marking()
    places = [Net.Place(place.name) for place in net.places]
    made.places.update(places)
    for place, tokens in zip(places, net.initial, strict=True):
        if tokens:
            initial[place] = tokens
    for number, t in enumerate(net.transitions):
        transition = Net.Transition(t.name, f"activity {number}" if number % 2 else None)
        made.transitions.add(transition)
        for p, weight in (*t.consume, *t.read):
            add_arc_from_to(places[p], transition, made, weight)
        for p, weight in (*t.produce, *t.read):
            add_arc_from_to(transition, places[p], made, weight)
    return made, initial


@pytest.mark.parametrize("count", COUNTS)
def test_what_pm4py_writes_is_read(pm4py: Any, tmp_path: Path, count: int, fresh_seed: int) -> None:
    rng = random.Random(fresh_seed)
    for _ in range(count):
        net = drawn(rng)
        made, initial = of_pm4py(net)
        pm4py.write_pnml(made, initial, initial, str(tmp_path / "n.pnml"))
        back = read_net(tmp_path / "n.pnml")
        assert counted(back) == counted(net) == counted_by_pm4py(pm4py, made, initial)
        assert {p.name for p in back.places} == {p.name for p in net.places}
        labels = {t.name: t.label for t in back.transitions}
        for number, t in enumerate(net.transitions):
            if number % 2:
                assert labels[t.name] == f"activity {number}"


@pytest.mark.parametrize("count", COUNTS)
def test_what_is_written_is_read_by_pm4py(pm4py: Any, tmp_path: Path, count: int, fresh_seed: int) -> None:
    rng = random.Random(fresh_seed)
    for _ in range(count):
        net = drawn(rng)
        save_net(net, tmp_path / "n.pnml")
        made, initial, _final = pm4py.read_pnml(str(tmp_path / "n.pnml"))
        assert counted_by_pm4py(pm4py, made, initial) == counted(net)


def test_safe_nets_are_counted_as_elsewhere() -> None:
    """The counter of these tests against that of others."""
    builder = NetBuilder("n")
    builder.place("p", initial=1)
    builder.place("q")
    builder.transition("t", consume=["p"], produce=["q"])
    markings, edges, safe = reachable(builder.build())
    assert (len(markings), edges) == counted(builder.build())
    assert safe
