"""Losses that nobody notices: by hand, and every engine against plain search over the net."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.answers.spaces_by_engine import spaces_of
from mcpn.answers.undetected_losses import late_losses
from mcpn.drawing.compose import MissionNet, compose
from mcpn.mission.model import Mission, Objective
from mcpn.mission.xml import read_mission
from mcpn.nets.petri import Marking
from mcpn.spaces.engine_names import Engine
from mcpn.testing import missions
from tests.answers.test_cutsets import small
from tests.draws import fewer
from tests.logic.asked import ENGINES
from tests.logic.oracle import Play, fragile_missions
from tests.small import activity, hw, mission, robot

Told = dict[str, tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]]
"""By hardware: in vain after its loss alone, after others too, and what succeeds if it is found in time."""


def found_of(net: MissionNet, engine: Engine) -> Told:
    space = spaces_of(net).space(engine, "alternatives")
    return {
        each.hardware: (each.unnoticed, each.unnoticed_later, each.in_time)
        for each in late_losses(net, space)
    }


def searched(net: MissionNet) -> Told:
    """The same by plain search: whether the present run of an objective may succeed, and by what."""
    play, told = Play(net), Told()
    everything = play.reach([play.initial])
    repairs = [f"{name}_EV_RD" for name in play.hardware]

    def succeeds(start: Marking, name: str, without: list[str]) -> bool:
        run = play.reach([start], [*repairs, *without], f"OBJ_{name}")
        return any(text == f"OBJ_{name}_EV_OK" for m in run for text, _ in play.edges(m))

    for name in (h.name for h in net.core.late if ("known", h.name) in net.by_role):
        (known,) = net.by_role["known", name]
        alone = play.reach([play.initial], [f"{other}_EV_OOS" for other in play.hardware if other != name])
        detected = f"{name}_EV_DETECTED"
        losses = [
            (m, to)
            for m in everything
            for text, to in play.edges(m)
            if text == f"{name}_EV_OOS" and not to[known] and detected not in dict(play.edges(to))
        ]
        unnoticed, later, in_time = list[str](), list[str](), list[str]()
        for section in net.graph.walk():
            runs = play.marks(f"OBJ_{section.name}")
            succeeding = f"OBJ_{section.name}_EV_OK"
            if not any(runs(m) and text == succeeding for m in everything for text, _ in play.edges(m)):
                continue
            # The loss takes success away, and nobody can tell.
            in_vain = [
                m
                for m, to in losses
                if runs(m) and runs(to)
                if succeeds(m, section.name, []) and not succeeds(to, section.name, [])
            ]
            if any(m in alone and not play.out(m) for m in in_vain):
                unnoticed.append(section.name)
            elif in_vain:
                later.append(section.name)
            lost = [m for m in alone if play.out(m) == {name} and not m[known] and runs(m)]
            if any(succeeds(m, section.name, []) and not succeeds(m, section.name, [detected]) for m in lost):
                in_time.append(section.name)
        if unnoticed or later or in_time:
            told[name] = tuple(unnoticed), tuple(later), tuple(in_time)
    return told


@fewer(0.5)
@given(
    missions(max_hardware=2, max_sections=4, late=True)
    | missions(max_hardware=2, max_sections=3, max_facts=1, max_events=1, late=True)
    | fragile_missions(max_hardware=2, max_sections=4, late=True, lasting=True)
    | missions(max_hardware=2, max_sections=3, max_producers=1, late=True, lasting=True),
    st.sampled_from(ENGINES),
)
def test_drawn_missions(of: Mission, engine: Engine) -> None:
    net = small(of, 400)
    if net is None:
        return
    expected = searched(net)
    event(f"unnoticed: {any(alone for alone, _, _ in expected.values())}")
    event(f"later: {any(later for _, later, _ in expected.values())}")
    event(f"in time: {any(in_time for _, _, in_time in expected.values())}")
    assert found_of(net, engine) == expected


@pytest.mark.parametrize("engine", ENGINES)
def test_a_test_beside_the_work_finds_it_in_time(engine: Engine) -> None:
    """What only one sensor can do fails unseen; with a test beside and another sensor it may succeed."""
    (camera, sonar) = hw("camera", "sonar")
    test = replace(activity("test", ()), detects=("camera",))
    of = mission(
        robot((replace(camera, detected="late"), sonar), activity("look", ("camera",), ("sonar",)), test),
        Objective(name="alone", activities=("look",)),
        Objective(name="watched", activities=("look", "test")),
        Objective(name="idle", activities=("test",)),
    )
    assert found_of(compose(of), engine) == {"camera": (("alone",), (), ("watched",))}


@pytest.mark.parametrize("engine", ENGINES)
def test_what_another_loss_has_done_is_not_told_of_this_one(engine: Engine) -> None:
    """An activity that was refused stays so when its wheels are back, whatever has become of a camera."""
    (camera, wheels) = hw("camera", "wheels")
    of = mission(
        robot(
            (replace(camera, detected="late"), wheels),
            activity("look", ("camera",)),
            activity("go", ("wheels",)),
        ),
        Objective(name="drive", activities=("go",), failure="drive"),
        Objective(name="film", activities=("look",)),
    )
    assert found_of(compose(of), engine) == {"camera": (("film",), (), ())}


ROVER = """<mission xmlns="urn:mcpn:mission:1" name="rover">
<robot name="r">
  <hardware name="encoders" detected="late"/>
  <hardware name="camera"/>
  <fact name="battery" values="ok low"/>
  <event name="low"><sets fact="battery" to="low"/></event>
  <activity name="drive">
    <alternative name="see" consumes="camera"/><alternative name="roll" consumes="encoders"/>
  </activity>
  <activity name="measure" requires="battery=ok"/>
</robot>
<objective name="go" activities="drive"/>
<objective name="note" activities="measure"/>
</mission>
"""


@pytest.mark.parametrize("engine", ENGINES)
def test_what_facts_make_impossible_is_not_told_of_a_loss(engine: Engine, tmp_path: Path) -> None:
    """Where the battery is low there is no measuring, whatever has become of the encoders."""
    path = tmp_path / "mission.xml"
    path.write_text(ROVER)
    assert found_of(compose(read_mission(path)), engine) == {"encoders": ((), ("go",), ())}
