"""Controllers of rules beside a certificate's net: as they are written, changed, and of a wrong generator."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.certificates import certcheck, ctlcheck, ctlforms
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.writing import certificate_of
from mcpn.controller import decisions, machine, ordering_states, reaction, rules
from mcpn.controller import reduce as reduce_
from mcpn.controller.document import document
from mcpn.errors import ConfluenceError, InputError, LimitError, PremiseError, UnsafeError
from mcpn.mission.model import Mission
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime import ControllerFileError
from mcpn.study import Study
from mcpn.testing import missions
from mcpn.testing.shape import Shape
from tests.certificates.changed_rules import CHANGES, Document, lockstep
from tests.conftest import ULYSSE
from tests.draws import campaign, fewer
from tests.shares import returns_early

EXPERIMENTS = ULYSSE.parent.parent
SMALL = Shape(sections=6, producers=2, alternatives=2)
DRAWN = st.one_of(
    missions(SMALL, events=2, timeouts=4, timed_blocks=4),
    missions(SMALL, events=2, facts=2, becoming=4, guards=4),
    missions(SMALL, crashes=True, late=True, lasting=True, faults=2),
    missions(SMALL, events=2, reasons=5, recovers=5, early=5, aborts=3),
    missions(SMALL, events=2, pauses=6, led=4, interrupted=True, timeouts=3),
    missions(SMALL, events=1, awkward_names=True, facts=1, late=True),
)
"""Everything that a mission may have, not all at once."""
FEW = {"whole": rules.FEW_RULES, "in parts": 0}
"""With none every event has parts that can have some."""


def listed(study: Study, most: int = 100_000) -> certcheck.Listing:
    net = certcheck.Net(json.loads(json.dumps(net_entry(study.mission_net))))
    return certcheck.Listing(net, most, float("inf"))


def made(study: Study, few: int = rules.FEW_RULES) -> Document:
    with patch.object(rules, "FEW_RULES", few):
        found = Study(study.mission).controller("modular")
    text: Document = json.loads(json.dumps(document(found, study.mission_net)))
    return text


def judged(graph: certcheck.Listing, controller: Document) -> tuple[int, int]:
    return ctlcheck.walked(graph, ctlforms.WalkedController(controller))


SMALL_MISSION = """
<mission xmlns="urn:mcpn:mission:1" name="m">
  <robot name="r">
    <hardware name="cam" repairable="false"/><hardware name="gps"/><hardware name="arm"/>
    <software name="pose"/><fact name="door" values="shut open"/>
    <event name="storm"/><event name="knock"><sets fact="door" to="open"/></event>
    <activity name="locate" produces="pose">
      <alternative name="by_gps" consumes="gps"/><alternative name="by_eye" consumes="cam"/>
    </activity>
    <activity name="go" consumes="pose"/><activity name="look" consumes="pose arm" faulty="true"/>
  </robot>
  <parallel name="both" timeout="90.5" failure="home">
    <on event="storm" goto="home" once="true"/>
    <objective name="near" activities="go" timeout="2.5"/>
    <objective name="far" activities="look" mandatory="false">
      <sets fact="door" to="shut" on="success"/>
    </objective>
  </parallel>
  <objective name="home" activities="go" failure="home" timeout="7"/>
