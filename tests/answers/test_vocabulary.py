"""The words of a mission: each that is listed is understood, and means what its copies mean."""

from __future__ import annotations

from hypothesis import given

from mcpn.answers.mission_names import MissionNames
from mcpn.answers.vocabulary import vocabulary
from mcpn.drawing.compose import MissionNet, compose
from mcpn.logic.syntax import parse
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.spaces.search.goal import Fires
from mcpn.testing import missions
from tests.conftest import ROOT


def understood(mission_net: MissionNet) -> None:
    words, names = vocabulary(mission_net), MissionNames(mission_net)
    for kind, named in (
        ("objective", words.objectives),
        ("pending", words.objectives),
        ("block", words.blocks),
        ("activity", words.activities),
        ("oos", words.hardware),
        ("available", words.software),
        ("event", words.events),
        ("happens", words.events),
    ):
        for word in named:
            parse(f"{kind}({word.name})", names)
    for activity in words.activities:
        for way in activity.alternatives:
            parse(f"alternative({activity.name})={way}", names)
    for end in words.ends:
        parse(end, names)


@given(missions())
def test_every_word_is_understood(mission: Mission) -> None:
    understood(compose(mission))


def test_a_word_means_its_copies() -> None:
    mission_net = compose(read_mission(ROOT / "experiments" / "courier" / "mission.xml"))
    understood(mission_net)
    words, names = vocabulary(mission_net), MissionNames(mission_net)
    assert [word.name for word in words.objectives if word.copies][:2] == ["ground.travel", "ground.unlock"]
    assert len(dict.fromkeys(word.name for word in words.events)) == len(words.events)
    for word in words.events:
        whole = parse(f"event({word.name})", names)
        each = [parse(f"event({copy})", names) for copy in word.copies or (word.name,)]
        assert isinstance(whole, Fires)
        together = {t for of in each if isinstance(of, Fires) for t in of.transitions}
        assert set(whole.transitions) == together, word.name
