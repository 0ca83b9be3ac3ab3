"""Which parameter counts where objective, alternative and activity say one name: in every target the same."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from mcpn.controller.document import document
from mcpn.controller.generate import generate
from mcpn.drawing.compose import compose
from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Parameter, Robot
from mcpn.robot.runtime import Controller as Runtime
from mcpn.robot.targets import files
from mcpn.robot.targets.type_numbers import MachineNumbers
from tests.controller.test_python import Generated

SAID = st.sets(st.sampled_from("abc")).map(sorted)


def parameters(of: str, names: list[str]) -> tuple[Parameter, ...]:
    return tuple(Parameter(name=name, value=f"{of} {name}") for name in names)


@given(SAID, SAID, SAID)
def test_the_objective_then_the_alternative_then_the_activity(
    activity: list[str], alternative: list[str], objective: list[str]
) -> None:
    of_activity, of_way = parameters("activity", activity), parameters("alternative", alternative)
    of_objective = parameters("objective", objective)
    act = Activity(
        name="act", alternatives=(Alternative(name="way", parameters=of_way),), parameters=of_activity
    )
    block = Objective(name="obj", activities=("act",), parameters=of_objective)
    mission_net = compose(
        Mission(name="mission", robots=(Robot(name="robot", activities=(act,)),), blocks=(block,))
    )
    controller = generate(mission_net)
    expected = {}
    for name in "abc":
        for said in (of_objective, of_way, of_activity):
            found = [p.value for p in said if p.name == name]
            if found:
                expected[name] = found[0]
                break
    runtime = Runtime.from_document(document(controller, mission_net))
    ((_, text),) = files(document(controller, mission_net), "python").items()
    for each in (runtime, Generated(text).controller()):
        (select,) = (a for a in each.handle("MISSION_EV_START") if a.verb == "select")
        assert {p.name: p.value for p in select.parameters} == expected
    # The generated C hands out what each element says; its comments say which counts.
    said_of = {
        "activity": {p.name: p.value for p in of_activity},
        "alternative": {p.name: p.value for p in of_way},
        "objective": {p.name: p.value for p in of_objective},
    }
    numbers = MachineNumbers(document(controller, mission_net))
    for kind, listed in (
        ("activities", "activity"),
        ("alternatives", "alternative"),
        ("objectives", "objective"),
    ):
        ((first, count),) = numbers.law[kind]
        given_out = numbers.parameters[first : first + count]
        assert {p.name: p.value for p in given_out} == said_of[listed]
