"""What is said of a mission, in formulas and of runs, against what its text means."""

from __future__ import annotations

from dataclasses import replace

import pytest

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.answers.verdicts.modes import Situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import InputError
from mcpn.events import Event, What
from mcpn.logic.questions import Questions
from mcpn.mission.model import SUCCEED, Handler, Objective, Recursive
from mcpn.mission.robot import Fact
from mcpn.report.words import changes, event_in_words, what_happens
from mcpn.spaces.engine_names import Engine
from tests.drawing.settling import stabilise
from tests.logic.asked import ENGINES
from tests.small import activity, hw, mission, robot


def test_what_changes_is_said_once_and_only_what_changes() -> None:
    before = Situation(
        objectives=("dive",),
        mode={"locate": "by_gps", "hear": "hear", "map": "fine"},
        refused=("dig",),
        waiting={"film": "film"},
        outcome=None,
    )
    after = Situation(
        objectives=("dive", "rise"),
        mode={"locate": "by_imu", "hear": "hear", "steer": "by_wire", "drive": "drive"},
        refused=("dig", "map"),
        waiting={"film": "film", "grab": "grab"},
        outcome="success",
    )
    assert changes(before, after) == [
        "rise begins",
        "locate changes from by_gps to by_imu",
        "steer runs as by_wire",  # drive runs as drive: its name says all
        "map has no way to run",
        "grab waits",
        "the mission ends in success",
    ]
    assert changes(after, after) == []
    event = Event(What.OUT_OF_SERVICE, "gps")
    assert event_in_words("m", event, after, after) == "gps fails"
    assert event_in_words("m", event, before, after).startswith("gps fails: rise begins, locate changes")


def test_every_kind_of_event_is_said() -> None:
    said = {what: what_happens(Event(what, "x"), "m") for what in What if what is not What.START}
    assert said == {
        What.SUCCESS: "objective x succeeds",
        What.FAILURE: "objective x fails",
        What.TIMEOUT: "the time of x is over",
        What.OUT_OF_SERVICE: "x fails",
        What.LOST: "x is lost for good",
        What.EARLIER: "the handler x has happened before",
        What.REPAIRED: "x works again",
        What.DETECTED: "the loss of x is noticed",
        What.DECLARED: "event x happens",
    }


def looking() -> MissionNet:
    """A camera's images, or what one sees by a lamp; what follows needs the arm."""
    of = robot(
        hw("camera", "lamp", "arm"),
        activity("driver", ("camera",), produces=("image",)),
        activity("look", ("image",), ("lamp",)),
        activity("grab", ("arm",)),
    )
    return compose(
        mission(of, Objective(name="see", activities=("look",)), Objective(name="take", activities=("grab",)))
    )


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("formula", "holds"),
    [
        ("EF refused(look)", True),
        ("EF (refused(look) & !oos(camera) & !oos(lamp))", True),  # until it is stopped
        ("AG (objective(see) & oos(camera) & oos(lamp) -> refused(look))", True),
        ("EF refused(driver)", False),  # nobody asks a driver that cannot run
        ("EF (alternative(look)=look_0 & oos(camera))", False),
        ("EF (alternative(look)=look_1 & available(camera))", True),  # no switch back
        ("EF alternative(look.look_1)", True),
        ("EF (available(image) & oos(camera))", False),
        ("EF (available(image) & activity(look))", True),
        ("AG (activity(driver) -> available(image))", True),
        ("EF (activity(look) & objective(take))", False),
        ("EF (objective(take) & !oos(arm) & event(arm_EV_OOS))", True),
        ("EF (oos(arm) & event(arm_EV_OOS))", False),
        ("EF waiting(grab)", False),
        ("EF (success | failure)", True),
        ("E[!oos(lamp) U failure]", True),  # the camera alone is enough to see: the arm fails
        ("E[!oos(arm) & !oos(camera) U objective(take)]", True),
        ("A[!objective(take) U objective(see)]", False),  # the start may be put off for ever
    ],
)
def test_words_mean_what_they_say(engine: Engine, formula: str, holds: bool) -> None:
    found = looking()
    assert Questions(spaces_of(found), on="alternatives", engine=engine).answer(formula).holds is holds


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_until_something_is_explained_all_along(engine: Engine) -> None:
    found = looking()
    answer = Questions(spaces_of(found), on="alternatives", engine=engine).answer("E[!oos(lamp) U oos(arm)]")
    assert answer.holds
    assert [note for note in answer.witness.notes if "!oos(lamp)" in note] != []
    assert str(answer.witness.run.events[-1]) == "arm_EV_OOS"
    assert "lamp_EV_OOS" not in map(str, answer.witness.run.events)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_follows_an_event_that_happens_once(engine: Engine) -> None:
    of = robot(hw("H"), activity("go", ("H",)), events=("recall",))
    away = Objective(
        name="away",
        activities=("go",),
        success=SUCCEED,
        handlers=(Handler(event="recall", goto="home", once=True),),
    )
    found = compose(
        mission(of, away, Objective(name="home", activities=("go",), success="away", failure="home"))
    )
    assert [section.name for section in found.graph.walk()] == ["away", "home"]
    questions = Questions(spaces_of(found), on="alternatives", engine=engine)
    for formula, holds in (
        ("EF objective(home)", True),
        ("EF (objective(away) & event(recall))", True),
        ("EF (objective(away) & !event(recall))", True),  # once more, after home
        ("EF (objective(home) & EX (objective(away) & EF event(recall)))", False),
    ):
        assert questions.answer(formula).holds is holds, formula


