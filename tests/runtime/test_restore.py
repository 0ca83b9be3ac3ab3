"""Actions of a restored controller, and journals."""

from __future__ import annotations

import contextlib
import io
import json
import random
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from mcpn.cli.line import command_line, run
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.errors import ConfluenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.robot.runtime import Action, Controller, Journal, Refused
from mcpn.robot.runtime.file_schema import signed_line
from mcpn.robot.runtime.journal import JournalError, read_journal
from mcpn.robot.runtime.restoring import _producers_first
from mcpn.testing import missions
from tests.conftest import ULYSSE
from tests.draws import composed, fewer
from tests.shares import returns_early

Orders = tuple[str, str | None, tuple[Any, ...]]


class Robot:
    """What a robot does that obeys: what runs, and with which alternative, and what holds hardware."""

    def __init__(self, running: bool | None = None) -> None:
        self.selected: dict[str, Orders] = {}
        self.running: dict[str, bool] = {}

    def obey(self, action: Action) -> None:
        if action.verb == "select":
            assert action.activity is not None
            assert action.alternative is not None
            self.selected[action.activity] = (action.alternative, action.objective, action.parameters)
        elif action.verb == "start":
            assert action.activity is not None
            assert not self.running.get(action.activity), "started twice"
            self.running[action.activity] = True
        elif action.verb == "stop":
            assert action.activity is not None
            self.running[action.activity] = False

    def does(self) -> dict[str, Orders]:
        return {activity: self.selected[activity] for activity, on in self.running.items() if on}


def told_to(robot: Robot, actions: tuple[Action, ...]) -> None:
    for action in actions:
        robot.obey(action)


@fewer(0.4, least=6)
@given(missions(), st.randoms(use_true_random=False), st.sampled_from(["hierarchical", "modular"]))
def test_a_restarted_robot_does_what_it_did(
    mission: Mission, rng: random.Random, form: Literal["hierarchical", "modular"]
) -> None:
    """A robot in any state that obeys what restore says does what one does that has obeyed all along."""
    mission_net = composed(mission)
    try:
        found = document(generate(mission_net, form), mission_net)
    except (ConfluenceError, LimitError) as error:
        returns_early(type(error).__name__)
        return
    controller, robot = Controller.from_document(found), Robot()
    for _ in range(rng.randrange(12)):
        if not controller.possible:
            break
        told_to(robot, controller.handle(rng.choice(controller.possible)))
    other, restarted = Controller.from_document(found), Robot()
    for activity in found["activities"]:
        restarted.running[activity] = rng.random() < 0.5
        restarted.selected[activity] = ("anything", None, ())
    actions = other.restore(controller.snapshot())
    told_to(restarted, actions)
    assert restarted.does() == robot.does()
    assert {a.activity for a in actions if a.verb == "stop"} == found["activities"].keys()
    check_order(actions, found)


def check_order(actions: tuple[Action, ...], found: dict[str, Any]) -> None:
    """Stop, release, select, start; what is consumed is started before its consumer, and stopped after it."""
    activities = found["activities"]
    needs = {
        name: {
            other
            for way in row["alternatives"].values()
            for other, made in activities.items()
            if set(made["produces"]) & set(way["consumes"])
        }
        for name, row in activities.items()
    }
    for _ in needs:  # what is needed by what is needed, too: in a cycle any order will do
        needs = {name: of.union(*(needs[other] for other in of)) for name, of in needs.items()}
    stopped = [a.activity or "" for a in actions if a.verb == "stop"]
    for number, first in enumerate(stopped):
        for later in stopped[number + 1 :]:
            assert first not in needs[later] or later in needs[first]
    verbs = [action.verb for action in actions]
    assert verbs == sorted(verbs, key=["stop", "release", "select", "start"].index)
    ways = {a.activity: a.alternative for a in actions if a.verb == "select"}
    started = [a.activity for a in actions if a.verb == "start"]
    assert sorted(ways, key=str) == sorted(started, key=str)
    for number, consumer in enumerate(started):
        consumed = found["activities"][consumer]["alternatives"][ways[consumer]]["consumes"]
        for producer in started[number:]:
            assert not set(found["activities"][producer]["produces"]) & set(consumed)


def journal(found: dict[str, Any], steps: int) -> tuple[str, Controller]:
    """A mission at random, some events of which are refused."""
    rng, stream = random.Random(3), io.StringIO()
    controller = Controller.from_document(found)
    controller.observe(Journal(stream, iter(range(10**6)).__next__))
    every = sorted(controller._tables.known)
    for _ in range(steps):
        with contextlib.suppress(Refused):
            controller.handle(rng.choice(every if rng.random() < 0.3 else controller.possible))
    return stream.getvalue(), controller


