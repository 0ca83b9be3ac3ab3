"""Where two runs part: on any small graph of markings, against the definitions."""

from __future__ import annotations

from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.space.stable.parting import parting_runs

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
