"""The modular controller beside the hierarchical one, on all states that either comes to."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import event, given
from hypothesis import strategies as st

from mcpn.controller import rules
from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.controller.modular import ModularController
from mcpn.drawing.compose import MissionNet, compose
from mcpn.errors import LimitError, SemanticsError
from mcpn.mission.model import SUCCEED, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.runtime import ControllerFileError, Refused, SnapshotError
from mcpn.robot.runtime.machines import RuleTables
from mcpn.robot.runtime.restoring import snapshot_text
from mcpn.robot.targets.json import write_json
from mcpn.spaces.stable import big_steps
from mcpn.testing import elements as drawn
from mcpn.testing import missions
from tests.draws import composed, fewer
from tests.runtime.damage import signed
from tests.small import activity, hw, mission, robot

MOST = 3_000
"""States that are walked through, of each mission."""


def place(runtime: Runtime) -> tuple[object, ...]:
    return runtime.section, runtime._state, runtime.out_of_service, runtime.happened, runtime.outcome


def fitting(runtime: Runtime) -> list[int]:
    """By event of the section that runs, how many effects its rules have that fit."""
    section = runtime._section
    if section is None:
        return []
    machine = section.machine
    assert isinstance(machine, RuleTables)
    return [len({effect for bits, effect in rules if bits.hold(runtime._state)}) for rules in machine.rules]


def side_by_side(mission_net: MissionNet, modular: ModularController, most: int = MOST) -> int:
    """Holds the two controllers against each other; says in how many pairs of states."""
    tables = generate(mission_net, max_states=MOST)
    one, other = (
        Runtime.from_document(json.loads(json.dumps(document(c, mission_net))), log=1)
        for c in (tables, modular)
    )
    known = {(place(one), place(other))}
    stack = [(one.snapshot(), other.snapshot())]
    while stack and len(known) < most:
        here = stack.pop()
        one.restore(here[0])
        other.restore(here[1])
        assert one.state == other.state
        assert [*one.mode.items()] == [*other.mode.items()]
        possible = one.possible
        assert possible == other.possible
        assert max(fitting(other), default=0) <= 1
        for refused in sorted(one._tables.known - {*possible})[:3]:
            for runtime in (one, other):
                with pytest.raises(Refused):
                    runtime.handle(refused)
        for text in possible:
            one.restore(here[0])
            other.restore(here[1])
            expected, found = one.handle(text), other.handle(text)
            assert expected == found, text
            assert [a.parameters for a in expected] == [a.parameters for a in found]
            pair = place(one), place(other)
            assert pair[0][2:] == pair[1][2:]
            if pair not in known:
                known.add(pair)
                stack.append((one.snapshot(), other.snapshot()))
    return len(known)


def check(of: Mission) -> None:
    mission_net = composed(of)
    for few in (rules.FEW_RULES, 0):  # with none, every event has parts that can have some
        try:
            with patch.object(rules, "FEW_RULES", few):
                modular = generate(mission_net, "modular")
            pairs = side_by_side(mission_net, modular)
        except (LimitError, SemanticsError) as error:
            event(type(error).__name__)
            return
        event("in parts" if any(type_.parts for type_ in modular.types) else "without parts")
        event("all states" if pairs < MOST else "some states")


@fewer(0.25)
@given(st.one_of(drawn.ANY, drawn.INTERRUPTED, drawn.IN_ROUNDS, drawn.APART, drawn.SAYING))
def test_any_mission(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(st.one_of(drawn.SHARING, drawn.DISJOINT, drawn.WIDE, drawn.CHAINS))
def test_missions_of_branches_and_chains(of: Mission) -> None:
    check(of)


@fewer(0.25)
@given(missions(max_objectives=3, max_depth=2, events=2, awkward_names=True, outputs=3))
def test_missions_with_declared_events(of: Mission) -> None:
    check(of)


def test_hardware_is_released_as_it_is_declared_whatever_alternative_held_it() -> None:
    """One alternative names ``b`` and ``c``, the other ``a`` and ``c``: both forms release ``c`` last."""
    of = robot(hw("a", "b", "c"), activity("go", ("c", "b"), ("c", "a")))
    blocks = (Objective(name="first", activities=("go",)), Objective(name="last", activities=("go",)))
    mission_net = compose(mission(of, *blocks))
    with patch.object(rules, "FEW_RULES", 0):
        modular = generate(mission_net, "modular")
    side_by_side(mission_net, modular)
    runtime = Runtime.from_document(json.loads(json.dumps(document(modular, mission_net))))
    runtime.handle("MISSION_EV_START")
    released = [a.hardware for a in runtime.handle("OBJ_first_EV_OK") if a.verb == "release"]
    assert released == ["b", "c"]


def test_the_parts_of_ulysse_reach_its_260_stable_states(ulysse_net: MissionNet) -> None:
    assert side_by_side(ulysse_net, generate(ulysse_net, "modular")) == 260


def pausing(branches: int) -> MissionNet:
    """Branches of two objectives that an event pauses all at once."""
    of = robot(
        hw("hatch", *(f"h{b}{t}" for b in range(branches) for t in range(2))),
        activity("hide", ("hatch",)),
        *(activity(f"work{b}{t}", (f"h{b}{t}",)) for b in range(branches) for t in range(2)),
        events=("storm",),
    )
    blocks = tuple(
        Recursive(
            name=f"branch{b}",
            blocks=tuple(Objective(name=f"o{b}{t}", activities=(f"work{b}{t}",)) for t in range(2)),
        )
        for b in range(branches)
    )
    storm = Handler(event="storm", pause="shelter")
    all_ = Parallel(name="all", blocks=blocks, handlers=(storm,), success=SUCCEED)
    return compose(mission(of, all_, Objective(name="shelter", activities=("hide",))))


def test_what_concerns_all_branches_is_a_sum() -> None:
    """A pause looks at each branch once: its rules grow as the branches do, not as their states multiply."""
    small, large = (generate(pausing(branches), "modular") for branches in (3, 6))
    for rules_, literals in (small.most, large.most):
        assert rules_ < 2 * 200
        assert literals < 2 * 400
    assert large.most[0] < 3 * small.most[0]
    with patch.object(rules, "FEW_RULES", 0):
        assert side_by_side(pausing(2), generate(pausing(2), "modular")) > 100


def test_where_an_event_goes_on_without_rules(
    ulysse_net: MissionNet, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the reaction is not found from whole sets, or has no parts, big steps are rules one by one."""
    expected = generate(ulysse_net, "modular")
    monkeypatch.setattr(rules, "FEW_RULES", 0)
    assert generate(ulysse_net, "modular").types[0].parts
    monkeypatch.setattr(rules, "conditions", lambda *_: None)
    assert generate(ulysse_net, "modular") == expected