def test_a_journal_says_what_happened(ulysse_document: dict[str, Any]) -> None:
    text, controller = journal(ulysse_document, 30)
    lines = [json.loads(line) for line in text.splitlines()]
    assert [line["time"] for line in lines] == list(range(30))
    assert [(line["event"], not line["refused"], line["actions"]) for line in lines] == [
        (step.event, step.taken, [*map(str, step.actions)]) for step in controller.log
    ]
    assert 0 < sum(line["refused"] for line in lines) < 30
    assert all(after["from"] == before["to"] for before, after in pairwise(lines))
    assert lines[-1]["to"]["section"] == controller.section
    assert lines[-1]["to"]["mode"] == dict(controller.mode)
    assert [told.event for told in read_journal(text.splitlines())] == [line["event"] for line in lines]


def test_a_journal_is_replayed_by_the_simulator(ulysse_document: dict[str, Any], tmp_path: Path) -> None:
    text, controller = journal(ulysse_document, 30)
    path = tmp_path / "log.jsonl"
    path.write_text(text)
    ran = CliRunner().invoke(command_line, ["simulate", str(ULYSSE), "--events", str(path), "--json"])
    assert ran.exit_code == 0, ran.output
    said = json.loads(ran.output)
    assert [step["event"] for step in said["steps"]] == [s.event for s in controller.log if s.taken]
    assert said["outcome"] == controller.outcome
    assert sorted(said["possible"]) == list(controller.possible)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda lines: lines[:1] + lines, "log.jsonl:2: found MISSION_EV_START, which is not possible here"),
        (lambda lines: ["{" + lines[0]], "log.jsonl:1: no line of a journal"),
        (lambda lines: [lines[0].replace('"refused": false', '"refused": true')], "line has been changed"),
        (lambda lines: [signed_line({**json.loads(lines[0]), "refused": 1})], "refused: found 1, expected t"),
        (lambda lines: [signed_line({**json.loads(lines[0]), "refused": True})], "which is possible here"),
    ],
)  # fmt: skip
def test_a_journal_that_the_mission_does_not_allow(
    change: Any, expected: str, ulysse_document: dict[str, Any], tmp_path: Path
) -> None:
    controller, stream = Controller.from_document(ulysse_document), io.StringIO()
    controller.observe(Journal(stream))
    controller.handle("MISSION_EV_START")
    path = tmp_path / "log.jsonl"
    path.write_text("\n".join(change(stream.getvalue().splitlines())))
    error = io.StringIO()
    with contextlib.redirect_stderr(error):
        assert run(["simulate", str(ULYSSE), "--events", str(path)]) == 2
    assert expected in error.getvalue()


@given(st.data())
def test_a_key_that_is_not_declared_is_refused_or_without_meaning(data: st.DataObject) -> None:
    """A line of another program may say more of an event; of places, and of runs that go on, nothing may."""
    place = {"phase": "running", "section": "o", "state": 0, "objectives": ["o"], "mode": {"a": "x"}}
    step = {
        "time": 0.5,
        "event": "e",
        "refused": False,
        "from": place,
        "to": dict(place),
        "actions": ["start a x"],
    }
    resumed = {"time": 0.5, "resumed": 3}
    where = data.draw(st.sampled_from(["event", "from", "to", "resumed"]))
    known = {*step, *place, *resumed, "number", "digest"}
    key = data.draw(st.from_regex("[a-z]{3,9}", fullmatch=True).filter(lambda key: key not in known))
    target: Any = {"event": step, "resumed": resumed}.get(where) or step[where]
    target[key] = data.draw(st.sampled_from([0, None, True, "x", {"y": 1}]))
    line = json.dumps(resumed if where == "resumed" else step)
    if where == "event":
        assert [(told.event, told.refused) for told in read_journal([line])] == [("e", False)]
        return
    with pytest.raises(JournalError, match=f'found "{key}", expected one of the keys') as caught:
        [*read_journal(["", line])]
    assert caught.value.line == 2


@given(st.data())
def test_producers_stand_before_what_consumes(data: st.DataObject) -> None:
    """Each activity once; what a producer outside of them makes is no reason to wait."""
    names = data.draw(st.permutations("abcdef"))
    makes = {
        name: data.draw(st.lists(st.sampled_from(names[:i]), unique=True)) if i else []
        for i, name in enumerate(names)
    }
    consumed = {name: makes[name] for name in data.draw(st.permutations(names[1:]))}
    order = _producers_first(consumed, {name: [name] for name in names})
    assert sorted(order) == sorted(consumed)
    for name, before in consumed.items():
        assert all(order.index(other) < order.index(name) for other in before if other in consumed)


def test_activities_in_a_cycle_stand_once_each() -> None:
    assert sorted(_producers_first({"a": ["b"], "b": ["a"]}, {"a": ["a"], "b": ["b"]})) == ["a", "b"]