def stable_graph(found: MissionNet) -> tuple[int, int]:
    """Stable markings and events between them, by the net's own rule."""
    net = found.net
    stack = [stabilise(net, net.initial)]
    seen, edges = set(stack), 0
    while stack:
        marking = stack.pop()
        for t in net.enabled(marking):
            after = stabilise(net, net.fire(marking, t))
            edges += 1
            if after not in seen:
                seen.add(after)
                stack.append(after)
    return len(seen), edges


@pytest.mark.parametrize("engine", ENGINES)
def test_sizes_are_of_the_stable_markings(ulysse_net: MissionNet, engine: Engine) -> None:
    for found in (ulysse_net, looking()):
        assert check(found, engine=engine).stable_sizes == stable_graph(found)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("EF oos(image)", "no resource is named image"),  # it is software
        ("EF available(image2)", "no resource is named image2; did you mean image"),
        ("EF alternative(look_0)", "found no name after look_0"),
        ("EF alternative(look)=by_ear", "no alternative of look is named by_ear"),
        ("EF objective(se)", "no objective is named se; did you mean see"),
        ("EF event(camera)", "no event is named camera"),
    ],
)
def test_a_word_about_nothing_of_the_mission_is_an_error(formula: str, words: str) -> None:
    found = looking()
    with pytest.raises(InputError, match=words):
        Questions(spaces_of(found), on="alternatives").answer(formula)


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("EF objective(walkk)", r"no objective is named walkk; did you mean rows\.walk\?"),
        ("EF objective(extrakt)", r"no objective is named extrakt; did you mean extract\?"),
        ("EF block(row)", r"no block is named row; did you mean rows\?"),
        ("EF event(leek)", r"no event is named leek; did you mean leak\?"),
        ("EF done(walkk)", r"no objective is named walkk; did you mean walk\?"),
        ("EF done(walk)", r"done\(walk\) is not kept: no route, condition or requirement"),
        ("EF fact(dor)=closed", r"no fact is named dor; did you mean door\?"),
        ("EF leak", r"leak alone says nothing: expected happens\(leak\)"),
        ("EF walk_try1", r"no word is named walk_try1; did you mean objective\(walk\)\?"),
        ("EF (rows & door)", r"rows alone says nothing: expected block\(rows\)"),
        (
            "EF OBJ_extract_EV_OK",
            r"OBJ_extract_EV_OK alone says nothing: expected happens\(OBJ_extract_EV_OK\)",
        ),
        ("EF zzz", r"no word is named zzz; expected success, failure, abort, or a word about an element"),
        ("EF abbort", r"no word is named abbort; did you mean abort\?"),
    ],
)
def test_what_is_near_is_said_as_it_is_written(formula: str, words: str) -> None:
    """One name for all rounds and tries, as an author writes it."""
    of = robot((), activity("a", ()), events=("leak",))
    of = replace(of, facts=(Fact(name="door", values=("open", "closed")),))
    leaks = (Handler(event="leak", goto="fail"),)
    walked = Objective(name="walk", activities=("a",), retries=1, handlers=leaks)
    blocks = (
        Recursive(name="rows", blocks=(walked,), repeat=12, failure="extract"),
        Objective(name="extract", activities=("a",), repeat=3, success="abort", failure="abort"),
    )
    with pytest.raises(InputError, match=words):
        Questions(spaces_of(compose(mission(of, *blocks))), on="alternatives").answer(formula)