def test_where_markings_came_before_the_steps(
    ulysse_net: MissionNet, monkeypatch: pytest.MonkeyPatch
) -> None:
    sooner = generate(ulysse_net, "modular")
    monkeypatch.setattr(big_steps, "MOST_SINGLY", 1)
    later = generate(ulysse_net, "modular")
    assert isinstance(sooner, ModularController)
    assert isinstance(later, ModularController)
    assert side_by_side(ulysse_net, later) == side_by_side(ulysse_net, sooner)


def test_a_section_of_much_hardware_is_not_listed() -> None:
    """24 resources, of which any may be out of service when the section is entered."""
    ways = [[(f"h{8 * i + j}",) for j in range(8)] for i in range(3)]
    of = robot(hw(*(h for way in ways for (h,) in way)), *(activity(f"a{i}", *ways[i]) for i in range(3)))
    mission_net = compose(mission(of, Objective(name="o", activities=("a0", "a1", "a2"))))
    with pytest.raises(LimitError, match="states: a machine lists every state"):
        generate(mission_net)
    found = generate(mission_net, "modular")
    # Each activity finds one of eight alternatives, or none, whatever the others find.
    (type_,) = found.types
    assert len(type_.entries) == 1
    assert sum(len(part) for part in type_.parts) < 3 * 9 * len(ways[0])
    runtime = Runtime.from_document(document(found, mission_net))
    for i in range(3):
        for j in range(i):
            assert runtime.handle(f"h{8 * i + j}_EV_OOS") == ()
    assert len(runtime.handle("MISSION_EV_START")) == 6
    assert runtime.mode == {"a0": "a0_0", "a1": "a1_1", "a2": "a2_2"}
    said = [str(a) for a in runtime.handle("h17_EV_RD")]
    assert said == []
    assert [str(a) for a in runtime.handle("h18_EV_OOS")] == ["release h18", "select a2 a2_1"]
    assert [str(a) for a in runtime.handle("h17_EV_OOS")] == ["release h17", "select a2 a2_3"]


