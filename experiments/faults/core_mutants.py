"""Mutants of nets, of core missions and of controllers that are walked beside each other: none is accepted.

Usage: ``python experiments/faults/core_mutants.py [--mutants N] [--seed S] [--of core|controller|sections]
[--second]`` changes N times a net beside its core mission or its controller, or puts another mission's core,
or a changed controller, beside a net, or beside a core mission of sections. What corecheck and ctlcheck, with
``--second`` also the programs in C++, and sectionctl accept is held against another oracle: the net as mcpn's
templates draw it of that mission, and the controller as its runtime takes events. Both are followed in pairs
with the unchanged ones, and must have the same events and say the same; whether something begins anew or goes
on is not asked of orders, as docs/certificates.md does not claim it. Exit code 1 if they do not, or one
program alone accepts it. 1,000 mutants take two minutes.
"""

from __future__ import annotations

import copy
import json
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple, TypeVar
from unittest.mock import patch

sys.path.append(str(Path(__file__).resolve().parents[2]))

from lxml import etree

from experiments.faults import campaigns
from experiments.faults.both_checkers import accepted, by_the_second_of_sections, proved, written
from experiments.faults.certificates import Truth, apart, change_net
from mcpn.certificates import certcheck
from mcpn.certificates.core_entry import core_entry
from mcpn.certificates.net_entry import net_entry
from mcpn.certificates.sections import sectionctl
from mcpn.controller import rules
from mcpn.controller.document import document
from mcpn.controller.generate import Form
from mcpn.errors import McpnError
from mcpn.events import Event
from mcpn.mission.xml import read_mission
from mcpn.robot.runtime.actions import Action
from mcpn.robot.runtime.controller_tables import RuntimePosition, Tables
from mcpn.robot.runtime.file_schema import ControllerFileError, digest_of
from mcpn.study import Study

Document = dict[str, Any]
At = TypeVar("At", bound=Hashable)
HOME = """<mission xmlns="urn:mcpn:mission:1" name="home">
  <robot name="cart">
    <hardware name="wheels"/><hardware name="eye" detected="late"/><hardware name="ear" repairable="false"/>
    <software name="map"/>
    <event name="call"/>
    <activity name="locate" produces="map">
      <alternative name="by_eye" consumes="eye"/><alternative name="by_ear" consumes="ear"/>
    </activity>
    <activity name="drive" switch_back="true">
      <alternative name="mapped" consumes="map wheels"/><alternative name="blind"/>
    </activity>
    <activity name="rest" detects="eye"/>
  </robot>
  <objective name="go" activities="drive" failure="abort" timeout="10"/>
  <parallel name="both" failure="back" success="back">
    <objective name="see" activities="drive"/>
    <objective name="wait" activities="rest" mandatory="false"/>
  </parallel>
  <objective name="back" activities="rest" success="succeed" failure="go">
    <on event="call" goto="abort" once="true"/>
  </objective>
</mission>
"""
DAY = """<mission xmlns="urn:mcpn:mission:1" name="day">
  <robot name="lamp">
    <hardware name="bulb"/><hardware name="panel" initial="oos"/>
    <fact name="light"/><fact name="warm"/>
    <event name="dusk"><sets fact="light" to="false"/></event>
    <event name="rain"/>
    <activity name="shine" requires="light" consumes="bulb"/>
    <activity name="glow"><alternative name="full" consumes="panel"/><alternative name="half"/></activity>
  </robot>
  <objective name="rise" activities="glow" failure="fail"><sets fact="light" to="true"/></objective>
  <parallel name="noon" failure="abort" success="set">
    <on event="rain" pause="shelter"/>
    <objective name="lit" activities="shine"/>
    <objective name="lazy" activities="glow" mandatory="false">
      <sets fact="warm" to="true" on="start"/>
    </objective>
  </parallel>
  <objective name="set" activities="glow" success="succeed" failure="rise"/>
  <objective name="shelter" activities="glow"/>
</mission>
"""
ROUND = """<mission xmlns="urn:mcpn:mission:1" name="round">
  <robot name="cart">
    <hardware name="wheels"/><hardware name="eye"/><hardware name="ear" repairable="false" shared="true"/>
    <software name="map"/>
    <event name="call"/>
    <activity name="locate" produces="map">
      <alternative name="by_eye" consumes="eye"/><alternative name="by_ear" consumes="ear"/>
    </activity>
    <activity name="drive" switch_back="true">
      <alternative name="mapped" consumes="map wheels"/><alternative name="blind" consumes="wheels"/>
    </activity>
    <activity name="hear" consumes="ear"/>
    <activity name="rest"><alternative name="on"/></activity>
  </robot>
  <on event="call" goto="home"/>
  <objective name="first" activities="drive" success="second" failure="both" timeout="10"/>
  <objective name="second" activities="drive" success="both" failure="home" timeout="10"/>
  <parallel name="both" failure="home" success="again">
    <objective name="see" activities="drive"/>
    <objective name="wait" activities="hear" mandatory="false"/>
  </parallel>
  <parallel name="again" failure="home" success="home">
    <objective name="look" activities="drive"/>
    <objective name="listen" activities="hear" mandatory="false"/>
  </parallel>
  <objective name="home" activities="rest" success="succeed" failure="home"/>
</mission>
"""
LOOK = {"begin", "success", "failure", "abort", "objective", "pending", "done", "active", "wait", "want"}
LOOK |= {"refused", "oos", "known", "fact", "happened"}
"""The roles that core missions say something of."""
ENDS = {"begin", "success", "failure", "abort"}


