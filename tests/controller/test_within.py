"""Monitors within a mission: at each prefix of a run, what all of the mission's ways to go on say.

What has been seen is taken out of a formula step by step (Bacchus, Kabanza, *Using temporal logics to express
search control knowledge for planning*, Artificial Intelligence 116, 2000); what is left is asked of the
present state by tableaux, which share nothing with automata.
"""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from hypothesis import event, given, reject
from hypothesis import strategies as st

from mcpn.answers.requirements import AskedRequirement
from mcpn.controller.monitors import watched
from mcpn.controller.monitors.watched import Watcher
from mcpn.controller.monitors.writing import files, monitors_of
from mcpn.drawing.compose import compose
from mcpn.errors import ConfluenceError, DivergenceError, LimitError
from mcpn.mission.model import Mission
from mcpn.mission.requirement import Requirement
from mcpn.nets.petri import Marking, PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.formula_names import Names
from mcpn.spaces.markings.explicit import explore
from mcpn.spaces.stable.alternatives import by_reduction
from mcpn.study import open_study
from mcpn.testing import missions
from tests.commands import mcpn, output
from tests.controller.test_monitors import COME, LOST, SEE, START, SURVEY
from tests.draws import fewer
from tests.logic import formulas as on_states
from tests.logic.formulas import Edges, Written
from tests.logic.ltl import tableau
from tests.logic.ltl.test_paths import fits

TRUE: Written = ("true",)
FALSE: Written = ("false",)


def both(operator: str, left: Written, right: Written) -> Written:
    """A conjunction or disjunction, constants left out."""
    stops, goes = (FALSE, TRUE) if operator == "&" else (TRUE, FALSE)
    if stops in (left, right):
        return stops
    if left == right:
        return left
    return right if left == goes else left if right == goes else (operator, left, right)


def no(formula: Written) -> Written:
    """A negation, constants left out."""
    return {TRUE: FALSE, FALSE: TRUE}.get(formula, ("!", formula))


class Progression:
    """What is left of a formula after a step."""

    def __init__(self, net: PetriNet, edges: Edges) -> None:
        self.net, self.edges = net, edges

    def after(self, f: Written, marking: Marking, fired: int) -> Written:
        """What the path from the next state on must satisfy, for all of it to satisfy a formula."""
        match f:
            case _ if not tableau.speaks_of_paths(f):
                return TRUE if marking in on_states.satisfying(f, self.net, self.edges) else FALSE
            case ("fires", *names):
                return TRUE if self.net.transitions[fired].name in names else FALSE
            case ("X", a):
                return a  # type: ignore[no-any-return]
            case ("!", a):
                return no(self.after(a, marking, fired))
            case ("&" | "|" as operator, a, b):
                return both(operator, self.after(a, marking, fired), self.after(b, marking, fired))
            case ("->", a, b):
                return both("|", no(self.after(a, marking, fired)), self.after(b, marking, fired))
            case ("F", a):
                return both("|", self.after(a, marking, fired), f)
            case ("G", a):
                return both("&", self.after(a, marking, fired), f)
            case ("U" | "W", a, b):
                kept = both("&", self.after(a, marking, fired), f)
                return both("|", self.after(b, marking, fired), kept)
            case ("R", a, b):
                kept = both("|", self.after(a, marking, fired), f)
                return both("&", self.after(b, marking, fired), kept)
        raise AssertionError(f)

    def value(self, left: Written, at: Marking) -> str | None:
        """What all ways to go on say of what is left of a formula; ``None`` where that is too large."""
        may = []
        for wanted in (left, no(left)):
            if not fits(wanted, self.edges):
                return None
            may.append(at in tableau.satisfying(wanted, self.net, self.edges))
        return {(True, True): "open", (True, False): "satisfied", (False, True): "violated"}[may[0], may[1]]


DRAWN = missions(sections=3, hardware=1, producers=1, alternatives=2, events=1) | missions(
    sections=3, hardware=1, producers=0, events=1, aborts=2, pauses=4
)


