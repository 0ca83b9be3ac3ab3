"""Every run that is shown replays on the net's own rule, and shows what it is said to show."""

from __future__ import annotations

from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.check.ctl import Evaluation, SymbolicMarkings
from mcpn.check.logic.formulas import EG, EU, EX, Const, Justice, walk
from mcpn.check.logic.language import parse
from mcpn.check.logic.questions import Questions
from mcpn.check.logic.resolve import resolve
from mcpn.check.logic.witness import Witness, explain, scenario
from mcpn.net.compose import MissionNet
from mcpn.net.petri import Marking, PetriNet
from mcpn.space.symbolic import reach
from tests.check.formulas import edges_of, formulas, satisfying
from tests.net.nets import nets, reachable, state_machines
from tests.shares import returns_early


def replayed(net: PetriNet, witness: Witness) -> list[Marking]:
    """The markings of a run, each firing checked against the net's own rule."""
    marking, passed = net.initial, [net.initial]
    assert witness.start == net.initial
    for fired, after in witness.steps:
        for t in fired:
            assert t in net.enabled(marking)
            marking = net.fire(marking, t)
        assert marking == after
        passed.append(marking)
    if witness.cycle is not None:
        assert passed[witness.cycle] == passed[-1]
        assert witness.cycle < len(witness.steps)
    return passed


@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]), st.data())
def test_runs_show_what_they_say(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    distance, _, _ = reachable(net)
    places = [p.name for p in net.places]
    inner = data.draw(formulas(places, [t.name for t in net.transitions], leaves=2))
    core = resolve(inner, net)
    satisfied = satisfying(inner, net, edges)
    evaluation = Evaluation(SymbolicMarkings(reach(net)))
    for formula in (EU(Const(True), core), EG(core), EX(core)):
        witness = explain(evaluation, formula)
        passed = replayed(net, witness)
        if not evaluation.holds(formula):
            continue
        temporal = any(isinstance(inside, EX | EU | EG) for inside, _ in walk(core))
        if isinstance(formula, EU) and not temporal:
            assert passed[-1] in satisfied
            assert len(witness.steps) == min(distance[m] for m in satisfied)
        if isinstance(formula, EX) and not temporal:
            assert len(passed) == 2
            assert passed[1] in satisfied
        if isinstance(formula, EG):
            assert all(marking in satisfied for marking in passed)
            assert witness.cycle is not None or not net.enabled(passed[-1])


@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]), st.data())
def test_fair_cycles_meet_every_constraint(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    assume(net.transitions)
    edges = edges_of(net)
    places = [p.name for p in net.places]
    drawn = data.draw(st.lists(formulas(places, [], leaves=1), min_size=1, max_size=2))
    fires = tuple(data.draw(st.lists(st.integers(0, len(net.transitions) - 1), max_size=2)))
    fair = [Justice(resolve(formula, net)) for formula in drawn] + [Justice(Const(False), fires)] * bool(
        fires
    )
    evaluation = Evaluation(SymbolicMarkings(reach(net)), fair)
    everything = EG(Const(True))
    if not evaluation.holds(everything):
        returns_early("no fair path")
        return
    witness = explain(evaluation, everything)
    passed = replayed(net, witness)
    if witness.cycle is None:
        assert not net.enabled(passed[-1])
        return
    around = set(passed[witness.cycle :])
    for formula in drawn:
        assert around & satisfying(formula, net, edges)
    if fires:
        assert any(t in fires for fired, _ in witness.steps[witness.cycle :] for t in fired)


def test_a_roboticist_can_read_how_ulysse_fails(ulysse_net: MissionNet) -> None:
    questions = Questions(ulysse_net.net, ulysse_net, on="alternatives")
    answer = questions.answer("EF failure", questions.core(parse("EF failure")))
    assert answer.holds
    # The first objective, diving and going up must fail in turn: no run has fewer events.
    assert [str(step.event) for step in answer.told] == [
        "MISSION_EV_START",
        "OBJ_coral_head.manual_moving_EV_FAIL",
        "OBJ_transect.diving_EV_FAIL",
        "OBJ_transect.going_up_EV_FAIL",
    ]
    assert "the mission ends in failure" in answer.told[-1].words
    assert answer.witness is not None
    lines = scenario(answer.witness, ulysse_net.net).splitlines()
    marking = ulysse_net.net.initial
    for line in lines:
        t = ulysse_net.net.transition_index[line.strip("{}")]
        assert t in ulysse_net.net.enabled(marking)
        marking = ulysse_net.net.fire(marking, t)
    assert marking[ulysse_net.failure]