@pytest.fixture(scope="module")
def of_ulysse(ulysse_net: MissionNet) -> dict[str, Any]:
    said: dict[str, Any] = json.loads(write_json(document(generate(ulysse_net, "modular"), ulysse_net)))
    return said


@pytest.mark.parametrize(
    "path",
    [
        ("bits",),
        ("idle",),
        ("status",),
        ("shown",),
        ("effects",),
        ("entries",),
        ("rules",),
        ("rules", 0, "if"),
        ("rules", 0, "do"),
        ("rules", 0, "event"),
        ("effects", 0, "changes"),
        ("effects", 0, "actions"),
        ("shown", 0, "kind"),
        ("status", 0, "when"),
    ],
    ids=str,
)
@pytest.mark.parametrize("wrong", [None, 10_000, -1, [10_000], [-1], "x", [{}]], ids=str)
def test_a_file_that_is_damaged_is_refused(
    path: tuple[str | int, ...], wrong: object, of_ulysse: dict[str, Any]
) -> None:
    said = json.loads(json.dumps(of_ulysse))
    at = said["types"][0]
    *way, last = path
    for key in way:
        at = at[key]
    at[last] = wrong
    if path == ("bits",) and wrong == 10_000:  # a state may have more bits than are spoken of
        Runtime.from_document(signed(said))
        return
    with pytest.raises(ControllerFileError):
        Runtime.from_document(signed(said))


def test_a_snapshot_holds_what_its_bits_say(of_ulysse: dict[str, Any]) -> None:
    runtime = Runtime.from_document(of_ulysse)
    runtime.handle("MISSION_EV_START")
    whole = json.loads(runtime.snapshot())
    assert whole["section"] is not None
    section = runtime._section
    assert section is not None
    assert isinstance(section.machine, RuleTables)
    for state in (-1, 1 << section.machine.bits, "0", None, True, 1.0):
        with pytest.raises(SnapshotError):
            runtime.restore(snapshot_text(whole | {"state": state}))
    for hardware in section.hardware:
        with pytest.raises(SnapshotError):
            runtime.restore(snapshot_text(whole | {"out_of_service": [hardware]}))
    runtime.restore(snapshot_text(whole))


def test_the_bound_is_of_the_rules_that_one_event_may_look_at(ulysse_net: MissionNet) -> None:
    found = generate(ulysse_net, "modular")
    most = 0
    for type_ in found.types:
        for event_ in range(-1, len(type_.events)):
            own = [rule for rule in (*type_.entries, *type_.rules) if rule.event == event_]
            then = [type_.effects[rule.effect].then for rule in own]
            follows = max((sum(len(type_.parts[part]) for part in parts) for parts in then), default=0)
            most = max(most, len(own) + follows)
    assert found.most[0] == 2 * most
    assert f"looks at {2 * most} rules" in found.size


TWO_TOKENS = """
<mission xmlns="urn:mcpn:mission:1" name="m">
  <robot name="r"><event name="stop"/><activity name="move"><alternative name="a"/></activity></robot>
  <protocols><protocol name="unused"><objective name="before" activities="move"/></protocol></protocols>
  <objective name="first" activities="move"/>
  <parallel name="both">
    <enter when="done(before)" else="succeed"/>
    <objective name="left">
      <parallel name="inner">
        <objective name="far_left" activities="move"><on event="stop" goto="succeed"/></objective>
      </parallel>
    </objective>
    <objective name="right">
      <objective name="far_right" activities="move"><on event="stop" goto="succeed"/></objective>
    </objective>
  </parallel>
</mission>
"""
"""An event puts two tokens into one place, in markings that the mission never comes to."""


def test_where_two_tokens_would_meet_there_is_no_modular_controller(tmp_path: Path) -> None:
    (tmp_path / "m.xml").write_text(TWO_TOKENS.lstrip())
    with pytest.raises(LimitError, match="where the mission never comes"):
        generate(compose(read_mission(tmp_path / "m.xml")), "modular")
