"""Small missions on which mcpn was once wrong, each with what must hold of it now."""

from __future__ import annotations

import random

import pytest

from mcpn.answers.verdicts.modes import situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.events import START, Event, What
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction
from tests.test_campaign import judge


def hw(*names: str) -> tuple[Hardware, ...]:
    return tuple(Hardware(name=name) for name in names)


def activity(name: str, *alternatives: tuple[str, ...], produces: tuple[str, ...] = ()) -> Activity:
    ways = tuple(Alternative(name=f"{name}{i}", consumes=k) for i, k in enumerate(alternatives))
    return Activity(name=name, alternatives=ways, produces=produces)


def robot(
    hardware: tuple[Hardware, ...], *activities: Activity, exclusive: bool = False
) -> tuple[Robot, ...]:
    software = tuple(Software(name=s, exclusive=exclusive) for a in activities for s in a.produces)
    return (Robot(name="r", hardware=hardware, software=software, activities=activities),)


def after(found: MissionNet, graph: AlternativesGraph, *events: Event) -> tuple[int, ...]:
    """The stable marking that some events lead to, one after the other, from the beginning."""
    state = 0
    for happened in events:
        (state,) = {
            target
            for label, target in graph.successors(state)
            if graph.net.transitions[label].event == happened
        }
    return graph.marking(state)


def ok(name: str) -> Event:
    return Event(What.SUCCESS, name)


def a_producer_falls_back_while_its_section_stops(*, exclusive: bool = True) -> Mission:
    """While ``drive`` stops, ``attitude`` takes the image at last, and ``vision`` may ask for the camera."""
    return Mission(
        name="rover",
        robots=robot(
            hw("stereo_rig", "mast", "star_tracker"),
            activity("vision", ("stereo_rig",), ("mast",), produces=("image",)),
            activity("attitude", ("star_tracker",), ("image",), produces=("heading",)),
            activity("drive", ("image", "heading")),
            activity("photo", ("mast",)),
            exclusive=exclusive,
        ),
        blocks=(
            Objective(name="approach", activities=("drive",)),
            Objective(name="panorama", activities=("photo",)),
        ),
    )


def hardware_fails_while_its_activity_waits() -> Mission:
    """``sample`` holds the arm and waits for the image, whose producer waits for the lamp."""
    return Mission(
        name="sampler",
        robots=robot(
            hw("lamp", "arm"),
            activity("imaging", ("lamp",), produces=("image",)),
            activity("sample", ("arm", "image")),
            activity("light", ("lamp",)),
            activity("think", ()),
            activity("stow", ("arm",)),
        ),
        blocks=(
            Parallel(
                name="both",
                failure="end",
                blocks=(
                    Recursive(
                        name="science",
                        blocks=(
                            Objective(name="plan", activities=("think",)),
                            Objective(name="take", activities=("sample",)),
                        ),
                    ),
                    Objective(name="lighting", activities=("light",)),
                ),
            ),
            Objective(name="end", activities=("stow",)),
        ),
    )


def one_failure_strikes_a_producer_and_what_is_above() -> Mission:
    """``fly`` gives the position back as the lidar fails, while ``scanning`` evaluates for the same reason.

    So the scan is released by ``localisation``, which has nothing beside it, in a chain of stops.
    """
    return Mission(
        name="drone",
        robots=robot(
            (Hardware(name="lidar", shared=True),),
            activity("scanning", ("lidar",), produces=("scan",)),
            activity("localisation", ("scan",), produces=("position",)),
            activity("fly", ("position", "lidar")),
        ),
        blocks=(Objective(name="leg", activities=("fly",), retries=1),),
    )


def what_is_given_up_still_evaluates() -> Mission:
    """As the lamp fails ``inspect`` gives ``outline`` up and asks for the image, as its producer does."""
    return Mission(
        name="inspector",
        robots=robot(
            (Hardware(name="lamp", shared=True), *hw("camera")),
            activity("imaging", ("camera",), produces=("image",)),
            activity("outlining", ("lamp",), ("image",), produces=("outline",)),
            activity("inspect", ("lamp", "outline"), ("image",)),
        ),
        blocks=(Objective(name="look", activities=("inspect",)),),
    )


