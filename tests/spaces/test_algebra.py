"""Every space of states against plain graph search on its own edges, and against the other spaces."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.permanent_loss import mortal
from mcpn.errors import ConfluenceError, SemanticsError
from mcpn.events import What
from mcpn.logic.evaluate import largest
from mcpn.mission.model import Mission
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.algebra import Space, partition
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.bits import BitSpace
from mcpn.spaces.custom_engine import OwnSpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.markings.masked import mask_of
from mcpn.spaces.projections import ImageStore
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.spaces.stable.confluence_by_sets import prove_confluent
from mcpn.testing import missions
from tests.draws import composed, fewer
from tests.nets.nets import graph_of, state_machines
from tests.spaces.members import members
from tests.spaces.plain import PlainSets
from tests.turns import ByTurns

Graph = dict[Marking, list[tuple[int, Marking]]]
Spaces = dict[str, Space[Any]]

MOST_STATES = 400
"""Each set is taken apart state by state, some hundred times for one mission."""


def plain_graph(net: PetriNet, *, stable: bool) -> tuple[Marking, Graph]:
    """The markings graph, or the alternatives graph, by firing alone."""

    def settled(marking: Marking) -> Marking:
        while stable and (enabled := net.enabled(marking)) and net.transitions[enabled[0]].internal:
            marking = net.fire(marking, enabled[0])
        return marking

    start = settled(net.initial)
    graph: Graph = {}
    queue = [start]
    for marking in queue:
        if marking not in graph:
            graph[marking] = [(t, settled(net.fire(marking, t))) for t in net.enabled(marking)]
            queue += [after for _, after in graph[marking]]
    return start, graph


def markings_spaces(net: PetriNet) -> Spaces:
    reached = reach(net)
    diagrams = {"diagrams": DiagramMarkings(reached), "diagrams by turns": ByTurns(reached)}
    return {"arrays": ArraySpace(explore(net)), **diagrams, "of one's own": OwnSpace(net, PlainSets)}


def alternatives_spaces(mission_net: MissionNet) -> Spaces:
    space = reach(mission_net.net)
    prove_confluent(mission_net.net, space=space)
    graph = by_reduction(explore(mission_net.net))
    return {
        "arrays": ArraySpace(graph),
        "bits": BitSpace(
            graph.net,
            [mask_of(graph.marking(state)) for state in range(graph.states)],
            [list(graph.successors(state)) for state in range(graph.states)],
        ),
        "diagrams": DiagramAlternatives(space),
        "composite": composite_space(mission_net),
    }


class Questions:
    """Draws sets and transitions, and asks every space and plain search the same of them."""

    def __init__(self, draw: Callable[[Any], Any], start: Marking, graph: Graph, spaces: Spaces) -> None:
        self.draw = draw
        self.start, self.graph, self.spaces = start, graph, spaces
        self.net = next(iter(spaces.values())).net

    def places(self) -> list[int]:
        places: list[int] = self.draw(
            st.lists(st.sampled_from(range(len(self.net.places))), max_size=3, unique=True)
        )
        return places

    def transitions(self) -> list[int] | None:
        some = st.sets(st.sampled_from(range(len(self.net.transitions)))).map(sorted)
        drawn: list[int] | None = self.draw(st.none() | some | some.map(self.all_but))
        return drawn

    def all_but(self, some: list[int]) -> list[int]:
        return [t for t in range(len(self.net.transitions)) if t not in some]

    def states(self) -> tuple[set[Marking], dict[str, Any]]:
        places, negated = self.places(), self.draw(st.booleans())
        plain = {m for m in self.graph if any(m[p] for p in places) != negated}
        sets = {
            n: s.everything - s.marked(places) if negated else s.marked(places)
            for n, s in self.spaces.items()
        }
        self.same(plain, lambda s, n: sets[n])
        return plain, sets

    def same(self, plain: set[Marking], asked: Callable[[Space[Any], str], Any]) -> None:
        for name, space in self.spaces.items():
            found = asked(space, name)
            assert found.count() == len(plain), name
            assert members(space, found) == plain, name
            assert bool(found) == bool(plain), name

    def edges(self, transitions: Iterable[int] | None) -> list[tuple[Marking, int, Marking]]:
        wanted = None if transitions is None else set(transitions)
        return [(m, t, a) for m, to in self.graph.items() for t, a in to if wanted is None or t in wanted]

    def ask(self) -> None:
        graph, same = self.graph, self.same
        same({self.start}, lambda s, n: s.initial)
        same(set(graph), lambda s, n: s.everything)
        same(set(), lambda s, n: s.nothing)
        same({m for m, to in graph.items() if not to}, lambda s, n: s.dead)
        stable = {m for m in graph if not any(self.net.transitions[t].internal for t in self.net.enabled(m))}
        same(stable if self.net.priorities else set(graph), lambda s, n: s.stable)
        a, sets_a = self.states()
        b, sets_b = self.states()
        same(a | b, lambda s, n: sets_a[n] | sets_b[n])
        same(a & b, lambda s, n: sets_a[n] & sets_b[n])
        same(a - b, lambda s, n: sets_a[n] - sets_b[n])
        along = self.draw(st.booleans())
        inside = b if along else set(graph)
        wanted = self.transitions()
        edges = self.edges(wanted)
        within = (lambda n: sets_b[n]) if along else (lambda n: None)
        same({m for m, _, t in edges if t in a}, lambda s, n: s.before(sets_a[n], wanted))
        same({t for m, _, t in edges if m in a}, lambda s, n: s.after(sets_a[n], wanted))
        same({m for m, _, _ in edges}, lambda s, n: s.enabling(s_all(s) if wanted is None else wanted))
        back = set(a)
        while more := {m for m, _, t in edges if t in back and m in inside} - back:
            back |= more
        same(back, lambda s, n: s.reaching(sets_a[n], within(n), wanted))
        forth = a & inside
        while more := {t for m, _, t in edges if m in forth and t in inside} - forth:
            forth |= more
        same(forth, lambda s, n: s.reached(sets_a[n], within(n), wanted))
        self.ask_guards(a, sets_a, b, sets_b)
        crossing: dict[int, set[Marking]] = {}
        for m, t, after in self.edges(None):
            if m in a and after in b:
                crossing.setdefault(t, set()).add(m)
        for name, space in self.spaces.items():
            found = list(space.crossing(sets_a[name], sets_b[name]))
            assert [t for t, _ in found] == sorted(crossing), name
            assert {t: members(space, states) for t, states in found} == crossing, name
        stays = set(a)
        while lost := {m for m in stays if graph[m] and not any(t in stays for _, t in graph[m])}:
            stays -= lost
        same(stays, lambda s, n: s.staying(sets_a[n]))
        for name, space in self.spaces.items():
            some = space.staying(sets_a[name], sets_b[name])
            assert bool(sets_b[name] & some) == bool(stays & b), name
        huge = st.integers(-(2**63) + 1, 2**63 - 1)
        drawn = self.draw(st.lists(st.integers(-2, 2) | huge, min_size=3, max_size=3))
        weights = dict(zip(self.places(), drawn, strict=False))
        sums = sorted({sum(m[p] * w for p, w in weights.items()) for m in graph})
        near = st.sampled_from(sums).flatmap(lambda at: st.integers(at - 1, at + 1))
        bound = self.draw(st.integers(-3, 3) | near | huge)
        same(
            {m for m in graph if sum(m[p] * w for p, w in weights.items()) <= bound},
            lambda s, n: s.at_most(weights, bound),
        )
        self.ask_images(a, sets_a)
        self.ask_runs(a, sets_a, inside, within, wanted)
        for name, space in self.spaces.items():
            counts = {t: n for t, n in space.firings(sets_a[name]).items() if n}
            expected: dict[int, int] = {}
            for m in a:
                for t, _ in graph[m]:
                    expected[t] = expected.get(t, 0) + 1
            assert counts == expected, name
            for index, region in enumerate(space.regions):
                others = [r for i, r in enumerate(space.regions) if i != index]
                assert not any(region & other for other in others), name
            assert sum(region.count() for region in space.regions) == len(graph), name

    def ask_guards(
        self, a: set[Marking], sets_a: dict[str, Any], b: set[Marking], sets_b: dict[str, Any]
    ) -> None:
        """Closures and steps where some ends of objectives may be taken from some states only."""
        objectives = [
            i
            for i, t in enumerate(self.net.transitions)
            if t.event and t.event.what in (What.SUCCESS, What.FAILURE)
        ]
        if not objectives:
            return
        chosen = self.draw(st.lists(st.sampled_from(objectives), max_size=2, unique=True))
        edges = [(m, t, after) for m, t, after in self.edges(None) if t not in chosen or m in b]
        guards = {n: dict.fromkeys(chosen, sets_b[n]) for n in self.spaces}
        back, forth = set(a), set(a)
        while more := {m for m, _, t in edges if t in back} - back:
            back |= more
        while more := {t for m, _, t in edges if m in forth} - forth:
            forth |= more
        self.same({m for m, _, t in edges if t in a}, lambda s, n: s.before(sets_a[n], None, guards[n]))
        self.same({t for m, _, t in edges if m in a}, lambda s, n: s.after(sets_a[n], None, guards[n]))
        self.same(back, lambda s, n: s.reaching(sets_a[n], None, None, guards[n]))
        self.same(forth, lambda s, n: s.reached(sets_a[n], None, None, guards[n]))
        for name, space in self.spaces.items():
            run = space.run(space.initial.pick(), sets_a[name], None, None, guards[name])
            assert (run is None) == (self.start not in back), name
            at = self.start
            for edge in run or ():
                after = space.marking(edge.target)
                assert (at, edge.transition, after) in edges, name
                at = after
            assert run is None or at in a, name

    def ask_images(self, a: set[Marking], sets_a: dict[str, Any]) -> None:
        places = self.places()
        images = ImageStore(len(places))
        rows = {tuple(i for i, p in enumerate(places) if m[p]) for m in a}
        expected = images.of_rows(rows)
        least = sorted((r for r in rows if not any(set(o) < set(r) for o in rows)), key=lambda r: (len(r), r))
        for name, space in self.spaces.items():
            found = space.image(sets_a[name], places, images)
            assert found == expected, name
            divided = partition(space, sets_a[name], places, images)
            parts = {marked: members(space, part) for marked, part in divided}
            assert parts == {
                frozenset(places[i] for i in row): {
                    m for m in a if tuple(i for i, p in enumerate(places) if m[p]) == row
                }
                for row in rows
            }, name
            assert sorted(images.minimal(found), key=lambda r: (len(r), r)) == least

    def ask_runs(
        self, goal: set[Marking], sets: dict[str, Any], inside: set[Marking], within: Any, wanted: Any
    ) -> None:
        distance = dict.fromkeys(goal, 0)
        edges = self.edges(wanted)
        length = 0
        while more := {m for m, _, t in edges if distance.get(t) == length and m in inside} - distance.keys():
            length += 1
            distance.update(dict.fromkeys(more, length))
        for name, space in self.spaces.items():
            begin = space.initial.pick()
            run = space.run(begin, sets[name], within(name), wanted)
            assert (run is None) == (self.start not in distance), name
            if run is None:
                continue
            if name != "composite":
                assert len(run) == distance[self.start], name
            at = self.start
            for edge in run:
                assert at in inside or at in goal
                assert wanted is None or edge.transition in wanted
                after = space.marking(edge.target)
                assert (edge.transition, after) in self.graph[at], name
                at = after
            assert at in goal, name
            assert {(e.transition, space.marking(e.target)) for e in space.edges(begin)} == set(
                self.graph[self.start]
            )


def s_all(space: Space[Any]) -> list[int]:
    return list(range(len(space.net.transitions)))


@fewer(0.4, least=4)
@given(missions(max_hardware=2, max_producers=1, max_sections=4), st.data())
def test_spaces_of_markings_agree_with_plain_search(mission: Mission, data: st.DataObject) -> None:
    net = composed(mission).net
    start, graph = plain_graph(net, stable=False)
    assume(len(graph) <= MOST_STATES)
    Questions(data.draw, start, graph, markings_spaces(net)).ask()


@fewer(0.4, least=4)
@given(
    missions(max_hardware=3, max_producers=2) | missions(max_hardware=2, max_producers=1, late=True),
    st.data(),
)
def test_spaces_of_alternatives_agree_with_plain_search(mission: Mission, data: st.DataObject) -> None:
    mission_net = composed(mission)
    try:
        spaces = alternatives_spaces(mission_net)
    except SemanticsError:
        assume(False)
    start, graph = plain_graph(mission_net.net, stable=True)
    assume(len(graph) <= MOST_STATES)
    Questions(data.draw, start, graph, spaces).ask()


@pytest.mark.parametrize("kind", ["markings", "alternatives"])
def test_spaces_of_ulysse_have_its_sizes(ulysse_net: MissionNet, kind: str) -> None:
    spaces = markings_spaces(ulysse_net.net) if kind == "markings" else alternatives_spaces(ulysse_net)
    spaces.pop("of one's own", None)  # sets of Python take half a minute
    for space in spaces.values():
        assert space.everything.count() == (44299 if kind == "markings" else 260)
        assert sum(space.firings(space.everything).values()) == (124078 if kind == "markings" else 1332)


@fewer(0.4, least=4)
@given(
    missions(max_hardware=2, max_producers=2, max_sections=4)
    | missions(max_hardware=2, max_producers=1, max_sections=4, late=True, lasting=True),
    st.data(),
)
def test_spaces_of_mortal_hardware_agree_with_plain_search(mission: Mission, data: st.DataObject) -> None:
    mission_net = composed(mission)
    try:
        prove_confluent(mission_net.net)
    except SemanticsError:
        assume(False)
    whole = mortal(mission_net)
    start, graph = plain_graph(whole.net, stable=True)
    assume(len(graph) <= MOST_STATES)
    spaces: Spaces = {
        "diagrams": DiagramAlternatives(reach(whole.net)),
        "composite": composite_space(mission_net, may_die=True),
    }
    Questions(data.draw, start, graph, spaces).ask()


@fewer(0.4, least=4)
@given(missions(max_hardware=3, max_producers=2))
def test_the_composite_refuses_what_is_not_confluent(mission: Mission) -> None:
    mission_net = composed(mission)
    net = mission_net.net
    try:
        prove_confluent(net)
    except SemanticsError as error:
        kind = type(error)
    else:
        composite_space(mission_net)
        return
    with pytest.raises(kind) as caught:
        composite_space(mission_net)
    ends = {_replayed(net, run) for run in caught.value.runs}
    assert kind is not ConfluenceError or len(ends) == 2


def _replayed(net: PetriNet, run: Iterable[str]) -> Marking:
    """Where a run leads; internal firings that it leaves out before an event are the only ones there are."""
    marking = net.initial
    for name in run:
        t = net.transition_index[name]
        while t not in net.enabled(marking):
            internal = [i for i in net.enabled(marking) if net.transitions[i].internal]
            assert internal, name
            marking = net.fire(marking, internal[0])
        marking = net.fire(marking, t)
    return marking


@given(state_machines(), st.data())
def test_every_space_knows_the_largest_sum_of_tokens(
    drawn: tuple[PetriNet, int], data: st.DataObject
) -> None:
    """In one pass over a diagram, from arrays, and by halving where a space knows no more than sets."""
    net, _ = drawn
    graph = graph_of(net)
    assume(graph is not None)
    weights = data.draw(st.dictionaries(st.integers(0, len(net.places) - 1), st.integers(0, 5)))
    wanted = max(sum(w * marking[p] for p, w in weights.items()) for marking in graph or ())
    assert {name: largest(space, weights) for name, space in markings_spaces(net).items()} == dict.fromkeys(
        markings_spaces(net), wanted
    )
