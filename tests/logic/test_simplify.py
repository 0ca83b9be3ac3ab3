"""Simplified formulas hold where the formulas do, and files are answered as the definitions say."""

from __future__ import annotations

from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.errors import Source
from mcpn.logic.answering import answer_all
from mcpn.logic.contest import Property
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX, says_one_state
from mcpn.logic.implied import bounds_of, conditions, weaker
from mcpn.logic.questions import Questions
from mcpn.logic.simplify import simplified
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.nets.structure import place_bounds
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.facts import Facts
from mcpn.spaces.search.goal import FALSE, TRUE, And, AtMost, Deadlock, Not, Or, as_goal, holds
from mcpn.turns import finished
from tests.draws import fewer
from tests.logic.formulas import Written, edges_of, formulas, read, satisfying
from tests.nets.nets import graph_of, nets, reachable, state_machines, token_nets

NETS = nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0])
PLAIN = nets(max_places=5, max_transitions=6, events=False) | state_machines().map(lambda drawn: drawn[0])


def drawn(data: st.DataObject, net: PetriNet, leaves: int = 6) -> Written:
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    formula: Written = data.draw(formulas(places, transitions, leaves=leaves))
    return formula


@fewer(0.5)
@given(NETS, st.data())
def test_simplified_formulas_hold_in_the_same_states(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges, evaluation = edges_of(net), Evaluation(ArraySpace(explore(net)))
    for _ in range(4):
        formula = drawn(data, net, leaves=8)
        core = read(formula, net)
        smaller = simplified(core, net, place_bounds(net))
        assert sum(1 for _ in smaller.walk()) <= sum(1 for _ in core.walk())
        found: set[Marking] = set()
        left = evaluation.states(smaller)
        while left:
            state = left.pick()
            found.add(evaluation.space.marking(state))
            left = left - evaluation.space.single(state)
        assert found == satisfying(formula, net, edges)


@fewer(0.5)
@given(PLAIN | token_nets(), st.data())
def test_next_is_spelled_out_as_a_condition_on_markings(net: PetriNet, data: st.DataObject) -> None:
    graph = graph_of(net)
    assume(graph is not None)
    assert graph is not None
    of_states = formulas([p.name for p in net.places], [t.name for t in net.transitions], of_paths=False)
    condition = read(data.draw(of_states), net)
    infinite = [float("inf")] * len(net.places)
    spelled = simplified(EX(EX(condition)), net, infinite, spelled=True)
    goal, after_two = as_goal(spelled, net), as_goal(condition, net)
    assert after_two is not None
    assume(goal is not None)  # what asks whether anything fires stays as it is
    assert goal is not None
    for marking, edges in graph.items():
        ends = [end for _, after in edges for _, end in graph[after]]
        assert holds(goal, net, marking) == any(holds(after_two, net, end) for end in ends)


@fewer(0.5)
@given(NETS, st.data())
def test_bounds_of_a_formula_hold_in_more_states_and_in_fewer(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    evaluation = Evaluation(ArraySpace(explore(net)))
    for _ in range(4):
        core = read(drawn(data, net, leaves=8), net)
        for part in (f for f in core.walk() if isinstance(f, EX | EU | EG)):
            here = evaluation.states(part)
            assert not here - evaluation.states(weaker(part))
            assert not evaluation.states(~weaker(part, wanted=False)) - here
            above, below = bounds_of(part)
            assert not here - evaluation.states(above)
            assert not evaluation.states(below) - here
            assert not any(isinstance(f, EX | EU | EG) for f in weaker(part).walk())


@fewer(0.5)
@given(PLAIN, st.data())
def test_conditions_that_are_said_to_be_constant_are(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    markings = edges_of(net)
    cores = [read(drawn(data, net, leaves=8), net) for _ in range(4)]
    asked = {condition for core in cores for condition in conditions(core)}
    facts = Facts(net)
    finished(facts.knowing_transitions())
    finished(facts.knowing(asked))
    for condition in asked:
        goal = as_goal(condition, net)
        assert goal is not None
        values = {holds(goal, net, marking) for marking in markings}
        assert facts.always(condition) is None or values == {facts.always(condition)}


@fewer(0.5)
@given(PLAIN, st.data())
def test_files_are_answered_as_the_definitions_say(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    asked = {f"f{i}": drawn(data, net, leaves=6) for i in range(4)}
    properties = [Property(name, read(formula, net), Source("file")) for name, formula in asked.items()]
    answers = {found.name: found.value for found in answer_all(Questions(net), properties)}
    expected = {name: net.initial in satisfying(f, net, edges) for name, f in asked.items()}
    assert answers == {name: str(value).upper() for name, value in expected.items()}


def test_idempotent_and_dual_operators() -> None:
    f, g, h = Deadlock(), EX(Deadlock()), AtMost(((0, 1),), 0)
    for written, wanted in (
        (EU(TRUE, EU(TRUE, f)), EU(TRUE, f)),
        (EU(TRUE, EU(g, f)), EU(TRUE, f)),
        (EU(g, EU(g, f)), EU(g, f)),
        (EU(g, Or(f, EU(g, f))), EU(g, f)),
        (EG(EG(f)), EG(f)),
        (EG(Not(EU(TRUE, f))), Not(EU(TRUE, f))),
        (EU(TRUE, Not(EG(f))), EU(TRUE, Not(f))),
        (EU(f, EU(TRUE, g)), EU(TRUE, g)),
        (EU(f, Or(g, EU(TRUE, h))), Or(EU(TRUE, h), EU(f, g))),
        (EG(And(f, Not(EU(TRUE, g)))), And(Not(EU(TRUE, g)), EG(f))),
        (Not(Not(f)), f),
        (And(f, f, TRUE), f),
        (Or(f, Not(f)), TRUE),
        (EG(TRUE), TRUE),
        (EX(FALSE), FALSE),
    ):
        assert simplified(written, NetBuilder("empty").build(), [float("inf")]) == wanted


@given(PLAIN, st.data())
def test_what_speaks_of_one_state_has_no_operator_of_time(net: PetriNet, data: st.DataObject) -> None:
    core = read(drawn(data, net), net)
    of_time = any(isinstance(part, EX | EG | EU) for part in core.walk())
    assert says_one_state(core) == (core not in (TRUE, FALSE) and not of_time)
    assert not says_one_state(TRUE)
    assert not says_one_state(EX(core))