</mission>
"""
"""Timers of objectives and a block, a fact, a handler of once, a shared producer, a loop, a crash."""


@pytest.fixture(scope="module")
def small(tmp_path_factory: pytest.TempPathFactory) -> Study:
    path = tmp_path_factory.mktemp("small") / "m.xml"
    path.write_text(SMALL_MISSION.lstrip())
    return Study(read_mission(path))


def test_the_parts_of_ulysse_do_what_its_net_does() -> None:
    study = Study(read_mission(ULYSSE))
    controller = made(study, 0)
    assert any(each["parts"] for each in controller["types"])
    assert judged(listed(study), controller) == (260, 1332)


def test_what_is_written_is_checked_with_times_and_crashes(small: Study, tmp_path: Path) -> None:
    certificate, controller = tmp_path / "m.cert", tmp_path / "controller.json"
    certificate.write_bytes(certificate_of(small.verdicts()).to_bytes())
    controller.write_text(json.dumps(made(small)))
    states = len(listed(small).stable)
    ((how, _, said),) = ctlcheck.checked(str(certificate), str(controller))
    assert (how, said.split(" pairs")[0]) == ("proved", str(states))
    with pytest.raises(certcheck.Limit):
        ctlcheck.checked(str(certificate), str(controller), most=100)


@pytest.mark.slow
@pytest.mark.parametrize("few", FEW)
@pytest.mark.parametrize("name", ["courier", "drone", "glider", "rover"])
def test_controllers_of_worked_missions(name: str, few: str) -> None:
    study = Study(read_mission(EXPERIMENTS / name / "mission.xml"))
    graph = listed(study, 2_000_000)
    pairs, taken = judged(graph, made(study, FEW[few]))
    assert pairs == len(graph.stable)
    assert taken == len({(s, graph.net.event[t]) for s, edges in enumerate(graph.edges) for t, _ in edges})


def judge(mission: Mission) -> str:
    """Walks the modular controllers of a drawn mission; says of what kind it is."""
    study = Study(mission)
    try:
        graph = listed(study, 20_000)
    except (certcheck.Limit, certcheck.Refuted, InputError) as error:
        return type(error).__name__
    for few in FEW.values():
        try:
            controller = made(study, few)
        except (LimitError, ConfluenceError, UnsafeError, PremiseError) as error:
            return type(error).__name__
        assert judged(graph, controller)[0] == len(graph.stable)
    return "walked"


@fewer(0.1, 3)
@given(DRAWN)
def test_controllers_of_drawn_missions(mission: Mission) -> None:
    if (how := judge(mission)) != "walked":
        returns_early(how)


@pytest.mark.slow
def test_controllers_of_many_drawn_missions() -> None:
    assert campaign(DRAWN, judge, 500)["walked"] > 250


def changed(graph: certcheck.Listing, whole: Document, seed: int) -> str:
    """What becomes of a controller in which something has been changed."""
    draw = random.Random(seed)
    controller: Document = json.loads(json.dumps(whole))
    CHANGES[seed % len(CHANGES)](controller, draw)
    if controller == whole:
        return "the same"
    try:
        judged(graph, controller)
    except certcheck.Refuted:
        return "refuted"
    except (certcheck.Malformed, LookupError):
        return "malformed"
    try:
        assert lockstep(controller, whole), f"seed {seed} is proved, and does something else"
    except ControllerFileError:
        return "refused by the runtime"
    return "equivalent"


def test_changed_controllers_are_refuted_or_do_the_same(small: Study) -> None:
    graph, controller = listed(small), made(small, 0)
    found = Counter(changed(graph, controller, seed) for seed in range(len(CHANGES)))
    assert found["refuted"] > len(CHANGES) // 2, found
    assert not found["refused by the runtime"]


Wrong = Callable[[Any], Any]


def _first_ones(found: Any) -> Any:
    return lambda *given: found(*given)[1:] or found(*given)


def _nothing(_: Any) -> Any:
    return lambda *given: ()


def _empty(_: Any) -> Any:
    return lambda reaction, *given: reaction.nothing


def _other_way(found: Any) -> Any:
    return lambda *given: found(*given) ^ 1


def _carried_the_other_way(found: Any) -> Any:
    def saying(maker: Any) -> Any:
        shown, carried = found(maker)
        return shown, [literal ^ 1 for literal in carried]

    return saying


def _everywhere(found: Any) -> Any:
    return lambda *given: [(action, given[2].states) for action, _ in found(*given)]


def _without(verb: str) -> Wrong:
    def wrong(found: Any) -> Any:
        return lambda *given: [each for each in found(*given) if each[0].verb != verb]

    return wrong


def _of_nothing(_: Any) -> Any:
    return lambda activity, states, *given: [(None, states)]


def _ordered_without(verb: str) -> Wrong:
    def wrong(found: Any) -> Any:
        return lambda *given: tuple(each for each in found(*given) if each.verb != verb)

    return wrong


FAULTS: dict[str, tuple[object, str, Wrong]] = {
    "rules are told apart by too little": (reduce_, "_enough", _nothing),
    "a rule that is needed is left out": (reduce_._Group, "_needed", lambda f: lambda *g: [*f(*g)][:-1]),
    "a rule is told apart from itself": (
        reduce_._Group,
        "_told_apart",
        lambda f: lambda *g: (w[:1] for w in f(*g)),
    ),
    "literals ask for the opposite": (rules._Maker, "_literal", _other_way),
    "an event asks for nothing of its transition": (rules._Maker, "_enabling", _nothing),
    "flags mean the opposite": (rules._Maker, "_saying", _carried_the_other_way),
    "sections are entered whatever is out of service": (rules, "idle_places", lambda f: lambda *g: {}),
    "a cover of states lacks one conjunction": (decisions.EventParts, "_needed", _first_ones),
    "parts fit more than they should": (
        decisions.EventParts,
        "_fitting",
        lambda f: lambda *g: (f(*g)[0][:1], 0),
    ),
    "actions are ordered in all states": (rules, "conditions", _everywhere),
    "parts stop nothing": (rules, "conditions", _without("stop")),
    "parts release nothing": (rules, "conditions", _without("release")),
    "parts arm no timer": (rules, "conditions", _without("arm")),
    "parts select nothing": (rules, "conditions", _without("select")),
    "what has been left stays": (reaction.EventReaction, "left", _empty),
    "actions are of no objective": (ordering_states, "_named", _of_nothing),
    "rules release nothing": (machine.Ordered, "actions", _ordered_without("release")),
    "rules disarm nothing": (machine.Ordered, "actions", _ordered_without("disarm")),
    "rules start nothing": (machine.Ordered, "actions", _ordered_without("start")),
}
"""What is wrong in the generator of rules: where, and what stands there instead."""


@pytest.mark.slow
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_the_generator_are_found(fault: str, small: Study) -> None:
    """A controller of a wrong generator is refuted, of one mission or the other, unless none is made."""
    where, name, wrong = FAULTS[fault]
    found = Counter[str]()
    for study in (small, Study(read_mission(ULYSSE))):
        graph = listed(study)
        for few in FEW.values():
            with patch.object(where, name, wrong(getattr(where, name))):
                try:
                    controller = made(study, few)
                except (AssertionError, LimitError):
                    found["none is made"] += 1
                    continue
            try:
                judged(graph, controller)
                found["proved"] += 1
                assert lockstep(controller, made(study, few)), "it is proved, and does something else"
            except certcheck.Refuted:
                found["refuted"] += 1
    assert found["refuted"], found


@pytest.mark.slow
@pytest.mark.parametrize("few", FEW)
@pytest.mark.parametrize("of", ["ulysse", "small"])
def test_many_changed_controllers(of: str, few: str, small: Study) -> None:
    study = Study(read_mission(ULYSSE)) if of == "ulysse" else small
    graph, whole = listed(study), made(study, FEW[few])
    found = Counter(changed(graph, whole, seed) for seed in range(60 * len(CHANGES)))
    assert found["refuted"] > 30 * len(CHANGES), found
    assert not found["refused by the runtime"], found
