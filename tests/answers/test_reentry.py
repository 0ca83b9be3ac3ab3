"""Blocks that one event ends and enters again: causes by brute force, numbers by dense solves."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.risk import risk
from mcpn.answers.reentry import blocks_entered_again
from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.drawing.compose import compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Hardware
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.stable.alternatives import direct
from tests.answers.dense import Dense, with_numbers
from tests.answers.test_cutsets import confirm
from tests.answers.test_risk_interrupted import assert_same
from tests.commands import mcpn
from tests.draws import fewer
from tests.logic.asked import ENGINES, Asked
from tests.mission.test_broken import NS
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot


def back(**of: str) -> Mission:
    """Two objectives beside each other, and a block that may lead back into itself."""
    blocks = (
        Objective(name="a", activities=("go",)),
        Objective(name="b", activities=("see",)),
    )
    both = Parallel(name="both", blocks=blocks, **of)  # type: ignore[arg-type]
    return mission(robot(hw("h", "g"), activity("go", ("h",), ()), activity("see", ("g",))), both)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_run_ends_though_its_objective_runs_again(engine: Engine) -> None:
    """Refused, ``b`` can only fail, though ``g`` be repaired: where ``a`` fails another run begins."""
    asked = Asked(compose(back(failure="both", failure_when="any")), engine)
    goal = asked.prospects.objectives["b"]
    assert goal.ends_from
    refused = asked.prospects.space.marked(asked.prospects.mission_net.by_role["refused", "see"])
    lost = asked.prospects.losing(goal, repairs=True)
    assert lost
    assert lost.count() == (refused & goal.running).count()
    confirm(asked)


@pytest.mark.parametrize("engine", ENGINES)
def test_what_may_be_either_is_refused_with_its_line(engine: Engine, tmp_path: Path) -> None:
    """A success of ``c`` ends ``both``, or leads back to where its branch begins if ``d`` has failed."""
    path = tmp_path / "m.xml"
    path.write_text(
        f"""<mission name="m" {NS}>
        <robot name="r"><activity name="go"/><activity name="stay"/><activity name="see"/></robot>
        <parallel name="both" success_when="any" success="both">
          <objective name="one">
            <parallel name="inner" failure="inner">
              <objective name="c" activities="go"/>
              <objective name="d" activities="stay"/>
            </parallel>
          </objective>
          <objective name="b" activities="see"/>
        </parallel></mission>"""
    )
    done = mcpn("causes", str(path), "--engine", engine)
    assert done.returncode == 2, done.stdout
    assert "m.xml:3" in done.stderr
    assert "put an objective between" in done.stderr


SEVERAL = st.sampled_from([2, 2, 2, 3])
MOST_STATES = 250


@st.composite
def returning(draw: st.DrawFn) -> Mission:
    """Blocks that end early, or are aborted, and whose routes lead back into them or into those around."""
    shared = (Hardware(name="h", shared=True),)
    # Each objective has an activity of its own: two that start one at the same moment would contend.
    ways: list[tuple[tuple[str, ...], ...]] = [((),), ((),), (("h",),), (("h",), ())]
    activities = tuple(activity(f"a{i}", *draw(st.sampled_from(ways))) for i in range(18))
    started = iter([a.name for a in activities])
    numbers = iter(range(100))

    def handlers() -> tuple[Handler, ...]:
        goto = draw(st.sampled_from([None, None, "abort", "succeed", "fail"]))
        return () if goto is None else (Handler(event="e", goto=goto),)

    def objective(name: str, *exits: str) -> Objective:
        routes = (draw(st.sampled_from([None, None, *exits])) for _ in range(2))
        return Objective(
            name=name,
            activities=(next(started),),
            success=next(routes),
            failure=next(routes),
            handlers=handlers(),
        )

    def branch(depth: int) -> Block:
        name = f"o{next(numbers)}"
        kind = draw(st.integers(0, 4))
        if kind == 0 and depth:
            return Recursive(name=name, blocks=(block(depth - 1, ("succeed", "abort")),))
        if kind <= 2:
            inner = draw(st.sampled_from([("abort",), ("succeed",), (f"{name}x",), (f"{name}y",)]))
            blocks = (objective(f"{name}x", *inner, "abort"), objective(f"{name}y", *inner))
            return Recursive(
                name=name, blocks=blocks[: draw(st.integers(1, 2))] if "y" not in inner[0] else blocks
            )
        return Objective(name=name, activities=(next(started),), handlers=handlers())

    def block(depth: int, around: tuple[str, ...] = ("last", "abort")) -> Parallel:
        name = f"p{next(numbers)}"
        routes = st.sampled_from([name, name, *around, None])
        routed = draw(st.tuples(routes, routes, routes).filter(lambda of: name in of))
        return Parallel(
            name=name,
            blocks=tuple(branch(depth) for _ in range(draw(SEVERAL))),
            success_when=draw(st.sampled_from(["all", "any", "2"])),
            failure_when=draw(st.sampled_from(["all", "any"])),
            success=routed[0],
            failure=routed[1],
            abort=routed[2],
        )

    blocks: tuple[Block, ...] = (block(1), Objective(name="last", activities=("a17",)))
    of = robot(shared, *activities, events=("e",))
    return Mission(name="m", robots=(of,), blocks=blocks)


def enters_again(of: Mission) -> bool:
    """Whether some block is; of a mission that cannot be composed the test says why."""
    try:
        return bool(blocks_entered_again(compose(of).graph))
    except (LimitError, SemanticsError):
        return True


@fewer(0.5, least=8)
@given(returning().filter(enters_again), st.sampled_from(ENGINES), st.booleans(), st.data())
def test_causes_and_numbers_are_those_of_brute_force(
    of: Mission, engine: Engine, demands: bool, data: st.DataObject
) -> None:
    try:
        found = compose(data.draw(with_numbers(of, demands=demands)))
        graph = direct(found.net, max_states=MOST_STATES)
        goals = Prospects(found, ArraySpace(graph)).objectives.values()
    except (LimitError, SemanticsError) as error:
        returns_early(type(error).__name__)
        return
    event(f"runs end from some states: {any(goal.ends_from for goal in goals)}")
    confirm(Asked(found, engine))
    assert_same(
        risk(Prospects(found, spaces_of(found).space(engine, "alternatives"))), Dense(found, graph).numbers()
    )
