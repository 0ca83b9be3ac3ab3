"""Which engine answers where nobody names one, and who does where it refuses."""

from __future__ import annotations

import pytest

from mcpn.answers.causes.find import find_causes
from mcpn.answers.spaces_by_engine import FEW, MissionSpaces, spaces_of
from mcpn.answers.verdicts.mission import check
from mcpn.drawing.compose import MissionNet, compose
from mcpn.drawing.templates import PaperTemplates
from mcpn.errors import LimitError
from mcpn.logic.questions import Questions
from mcpn.mission.model import Objective
from mcpn.mission.xml import read_mission
from mcpn.spaces.engine_names import Engine, On
from mcpn.spaces.engines import Choice, answered
from tests.composite.test_local import Wearing
from tests.conftest import ROOT
from tests.small import activity, hw, mission, robot


def with_hardware(count: int) -> MissionNet:
    of = robot(hw(*(f"h{i}" for i in range(count))), activity("work", ("h0",)))
    return compose(mission(of, Objective(name="only", activities=("work",))))


@pytest.mark.parametrize("refusals", range(3))
def test_another_engine_is_asked_where_one_refuses(refusals: int) -> None:
    asked: list[Engine] = []

    def ask(choice: Choice) -> int:
        asked.append(choice.engine)
        if len(asked) <= refusals:
            raise LimitError(f"refusal {len(asked)}")
        return 7

    found, choice = answered(ask, spaces_of(with_hardware(2)).choices("alternatives"))
    assert (found, asked) == (7, ["explicit", "local", "symbolic"][: refusals + 1])
    assert choice.engine == asked[-1]
    assert choice.why is not None
    assert ("refusal 2" in choice.why) == (refusals == 2)


@pytest.mark.parametrize("on", ["markings", "alternatives"])
def test_where_all_refuse_the_last_one_s_error_is_told(on: On) -> None:
    asked: list[Engine] = []

    def ask(choice: Choice) -> int:
        asked.append(choice.engine)
        raise LimitError(f"refusal {len(asked)}")

    with pytest.raises(LimitError, match=r"refusal [23]") as caught:
        answered(ask, spaces_of(with_hardware(2)).choices(on))
    assert str(caught.value) == f"refusal {len(asked)}"
    asked.clear()
    with pytest.raises(LimitError, match="refusal 1"):
        answered(ask, spaces_of(with_hardware(2), engine="local").choices(on))
    assert asked == ["local"]


def test_much_hardware_is_not_listed_to_find_out() -> None:
    asked: list[Engine] = []

    def ask(choice: Choice) -> int:
        asked.append(choice.engine)
        return 0

    _, choice = answered(ask, spaces_of(with_hardware(FEW.bit_length())).choices("alternatives"))
    assert asked == ["local"]
    assert "16 hardware resources that may fail have 2^16 states" in str(choice)


def test_all_questions_of_stable_states_have_one_home(ulysse_net: MissionNet) -> None:
    formula = "EF (failure & oos(GPS_sensor))"
    for limit, engine in ((None, "explicit"), (100, "local")):
        questions = Questions(spaces_of(ulysse_net), on="alternatives", max_states=limit)
        answer = questions.answer(formula)
        assert answer.holds
        assert answer.choice.engine == engine
        found = check(ulysse_net, max_states=limit)
        assert (found.choice.engine, found.stable_sizes) == (engine, (260, 1332))
        assert found.marking_sizes == ((44299, 124078) if limit is None else None)
        causes = find_causes(ulysse_net, max_states=limit)
        assert causes.choice.engine == engine
        assert causes.mission.cut_sets == [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")]


def test_a_mission_that_composition_refuses_is_held_by_a_diagram() -> None:
    templates = Wearing()
    mission = read_mission(ROOT / "experiments" / "ulysse" / "mission.xml")
    found = check(MissionSpaces(compose(mission, templates), templates=templates), max_states=100)
    assert found.choice.engine == "symbolic"
    assert found.choice.why is not None
    assert found.choice.why.startswith("local gives no answer: section")
    assert found.verdicts["confluent"].holds
    usual = check(compose(mission, PaperTemplates()), max_states=100)
    assert usual.choice.engine == "local"
