"""CTL by markings as they are needed agrees with the definitions, whatever the budgets and the order."""

from __future__ import annotations

from collections.abc import Collection
from itertools import islice

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn._kernel import Checker, Goals, TokenNet
from mcpn.logic.answering import answer_all
from mcpn.logic.formulas import EG, EU, EX
from mcpn.logic.on_the_fly import LocalChecks, OnTheFlyCheck
from mcpn.logic.questions import Questions
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.nets.reduce.reduction import reduce_for_branching
from mcpn.spaces.search.goal import TRUE, AtMost, Not
from mcpn.spaces.search.searches import Searches
from mcpn.testing.nets import philosophers
from mcpn.turns import Pausing, finished
from tests.draws import fewer
from tests.logic.formulas import edges_of, formulas, read, satisfying
from tests.nets.nets import graph_of, nets, state_machines, token_nets

PLAIN = (
    token_nets()
    | nets(max_places=5, max_transitions=6, events=False)
    | state_machines().map(lambda drawn: drawn[0])
)


@fewer(0.5)
@given(PLAIN, st.data())
def test_it_agrees_with_the_definitions(net: PetriNet, data: st.DataObject) -> None:
    assume(graph_of(net) is not None)
    edges = edges_of(net)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    drawn = data.draw(st.lists(formulas(places, transitions, leaves=8), min_size=1, max_size=4))
    cores = [read(formula, net) for formula in drawn]
    check = OnTheFlyCheck(net, cores)
    # Budgets that are too small leave nothing behind that is not so; seeds change no answer.
    rounds = data.draw(st.lists(st.integers(1, 40), max_size=6))
    for number, steps in enumerate((*rounds, 10**6)):
        for formula, core in zip(drawn, cores, strict=True):
            found = check.decide(core, steps, seed=number)
            assert found in (None, net.initial in satisfying(formula, net, edges))
            assert found is not None or steps < 10**6
    assert check.markings <= len(edges)
    for formula, core in zip(drawn, cores, strict=True):
        for inside in core.walk():
            if isinstance(inside, EX | EU | EG):
                assert check.decide(inside, 10**6) is not None
        assert check.decide(core, 10**6) == (net.initial in satisfying(formula, net, edges))


@fewer(0.5)
@given(PLAIN, st.data())
def test_pauses_change_nothing(net: PetriNet, data: st.DataObject) -> None:
    assume(graph_of(net) is not None)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    drawn = data.draw(st.lists(formulas(places, transitions, leaves=8), min_size=1, max_size=4))
    pause, seed = data.draw(st.integers(1, 9)), data.draw(st.integers(0, 3))
    edges, cores = edges_of(net), [read(formula, net) for formula in drawn]
    check = OnTheFlyCheck(net, cores)
    for core in cores:  # left where they rest, since another is asked
        next(check.deciding(core, 10**6, seed, pause), None)
    for formula, core in zip(drawn, cores, strict=True):
        value = net.initial in satisfying(formula, net, edges)
        assert finished(check.deciding(core, 10**6, seed, pause)) == value


def test_a_search_that_pauses_goes_on_where_it_was() -> None:
    net = philosophers(6)
    two_tokens = AtMost(((0, -1),), -2)
    nested = EG(Not(EU(TRUE, two_tokens)))  # the search inside looks at every marking
    check = OnTheFlyCheck(net, [nested])
    answers = []

    def work() -> Pausing[None]:
        answers.append((yield from check.deciding(nested, 10**6, 0, 50)))

    looked = [check.markings for _ in islice(work(), 1_000)]
    assert looked[5] > looked[1]
    assert answers == [True]


def _stretched(net: PetriNet, transitions: Collection[int]) -> PetriNet:
    """The net with some transitions in two steps: what they take they take before they put."""
    builder = NetBuilder(net.name)
    names = [builder.place(place.name, initial=place.initial) for place in net.places]
    for t, transition in enumerate(net.transitions):
        consume, produce, read = (
            {names[p]: weight for p, weight in side}
            for side in (transition.consume, transition.produce, transition.read)
        )
        if t in transitions:
            between = builder.place(f"in {transition.name}")
            builder.transition(transition.name, consume=consume, produce=[between], read=read)
            builder.transition(f"end of {transition.name}", consume=[between], produce=produce)
        else:
            builder.transition(transition.name, consume=consume, produce=produce, read=read)
    return builder.build()


