"""Each activity of an objective that runs does so, waits or is refused: roles, words and files agree."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.verdicts.modes import situation
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import ConfluenceError, DivergenceError, InputError, LimitError
from mcpn.logic.questions import Questions
from mcpn.mission.model import Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Hardware, Robot, Software
from mcpn.report.graphs import save_graph
from mcpn.spaces.engine_names import Engine
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import AlternativesGraph, by_reduction
from mcpn.testing import missions
from tests.drawing.promises import check_promises
from tests.draws import fewer
from tests.logic.asked import ENGINES
from tests.shares import returns_early
from tests.small import activity, hw, mission, robot

LIMIT = 20_000


def beside(of: Robot) -> Mission:
    """While ``o1`` runs ``o3`` takes what ``b`` of ``o2`` needs: ``b`` waits once ``o1`` has ended."""
    series = Recursive(
        name="r1",
        blocks=(Objective(name="o1", activities=("a",)), Objective(name="o2", activities=("b",))),
    )
    return mission(of, Parallel(name="p", blocks=(series, Objective(name="o3", activities=("c",)))))


def for_hardware() -> Mission:
    return beside(robot(hw("h"), activity("a", ()), activity("b", ("h",)), activity("c", ("h",))))


def for_exclusive_software() -> Mission:
    wanted = [activity("b", ("s",)), activity("c", ("s",))]
    return beside(
        Robot(
            name="r",
            hardware=(Hardware(name="h"),),
            software=(Software(name="s", exclusive=True),),
            activities=(activity("d", ("h",), produces=("s",)), activity("a", ()), *wanted),
        )
    )


def for_the_first_alternative() -> Mission:
    """``b`` could run without ``h``: it waits for ``h`` all the same, as long as that is in service."""
    return beside(robot(hw("h"), activity("a", ()), activity("b", ("h",), ()), activity("c", ("h",))))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("waits", [for_hardware, for_exclusive_software, for_the_first_alternative])
def test_an_activity_waits_for_what_another_one_has(waits: Callable[[], Mission], engine: Engine) -> None:
    found = compose(waits())
    questions = Questions(spaces_of(found), on="alternatives", engine=engine)

    def holds(formula: str) -> bool:
        return questions.answer(formula).holds

    assert holds("EF waiting(b)")
    assert holds("AG (waiting(b) -> objective(o2) & objective(o3) & activity(c))")
    assert holds("AG (objective(o2) & activity(c) & !oos(h) -> waiting(b))")
    assert holds("AG !(waiting(b) & (activity(b) | refused(b)))")
    assert holds("AG (waiting(b) -> !event(OBJ_o2_EV_OK))")
    first = found.usage.activities["b"].alternatives[0].name
    assert holds(f"AG (waiting(b) <-> waiting(b)={first})")
    assert holds("EF (activity(b) & oos(h))") == (waits is for_the_first_alternative)
    assert not holds("EF waiting(c)")


def test_a_value_stands_after_words_about_alternatives_alone() -> None:
    found = compose(for_hardware())
    questions = Questions(spaces_of(found), on="alternatives", engine="explicit")
    with pytest.raises(InputError, match="no alternative of b is named other"):
        questions.answer("EF waiting(b)=other")
    with pytest.raises(InputError, match=r"expected refused\(b\) alone, found =b after it"):
        questions.answer("EF refused(b)=b")


def test_the_files_say_who_waits(tmp_path: Path) -> None:
    found = compose(for_hardware())
    graph = by_reduction(explore(found.net))
    for suffix in ("json", "dot"):
        save_graph(graph, found, tmp_path / f"graph.{suffix}")
    states = json.loads((tmp_path / "graph.json").read_text())["states"]
    assert '"o2, o3, b waits"' in (tmp_path / "graph.dot").read_text()
    both = [s for s in states if s["objectives"] == ["o2", "o3"] and not s["out_of_service"]]
    assert {tuple(s["waiting"].items()) for s in both if "c" in s["mode"]} == {(("b", "b"),)}


def one_of(objective: str, activity: Activity) -> str:
    runs, waits, refused = (f"{word}({activity.name})" for word in ("activity", "waiting", "refused"))
    some = f"{runs} | {waits} | {refused}"
    ways = " | ".join(f"alternative({activity.name})={w.name}" for w in activity.alternatives)
    none = f"!({runs} & {waits}) & !({runs} & {refused}) & !({waits} & {refused})"
    return f"AG (objective({objective}) -> ({some}) & {none} & ({runs} <-> {ways}))"


def waiting_in(found: MissionNet, graph: AlternativesGraph) -> set[str]:
    states = (situation(found, graph.marking(state)) for state in range(graph.states))
    return {f"{a}.{way}" for s in states for a, way in s.waiting.items()}


@fewer(0.5, least=8)
@given(missions(max_sections=5, producers=2) | missions(max_sections=4, producers=2, max_events=2))
def test_each_activity_is_one_thing_in_the_words_of_every_engine(mission: Mission) -> None:
    found = compose(mission)
    try:
        markings = explore(found.net, max_states=LIMIT)
        check_promises(found, markings)
        graph = by_reduction(markings)
    except (LimitError, ConfluenceError, DivergenceError) as error:
        returns_early(type(error).__name__)
        return
    wait = waiting_in(found, graph)
    for engine in ENGINES:
        questions = Questions(spaces_of(found), on="alternatives", engine=engine)
        for section in found.graph.walk():
            for name in section.activities:
                assert questions.answer(one_of(section.name, found.usage.activities[name])).holds
        for name in found.usage.started:
            for way in found.usage.activities[name].alternatives:
                answer = questions.answer(f"EF waiting({name})={way.name}")
                assert answer.holds == (f"{name}.{way.name}" in wait), (engine, name, way.name)