# What is so, by other code than the checkers'.


class Moves(NamedTuple):
    """What is said in a state, and where each event leads; None where it leads to several states."""

    said: Hashable
    after: Mapping[Hashable, Any]


def alike(one: Callable[[At], Moves], other: Callable[[At], Moves], first: tuple[At, At]) -> bool:
    """Whether both say the same, and have the same events, in all states that they reach together."""
    met, todo = {first}, [first]
    for a, b in todo:  # grows while it is walked
        here, there = one(a), other(b)
        if here.said != there.said or here.after.keys() != there.after.keys():
            return False
        for event, target in here.after.items():
            pair = (target, there.after[event])
            if None in pair:
                return False
            if pair not in met:
                met.add(pair)
                todo.append(pair)
    return True


def of_net(truth: Truth, roles: set[str]) -> Callable[[int], Moves]:
    """The states of a net, with what its places say by some roles."""
    said: list[set[tuple[str, str]]] = [set() for _ in range(truth.graph.states)]
    for role, element in truth.roles:
        word = ("wait" if role == "want" else role, "" if role in ENDS else element)
        for state in truth.mask(truth.says(role, element)).nonzero()[0] if role in roles else ():
            said[state].add(word)
    after: list[dict[Hashable, Any]] = [{} for _ in said]
    graph = truth.graph
    for s, t, n in zip(graph.sources.tolist(), graph.labels.tolist(), graph.targets.tolist(), strict=True):
        event = truth.events[t]
        after[s][event] = n if after[s].get(event, n) == n else None
    return lambda state: Moves(frozenset(said[state]), after[state])


Runs = Mapping[str, str]
"""By activity that runs or asks its alternative."""


def claimed(event: str, orders: Sequence[Action], before: Runs, after: Runs, consumes: Runs) -> list[str]:
    """The orders less those by which something begins anew that may as well go on, which is not claimed.

    Args:
        event: What they answer.
        orders: What the robot is told.
        before: What runs and asks before it.
        after: What runs after it.
        consumes: By activity and alternative, as ``activity.alternative``, what it consumes, in one text.
    """
    going = {name for name, way in before.items() if after.get(name) == way}
    changed = {each.activity for each in orders if each.verb in ("stop", "select")} - going

    def held(by: Iterable[str | None]) -> set[str]:
        ways = (consumes.get(f"{name}.{before[name]}", "") for name in by if name and name in before)
        return {hardware for way in ways for hardware in way.split()}

    timers = {verb: {each.objective for each in orders if each.verb == verb} for verb in ("arm", "disarm")}
    anew = (timers["arm"] & timers["disarm"]) - {Event.parse(event).element}
    spared = held(going) - held(changed)
    return [
        str(each)
        for each in orders
        if not (each.activity and each.activity in going)
        and not (each.verb == "release" and each.hardware in spared)
        and not (each.verb in timers and each.objective in anew)
    ]