@fewer(0.5)
@given(PLAIN, st.data())
def test_a_net_reduced_for_formulas_answers_the_same(net: PetriNet, data: st.DataObject) -> None:
    net = _stretched(net, data.draw(st.sets(st.sampled_from(range(max(len(net.transitions), 1))))))
    assume(graph_of(net) is not None)
    edges = edges_of(net)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    drawn = data.draw(st.lists(formulas(places[:3], transitions[:2], leaves=5), min_size=1, max_size=3))
    cores = {read(formula, net): net.initial in satisfying(formula, net, edges) for formula in drawn}
    checks = LocalChecks(net, Searches(net))
    checks.ask(list(cores))
    for core, value in cores.items():
        assert finished(checks.deciding(core, 10**6)) == value


def test_steps_that_nothing_disables_are_fired_at_once() -> None:
    builder = NetBuilder("beside")
    for line in "abcd":
        for step in range(4):
            builder.place(f"{line}{step}", initial=int(step == 0))
        for step in range(3):
            builder.transition(f"{line}{step}", consume=[f"{line}{step}"], produce=[f"{line}{step + 1}"])
    net = builder.build()
    reduced = reduce_for_branching(net, {0, 3})
    kept = [place.name for place in reduced.net.places]
    assert kept == ["a0", "a2", "a3"], "the last step of the line is seen, the other lines are not"


def _counter(limit: int) -> PetriNet:
    """A place that grows without end where no other limits it; a token comes back any time."""
    builder = NetBuilder("counter")
    builder.place("up")
    builder.place("room", initial=limit)
    builder.transition("more", consume=["room"], produce=["up"])
    builder.transition("endless", produce=["up"])
    return builder.build()


def test_endless_nets_are_answered_where_few_markings_decide() -> None:
    net = _counter(3)
    many, none = AtMost(((0, -1),), -40), AtMost(((0, 1),), 0)
    reached, never = EU(TRUE, many), EG(none)
    check = OnTheFlyCheck(net, [reached, never])
    assert check.decide(reached, 10**5) is True  # places get wider twice on the way
    assert check.decide(never, 10**5) is False
    stays = EG(AtMost(((1, -1),), -3))  # some run never takes from the room, and is endless without a cycle
    check = OnTheFlyCheck(net, [stays])
    assert check.decide(stays, 10**4) is None


def test_memory_is_a_limit() -> None:
    net = _counter(0)
    far = EU(TRUE, AtMost(((0, -1),), -(10**6)))
    check = OnTheFlyCheck(net, [far], max_bytes=1 << 20)
    assert check.decide(far, 10**7) is None
    assert check.markings < 10**5
    assert check.decide(far, 10**7) is None


def test_the_kernel_checks_what_it_is_given() -> None:
    net, goals = TokenNet(1, [([], [(0, 1)], False)], False), Goals(1, [("dead", [], [], 0)])
    for operators, told in (
        ([("goal", [1])], "no goal"),
        ([("sometimes", [0])], "no such operator"),
        ([("goal", [0]), ("until", [0])], "number of operands"),
        ([("not", [0])], "names a later one"),
    ):
        with pytest.raises(ValueError, match=told):
            Checker(net, [0], goals, operators, 1 << 20)
    with pytest.raises(ValueError, match="each place"):
        Checker(net, [0, 0], goals, [], 1 << 20)
    checker = Checker(net, [0], goals, [("goal", [0])], 1 << 20)
    with pytest.raises(ValueError, match="no such operator"):
        checker.decide(1, 10)
    assert checker.decide(0, 10) == "no"
    assert checker.decide(0, 1) == "steps"


def test_a_space_that_nobody_asked_for_is_not_begun(monkeypatch: pytest.MonkeyPatch) -> None:
    questions = Questions(philosophers(2), engine="search")
    monkeypatch.setattr(questions.spaces, "going_on", lambda _: pytest.fail("it is begun"))
    found = list(answer_all(questions, (), ["Liveness", "ReachabilityDeadlock"]))
    assert {verdict.value for verdict in found} == {"TRUE", "FALSE"}
