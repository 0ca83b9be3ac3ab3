"""Failures with names: hand-written missions, what each comes to, and all that play them; what is wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from mcpn.drawing.compose import compose
from mcpn.errors import InputError
from mcpn.events import Event, What
from mcpn.mission.core.flattening import flatten
from mcpn.mission.model import Each, FactRoute, Mission, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.xml import read_mission
from mcpn.testing.judge.interpreter import FAILURE, SUCCESS, Happening, Interpreter
from tests.judge.lockstep import Judge
from tests.judge.test_abort import BEGIN, ROBOT, one
from tests.judge.test_interpreter import play
from tests.small import activity, hw, mission, robot


def on(reason: str, goto: str, *when: str) -> FactRoute:
    return FactRoute(on="failure", reason=reason, goto=goto, when=when)


def named(name: str, *routes: FactRoute, **others: object) -> Objective:
    """An objective with the activity of its name, that may be stuck or lost."""
    return Objective(name=name, activities=(name,), failures=("stuck", "lost"), routes=routes, **others)  # type: ignore[arg-type]


def failed(name: str, reason: str = "") -> Happening:
    return f"{FAILURE} {reason}".strip(), name


PLAIN = mission(ROBOT, named("a", on("stuck", "c"), failure="b"), one("b"), one("c"))
TRIES = mission(ROBOT, named("a", on("stuck", "b"), retries=1, repeat=2), one("b"))
RECOVERS = mission(
    ROBOT,
    Recursive(name="r", blocks=(named("a", on("stuck", "c"), recover="b", times=1), one("b"), one("c"))),
)
OUTER = mission(
    ROBOT,
    Recursive(
        name="r",
        blocks=(Recursive(name="s", blocks=(named("a", retries=1), one("b", failure="fail"))),),
        routes=(on("stuck", "c"), on("lost", "fail")),
        retries=1,
        success="succeed",
    ),
    one("c"),
)
ANOTHER_WAY = mission(
    ROBOT,
    Recursive(name="r", blocks=(named("a", failure="b"), one("b")), routes=(on("lost", "c"),)),
    one("c"),
)
BRANCH = mission(
    ROBOT,
    Parallel(
        name="both", blocks=(named("a"), Recursive(name="r", blocks=(named("b", on("stuck", "c")), one("c"))))
    ),
)
VALUES = mission(
    ROBOT,
    Each(name="e", values=("x", "y"), blocks=(named("a"),), routes=(on("lost", "b"),), success="succeed"),
    one("b"),
)
USED = replace(
    mission(ROBOT, Use(name="u", protocol="p", routes=(on("lost", "b"),), success="succeed"), one("b")),
    protocols=(Protocol(name="p", blocks=(named("a"),)),),
)
IN_TIME = mission(
    ROBOT,
    Recursive(
        name="o",
        blocks=(
            Recursive(name="r", blocks=(named("a", on("stuck", "c")), one("c")), timeout=5.0, retries=1),
        ),
        success="succeed",
        failure="b",
    ),
    one("b"),
)
MISSIONS = (PLAIN, TRIES, RECOVERS, OUTER, ANOTHER_WAY, BRANCH, VALUES, USED, IN_TIME)


@pytest.mark.parametrize("of", MISSIONS)
def test_all_that_play_it_agree(of: Mission) -> None:
    verdict = Judge(of).judge()
    assert verdict.kind == "agree"
    assert "modular controller" in verdict.pairs


@pytest.mark.parametrize(
    ("of", "events", "running", "outcome"),
    [
        (PLAIN, [failed("a", "stuck")], {"c"}, None),
        (PLAIN, [failed("a", "lost")], {"b"}, None),
        (PLAIN, [failed("a")], {"b"}, None),
        (TRIES, [failed("a_1_try1", "stuck")], {"b"}, None),
        (TRIES, [failed("a_1_try1", "lost")], {"a_1_try2"}, None),
        (TRIES, [(SUCCESS, "a_1_try1"), failed("a_2_try1", "stuck")], {"b"}, None),
        (RECOVERS, [failed("a_run1", "stuck")], {"c"}, None),
        (RECOVERS, [failed("a_run1", "lost")], {"b_a1"}, None),
        # The inner block has its tries first; where it leads to fail, the outer one knows the reason.
        (OUTER, [failed("r_try1.a_try1", "stuck")], {"r_try1.a_try2"}, None),
        (OUTER, [failed("r_try1.a_try1", "stuck"), failed("r_try1.a_try2", "stuck")], {"c"}, None),
        (OUTER, [failed("r_try1.a_try1"), failed("r_try1.a_try2", "lost")], set(), "failure"),
        (OUTER, [failed("r_try1.a_try1"), failed("r_try1.a_try2")], {"r_try2.a_try1"}, None),
        (ANOTHER_WAY, [failed("a", "lost")], {"b"}, None),
        (ANOTHER_WAY, [failed("a", "lost"), failed("b")], set(), "failure"),
        (BRANCH, [failed("b", "stuck"), failed("a", "lost")], {"c"}, None),
        (BRANCH, [failed("b", "lost"), failed("a", "lost")], set(), "failure"),
        (VALUES, [(SUCCESS, "a_x"), failed("a_y", "lost")], {"b"}, None),
        (USED, [failed("u.a", "lost")], {"b"}, None),
        (USED, [failed("u.a", "stuck")], set(), "failure"),
        (IN_TIME, [failed("r_try1.a", "stuck")], {"r_try1.c"}, None),
        (IN_TIME, [failed("r_try1.a", "lost")], {"r_try2.a"}, None),
    ],
)
def test_what_a_named_failure_leads_to(
    of: Mission, events: list[Happening], running: set[str], outcome: str | None
) -> None:
    _, state = play(Interpreter(of), BEGIN, *events)
    assert state.running == running
    assert state.outcome == outcome


def test_each_name_is_an_event() -> None:
    texts = {str(t.event) for t in compose(PLAIN).net.transitions if t.event}
    assert {"OBJ_a_EV_FAIL", "OBJ_a_EV_FAIL_stuck", "OBJ_a_EV_FAIL_lost", "OBJ_b_EV_FAIL"} <= texts
    assert "OBJ_b_EV_FAIL_stuck" not in texts
    assert Event.parse("OBJ_a_EV_FAIL_stuck") == Event(What.FAILURE, "a", "stuck")


def test_what_an_activity_names_its_objectives_fail_for() -> None:
    of = robot(hw("h"), replace(activity("a", ("h",)), failures=("lost",)), activity("b", ()))
    graph = flatten(mission(of, Objective(name="x", activities=("b", "a"), failures=("stuck", "lost"))))
    (section,) = graph.sections
    assert [reason for reason, _ in section.walk().__next__().reasons] == ["lost", "stuck"]


HEAD = '<mission name="m" xmlns="urn:mcpn:mission:1"><robot name="r"><activity name="a"{}/></robot>\n'
"""The blocks begin in line 2."""
X = '<objective name="x" activities="a" failures="{}">'
NONE = '<objective name="x" activities="a">'
STUCK = ' failures="stuck"'
GO = '<route on="failure" reason="stuck" goto="fail"/>'
END = "</objective>"


@pytest.mark.parametrize(
    ("activity_says", "blocks", "line", "expected"),
    [
        ("", X.format("stuck stuck") + END, 2, "failures of x names stuck 2 times"),
        ("", X.format("stuck stuck=0.1") + END, 2, "failures of x names stuck twice"),
        ("", X.format("EV_x") + END, 2, "with none of the words EV and EARLIER"),
        ("", X.format("1st") + END, 2, "expected names of letters, digits and _"),
        ("", X.format("stuck=2") + END, 2, "is 2, expected a number from 0 to 1"),
        ("", X.format("p=0.6 q=0.6") + END, 2, "are 1.2 together, expected at most 1"),
        (
            "",
            X.format('p=0.3 q=0.3" failure_probability="0.5') + END,
            2,
            "are 0.6 together, expected at most its failure_probability, 0.5",
        ),
        (' failures="EARLIER"', NONE + END, 1, "failures of activity a names 'EARLIER'"),
        ("", X.format("stock") + f"\n{GO}{END}", 3, "expected one of stock (did you mean stock?)"),
        ("", f"{NONE}\n{GO}{END}", 3, 'for which nothing in x fails; declare it by failures="..."'),
        (STUCK, f'{NONE}\n<route reason="stuck" goto="fail"/>{END}', 3, "though it is one on success"),
        (STUCK, f'{NONE}\n<route on="failure" goto="fail"/>{END}', 3, "asks for no fact and names no reason"),
        (STUCK, f"{NONE}{GO}\n{GO}{END}", 3, "behind one that always counts"),
        (STUCK, f'<parallel name="p">\n{GO}{NONE}{END}</parallel>', 3, "though p is a parallel block"),
        (
            STUCK,
            f'<objective name="o">\n{GO}<parallel name="p">{NONE}{END}</parallel>{END}',
            3,
            "for which nothing in o fails",
        ),
        (
            STUCK,
            f'<objective name="o" timeout="5">\n{GO}{NONE}{END}{END}',
            3,
            "though o holds blocks and has a timeout",
        ),
        (
            STUCK,
            f'<objective name="o">\n{GO}<objective name="p" timeout="5">{NONE}{END}{END}{END}',
            3,
            "for which nothing in o fails",
        ),
        (STUCK, f'<parallel name="p">{NONE}\n{GO}{END}</parallel>', 3, "it is a child of a parallel block"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(
    activity_says: str, blocks: str, line: int, expected: str, tmp_path: Path
) -> None:
    path = tmp_path / "m.xml"
    path.write_text(HEAD.format(activity_says) + blocks + "</mission>")
    with pytest.raises(InputError) as caught:
        read_mission(path)
    (problem,) = caught.value.problems
    assert problem.source is not None
    assert problem.source.line == line
    assert expected in problem.message
