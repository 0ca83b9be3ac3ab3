"""Simplified formulas hold where the formulas do, and files are answered as the definitions say."""

from __future__ import annotations

from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.errors import Source
from mcpn.logic.contest import Property
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.questions import Questions
from mcpn.logic.simplify import simplified
from mcpn.logic.verdicts import answer_all
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.nets.structure import place_bounds
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.goal import FALSE, TRUE, And, Deadlock, Not, Or
from tests.draws import fewer
from tests.logic.formulas import Written, edges_of, formulas, read, satisfying
from tests.nets.nets import nets, reachable, state_machines

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
    f, g = Deadlock(), EX(Deadlock())
    for written, wanted in (
        (EU(TRUE, EU(TRUE, f)), EU(TRUE, f)),
        (EU(TRUE, EU(g, f)), EU(TRUE, f)),
        (EU(g, EU(g, f)), EU(g, f)),
        (EU(g, Or(f, EU(g, f))), EU(g, f)),
        (EG(EG(f)), EG(f)),
        (EG(Not(EU(TRUE, f))), Not(EU(TRUE, f))),
        (Not(Not(f)), f),
        (And(f, f, TRUE), f),
        (Or(f, Not(f)), TRUE),
        (EG(TRUE), TRUE),
        (EX(FALSE), FALSE),
    ):
        assert simplified(written, NetBuilder("empty").build(), []) == wanted
