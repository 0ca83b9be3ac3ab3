"""Generated code on the runs of a bench: in C, in Python and as SCXML it does what the runtime does."""

from __future__ import annotations

import json
import random
import shutil
import sys
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import Mission
from mcpn.robot.bench.controller_places import ControllerPlace, Places
from mcpn.robot.bench.generated_code import Program, compare
from mcpn.robot.bench.scxml_replay import Statechart
from mcpn.robot.runtime.controller_tables import Tables
from mcpn.testing import missions
from tests.commands import mcpn
from tests.draws import fewer
from tests.shares import returns_early


@pytest.mark.parametrize("target", ["python", "c"])
def test_generated_code_on_the_same_runs(target: str, ulysse_net: MissionNet, tmp_path: Path) -> None:
    if target == "c" and not shutil.which("gcc"):
        pytest.skip("needs gcc")
    controller = generate(ulysse_net)
    places = Places(Tables(document(controller, ulysse_net)))
    every = sorted(places.tables.known)
    runs = [["MISSION_EV_START", *random.Random(n).choices(every, k=30), "no_such_EV"] for n in range(20)]
    assert compare(Program(document(controller, ulysse_net), target, tmp_path), places, runs) is None
    wrong = Program(document(generate(ulysse_net, "flat"), ulysse_net), target, tmp_path)
    answers = wrong.answers(runs)

    class Damaged(Program):
        def __init__(self) -> None:
            pass

        def answers(self, runs: list[list[str]]) -> list[str]:
            return [
                *answers[:40],
                answers[40].replace("_EV_", "_"),
                *answers[41:],
            ]

    difference = compare(Damaged(), places, runs)
    assert difference is not None
    assert list(difference.events) == runs[1][: 41 - len(runs[0])]


BRANCHED = missions(events=1, facts=2, timeouts=1, objectives=3, sections=4, awkward_names=True)


@pytest.mark.long
@fewer(0.2)
@given(BRANCHED, st.integers(0, 2**32), st.booleans())
def test_scxml_in_lockstep(mission: Mission, seed: int, flat: bool) -> None:
    """On any mission, as python-statemachine runs it; a tenth of the events are impossible or unknown."""
    pytest.importorskip("statemachine.io.scxml.processor", reason="needs mcpn[scxml]")
    mission_net = compose(mission)
    try:
        controller = generate(mission_net, "flat" if flat else "hierarchical", max_states=200)
        statechart = Statechart(document(controller, mission_net))
    except (SemanticsError, LimitError) as error:
        returns_early(type(error).__name__)
        return
    places = Places(Tables(document(controller, mission_net)))
    rng = random.Random(seed)
    runs = [drawn(places, rng) for _ in range(3)]
    assert compare(statechart, places, runs) is None

    class Deaf(Statechart):
        """It misses the last event."""

        def answers(self, runs: list[list[str]]) -> list[str]:
            *told, _ = super().answers(runs)
            return [*told, told[-1] if told else "before"]

    run = next((run for run in runs if places.after(reached(places, run[:-1]), run[-1]) is not None), None)
    if run is not None and len(run) > 1:
        deaf = Deaf(document(controller, mission_net))
        difference = compare(deaf, places, [run])
        if deaf.answers([run]) == statechart.answers([run]):  # the last event did what the one before did
            assert difference is None
        else:
            assert difference is not None
            assert list(difference.events) == run


def drawn(places: Places, rng: random.Random) -> list[str]:
    """Up to thirty events at random."""
    place, events = places.start, list[str]()
    while len(events) < 30 and place.possible:
        noise = rng.random() < 0.1
        some = {*places.tables.known, "no_such_EV"} if noise else {*place.possible}
        events.append(rng.choice(sorted(some)))
        place = reached(places, events[-1:], place)
    return events


def reached(places: Places, events: list[str], place: ControllerPlace | None = None) -> ControllerPlace:
    place = place or places.start
    for event in events:
        step = places.after(place, event)
        place = place if step is None else step[0]
    return place


def test_the_command_runs_scxml(written: str) -> None:
    pytest.importorskip("statemachine.io.scxml.processor", reason="needs mcpn[scxml]")
    found = mcpn("bench", written, "--runs", "50", "--against", "scxml", "--json")
    assert found.returncode == 0, found.stderr
    told = {"target": "scxml", "agrees": True, "events": [], "expected": None, "found": None}
    assert json.loads(found.stdout)["against"] == told


def test_without_the_interpreter_of_scxml(ulysse_net: MissionNet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "statemachine.io.scxml.processor", None)
    with pytest.raises(LimitError, match="needs python-statemachine: pip install 'mcpn"):
        Statechart(document(generate(ulysse_net), ulysse_net))
