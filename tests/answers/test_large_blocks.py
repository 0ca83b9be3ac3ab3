"""Failure causes of one large section, by every engine that can build it, with nothing left out."""

from __future__ import annotations

from itertools import product

import pytest

from mcpn.answers.causes.find import Causes, find_causes
from mcpn.answers.causes.fmeca import fmeca
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Block, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity
from mcpn.spaces.engine_names import Engine
from tests.logic.asked import ENGINES
from tests.small import activity, hw, mission, robot


def in_one_block(hardware: list[str], activities: list[Activity], branches: list[Block]) -> MissionNet:
    block = Parallel(name="block", blocks=tuple(branches))
    return compose(mission(robot(hw(*hardware), *activities), block))


def pairs_of(branch: int, each: int) -> list[tuple[str, ...]]:
    """The ways of one branch: pairs of its own hardware."""
    names = [f"b{branch}_h{i}" for i in range(each)]
    return [(names[i], names[i + 1]) for i in range(0, each, 2)]


def wide(branches: int, each: int) -> MissionNet:
    """Branches with hardware of their own; the last two are optional."""
    ways = [pairs_of(b, each) for b in range(branches)]
    objectives = [
        Objective(name=f"o{b}", activities=(f"a{b}",), mandatory=b < branches - 2) for b in range(branches)
    ]
    return in_one_block(
        [h for of in ways for way in of for h in way],
        [activity(f"a{b}", *of) for b, of in enumerate(ways)],
        list(objectives),
    )


def contended(one: int, other: int) -> MissionNet:
    """Two branches with sensors of their own and a spare that both may fall back to, one at a time."""
    hardware = ["spare"]
    activities = [activity("wait", ())]
    for b, count in enumerate((one, other)):
        names = [f"b{b}_h{i}" for i in range(count)]
        hardware += names
        activities.append(activity(f"a{b}", *((n,) for n in names[:-1]), (names[-1], "spare")))
    first = Recursive(name="r0", blocks=(Objective(name="o0", activities=("a0",)),))
    second = Recursive(
        name="r1",
        blocks=(Objective(name="begin", activities=("wait",)), Objective(name="o1", activities=("a1",))),
    )
    return in_one_block(hardware, activities, [first, second])


def complete(causes: Causes) -> None:
    """Nothing is left out: every moment, event, run and row is there."""
    goals = (causes.mission, *causes.objectives.values())
    moments = {"start", "whenever", "sometime"}
    for goal in goals:
        assert set(goal.moments) == (moments if goal is causes.mission else moments | {"entry"})
        assert bool(goal.cut_sets) is bool(goal.critical) is bool(goal.critical_with_repairs)
        assert all(critical.edges > 0 for critical in (*goal.critical, *goal.critical_with_repairs))
        assert all(goal.find_run(names) is not None for names in goal.cut_sets[:2])
    assert [s.section for s in causes.survival] == [None, "block"]
    assert all(s.always is not None and s.at_most is not None and s.run for s in causes.survival)


def facts(causes: Causes) -> object:
    """What must not depend on the engine; runs may be others."""
    goals = (causes.mission, *causes.objectives.values())
    return (
        [
            (g.name, g.moments, sorted(map(repr, g.critical)), sorted(map(repr, g.critical_with_repairs)))
            for g in goals
        ],
        [(s.section, s.cut_sets, s.always, s.at_most) for s in causes.survival],
        fmeca(causes.prospects),
    )


@pytest.mark.parametrize("found", [wide(3, 2), contended(2, 2)], ids=["wide", "contended"])
def test_every_engine_tells_all_and_the_same(found: MissionNet) -> None:
    first, *others = (find_causes(found, engine=engine) for engine in ENGINES)
    complete(first)
    for other in others:
        complete(other)
        assert facts(other) == facts(first)


def check_wide(branches: int, each: int, engine: Engine) -> None:
    causes = find_causes(wide(branches, each), engine=engine)
    complete(causes)
    # An objective is lost with one resource of each of its pairs.
    lost = {b: sorted(tuple(sorted(names)) for names in product(*pairs_of(b, each))) for b in range(branches)}
    for b in range(branches):
        assert sorted(causes.objectives[f"o{b}"].cut_sets) == lost[b]
    assert sorted(causes.mission.cut_sets) == sorted(names for b in range(branches - 2) for names in lost[b])


def check_contended(one: int, other: int, engine: Engine) -> None:
    causes = find_causes(contended(one, other), engine=engine)
    complete(causes)
    for b, count in enumerate((one, other)):
        names = [f"b{b}_h{i}" for i in range(count)]
        # All its own sensors, or the spare instead of the last of them; the spare may be in use beside it.
        lost = [tuple(names), tuple(sorted((*names[:-1], "spare")))]
        assert sorted(causes.objectives[f"o{b}"].moments["start"]) == sorted(lost)


def test_a_wide_block_by_closed_form() -> None:
    check_wide(3, 4, "local")


def test_a_block_with_contention_by_closed_form() -> None:
    check_contended(2, 3, "local")


@pytest.mark.slow
def test_five_branches_of_six_resources() -> None:
    check_wide(5, 6, "local")


@pytest.mark.slow
def test_contention_and_twenty_resources_in_one_section() -> None:
    check_contended(9, 10, "local")
