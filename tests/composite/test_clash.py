"""Errors of missions that are not confluent: their runs replayed, their words held against the mission."""

from __future__ import annotations

from collections import deque

import pytest
from hypothesis import assume, event, given
from hypothesis import strategies as st

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.composite.clash import Clash, Rival, find_clash
from mcpn.composite.clash_sentences import explained, sentence
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, LimitError, SemanticsError
from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.engine_names import SPACE_ENGINES, Engine
from mcpn.spaces.engines import Choice
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.run import Completion
from mcpn.spaces.stable.alternatives import by_reduction, direct
from mcpn.spaces.stable.run_to_completion import fault_after
from mcpn.testing import missions
from mcpn.testing.elements import CRASHING
from tests import small
from tests.draws import composed, fewer
from tests.shares import returns_early
from tests.spaces.runs import assert_parts

CONTENDED = missions(max_objectives=2, max_sections=4, max_hardware=2)


def errors_of(found: MissionNet) -> list[ConfluenceError]:
    """By reduction and directly; none where the mission is confluent or too large."""
    errors = []
    try:
        markings = explore(found.net, max_states=10_000)
    except LimitError:
        return []
    for reduced in (True, False):
        try:
            by_reduction(markings) if reduced else direct(found.net)
        except ConfluenceError as error:
            errors.append(error)
    assert len(errors) in (0, 2)
    return errors


def faults(net: PetriNet) -> list[SemanticsError]:
    """The error of each event that has not one outcome, behind those that have one."""
    completion, start, found = Completion(net), list(net.initial), list[SemanticsError]()
    deque(completion.settle(start), 0)
    runs: dict[Marking, list[int]] = {tuple(start): []}
    queue = deque(runs)
    while queue:
        marking = queue.popleft()
        for t in net.enabled(marking):
            run = [*runs[marking], t]
            if (error := fault_after(net, run)) is not None:
                found.append(error)
            elif (after := completion.after(marking, t)[1]) not in runs:
                runs[after] = run
                queue.append(after)
    return found


@given(CONTENDED)
def test_runs_part_where_the_outcome_is_decided(mission: Mission) -> None:
    found = compose(mission)
    net = found.net
    errors = errors_of(found)
    event(f"confluent: {not errors}")
    for error in errors:
        first, second = error.runs
        assert_parts(net, first, second)
        of = (net.transitions[net.transition_index[name]].event for name in first)
        assert error.events == tuple(str(e) for e in of if e is not None)


@given(CONTENDED)
def test_a_clash_is_of_the_mission(mission: Mission) -> None:
    found = compose(mission)
    activities = {a.name: a for a in mission.activities}
    running = {section.name: section.activities for section in found.graph.walk()}

    def below(activity: str) -> set[str]:
        producers = {s: a.name for a in mission.activities for s in a.produces}
        ways = activities[activity].alternatives
        suppliers = {producers[k] for way in ways for k in way.consumes if k in producers}
        return {activity}.union(*map(below, suppliers))

    for error in errors_of(found):
        clash = find_clash(found, error)
        event(f"{clash.kind or 'other'}: {clash.where}")
        names = tuple(rival.name for rival in clash.rivals)
        if clash.kind in ("hardware", "software"):
            for rival in clash.rivals:
                consumed = {k for way in activities[rival.name].alternatives for k in way.consumes}
                assert consumed >= set(clash.wanted)
                assert rival.objectives
                for objective in rival.objectives:
                    assert any(rival.name in below(a) for a in running[objective])
        elif clash.kind == "activity":
            for name in names:
                assert set(running[name]) >= set(clash.wanted)
        elif clash.kind == "stop":
            assert {rival.name for rival in clash.rivals} == set(clash.wanted)
            assert len(activities[names[0]].alternatives) > 1
            continue
        else:
            assert clash.kind == "producer"
            (producer,) = clash.wanted
            assert any(rival.name in activities[producer].produces for rival in clash.rivals)
            continue
        # The warnings that are given before any state is explored have it, too.
        known = {(c.wanted.removeprefix("activity "), c.rivals) for c in found.usage.contentions}
        assert any((wanted, names) in known for wanted in clash.wanted) or clash.kind == "activity"


