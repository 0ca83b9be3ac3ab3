"""Names in formulas: each means all copies of what it names, whichever ways lead to them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given

from mcpn.answers.causes.find import find_causes
from mcpn.answers.mission_names import MissionNames
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.answers.vocabulary import vocabulary
from mcpn.controller.monitors.writing import monitors_of
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import InputError
from mcpn.events import ENDING, Event
from mcpn.logic.ltl.formulas import Happens
from mcpn.logic.questions import Questions
from mcpn.mission.model import Handler, Mission, Objective, Protocol, Recursive, Use
from mcpn.mission.requirement import Requirement, RestrictedAvoidance
from mcpn.spaces.search.goal import Fires, Formula, marked
from mcpn.study import Study, open_study
from mcpn.testing.elements import LED, MISSIONS
from tests.draws import composed
from tests.judge.named import ambiguous, in_all_uses, meant
from tests.judge.test_faults import fault
from tests.logic.asked import ENGINES
from tests.small import activity, mission, robot


class Expected:
    """What words mean of objectives by their names in the net, without any look-up."""

    def __init__(self, of: MissionNet) -> None:
        self.of = of

    def places(self, role: str, names: Iterable[str]) -> Formula:
        wanted = {*names}
        return marked(*(p for p, (kind, name) in self.of.roles.items() if kind == role and name in wanted))

    def transitions(self, names: Iterable[str], what: Any) -> tuple[int, ...]:
        wanted = {Event(what, name) for name in names}
        return tuple(i for i, t in enumerate(self.of.net.transitions) if t.event in wanted)


def names_mean_all_copies(mission: Mission) -> None:
    of = composed(mission)
    names, expected = MissionNames(of), Expected(of)
    for path, copies in meant(mission).items():
        for called in (".".join(path), *(name for name in copies if len(copies) == 1)):
            for word in ("objective", "pending"):
                assert names.word(word, called) == expected.places(word, copies), (word, called)
            assert names.word("block", called) == expected.places("objective", copies)
            for what in ENDING:
                if transitions := expected.transitions(copies, what):
                    said = str(Event(what, called))
                    assert names.word("event", said) == Fires(transitions), said
                    assert names.word("happens", said) == Happens(transitions), said
    for path, held in meant(mission, blocks=True).items():
        assert names.word("block", ".".join(path)) == expected.places("objective", held), path
    for (text, name), everywhere in in_all_uses(mission).items():
        if name in {".".join(path) for path in meant(mission)}:
            continue  # it is what the mission itself calls so
        if sum(other == name for _, other in in_all_uses(mission)) == 1:
            assert names.word("objective", name) == expected.places("objective", everywhere), (text, name)
        else:
            with pytest.raises(InputError, match="no objective is named"):
                names.word("objective", name)
    words = vocabulary(of)
    reached = {objective.name for objective in of.graph.walk()}
    listed = [{*(word.copies or (word.name,))} for word in words.objectives]
    assert sorted(map(sorted, listed)) == sorted(
        sorted(copies & reached) for copies in meant(mission).values() if copies & reached
    )
    for listed_word in words.objectives:
        called, copies = listed_word.name, {*(listed_word.copies or (listed_word.name,))}
        assert names.word("objective", called) == expected.places("objective", copies), called


@given(LED)
def test_a_name_means_all_copies_where_routes_lead_to_one(mission: Mission) -> None:
    event("called by the name of all" if ambiguous(mission) else "no such")
    names_mean_all_copies(mission)


@given(MISSIONS)
def test_a_name_means_all_copies(mission: Mission) -> None:
    names_mean_all_copies(mission)


def test_a_name_in_a_protocol_means_all_of_its_uses() -> None:
    hand = mission(
        robot((), activity("drive", ())),
        Use(name="there", protocol="p"),
        Use(name="back", protocol="p"),
    )
    of = compose(replace(hand, protocols=(Protocol(name="p", blocks=(one("dock", "drive"),)),)))
    assert MissionNames(of).word("objective", "dock") == Expected(of).places(
        "objective", ["there.dock", "back.dock"]
    )


def test_what_a_protocol_requires_is_asked_of_copies_that_are_run_while_others_pause() -> None:
    """The sibling itself, to which only a pause leads, is not asked."""
    never = Requirement(name="r", formula="G !(objective(dock) & objective(work))")
    for uses in (1, 2):
        of = mission(
            OUTSIDE,
            Recursive(name="visit", handlers=(RAIN,), blocks=(one("work", "drive"),)),
            Recursive(name="shelter", blocks=(Use(name="inner", protocol="p"),)),
            *(Use(name=f"home{i}", protocol="p") for i in range(1, uses)),
        )
        docking = Protocol(name="p", blocks=(one("dock", "cover"),), requirements=(never,))
        of = replace(of, protocols=(docking,))
        asked = {answer.asked.name: answer.holds for answer in check(compose(of)).requirements}
        homes = [f"home{i}.r" for i in range(1, uses)]
        assert asked == dict.fromkeys([*homes, "shelter_at_work.inner.r"], True)


def one(name: str, runs: str, *handlers: Handler, **routes: object) -> Objective:
    return Objective(name=name, activities=(runs,), handlers=handlers, **routes)  # type: ignore[arg-type]


RAIN = Handler(event="rain", pause="shelter")
OUTSIDE = robot((), activity("drive", ()), activity("cover", ()), events=("rain",))
COVER = Recursive(name="shelter", blocks=(one("go_in", "cover"),))
LED_TO = {
    "failure": mission(OUTSIDE, one("work", "drive", RAIN, failure="shelter"), one("shelter", "cover")),
    "inside": mission(OUTSIDE, one("work", "drive", RAIN, failure="shelter"), COVER),
    "recovery": mission(
        OUTSIDE,
        one("work", "drive", recover="shelter"),
        one("last", "drive", failure="shelter"),
        one("shelter", "cover"),
    ),
    "rounds": mission(
        OUTSIDE, one("work", "drive", RAIN, failure="shelter", repeat=2), one("shelter", "cover", retries=1)
    ),
}


@pytest.mark.parametrize(
    ("of", "formula", "holds"),
    [
        ("failure", "G !objective(shelter)", False),
        ("failure", "G (happens(rain_EV) & objective(work) -> X objective(shelter))", True),
        ("failure", "F objective(shelter) -> F happens(OBJ_work_EV_FAIL)", False),
        ("failure", "G !happens(OBJ_shelter_EV_FAIL)", False),
        ("failure", "EF objective(shelter_at_work)", True),
        ("failure", "EF (objective(shelter) & !objective(shelter_at_work))", True),
        ("inside", "G (block(shelter) <-> objective(go_in))", True),
        ("inside", "G (objective(shelter.go_in) <-> objective(go_in))", True),
        ("inside", "G (block(shelter_at_work) <-> objective(shelter_at_work.go_in))", True),
        ("inside", "EF (objective(go_in) & objective(shelter_at_work.go_in))", True),
        ("inside", "G !(block(work) & block(shelter))", True),
        ("recovery", "F objective(shelter) -> F objective(last)", False),
        ("recovery", "EF (objective(shelter) & EF objective(last))", True),
        ("recovery", "G !(block(work) & objective(shelter))", True),
        ("rounds", "G (objective(shelter_at_work_2) -> objective(shelter))", True),
        ("rounds", "EF (objective(shelter_at_work_2) & objective(shelter_at_work_2_try2))", True),
        ("rounds", "EF (objective(shelter) & !objective(shelter_at_work_1) & EF objective(work_2))", True),
    ],
)
def test_what_a_formula_says(of: str, formula: str, holds: bool) -> None:
    for engine in ENGINES:
        assert (
            Questions(spaces_of(compose(LED_TO[of])), on="alternatives", engine=engine).answer(formula).holds
            is holds
        )


def test_a_sibling_whose_pause_never_comes_has_a_name() -> None:
    """Within the block its own handler answers the event: the pause that names the sibling never comes."""
    work = one("work", "drive", Handler(event="rain", goto="fail"))
    of = compose(mission(OUTSIDE, Recursive(name="visit", handlers=(RAIN,), blocks=(work,)), COVER))
    for formula in ("EF objective(go_in)", "EF block(shelter)", "E(F happens(OBJ_shelter.go_in_EV_OK))"):
        assert not Questions(spaces_of(of), on="alternatives").answer(formula).holds
    for no_event in ("OBJ_go_in_EV_TIMEOUT", "OBJ_shelter_EV_OK", "OBJ_visit_EV_OK"):
        with pytest.raises(InputError, match=f"no event is named {no_event}"):
            MissionNames(of).word("event", no_event)
    assert of.graph.copies.meant("shelter.go_in") == ["go_in"]
    (said,) = (problem.message for problem in check(of).unselectable)
    assert said == "objective go_in can never be entered: no route reaches it"


def test_what_is_entered_twice_by_two_ways_is_entered_twice() -> None:
    never = Requirement(name="r", patterns=(RestrictedAvoidance(objectives=("shelter",), at_most=1),))
    (answer,) = check(compose(replace(LED_TO["failure"], requirements=(never,)))).requirements
    assert answer.holds is False
    (watched,) = monitors_of(
        Study(replace(LED_TO["failure"], requirements=(never,))).mission_spaces()
    ).monitors
    events = ["MISSION_EV_START", "rain", "OBJ_shelter_at_work_EV_OK", "OBJ_work_EV_FAIL"]
    assert watched.run(events) == ["open", "open", "open", "open", "violated"]


def test_causes_of_all_copies() -> None:
    assert {*find_causes(compose(LED_TO["inside"])).of(["go_in"]).objectives} == {
        "go_in",
        "shelter_at_work.go_in",
    }


def test_names_that_only_look_like_copies() -> None:
    """Numbers behind a name are no copies where another text writes them so."""
    of = mission(
        OUTSIDE,
        Use(name="u", protocol="p"),
        one("work", "drive", RAIN, repeat=2, failure="shelter"),
        one("shelter", "cover"),
    )
    used = (one("shelter", "cover"), one("shelter_at_sea", "cover"), one("work_3", "drive"))
    of = replace(of, protocols=(Protocol(name="p", blocks=used),))
    copies = compose(of).graph.copies
    assert copies.meant("u.shelter") == ["u.shelter"]
    assert copies.meant("work_3") == ["u.work_3"]
    assert copies.plain("u.work_3") == "u.work_3"
    assert copies.meant("work") == ["work_1", "work_2"]
    assert {*copies.meant("shelter")} == {"shelter", "shelter_at_work_1", "shelter_at_work_2"}
    assert copies.meant("shelter", "u.") == ["u.shelter"]


@pytest.mark.parametrize(
    ("name", "formula", "holds"),
    [
        ("nm9", "G !objective(shelter)", False),
        ("nm4", "G (happens(rain_EV) & objective(work) -> X objective(shelter))", True),
        ("nm4", "EF (objective(shelter) & EF (!objective(shelter) & EF objective(shelter)))", True),
        ("nm8", "EF objective(go_in)", True),
        ("nm3", "EF (objective(s) & EF objective(z))", True),
        ("monitor", "EF (objective(o5_at_o4) & objective(o5))", True),
    ],
)
def test_missions_that_showed_it(faults: Path, name: str, formula: str, holds: bool) -> None:
    study = open_study(fault(faults, f"names_of_copies_{name}"))
    assert study.ctl(formula).holds is holds