@fewer(0.3)
@given(DRAWN, st.data())
def test_each_prefix_says_what_all_ways_to_go_on_say(mission: Mission, data: st.DataObject) -> None:
    mission_net = compose(mission)
    net = mission_net.net
    try:
        graph = by_reduction(explore(net, max_states=400))
    except (LimitError, ConfluenceError, DivergenceError):
        reject()
    space = ArraySpace(graph)
    if graph.states > 60:
        reject()
    leaving = {s: [*space.edges(s)] for s in range(graph.states)}
    edges: dict[Marking, list[tuple[Any, Marking]]] = {
        graph.marking(s): [(e.transition, graph.marking(e.target)) for e in of] for s, of in leaving.items()
    }
    if any(len({net.transitions[e.transition].event for e in of}) < len(of) for of in leaving.values()):
        reject()  # one event by two transitions, which fires(...) tells apart and no monitor does
    running = [p.name for i, p in enumerate(net.places) if mission_net.roles.get(i, ("",))[0] == "objective"]
    happening = [t.name for t in net.transitions if t.event is not None]
    ends = [net.places[p].name for p in mission_net.ends.values()]
    for marking, of in edges.items():
        if any(marking[p] for p in mission_net.ends.values()):  # where nothing need happen any more
            of.append((None, marking))
    written = data.draw(tableau.formulas([*running, *ends], happening, leaves=4, of_ctl=False))
    if not tableau.speaks_of_paths(written) or not fits(written, edges):
        return
    text, names = tableau.text(written), Names(net)
    said = tableau.read(written, net)
    asked = AskedRequirement("r", Requirement(name="r", formula=text), text, said, names)
    watcher, progression = Watcher(space, mission_net.ends.values()), Progression(net, edges)
    monitor, plain = watcher.monitor(asked, said, True), watcher.monitor(asked, said)
    assert monitor.within
    assert not plain.within
    chosen = random.Random(data.draw(st.integers(0, 99)))
    for _ in range(4):
        state, left, taken = 0, written, list[str]()
        for _ in range(5):
            expected = progression.value(left, graph.marking(state))
            if expected is None:
                break
            found, sooner = monitor.run(taken)[-1], plain.run(taken)[-1]
            assert found == expected, (text, taken)
            assert sooner in ("open", found), (text, taken)
            event(f"{found}, by any continuation {sooner}")
            if not leaving[state] or expected != "open":
                break
            edge = chosen.choice(leaving[state])
            left = progression.after(left, graph.marking(state), edge.transition)
            taken.append(str(net.transitions[edge.transition].event))
            state = edge.target


@pytest.fixture
def survey(tmp_path: Path) -> Path:
    path = tmp_path / "survey.xml"
    path.write_text(SURVEY)
    return path


def test_what_the_mission_cannot_do_any_more_is_decided(survey: Path) -> None:
    plain, within = (monitors_of(open_study(survey).mission_spaces(), within=of) for of in (False, True))
    values = {
        of: {each.name: each.run([START, "OBJ_come_EV_FAIL"])[-1] for each in monitors.monitors}
        for of, monitors in (("plain", plain), ("within", within))
    }
    # The mission has failed: nobody sees any more, and it does not succeed.
    assert values["plain"] == dict.fromkeys(values["plain"], "open")
    assert values["within"] | {"after": "", "works": ""} == {
        "sees": "satisfied",
        "comes": "violated",
        "ends": "violated",
        "after": "",
        "works": "",
    }
    (comes,) = (each for each in within.monitors if each.name == "comes")
    assert comes.run([START, COME]) == ["open", "open", "satisfied"]
    (ends,) = (each for each in within.monitors if each.name == "ends")
    assert ends.run([START, COME, SEE]) == ["open", "open", "open", "satisfied"]
    assert ends.run([START, COME, LOST])[-1] == "violated"  # nothing brings film back into an objective


def test_a_mission_that_has_ended_may_stay_as_it_is(tmp_path: Path) -> None:
    """Only hardware changes there: a monitor that waited for that said that it must fail some day."""
    calm = '<requirement name="calm" formula="G !oos(camera)"/>'
    (tmp_path / "m.xml").write_text(SURVEY.replace("<requirement", f"{calm}<requirement", 1))
    of = monitors_of(open_study(tmp_path / "m.xml").mission_spaces(), within=True)
    (monitor,) = (each for each in of.monitors if each.name == "calm")
    assert monitor.run([START, COME, SEE, LOST]) == ["open", "open", "open", "open", "violated"]


def test_the_command_says_what_decides(survey: Path, tmp_path: Path) -> None:
    log = tmp_path / "robot.log"
    log.write_text(f"{START}\nOBJ_come_EV_FAIL\n")
    found = output("monitor", survey, "--log", log, "--within-mission", code=1)
    assert {*found["within_mission"].values()} == {True}
    assert found["log"]["values"]["comes"] == "violated"
    found = output("monitor", survey, "--log", log)
    assert {*found["within_mission"].values()} == {False}
    assert {*found["log"]["values"].values()} == {"open"}


def test_too_large_a_monitor_is_decided_by_any_continuation(
    survey: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(watched, "MAX_WITHIN", 2)
    of, plain = (monitors_of(open_study(survey).mission_spaces(), within=within) for within in (True, False))
    large: dict[str, Any] = {each.name: each for each in of.monitors if not each.within}
    assert "comes" in large
    assert large == {each.name: each for each in plain.monitors if each.name in large}
    assert '"within_mission": false' in files(of)["monitors.json"]


def test_the_limit_is_told(survey: Path, tmp_path: Path) -> None:
    run = mcpn("monitor", survey, "--within-mission", "-o", tmp_path / "build")
    assert run.returncode == 0
    assert "any continuation" not in run.stdout