@fewer(0.4)
@given(CONTENDED)
def test_every_engine_names_a_real_clash(mission: Mission) -> None:
    found = compose(mission)
    errors = errors_of(found)
    assume(errors)
    net, words = found.net, str(explained(found, errors[1]))
    engines: tuple[Engine, ...] = ("explicit", "symbolic", "local")
    for engine in engines:
        verdict = check(found, engine=engine).verdicts["confluent"]
        assert verdict.holds is False
        first, second = (tuple(net.transitions[t].name for t in run.transitions) for run in verdict.runs)
        assert_parts(net, first, second)
        assert verdict.explanation == str(explained(found, ConfluenceError("", (first, second))))
        event(f"{engine} names the nearest: {verdict.explanation == words}")


def test_an_error_of_a_net_in_which_more_happens_keeps_its_words(ulysse_net: MissionNet) -> None:
    known = ulysse_net.net.transitions[0].name
    error = ConfluenceError("said of it", ((known, "GPS_earlier"), (known, "IMU_earlier")))
    assert explained(ulysse_net, error) is error


def a_clash_after_a_crash_of_what_does_not_run() -> MissionNet:
    """``a`` begins with its first alternative, unless that has crashed before it began."""
    ways = (Alternative(name="a1", faulty=True), Alternative(name="a2", consumes=("h",)))
    of = small.robot(small.hw("h"), Activity(name="a", alternatives=ways), small.activity("b", ("h",)))
    branches = (Objective(name="x", activities=("a",)), Objective(name="y", activities=("b",)))
    return compose(small.mission(of, Parallel(name="p", blocks=branches)))


@pytest.mark.parametrize("engine", SPACE_ENGINES)
def test_a_clash_that_causes_alone_come_to_is_told_as_such(engine: Engine) -> None:
    found = a_clash_after_a_crash_of_what_does_not_run()
    assert check(found, engine=engine).verdicts["confluent"].holds
    with pytest.raises(ConfluenceError) as error:
        spaces_of(found).space(engine, "alternatives", may_die=True)
    assert error.value.events == ("a.a1_EV_OOS", "MISSION_EV_START")
    said = str(error.value)
    assert "a (objective x) and b (objective y), both in parallel block p, ask for h at the same" in said
    assert "this comes of a crash of a.a1 while it does not run" in said


