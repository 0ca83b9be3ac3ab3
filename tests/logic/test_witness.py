"""Every run that is shown replays on the net's own rule, and shows what it is said to show."""

from __future__ import annotations

from itertools import product
from typing import Any

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import MissionNet
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX, Justice
from mcpn.logic.questions import Questions
from mcpn.logic.syntax import parse
from mcpn.logic.witness import Witness, explain, scenario
from mcpn.nets.petri import Marking, NetBuilder, PetriNet
from mcpn.report.words import in_words
from mcpn.spaces.algebra import Space
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.diagrams.spaces import DiagramMarkings
from mcpn.spaces.diagrams.symbolic import reach
from mcpn.spaces.engine_names import Engine, On
from mcpn.spaces.formula_names import Names
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.search.goal import FALSE, TRUE
from tests.logic.formulas import edges_of, formulas, read, satisfying
from tests.nets.nets import nets, reachable, state_machines
from tests.shares import returns_early


def spaces(net: PetriNet) -> list[Space[Any]]:
    return [ArraySpace(explore(net)), DiagramMarkings(reach(net))]


def replayed(net: PetriNet, witness: Witness) -> list[Marking]:
    """The markings of a run, each firing checked against the net's own rule."""
    marking, passed = net.initial, [net.initial]
    assert witness.space.marking(witness.start) == net.initial
    for edge in witness.steps:
        for t in (edge.transition, *edge.internal):
            assert t in net.enabled(marking)
            marking = net.fire(marking, t)
        assert marking == witness.space.marking(edge.target)
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
    core = read(inner, net)
    satisfied = satisfying(inner, net, edges)
    every = [EU(TRUE, core), EG(core), EX(core)]
    for evaluation, formula in product(map(Evaluation, spaces(net)), every):
        witness = explain(evaluation, formula)
        passed = replayed(net, witness)
        if not evaluation.holds(formula):
            continue
        temporal = any(isinstance(inside, EX | EU | EG) for inside in core.walk())
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
def test_a_run_until_something_stays_where_it_may(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    edges = edges_of(net)
    places, transitions = [p.name for p in net.places], [t.name for t in net.transitions]
    along, goal = (data.draw(formulas(places, transitions, leaves=2)) for _ in range(2))
    inside, there = (satisfying(formula, net, edges) for formula in (along, goal))
    layers, seen = [{net.initial}], {net.initial}
    while layers[-1] and not layers[-1] & there:
        layers.append({after for marking in layers[-1] & inside for _, after in edges[marking]} - seen)
        seen |= layers[-1]
    shortest = len(layers) - 1 if layers[-1] else None
    formula = EU(read(along, net), read(goal, net))
    goes_on = any(isinstance(part, EX | EU | EG) for part in formula.operands[1].walk())
    for evaluation in map(Evaluation, spaces(net)):
        assert evaluation.holds(formula) == (shortest is not None)
        passed = replayed(net, explain(evaluation, formula))
        if shortest is not None:
            assert set(passed[:shortest]) <= inside
            assert passed[shortest] in there
            assert goes_on or len(passed) == shortest + 1


@given(nets(max_places=5, max_transitions=6) | state_machines().map(lambda drawn: drawn[0]), st.data())
def test_fair_cycles_meet_every_constraint(net: PetriNet, data: st.DataObject) -> None:
    assume(reachable(net)[2])
    assume(net.transitions)
    edges = edges_of(net)
    places = [p.name for p in net.places]
    drawn = data.draw(st.lists(formulas(places, [], leaves=1), min_size=1, max_size=2))
    fires = tuple(data.draw(st.lists(st.integers(0, len(net.transitions) - 1), max_size=2)))
    fair = [Justice(read(formula, net)) for formula in drawn] + [Justice(FALSE, fires)] * bool(fires)
    for space in spaces(net):
        evaluation = Evaluation(space, fair)
        everything = EG(TRUE)
        if not evaluation.holds(everything):
            returns_early("no fair path")
            return
        witness = explain(evaluation, everything)
        passed = replayed(net, witness)
        if witness.cycle is None:
            assert not net.enabled(passed[-1])
            continue
        around = set(passed[witness.cycle :])
        for formula in drawn:
            assert around & satisfying(formula, net, edges)
        if fires:
            assert any(edge.transition in fires for edge in witness.steps[witness.cycle :])


@pytest.mark.parametrize("fired", [0, 1, 2])
def test_a_fair_cycle_takes_the_firing_that_is_asked_for(fired: int) -> None:
    """Of several firings between the same markings it is not the first that counts, but the one asked for."""
    builder = NetBuilder("alike")
    builder.place("p", initial=1)
    for name in "xyz":
        builder.transition(name, consume=["p"], produce=["p"])
    net = builder.build()
    for space in spaces(net):
        evaluation = Evaluation(space, [Justice(FALSE, (fired,))])
        for text in ("EG p", "E ((G F p) & F G p)"):
            witness = explain(evaluation, parse(text, Names(net)))
            assert witness.cycle is not None
            assert fired in {edge.transition for edge in witness.steps[witness.cycle :]}


def test_a_run_is_explained_in_the_users_words(ulysse_net: MissionNet) -> None:
    questions = Questions(spaces_of(ulysse_net), on="alternatives", engine="explicit")

    def notes(text: str) -> list[str]:
        answer = questions.answer(text)
        return [note.partition("here: ")[2] for note in answer.witness.notes]

    words = [
        "activity(localisation)",
        "oos(GPS_sensor)",
        "available(IMU_sensor)",
        "!objective(transect.filming)",
        "event(IMU_sensor_EV_OOS)",
    ]
    assert sorted(notes(f"EF ({' & '.join(words)})")) == sorted(words)
    # What is written by places and transitions is said so; what fails is said in the same words.
    plain = Questions(spaces_of(ulysse_net), on="alternatives", engine="explicit")
    answer = plain.answer("EF GPS_sensor_OOS")
    assert [note.rpartition(": ")[2] for note in answer.witness.notes] == ["GPS_sensor_OOS"]
    assert notes("AG !oos(GPS_sensor)") == ["oos(GPS_sensor)"]


@pytest.mark.parametrize("engine", ["explicit", "symbolic"])
def test_a_roboticist_can_read_how_ulysse_fails(ulysse_net: MissionNet, engine: Engine) -> None:
    questions = Questions(spaces_of(ulysse_net), on="alternatives", engine=engine)
    answer = questions.answer("EF failure")
    assert answer.holds
    told = list(in_words(ulysse_net, answer.witness.run))
    # The first objective, diving and going up must fail in turn: no run has fewer events.
    assert [str(event) for event, _ in told] == [
        "MISSION_EV_START",
        "OBJ_coral_head.manual_moving_EV_FAIL",
        "OBJ_transect.diving_EV_FAIL",
        "OBJ_transect.going_up_EV_FAIL",
    ]
    assert "the mission ends in failure" in told[-1][1]
    lines = scenario(answer.witness).splitlines()
    marking = ulysse_net.net.initial
    for line in lines:
        t = ulysse_net.net.transition_index[line.strip("{}")]
        assert t in ulysse_net.net.enabled(marking)
        marking = ulysse_net.net.fire(marking, t)
    assert marking[ulysse_net.failure]


@pytest.mark.parametrize("on", ["alternatives", "markings"])
def test_runs_of_stable_states_alone_go_on_by_themselves(ulysse_net: MissionNet, on: On) -> None:
    """On markings each internal transition is a step of its own, and a run ends where it is shown to."""
    run = Questions(spaces_of(ulysse_net), on=on, engine="symbolic").answer("EF failure").witness.run
    assert run.settles == (on == "alternatives")
