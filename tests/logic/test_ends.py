"""Where each firing takes tokens away every path ends, and formulas are what they come to there."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import Source
from mcpn.logic.answering import answer_all
from mcpn.logic.contest import Property
from mcpn.logic.formulas import every_path
from mcpn.logic.ltl.formulas import Next, always, eventually
from mcpn.logic.questions import Questions
from mcpn.logic.simplify import simplified, takes_away, where_all_ends, where_paths_end
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.search.goal import Fires
from tests.draws import fewer
from tests.logic.formulas import formulas, read

MOVES = st.lists(
    st.tuples(st.permutations(range(5)), st.booleans()), min_size=1, max_size=6
)  # jumps from two places to a third, or a place that is emptied


def board(moves: list[tuple[list[int], bool]], marks: list[bool]) -> PetriNet:
    """A net in which each firing leaves fewer tokens."""
    net = NetBuilder("board")
    for place in range(5):
        net.place(f"p{place}", initial=int(marks[place]))
    for number, ((first, second, to, *_), jumps) in enumerate(moves):
        name = f"t{number}"
        net.transition(name, consume=[f"p{first}", *([f"p{second}"] * jumps)], produce=[f"p{to}"] * jumps)
    return net.build()


@fewer(0.3)
@given(MOVES, st.lists(st.booleans(), min_size=5, max_size=5), st.data())
def test_formulas_are_what_they_come_to_where_paths_end(
    moves: list[tuple[list[int], bool]], marks: list[bool], data: st.DataObject
) -> None:
    net = board(moves, marks)
    assert takes_away(net)
    evaluation = Questions(net, engine="explicit").evaluation
    dead, everything, nothing = evaluation.space.dead, evaluation.space.everything, evaluation.space.nothing
    names = [p.name for p in net.places], [t.name for t in net.transitions]
    for _ in range(4):
        formula = read(data.draw(formulas(*names, leaves=6)), net)
        states = evaluation.states(formula)
        if (value := where_all_ends(formula)) is not None:
            assert states & dead == (dead if value else nothing)
        for part in formula.walk():
            if (value := where_paths_end(part)) is not None:
                assert evaluation.states(part) == (everything if value else nothing)
        assert evaluation.states(simplified(formula, net, [9.0] * 5, where_paths_end)) == states


def test_what_paths_come_to_answers_without_a_search() -> None:
    net = board([([0, 1, 2, 3, 4], True), ([2, 3, 4, 0, 1], True)], [True, True, False, True, False])
    again = Fires((0,))
    asked = {
        "again and again": (every_path(always(eventually(Next(again)))), "FALSE"),
        "at last never": (every_path(eventually(always(~again))), "TRUE"),
    }
    source = Source("board.xml", 1)
    properties = [Property(name, formula, source) for name, (formula, _) in asked.items()]
    answers = list(answer_all(Questions(net), properties))
    assert {a.name: a.value for a in answers} == {name: value for name, (_, value) in asked.items()}
    assert {a.techniques for a in answers} == {("QUERY_REDUCTION",)}


def test_what_only_reads_goes_on_for_ever() -> None:
    net = NetBuilder("reading")
    net.place("p", initial=1)
    net.transition("t", read=["p"])
    assert not takes_away(net.build())
