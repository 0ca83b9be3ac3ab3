"""What a Python user types first: it is there, it is loaded when it is used, its examples are true."""

from __future__ import annotations

import doctest
import subprocess
import sys
from importlib import import_module
from pathlib import Path
from typing import Any, assert_type

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

import mcpn
from mcpn.answers.causes.find import Causes
from mcpn.answers.verdicts.mission import MissionCheck
from mcpn.controller.modular import AnyController
from mcpn.errors import LimitError
from mcpn.logic.behaviour import NetCheck
from mcpn.logic.session import Answer
from mcpn.mission.model import Mission
from mcpn.nets.petri import PetriNet
from mcpn.report.pictures.drawing import Drawing
from mcpn.spaces.markings.graph import StateGraph
from mcpn.spaces.summary import SpaceSummary
from mcpn.testing import missions
from mcpn.testing.printing import as_xml
from tests.conftest import ROOT, ULYSSE
from tests.nets.nets import graph_of, pt_nets


@pytest.mark.parametrize("name", ["mcpn", "mcpn.study"])
def test_the_examples_are_true(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    found = doctest.testmod(import_module(name))
    assert found.attempted >= 3
    assert found.failed == 0


def test_every_name_is_there_and_can_be_called() -> None:
    for name in mcpn.__all__:
        assert name in dir(mcpn)
        assert callable(getattr(mcpn, name))
    with pytest.raises(AttributeError, match="no attribute 'verify'"):
        mcpn.verify  # noqa: B018


@pytest.mark.parametrize("name", mcpn.__all__)
def test_every_name_has_an_example(name: str) -> None:
    assert doctest.DocTestFinder(recurse=False).find(getattr(mcpn, name))[0].examples, name


def test_a_users_type_checker_sees_what_they_give() -> None:
    """Mypy reads this: py.typed, and the names that are loaded when they are used."""
    mission = mcpn.read_mission(Path(ULYSSE))
    assert_type(mission, Mission)
    study = mcpn.open(ULYSSE)
    assert_type(study, mcpn.Study)
    assert_type(mcpn.open(mission), mcpn.Study)
    assert_type(study.check(), MissionCheck | NetCheck)
    assert_type(study.verdicts(), MissionCheck)
    assert_type(study.states(), SpaceSummary)
    assert_type(study.graph(), StateGraph)
    assert_type(study.ctl("EF success"), Answer)
    assert_type(study.causes(), Causes)
    assert_type(study.controller(), AnyController)
    assert_type(study.picture(), Drawing)
    assert (Path(mcpn.__file__).parent / "py.typed").is_file()


def test_the_package_itself_loads_nothing() -> None:
    script = "import sys, mcpn\nprint(*sorted(m for m in sys.modules if m[:4] == 'mcpn' or m == 'numpy'))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["mcpn", "mcpn.version"]


@pytest.mark.parametrize(("drawn", "parts"), [(missions(), ()), (pt_nets(), ("places",))])
def test_a_failing_property_shows_its_example_whole(
    drawn: st.SearchStrategy[object], parts: tuple[str, ...]
) -> None:
    """The repr is short, what hypothesis prints of a failure is not."""
    seen: list[Any] = []

    @settings(max_examples=1, database=None, phases=[Phase.generate])
    @given(drawn)
    def fails(example: object) -> None:
        seen.append(example)
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError) as failed:
        fails()
    told = "\n".join(failed.value.__notes__)
    for part in parts:
        assert f"{part}=" in told
        assert all(f"name={each.name!r}" in told for each in getattr(seen[-1], part))
    if isinstance(seen[-1], Mission):
        assert all(line.strip() in told for line in as_xml(seen[-1]).splitlines())
        assert told.index("<mission ") < told.index("</mission>")
    assert repr(seen[-1]) not in told


def test_a_graph_of_states_goes_to_networkx(ulysse_markings: StateGraph) -> None:
    drawn = ulysse_markings.to_networkx()
    assert (drawn.number_of_nodes(), drawn.number_of_edges()) == (44299, 124078)
    net = ulysse_markings.net
    for state in (0, 17, 44298):
        assert drawn.nodes[state]["marking"].keys() == net.marked(ulysse_markings.marking(state))
        found = {(edge["transition"], target) for _, target, edge in drawn.out_edges(state, data=True)}
        assert found == {(net.transitions[t].name, to) for t, to in ulysse_markings.successors(state)}


@given(pt_nets())
def test_the_graph_of_a_net_is_that_of_its_rule(net: PetriNet) -> None:
    expected = graph_of(net, 200)
    if expected is None or (net.priorities and any(max(marking) > 1 for marking in expected)):
        return
    drawn = mcpn.open(net).graph("markings").to_networkx()
    names = [place.name for place in net.places]
    at = {
        state: tuple(marked.get(name, 0) for name in names) for state, marked in drawn.nodes(data="marking")
    }
    assert sorted(at.values()) == sorted(expected)
    edges = sorted((at[s], net.transition_index[name], at[t]) for s, t, name in drawn.edges(keys=True))
    assert edges == sorted((s, t, after) for s, fired in expected.items() for t, after in fired)
    assert {edge["event"] for *_, edge in drawn.edges(data=True)} <= {
        None if t.event is None else str(t.event) for t in net.transitions
    }


def test_the_graph_of_stable_states_has_events(ulysse: Mission) -> None:
    drawn = mcpn.open(ulysse).graph().to_networkx()
    assert (drawn.number_of_nodes(), drawn.number_of_edges()) == (260, 1332)
    assert all(edge["event"] for *_, edge in drawn.edges(data=True))
    with pytest.raises(LimitError):
        mcpn.open(ulysse).graph(max_states=100)
