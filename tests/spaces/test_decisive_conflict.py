"""Where two runs part: on any small graph of markings, and on its net, against the definitions."""

from __future__ import annotations

from unittest import mock

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.errors import ConfluenceError, DivergenceError, SemanticsError, UnsafeError
from mcpn.events import Event
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.stable import run_to_completion
from mcpn.spaces.stable.alternatives import direct
from mcpn.spaces.stable.decisive_conflict import parting_runs
from mcpn.spaces.stable.run_to_completion import fault_after
from tests.spaces.runs import assert_parts, markings_of

Graph = dict[int, dict[int, int]]


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    """Markings behind marking 0, by transition, two of them stable; half of the graphs have no cycle."""
    size, cyclic = draw(st.integers(3, 7)), draw(st.booleans())
    drawn: Graph = {}
    for marking in range(size):
        later = st.integers(0 if cyclic else marking + 1, size - 1)
        successors = draw(st.lists(later, min_size=1, max_size=3)) if marking < size - 2 else []
        drawn[marking] = {10 * marking + i: successor for i, successor in enumerate(successors)}
    reached, queue = {0}, [0]
    for marking in queue:
        new = set(drawn[marking].values()) - reached
        reached |= new
        queue += sorted(new)
    return {marking: drawn[marking] for marking in sorted(reached)}


def distances(graph: Graph, start: int) -> dict[int, int]:
    found, queue = {start: 0}, [start]
    for marking in queue:
        for successor in graph[marking].values():
            if successor not in found:
                found[successor] = found[marking] + 1
                queue.append(successor)
    return found


def ends(graph: Graph, marking: int) -> set[int]:
    return {m for m in distances(graph, marking) if not graph[m]}


def has_cycle(graph: Graph) -> bool:
    return any(m in distances(graph, successor) for m in graph for successor in graph[m].values())


@given(graphs())
def test_runs_part_at_two_transitions_that_decide_the_end(graph: Graph) -> None:
    assume(len(ends(graph, 0)) > 1)
    runs = parting_runs(graph, 0)
    passed = [[0], [0]]
    for run, markings in zip(runs, passed, strict=True):
        for t in run:
            markings.append(graph[markings[-1]][t])
        assert not graph[markings[-1]]
    assert passed[0][-1] != passed[1][-1]
    deciding = {
        m: {next(iter(last)) for s in graph[m].values() if len(last := ends(graph, s)) == 1} for m in graph
    }
    nearest = min((d for m, d in distances(graph, 0).items() if len(deciding[m]) > 1), default=None)
    event(f"a marking decides: {nearest is not None}")
    if nearest is None:
        assert has_cycle(graph)
        return
    parted = next(i for i, (a, b) in enumerate(zip(*runs, strict=False)) if a != b)
    assert parted == nearest
    for run, markings in zip(runs, passed, strict=True):
        after = markings[parted + 1]
        assert ends(graph, after) == {markings[-1]}
        assert len(run) == parted + 1 + distances(graph, after)[markings[-1]]


def machine(graph: Graph, behind: int, *, beside: bool, overfull: int | None) -> PetriNet:
    """The graph as a state machine that some events lead to.

    Args:
        graph: The graph.
        behind: How many events.
        beside: Whether another token takes one internal step meanwhile.
        overfull: A marking from which a firing is unsafe.
    """
    builder = NetBuilder("machine", priorities=True)
    places = [builder.place(f"m{marking}", initial=int(marking == behind == 0)) for marking in range(7)]
    for number in range(behind):
        builder.place(f"e{number}", initial=int(number == 0))
    for number in range(behind):
        after = f"e{number + 1}" if number + 1 < behind else places[0]
        builder.transition(f"event{number}", consume=[f"e{number}"], produce=[after], event=Event.parse("E"))
    for marking, successors in graph.items():
        for t, successor in successors.items():
            builder.transition(f"t{t}", consume=[places[marking]], produce=[places[successor]])
    if beside:
        builder.place("here", initial=1)
        builder.place("there")
        # First of all transitions by its name and last by its number: it comes into each run late.
        builder.transition("along", consume=["here"], produce=["there"])
    if overfull is not None:
        builder.place("full", initial=1)
        builder.transition("over", consume=[places[overfull]], produce=["full"])
    return builder.build()


@pytest.mark.parametrize("listed", [run_to_completion.MOST_LISTED, 0])
@given(graphs(), st.integers(0, 2), st.booleans(), st.none() | st.integers(0, 6))
def test_every_interleaving_is_judged(
    listed: int, graph: Graph, behind: int, beside: bool, overfull: int | None
) -> None:
    if overfull not in graph:
        overfull = None
    net = machine(graph, behind, beside=beside, overfull=overfull)
    events = [net.transition_index[f"event{number}"] for number in range(behind)]
    cyclic, split = has_cycle(graph), len(ends(graph, 0)) > 1
    possible: set[type[SemanticsError]] = {
        kind
        for kind, holds in (
            (DivergenceError, cyclic),
            (ConfluenceError, split),
            (UnsafeError, overfull is not None),
        )
        if holds
    }
    event(f"{sorted(kind.__name__ for kind in possible)}")
    with mock.patch.object(run_to_completion, "MOST_LISTED", listed):
        told: list[SemanticsError | None] = [fault_after(net, events)]
        try:
            direct(net)
        except SemanticsError as error:
            told.append(error)
        else:
            told.append(None)
    for found in told:
        assert (found is None and not possible) or type(found) in possible
        if isinstance(found, ConfluenceError):
            assert_parts(net, *found.runs)
        elif isinstance(found, DivergenceError):
            passed = markings_of(net, found.runs[0])
            assert passed[-1] in passed[:-1]
        elif isinstance(found, UnsafeError):
            last = markings_of(net, found.run)[-1]
            assert max(net.fire(last, net.transition_index[found.transition])) > 1