def eight_branches() -> Mission:
    names = [f"leg{i}" for i in range(8)]
    return Mission(
        name="octopod",
        robots=robot(hw("h"), *(activity(f"move_{n}", ()) for n in names)),
        blocks=(
            Parallel(
                name="walk",
                blocks=tuple(
                    Objective(name=n, activities=(f"move_{n}",), mandatory=i != 3)
                    for i, n in enumerate(names)
                ),
            ),
        ),
    )


@pytest.mark.parametrize(
    "mission",
    [
        a_producer_falls_back_while_its_section_stops(),
        hardware_fails_while_its_activity_waits(),
    ],
    ids=lambda mission: mission.name,
)
def test_every_engine_and_both_controllers_agree(mission: Mission) -> None:
    assert judge(mission, random.Random(1)) == "confluent, may contend"


def test_a_shared_image_needs_no_luck() -> None:
    mission = a_producer_falls_back_while_its_section_stops(exclusive=False)
    assert judge(mission, random.Random(1)) == "confluent, cannot contend"


def test_a_scan_released_in_a_chain_of_stops_is_not_counted_twice() -> None:
    mission = one_failure_strikes_a_producer_and_what_is_above()
    assert judge(mission, random.Random(1)) == "confluent, cannot contend"
    found = compose(mission)
    graph = by_reduction(explore(found.net))
    failed, repaired = Event(What.OUT_OF_SERVICE, "lidar"), Event(What.REPAIRED, "lidar")
    # The first leg began with lidar and lost it; the second begins after the repair, and runs.
    (first, second) = (o.name for o in found.graph.walk())
    begun = (START, failed, repaired, Event(What.FAILURE, first))
    again = situation(found, after(found, graph, *begun))
    assert again.objectives == (second,)
    assert again.mode == {a: f"{a}0" for a in ("scanning", "localisation", "fly")}


def test_an_alternative_shares_with_what_the_one_before_it_leaves_behind() -> None:
    mission = what_is_given_up_still_evaluates()
    assert judge(mission, random.Random(1)) == "confluent, cannot contend"


def test_what_begins_waits_until_no_producer_evaluates() -> None:
    found = compose(a_producer_falls_back_while_its_section_stops())
    assert found.usage.handover.gated == {"panorama"}
    begin = next(t for t in found.net.transitions if t.name == "OBJ_panorama_begin")
    assert begin.rank == len(found.net.internal_ranks) - 1  # after all that stops


def test_a_resource_that_fails_while_its_activity_waits_can_be_repaired() -> None:
    found = compose(hardware_fails_while_its_activity_waits())
    graph = by_reduction(explore(found.net))
    begin = (START, ok("plan"))
    failed = Event(What.OUT_OF_SERVICE, "arm")
    waiting = situation(found, after(found, graph, *begin))
    assert waiting.waiting == {"sample": "sample0", "imaging": "imaging0"}
    without = situation(found, after(found, graph, *begin, failed))
    assert (without.out_of_service, without.refused, without.waiting) == (("arm",), ("sample",), {})
    repaired = (*begin, failed, Event(What.REPAIRED, "arm"))
    again = situation(found, after(found, graph, *repaired, ok("lighting"), Event(What.FAILURE, "take")))
    assert (again.objectives, again.mode) == (("end",), {"stow": "stow0"})


def test_a_wide_block_remembers_which_branches_have_ended() -> None:
    found = compose(eight_branches())
    graph = by_reduction(explore(found.net))
    begun = (START, ok("leg0"), Event(What.FAILURE, "leg1"), ok("leg4"))
    assert situation(found, after(found, graph, *begun)).done == ("leg0", "leg1", "leg4")
