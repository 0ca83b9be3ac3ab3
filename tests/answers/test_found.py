"""Sets of states that satisfy a formula: the same on every engine; what other libraries are given of them."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import fields
from functools import cache

import networkx
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcpn
from mcpn.answers.state_sets import FoundStates
from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.errors import InputError, LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.nets.petri import NetBuilder
from mcpn.spaces.diagrams.export import EMPTY, END, Diagram
from mcpn.spaces.engine_names import Engine, On
from mcpn.study import Study
from mcpn.testing import missions
from mcpn.testing.kit.corpus import MISSIONS
from mcpn.testing.nets import FAMILIES
from tests.draws import fewer
from tests.shares import returns_early

ENGINES: tuple[Engine, ...] = ("explicit", "symbolic", "local")


def markings(found: FoundStates) -> set[tuple[int, ...]]:
    return {tuple(found.space.marking(state)) for state in found.members()}


@fewer(0.2)
@given(missions(hardware=2, producers=1, sections=4), st.integers(0, 3), st.integers(0, 9))
def test_every_engine_finds_and_draws_the_same(mission: Mission, n: int, seed: int) -> None:
    study = Study(mission)
    try:
        by_engine = [study.satisfying("!EF success", engine=engine, max_states=3_000) for engine in ENGINES]
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    for engine, found in zip(ENGINES, by_engine, strict=True):
        # What is left once all that may succeed is taken away, by the answers to single states.
        assert found.count == len(markings(found)) == len(found)
        assert not found & study.satisfying("EF success", engine=engine, max_states=3_000)
    assert len({frozenset(markings(found)) for found in by_engine}) == 1
    samples = [found.sample(n, seed) for found in by_engine]
    assert samples[0] == samples[1] == samples[2]
    assert len(samples[0]) == min(n, by_engine[0].count)


def test_states_of_the_paper_s_mission(ulysse: Mission) -> None:
    study = mcpn.open(ulysse)
    every, able = study.satisfying(), study.satisfying("EF success")
    lost = every - able
    assert (every.count, able.count, lost.count) == (260, 244, 16)
    assert (able | lost).count == 260
    assert not able & lost
    assert repr(lost) == "<16 states, engine explicit: (true) & !(EF success)>"
    told = list(lost)
    assert all(isinstance(said, Situation) for said in told)
    assert Counter(said.outcome for said in told if isinstance(said, Situation)) == {"failure": 8, None: 8}
    with pytest.raises(ValueError, match="sets of two spaces do not mix"):
        able & study.satisfying("EF success", engine="symbolic")


def test_a_sample_is_drawn_evenly() -> None:
    """Of six markings each comes as often as others, also where places hold several tokens."""
    net = NetBuilder("tokens")
    net.place("left", initial=5)
    net.place("right")
    net.transition("go", consume=["left"], produce=["right"])
    net.transition("back", consume=["right"], produce=["left"])
    for engine in ("explicit", "symbolic"):
        found = Study(net.build()).satisfying(engine=engine)
        drawn = Counter(str(found.sample(1, seed)[0]) for seed in range(600))
        assert len(drawn) == found.count == 6
        assert min(drawn.values()) > 60
        assert len({str(said) for said in found.sample(6)}) == 6


@pytest.mark.parametrize("on", ["alternatives", "markings"])
@pytest.mark.parametrize("name", ["facts", "found late", "pauses"])
def test_a_graph_of_a_mission_says_in_networkx_what_its_states_say(name: str, on: On) -> None:
    """Each node says what the situation there says, and the tokens beside it."""
    study = mcpn.open(MISSIONS[name])
    listed = study.graph(on)
    graph = listed.to_networkx()
    assert len(graph) == len(listed) > 5
    for state, tokens in enumerate(listed):
        now = situation(study.mission_net, listed.marking(state))
        said = {field.name: getattr(now, field.name) for field in fields(now)}
        assert graph.nodes[state] == {"marking": tokens, **said}
    if on == "alternatives":
        found = study.satisfying().to_networkx()
        said_by = [Counter(str(node["mode"]) for _, node in g.nodes(data=True)) for g in (graph, found)]
        assert said_by[0] == said_by[1]


def test_states_go_to_networkx(ulysse: Mission) -> None:
    for engine in ENGINES:
        graph = mcpn.open(ulysse).satisfying(engine=engine).to_networkx()
        assert (graph.number_of_nodes(), graph.number_of_edges()) == (260, 1332)
        ends = [data for _, data in graph.nodes(data=True) if data["outcome"] == "success"]
        assert ends
        assert all(not data["objectives"] for data in ends)
        assert {"mode", "out_of_service", "facts"} <= ends[0].keys()
    able = mcpn.open(ulysse).satisfying("EF success & !success").to_networkx()
    assert networkx.number_of_nodes(able) < 244


@pytest.mark.parametrize("question", ["satisfying", "ctl", "states", "check", "causes", "graph"])
def test_a_word_that_names_no_engine_or_graph_is_refused(question: str, ulysse: Mission) -> None:
    """Another engine would answer in its name, and who compares engines compares one with itself."""
    asked = getattr(mcpn.open(ulysse), question)
    given = ("EF success",) if question in ("satisfying", "ctl") else ()
    if question != "graph":
        with pytest.raises(InputError, match=r"found the engine 'symbolical', expected one of auto"):
            asked(*given, engine="symbolical")
    if question not in ("check", "causes"):
        with pytest.raises(InputError, match=r"found the graph 'stable', expected one of markings, altern"):
            asked(*given, on="stable")
    if question in ("satisfying", "ctl"):
        with pytest.raises(InputError, match=r"found the engine 'pyeda', which only counts markings"):
            asked(*given, engine="pyeda")


def test_states_of_nets_are_tokens_by_place() -> None:
    found = Study(FAMILIES["philosophers"].net(3)).satisfying("AX false")
    assert found.count == 2
    assert all(not isinstance(said, Situation) and set(said.values()) == {1} for said in found)
    graph = found.to_networkx()
    assert (graph.number_of_nodes(), graph.number_of_edges()) == (2, 0)


def test_states_go_to_pandas(ulysse: Mission, monkeypatch: pytest.MonkeyPatch) -> None:
    found = mcpn.open(ulysse).satisfying("EF success")
    with monkeypatch.context() as patched:
        patched.setitem(sys.modules, "pandas", None)
        with pytest.raises(LimitError, match=r"a table needs pandas: pip install 'mcpn\[pandas\]'"):
            found.to_pandas()
    pytest.importorskip("pandas", reason="needs pandas: the extra pandas")
    table, none = found.to_pandas(), (found - found).to_pandas()
    assert (len(none), [*none.columns]) == (0, [*table.columns])
    assert len(table) == 244
    assert table["GPS_sensor"].dtype == bool
    assert (table["outcome"] == "success").sum() == len([s for s in found if s.outcome == "success"])  # type: ignore[union-attr]


def counted(diagram: Diagram) -> int:
    @cache
    def of(node: int) -> int:
        if node in (EMPTY, END):
            return int(node == END)
        return of(diagram.nodes[node].low) + of(diagram.nodes[node].high)

    return of(0) if diagram.nodes else 1


def test_diagrams_are_shown_node_by_node() -> None:
    """Paths to the end are markings; nodes are those that the engine counts."""
    study = Study(FAMILIES["philosophers"].net(4))
    found = study.satisfying(engine="symbolic")
    diagram = found.diagram()
    assert counted(diagram) == found.count == 322
    assert len(diagram) == found.states.nodes()
    graph = diagram.to_networkx()
    assert networkx.is_directed_acyclic_graph(graph)
    assert {data["place"] for n, data in graph.nodes(data=True) if n >= 0} <= {
        f"{sign}{place.name}" for place in study.net.places for sign in ("", "not ")
    }
    drawn = diagram.to_dot()
    assert drawn.count("[label=") == len(diagram) + 1
    assert drawn.count("style=") == sum(data != EMPTY for _, data in graph.edges())
    with pytest.raises(LimitError, match="engine explicit holds no diagram: ask with engine='symbolic'"):
        study.satisfying(engine="explicit").diagram()


def test_drawn_diagrams_show_names_as_they_are() -> None:
    """Graphviz knows no escapes of JSON, and reads ``&amp;`` as the sign."""
    builder = NetBuilder("n")
    builder.place("tête & queue", initial=1)
    builder.transition("t", consume={"tête & queue": 1})
    found = Study(builder.build()).satisfying(engine="symbolic")
    labels = [line for line in found.diagram().to_dot().splitlines() if line.startswith("  n0 [")]
    assert labels == ['  n0 [label="tête &amp; queue"];']


def test_graphs_have_a_length_and_can_be_walked(ulysse: Mission) -> None:
    graph = mcpn.open(ulysse).graph()
    assert len(graph) == graph.states == len(list(graph)) == 260
    assert next(iter(graph))["MISSION_begin"] == 1