def of_controller(tables: Tables, consumes: Runs) -> Callable[[Any], Moves]:
    """The states of a controller, with what it orders, as far as :func:`claimed`."""

    def moves(at: RuntimePosition) -> Moves:
        inside = at.section.state(at.state) if at.section else None
        shows = (sorted(inside.objectives), sorted(inside.mode.items())) if inside else ()
        after = dict[Hashable, Any]()
        for event in tables.possible(at):
            step = tables.after(at, event)
            if step is not None:
                there = step[0].section.state(step[0].state).mode if step[0].section else {}
                before = {**inside.waiting, **inside.mode} if inside else {}
                orders = claimed(event, step[1], before, there, consumes)
                after[event, tuple(orders)] = step[0]._replace(
                    gone=frozenset(step[0].gone), true=frozenset(step[0].true)
                )
        return Moves((at.phase, frozenset(at.gone), repr(shows)), after)

    return moves


def as_runtime(controller: Document) -> tuple[Callable[[Any], Moves], Any]:
    """A controller as the runtime takes it, and where it begins."""
    tables = Tables({**controller, "digest": digest_of(controller)})
    gone, true = frozenset(tables.out_of_service), frozenset(tables.true_at_first)
    consumes = {
        f"{activity}.{way}": " ".join(each["consumes"])
        for activity, of in controller["activities"].items()
        for way, each in of["alternatives"].items()
    }
    return of_controller(tables, consumes), RuntimePosition("before", None, 0, gone, true)


# Missions and their changes.


class Original(NamedTuple):
    """A mission with its net, and what is beside it."""

    text: str
    net: Document
    core: Document
    controllers: list[Document]

    @property
    def truth(self) -> Truth:
        """What its net does."""
        return Truth(self.net)


def plain(value: Any) -> Any:
    """A document as it is read back."""
    return json.loads(json.dumps(value))


def study_of(text: str) -> Study:
    """A mission that is written out."""
    with tempfile.NamedTemporaryFile(suffix=".xml") as file:
        Path(file.name).write_text(text)
        return Study(read_mission(file.name))


@cache
def originals() -> list[Original]:
    """The missions, with controllers of all forms, of rules also with parts wherever there may be some."""
    found = [original(text, ("hierarchical", "flat", "modular")) for text in (HOME, DAY)]
    with patch.object(rules, "FEW_RULES", 0):
        return [_with_rules(each, study_of(each.text)) for each in found]


def _with_rules(original: Original, study: Study) -> Original:
    more = plain(document(study.controller("modular"), study.mission_net))
    return original._replace(controllers=[*original.controllers, more])


@cache
def original(text: str, forms: tuple[Form, ...]) -> Original:
    """A mission with controllers of some forms."""
    study = study_of(text)
    net = study.mission_net
    controllers = [plain(document(study.controller(form), net)) for form in forms]
    return Original(text, plain(net_entry(net)), plain(core_entry(net)), controllers)


def other_mission(text: str, draw: random.Random) -> str:
    """A mission of which an attribute is left out, or has the value of another one, or an element is gone."""
    root = etree.fromstring(text)
    nodes = [each for each in root.iter() if each.attrib and each is not root]
    node = draw.choice(nodes)
    key = draw.choice(list(node.attrib))
    values = {str(value) for each in nodes for value in each.attrib.values()} | {"true", "false", "oos"}
    match draw.randrange(5):
        case 0:
            parent = node.getparent()
            assert parent is not None, "the root is not drawn"
            parent.remove(node)
        case 1:
            del node.attrib[key]
        case 2:
            more = [
                "shared",
                "faulty",
                "repairable",
                "mandatory",
                "switch_back",
                "detected",
                "initial",
                "failure",
            ]
            node.set(draw.choice(more), draw.choice(["true", "false", "late", "oos", "succeed", "fail"]))
        case _:
            node.set(key, draw.choice(sorted(values)))
    return etree.tostring(root, encoding="unicode")


def change_controller(controller: Document, draw: random.Random) -> str:
    """Changes a controller at one place; says where."""
    part = draw.choice(["types", "types", "types", "sections", "late", "hardware", "activities", "changing"])
    places = list(_places(controller[part]))
    if places:
        holder, key = draw.choice(places)
        found = holder[key]
        alike = [h[k] for h, k in places if type(h[k]) is type(found)]
        if isinstance(found, list | dict) and draw.random() < 0.5:
            del holder[key]
        else:
            holder[key] = copy.deepcopy(draw.choice(alike))
    return part


