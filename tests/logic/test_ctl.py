"""CTL by diagrams, by arrays and by the definitions; and the contest's verdicts."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import pytest
from hypothesis import assume, event, given, reject
from hypothesis import strategies as st

from mcpn.answers.mission_names import progress
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.composite.composing import composite_space
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, InputError, LimitError
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import Justice
from mcpn.logic.questions import Questions
from mcpn.logic.syntax import parse
from mcpn.logic.witness import explain
from mcpn.mission.model import Mission
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramAlternatives, DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engine_names import Asked
from mcpn.spaces.formula_names import Names
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.markings.graph import StateGraph
from mcpn.spaces.search.goal import Formula
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.testing import missions
from tests.answers.components import ByComponents
from tests.draws import fewer
from tests.logic.formulas import Written, edges_of, formulas, read, satisfying
from tests.nets.nets import nets, reachable, state_machines
from tests.turns import ByTurns


def names(net: PetriNet) -> tuple[list[str], list[str]]:
    return [p.name for p in net.places], [t.name for t in net.transitions]


def satisfy(evaluation: Evaluation[Any], formula: Formula) -> set[Marking]:
    """The markings that satisfy a formula, picked one after the other."""
    space, found = evaluation.space, set()
    left = evaluation.states(formula)
    while left:
        state = left.pick()
        found.add(space.marking(state))
        left = left - space.single(state)
    return found


def by_components(evaluation: ByComponents, formula: Formula) -> set[Marking]:
    graph, found = evaluation.graph, evaluation.states(formula)
    return {graph.marking(state) for state in range(graph.states) if found[state]}


def spaces(net: PetriNet) -> list[Space[Any]]:
    reached = reach(net)
    return [ArraySpace(explore(net)), DiagramMarkings(reached), ByTurns(reached)]


@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]), st.data())
def test_spaces_and_the_definitions_agree(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    evaluations = list(map(Evaluation, spaces(net)))
    for formula in data.draw(st.lists(formulas(*names(net)), min_size=4, max_size=4)):
        expected = satisfying(formula, net, edges)
        core = read(formula, net)
        for evaluation in evaluations:
            assert evaluation.holds(core) == (net.initial in expected)
            assert satisfy(evaluation, core) == expected
            assert evaluation.holds(core) == (net.initial in expected)


def constraints(net: PetriNet) -> st.SearchStrategy[list[Justice]]:
    fires = st.lists(st.integers(0, len(net.transitions) - 1), max_size=2).map(tuple)
    places, transitions = names(net)
    states = formulas(places, transitions, leaves=2).map(lambda formula: read(formula, net))
    return st.lists(st.builds(Justice, states, fires if net.transitions else st.just(())), max_size=3)


class InRegions(ArraySpace):
    """Arrays that know their strongly connected components, in coarse groups."""

    def __init__(self, graph: StateGraph, groups: int) -> None:
        super().__init__(graph)
        reached = [self.reached(self.single(s)) for s in range(graph.states)]
        parts: list[Any] = [self.nothing] * groups
        for s in range(graph.states):
            # How many states a state reaches is the same throughout a component.
            part = reached[s].count() % groups
            parts[part] = parts[part] | self.single(s)
        self.regions = [part for part in parts if part]


class Hasty(Evaluation[Any]):
    """Leaves out of fair hulls at once all that cannot go on for ever."""

    first_steps = 0


@fewer(0.6)
@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]), st.data())
def test_fairness_on_every_space_agrees_with_components(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    fair = data.draw(constraints(net))
    graph = explore(net)
    everyone = [*spaces(net), InRegions(graph, data.draw(st.integers(1, 5)))]
    evaluations = [kind(space, fair) for space in everyone for kind in (Evaluation, Hasty)]
    oracle = ByComponents(graph, fair)
    for formula in data.draw(st.lists(formulas(*names(net)), min_size=4, max_size=4)):
        core = read(formula, net)
        for evaluation in evaluations:
            assert satisfy(evaluation, core) == by_components(oracle, core)
            assert evaluation.holds(core) == oracle.holds(core)


def check_witness(mission_net: MissionNet, evaluation: Evaluation[Any], core: Formula) -> None:
    """The run shown is one of the whole net, ends where its space says, and comes round where it says so."""
    net, witness = mission_net.net, explain(evaluation, core)
    marking = net.initial
    for t, after in witness.run.steps():
        assert t in net.enabled(marking)
        marking = net.fire(marking, t)
        assert marking == tuple(after)
    assert marking == witness.space.marking(witness.end)
    if witness.cycle is not None:
        before = [witness.start, *(edge.target for edge in witness.steps)][witness.cycle]
        assert witness.space.marking(before) == marking


@fewer(0.4)
@given(missions() | missions(late=True, sections=6), st.data())
def test_spaces_agree_on_both_graphs_of_missions(mission: Mission, data: st.DataObject) -> None:
    mission_net = compose(mission)
    net = mission_net.net
    try:
        markings = explore(net, max_states=500)
    except LimitError:
        reject()
    space = reach(net)
    graphs: list[tuple[StateGraph, list[Space[Any]]]] = [
        (markings, [ArraySpace(markings), DiagramMarkings(space)])
    ]
    try:
        reduced = by_reduction(markings)
        graphs.append((reduced, [ArraySpace(reduced), DiagramAlternatives(space)]))
    except (ConfluenceError, DivergenceError):
        assert mission_net.usage.contentions
    else:
        with suppress(LimitError):  # interruptions
            graphs[-1][1].append(composite_space(mission_net))
            event("by composition")
    drawn: list[Written] = data.draw(st.lists(formulas(*names(net), leaves=4), min_size=2, max_size=2))
    for graph, every in graphs:
        for fair in ((), progress(mission_net)):
            oracle = ByComponents(graph, fair)
            for formula in drawn:
                core = read(formula, net, mission_net)
                expected = by_components(oracle, core)
                for each in every:
                    assert satisfy(Hasty(each, fair), core) == expected
                    evaluation = Evaluation(each, fair)
                    assert evaluation.holds(core) == oracle.holds(core)
                    assert satisfy(evaluation, core) == expected
                    check_witness(mission_net, evaluation, core)


ENDS = "success | failure"


@pytest.mark.parametrize(
    ("engine", "on"),
    [
        ("symbolic", "markings"),
        ("explicit", "markings"),
        ("symbolic", "alternatives"),
        ("explicit", "alternatives"),
        ("local", "alternatives"),
    ],
)
@pytest.mark.parametrize(
    ("formula", "fair", "holds"),
    [
        (f"AG EF ({ENDS})", (), True),
        (f"AF ({ENDS})", (), False),  # a sensor may fail and recover for ever
        (f"AF ({ENDS})", ("progress",), True),
        ("AF success", ("progress",), False),
        ("EF failure", (), True),
        ("E[!success U oos(thruster_actuator) & E[oos(thruster_actuator) U success]]", (), False),
        ("EF (!success & oos(thruster_actuator) & E[oos(thruster_actuator) U success])", (), False),
        ("EF (oos(GPS_sensor) & !success & E[oos(GPS_sensor) U success])", (), True),
        ("AG (alternative(localisation)=gps_localisation -> !oos(GPS_sensor) | !stable)", (), True),
        ("AG (success -> AG success)", (), True),
        ("EF (objective(going_up) & alternative(localisation.imu_localisation))", (), True),
    ],
)
def test_ctl_formulas_of_ulysse_by_each_engine(
    ulysse_net: MissionNet, engine: Asked, on: str, formula: str, fair: tuple[str, ...], holds: bool
) -> None:
    questions = Questions(
        spaces_of(ulysse_net),
        on="markings" if on == "markings" else "alternatives",
        engine=engine,
        fair=fair,
    )
    assert questions.answer(formula).holds is holds


def test_words_need_a_mission(ulysse_net: MissionNet) -> None:
    with pytest.raises(InputError, match="is a word of missions"):
        parse("success", Names(ulysse_net.net))
    with pytest.raises(InputError, match="progress speaks of missions"):
        Questions(ulysse_net.net, fair=["progress"])
