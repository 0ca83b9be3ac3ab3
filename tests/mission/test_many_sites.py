"""What flattening a mission of many sites makes and asks, counted by site."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from experiments.growth.growth import of_natural
from mcpn.drawing.compose import compose
from mcpn.mission.core.copies import BlockPosition, Copies
from mcpn.mission.core.flattening import flatten
from mcpn.mission.core.objectives_graph import ObjectivesGraph, ParallelSection, Section
from mcpn.mission.model import Objective, Parallel, Recursive
from mcpn.mission.static import handover
from tests.small import activity, mission, robot


def test_a_branch_has_one_graph(monkeypatch: pytest.MonkeyPatch) -> None:
    made, initialise = list[str](), ObjectivesGraph.__init__

    def noted(graph: ObjectivesGraph, *given: object, **named: object) -> None:
        initialise(graph, *given, **named)  # type: ignore[arg-type]
        made.append(graph.entry)

    monkeypatch.setattr(ObjectivesGraph, "__init__", noted)
    flatten(of_natural("sites")(6))
    branches = [f"do{site}_{branch}" for site in range(6) for branch in range(2)]
    assert made == [*branches, "reach0", "reach0"]  # that of the mission, then with what belongs to it


def test_only_the_graph_of_the_mission_tells_copies(monkeypatch: pytest.MonkeyPatch) -> None:
    made, initialise = list[Copies](), Copies.__init__

    def noted(copies: Copies) -> None:
        initialise(copies)
        made.append(copies)

    monkeypatch.setattr(Copies, "__init__", noted)
    graph = flatten(of_natural("sites")(6))
    assert made == [graph.copies]
    inside = [
        each for section in graph.sections if isinstance(section, ParallelSection) for each in section.graphs
    ]
    assert len(inside) == 12
    assert not any(each.copies.objectives or each.requirements for each in inside)


def test_branches_of_one_objective_are_not_looked_into_for_what_they_hand_over(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked, onward = list[str](), handover._onward

    def noted(graph: ObjectivesGraph, beside: handover.Running) -> Iterator[tuple[frozenset[str], Section]]:
        asked.append(graph.entry)
        return onward(graph, beside)

    monkeypatch.setattr(handover, "_onward", noted)
    inside = [Objective(name=name, activities=("a",)) for name in ("x", "y")]
    two = Recursive(name="two", blocks=tuple(inside))
    one = Objective(name="one", activities=("b",))
    both = mission(robot((), activity("a", ()), activity("b", ())), Parallel(name="both", blocks=(two, one)))
    assert compose(both).usage.handover.with_idle == {"a"}
    assert asked == ["both", "x"]


def test_a_graph_of_which_all_is_reached_is_itself_and_another_is_not() -> None:
    blocks = [Objective(name="o", activities=("a",), success="c"), Objective(name="c", activities=("a",))]
    graph = flatten(mission(robot((), activity("a", ())), *blocks))
    assert graph.reachable() is graph
    wider = ObjectivesGraph(graph.sections, "c")
    assert [section.name for section in wider.reachable().unreached] == ["o"]


def test_what_authors_say_is_gathered_once(monkeypatch: pytest.MonkeyPatch) -> None:
    graph = flatten(of_natural("sites")(6))
    walked, chain = list[str](), vars(BlockPosition)["chain"]

    def noted(position: BlockPosition) -> Iterator[BlockPosition]:
        walked.append(position.block)
        return iter(chain.fget(position))

    monkeypatch.setattr(BlockPosition, "chain", property(noted))
    assert [graph.copies.meant_as(word) for word in ("optional", "endless", "fails")] == [set(), set(), set()]
    assert graph.copies.meant_as("entered") == graph.copies.objectives.keys()
    assert len(walked) == len(graph.copies.objectives)