def _places(value: Any) -> Any:
    """All places inside a value that hold something."""
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, found in inside:
        yield value, key
        yield from _places(found)


# The campaign.


def of_core(draw: random.Random, second: bool) -> tuple[str, bool, list[str]]:
    """Changes a net or a core mission: how, whether it is accepted, and what is wrong with that."""
    original = draw.choice(originals())
    net, core, other = copy.deepcopy(original.net), original.core, original.net
    if draw.random() < 0.5:
        how, other = change_net(net, draw), net
    else:
        how = "another mission"
        try:
            drawn = study_of(other_mission(original.text, draw)).mission_net
        except McpnError:
            return "no mission", False, []
        core, other = plain(core_entry(drawn)), plain(net_entry(drawn))
    first, second_ = proved("core", {"net": net, "core": core}, second)
    if not first | second_:
        return how, False, []
    return how, True, apart(first, second_) + _unlike(original.net, other, LOOK)


def _unlike(net: Document, other: Document, roles: set[str]) -> list[str]:
    """What is wrong where two nets should do the same."""
    try:
        same = alike(of_net(Truth(net), roles), of_net(Truth(other), roles), (0, 0))
    except McpnError as error:
        return [str(error)]
    return [] if same else ["it does something else"]


def of_walked(draw: random.Random, second: bool) -> tuple[str, bool, list[str]]:
    """Changes a net or a controller: how, whether it is accepted, and what is wrong with that."""
    original = draw.choice(originals())
    controller = draw.choice(original.controllers)
    net, changed = copy.deepcopy(original.net), copy.deepcopy(controller)
    in_net = draw.random() < 0.4
    how = change_net(net, draw) if in_net else f"controller: {change_controller(changed, draw)}"
    first, second_ = accepted(net, changed, second)
    if not first | second_:
        return how, False, []
    if first != second_:
        return how, True, apart(first, second_)
    if in_net:
        return how, True, _unlike(original.net, net, {*ENDS, "objective", "active", "oos"})
    return _as_before(controller, changed, how)


def _as_before(controller: Document, changed: Document, how: str) -> tuple[str, bool, list[str]]:
    """What is wrong with a changed controller that is accepted."""
    was, begin = as_runtime(controller)
    try:
        now, first = as_runtime(changed)
    except ControllerFileError:
        return f"{how}, refused as it is loaded", True, []
    return how, True, [] if alike(was, now, (begin, first)) else ["it does something else"]


def by_sections(core: Document, controller: Document) -> str:
    """What sectionctl says of a controller beside a core mission."""
    with written({"core": core}) as path, tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(controller, file)
        file.flush()
        try:
            ((how, _, _),) = sectionctl.checked(path, file.name)
        except (certcheck.Malformed, certcheck.Limit) as error:
            return type(error).__name__.lower()
    return how


def of_sections(draw: random.Random, second: bool) -> tuple[str, bool, list[str]]:
    """Changes a controller beside a mission of sections: as :func:`of_walked`, one type at a time."""
    mission = original(ROUND, ("hierarchical", "modular"))
    controller = draw.choice(mission.controllers)
    changed = copy.deepcopy(controller)
    how = f"controller: {change_controller(changed, draw)}"
    first = {"controller"} if by_sections(mission.core, changed) == "proved" else set[str]()
    other = by_the_second_of_sections(mission.core, changed) if second else first
    if first != other:
        return how, True, apart(first, other)
    return _as_before(controller, changed, how) if first else (how, False, [])


CAMPAIGNS = {"core": of_core, "controller": of_walked, "sections": of_sections}


def campaign(of: str, mutants: int, seed: int, second: bool = False) -> tuple[Counter[str], list[str]]:
    """Changes what is walked; what became of each change, and those that are accepted wrongly."""
    found, wrong = Counter[str](), list[str]()
    for number in range(mutants):
        how, accepted, why = CAMPAIGNS[of](random.Random(f"{seed} {number}"), second)
        wrong += [f"{of}: mutant {number} of seed {seed}, {how}: {each}" for each in why]
        found[f"{how}: {'accepted' if accepted else 'not accepted'}"] += 1
    return found, wrong


if __name__ == "__main__":
    sys.exit(campaigns.ran("Mutants of nets, core missions and controllers.", CAMPAIGNS, campaign))