@fewer(0.4, least=6)
@given(CRASHING, st.sampled_from(SPACE_ENGINES))
def test_clashes_where_hardware_may_die_are_told_in_mission_words(mission: Mission, engine: Engine) -> None:
    try:
        spaces_of(composed(mission)).space(Choice(engine, max_states=10_000), "alternatives", may_die=True)
        return
    except ConfluenceError as error:
        said = str(error)
    except (SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return
    event(f"of a crash of what does not run: {'while it does not run' in said}")
    assert "at the same moment" in said or "at the moment at which" in said, "rivals, not transitions"


def robot(*activities: Activity) -> tuple[Robot, ...]:
    software = tuple(Software(name=s) for a in activities for s in a.produces)
    return (Robot(name="r", hardware=(Hardware(name="h"),), software=software, activities=activities),)


def activity(name: str, *consumes: str, produces: tuple[str, ...] = ()) -> Activity:
    return Activity(name=name, alternatives=(Alternative(name=name, consumes=consumes),), produces=produces)


def clash_of(mission: Mission) -> Clash:
    found = compose(mission)
    with pytest.raises(ConfluenceError) as raised:
        direct(found.net)
    return find_clash(found, raised.value)


def test_two_branches_want_one_resource() -> None:
    blocks = (
        Objective(name="film", activities=("film",)),
        Objective(name="advance", activities=("advance",)),
    )
    clash = clash_of(
        Mission(
            name="m",
            robots=robot(activity("film", "h"), activity("advance", "h")),
            blocks=(Parallel(name="census", blocks=blocks),),
        )
    )
    rivals = Rival("activity", "advance", ("advance",)), Rival("activity", "film", ("film",))
    assert clash == Clash("hardware", ("h",), rivals, "branches", "census")
    assert sentence(clash) == (
        "not confluent: advance (objective advance) and film (objective film), both in parallel block "
        "census, ask for h at the same moment, and what follows depends on which comes first; to change "
        "this, put the two in sequence, or let one of them use another resource, or give one of them an "
        'alternative without h, or declare h with shared="true"'
    )


def test_objectives_that_begin_in_turn_are_not_what_clashes() -> None:
    """Where an activity switches back, what one objective starts may come before the other begins."""
    either = (Alternative(name="near", consumes=("h",)), Alternative(name="far"))
    film = Activity(name="film", switch_back=True, alternatives=either)
    blocks = (
        Objective(name="census", activities=("film",)),
        Objective(name="road", activities=("advance",), mandatory=False),
    )
    robots = (
        Robot(
            name="r",
            hardware=(Hardware(name="h", faulty=False),),
            activities=(film, activity("advance", "h")),
        ),
    )
    clash = clash_of(
        Mission(name="m", robots=robots, blocks=(Parallel(name="both", retries=1, blocks=blocks),))
    )
    rivals = (
        Rival("activity", "advance", ("both_try1.road",)),
        Rival("activity", "film", ("both_try1.census",)),
    )
    assert clash == Clash("hardware", ("h",), rivals, "branches", "both_try1")


def test_two_activities_of_one_objective() -> None:
    clash = clash_of(
        Mission(
            name="m",
            robots=robot(activity("film", "h"), activity("advance", "h")),
            blocks=(Objective(name="x", activities=("film", "advance")),),
        )
    )
    assert (clash.where, clash.block) == ("objective", None)
    assert "advance and film, both for objective x, ask for h" in sentence(clash)
    assert "start them by two objectives in sequence" in sentence(clash)


def test_an_activity_and_its_supplier_cannot_run_in_sequence() -> None:
    suppliers = activity("see", "h", produces=("image",)), activity("hear", "h", produces=("sound",))
    clash = clash_of(
        Mission(
            name="m",
            robots=robot(*suppliers, activity("follow", "image", "sound")),
            blocks=(Objective(name="x", activities=("follow",)),),
        )
    )
    assert clash.where == "chain"
    assert "hear and see, both for objective x, ask for h" in sentence(clash)
    assert "sequence" not in sentence(clash)


def test_two_branches_start_one_activity() -> None:
    blocks = (Objective(name="a", activities=("film",)), Objective(name="b", activities=("film",)))
    clash = clash_of(
        Mission(name="m", robots=robot(activity("film", "h")), blocks=(Parallel(name="both", blocks=blocks),))
    )
    assert (clash.kind, clash.wanted) == ("activity", ("film",))
    assert "objectives a and b, both in parallel block both, start activity film" in sentence(clash)
    assert "an activity of its own" in sentence(clash)


def test_no_activity_is_stopped_while_it_changes_its_alternative() -> None:
    # Where h returns, `follow` leaves the sound and the chart, whose producers would change as well.
    ways = {
        "locate": (("h",), ("k",)),
        "map": (("h",), ("position",), ()),
        "hear": (("h",),),
        "follow": (("sound", "chart"), ("k", "position")),
    }
    products = {"locate": ("position",), "map": ("chart",), "hear": ("sound",)}
    activities = tuple(
        Activity(
            name=name,
            alternatives=tuple(Alternative(name=f"{name}{i}", consumes=way) for i, way in enumerate(each)),
            produces=products.get(name, ()),
            switch_back=len(each) > 1,
        )
        for name, each in ways.items()
    )
    hardware = (Hardware(name="h"), Hardware(name="k", faulty=False))
    software = tuple(Software(name=s) for (s,) in products.values())
    robots = (Robot(name="r", hardware=hardware, software=software, activities=activities),)
    found = compose(Mission(name="m", robots=robots, blocks=(Objective(name="x", activities=("follow",)),)))
    clashes = [find_clash(found, error) for error in faults(found.net) if isinstance(error, ConfluenceError)]
    assert {(clash.kind, clash.wanted) for clash in clashes} == {("hardware", ("h",))}  # it starts with both


def test_a_producer_goes_on_while_its_other_resource_is_asked_for() -> None:
    # Where h fails, `follow` gives the image back and asks for the sound, and their producer changes as well.
    of = small.robot(
        small.hw("h", "g"),
        small.activity("listen", ("h",), (), produces=("sound", "image")),
        small.activity("follow", ("image", "h"), ("sound", "g")),
    )
    found = compose(small.mission(of, Objective(name="x", activities=("follow",))))
    assert not faults(found.net)
