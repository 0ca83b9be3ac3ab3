"""Tests of a behaviour tree: runs of the mission made of it, as substitution rules of BehaviorTree.CPP.

The library replaces leaves of a tree by nodes that answer what a rule says. So that a run of the mission is
played, a counter on the blackboard says how many of its answers have been given: a leaf whose turn it is
answers, and counts; another one waits. A leaf that is ticked again while something behind it runs repeats
its last answer.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from mcpn.answers.causes.find import Causes
from mcpn.answers.verdicts.mission import NOMINAL, MissionCheck
from mcpn.drawing.compose import MissionNet
from mcpn.errors import InputError
from mcpn.events import Event, What
from mcpn.mission.model import walk
from mcpn.spaces.run import Run
from mcpn.trees.importing import Imported
from mcpn.trees.instances import Instance, Place, filters, instances, place_of
from mcpn.trees.ledger import Kind
from mcpn.trees.translator import BlockOrigin

STEP = "mcpn_step"
"""The entry of the root's blackboard that counts answers; a test sets it to 0 before the first tick."""
FAILED, SUCCEEDED = "FAILURE", "SUCCESS"


@dataclass(frozen=True, slots=True)
class LeafAnswer:
    """What a leaf answers when its turn comes.

    Args:
        leaf: The leaf.
        good: Whether that is success.
        event: The event of the mission that it stands for.
    """

    leaf: Instance
    good: bool
    event: Event

    @property
    def status(self) -> str:
        """As the library calls it."""
        return SUCCEEDED if self.good else FAILED


@dataclass(frozen=True, slots=True)
class TreeTest:
    """One test of a tree.

    Args:
        name: What it is, in words.
        returns: What the tree returns in the end; ``None`` where that is not said.
        never: What the tree never returns, whatever else its leaves answer; ``None`` where that is not said.
        answers: What leaves answer, in order; empty where each always answers the same.
        rules: What the library reads.
    """

    name: str
    returns: str | None
    never: str | None
    answers: tuple[LeafAnswer, ...]
    rules: Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True, slots=True)
class Mocks:
    """All tests of a tree, and what could not be one.

    Args:
        scenarios: The tests.
        left_out: What is none, with the reason.
    """

    scenarios: tuple[TreeTest, ...]
    left_out: tuple[tuple[str, str], ...]


class _Unplayable(Exception):
    """A run that the leaves alone do not decide; its text says why."""


def mocks(imported: Imported, mission_net: MissionNet, checked: MissionCheck, causes: Causes) -> Mocks:
    """Makes tests of a tree: the run on which nothing fails, runs to failure, and minimal sets.

    Args:
        imported: The tree, and what it became.
        mission_net: The mission, whose robot may have been written since.
        checked: Its verdicts.
        causes: What makes it fail.

    Raises:
        InputError: The mission was made of another tree.
    """
    player = _RulePlayer(imported, mission_net)
    wanted = [("nothing fails", SUCCEEDED, _first(checked, NOMINAL))]
    wanted.append(("shortest failure", FAILED, _first(checked, "failure_reachable")))
    sets = [names for names in causes.mission.cut_sets if names]
    wanted += [(f"failure by {_and(names)}", FAILED, causes.mission.runs[names]) for names in sets]
    found, left = list[TreeTest](), list[tuple[str, str]]()
    for name, returns, run in wanted:
        if run is None:
            continue
        try:
            found.append(player.played(name, returns, run))
        except _Unplayable as why:
            left.append((name, str(why)))
    for names in sets:
        name = f"without {_and(names)}"
        failing = {
            o for o, found in causes.objectives.items() if any(set(s) <= set(names) for s in found.cut_sets)
        }
        try:
            found.append(player.without(name, failing))
        except _Unplayable as why:
            left.append((name, str(why)))
    return Mocks(tuple(found), tuple(left))


def _first(checked: MissionCheck, verdict: str) -> Run | None:
    """The run that a verdict shows."""
    decided = checked.verdicts.get(verdict)
    return decided.runs_of_events[0] if decided is not None and decided.holds and decided.runs else None


def _and(names: Iterable[str]) -> str:
    return " and ".join(sorted(names))


class _RulePlayer:
    """Makes rules of what leaves answer.

    Args:
        imported: The tree, and what it became.
        mission_net: The mission.
    """

    def __init__(self, imported: Imported, mission_net: MissionNet) -> None:
        self.imported, self.mission_net = imported, mission_net
        self.kind = imported.ledger.kind
        self.leaves = instances(imported.forest)
        self.by_place: dict[Place, Instance] = {leaf.place: leaf for leaf in self.leaves}
        self.filters = filters(imported.forest, self.leaves)
        self.copies = mission_net.graph.copies
        known = {name: self.leaf(name) for name in self.copies.objectives}
        self.leaf_of: dict[str, Instance] = {name: leaf for name, leaf in known.items() if leaf is not None}
        texts = (imported.mission.blocks, *(protocol.blocks for protocol in imported.mission.protocols))
        written = {block.name for blocks in texts for block in walk(blocks)}
        if not any(position.path[-1] in written for position in self.copies.objectives.values()):
            tree, own = imported.ledger.file, mission_net.mission.source
            raise InputError.at(own, f"no objective of {tree} is in this mission: it is of another tree")

    def leaf(self, objective: str) -> Instance | None:
        """The leaf that an objective stands for."""
        *uses, block = self.copies.objectives[objective].path
        origin = self.imported.origins.get(block)
        if origin is None or origin.leaf is None:
            return None
        around = (self.imported.origins.get(use, BlockOrigin()) for use in uses)
        chain = [node for use in around if use.leaf is None for node in use.chain]
        return self.by_place.get(place_of((*chain, *origin.chain), origin.leaf))

    def silent(self, objective: str) -> bool:
        """Whether an objective stands for no leaf, and its outcome makes no difference."""
        return self.copies.objectives[objective].path[-1] in self.imported.silent

    def without(self, name: str, failing: Iterable[str]) -> TreeTest:
        """Leaves that always fail, and all others that always succeed: the tree must not succeed."""
        if self.kind is Kind.LEFT_OUT:
            raise _Unplayable("parts of the tree are left out of the mission")
        lost = {self.leaf_of[objective].place for objective in failing if objective in self.leaf_of}
        if not lost:
            raise _Unplayable("no leaf of the tree fails by it")
        other = sorted(o for o in failing if o not in self.leaf_of)
        if other:
            raise _Unplayable(f"{other[0]}, which is no leaf of the tree, fails by it too")
        rules: dict[str, str] = {}
        for leaf in self.leaves:
            answer = "fails" if leaf.place in lost else "succeeds"
            if rules.setdefault(self.filter(leaf), answer) != answer:
                raise _Unplayable(
                    f"{leaf.node.title} stands for several leaves of one path, which answer otherwise"
                )
        configs = {"fails": {"return_status": FAILED}, "succeeds": {"return_status": SUCCEEDED}}
        return TreeTest(name, None, SUCCEEDED, (), _document(configs, rules))

    def filter(self, leaf: Instance) -> str:
        """The filter of a rule that is for one leaf."""
        if leaf.place not in self.filters:
            line = leaf.node.source.line
            raise _Unplayable(f"line {line}: {leaf.node.title} has no path of its own that a rule may name")
        return self.filters[leaf.place]

    def played(self, name: str, returns: str, run: Run) -> TreeTest:
        """The leaves' answers of a run, one after the other."""
        if self.kind in (Kind.MORE, Kind.LEFT_OUT):
            raise _Unplayable("the mission has runs that the tree has not, and this may be one of them")
        if self.outcome(run) is None:
            raise _Unplayable("the mission does not end by it: it only cannot succeed any more")
        answers = tuple(self.answers(run))
        configs: dict[str, Mapping[str, Any]] = {}
        rules = {}
        for leaf in self.leaves:
            rule = self.filter(leaf)
            turns = [(number, a.good) for number, a in enumerate(answers) if self.filter(a.leaf) == rule]
            rules[rule] = rule
            configs[rule] = _config(turns, leaf.asked)
        return TreeTest(name, returns, None, answers, _document(configs, rules))

    def answers(self, run: Run) -> Iterable[LeafAnswer]:
        """What leaves answer on a run."""
        before, last = frozenset[str](), ""  # what ran before the last answer, and who gave it
        given = set[Place]()
        for event, running in self.steps(run):
            answer = self.answer(event)
            if answer is None:
                continue
            if answer.leaf.asked and event.what is not What.DECLARED and event.element in before - {last}:
                raise _Unplayable(
                    f"{answer.leaf.node.title} answers in the tick that asks it, before another leaf does"
                )
            if answer.leaf.rounds:
                raise _Unplayable(
                    f"{answer.leaf.node.title} is in a node that returns between its rounds or children; it "
                    "is ticked again while something behind it runs, and the library halts that then"
                )
            if answer.leaf.kept and answer.leaf.place in given:
                raise _Unplayable(f"{answer.leaf.node.title} changes its answer, which a replaced leaf keeps")
            given.add(answer.leaf.place)
            yield answer
            before, last = running, event.element

    def steps(self, run: Run) -> Iterable[tuple[Event, frozenset[str]]]:
        """Each event of a run, with the objectives that run before it."""
        drawn = self.mission_net.net
        roles = {drawn.places[place].name: role for place, role in self.mission_net.roles.items()}
        known = [(index, roles.get(place.name, ("", ""))) for index, place in enumerate(run.net.places)]
        objectives = {index: element for index, (role, element) in known if role == "objective"}
        running = frozenset[str]()
        for fired, marking in run.steps():
            event = run.net.transitions[fired].event
            if event is not None:
                yield event, running
            running = frozenset(element for index, element in objectives.items() if marking[index])

    def outcome(self, run: Run) -> str | None:
        """How the mission has ended after a run."""
        *_, (_, marking) = run.steps()
        own = self.mission_net.mission.name
        drawn = self.mission_net.net
        ends = ("success", "failure", "abort")
        roles = {
            drawn.places[p].name: role
            for p, (role, element) in self.mission_net.roles.items()
            if element == own
        }
        marked = {
            roles.get(place.name) for place, tokens in zip(run.net.places, marking, strict=True) if tokens
        }
        return next((end for end in ends if end in marked), None)

    def answer(self, event: Event) -> LeafAnswer | None:
        """What a leaf answers by an event; ``None`` where no leaf has to."""
        match event.what:
            case What.START | What.OUT_OF_SERVICE:
                return None
            case What.SUCCESS | What.FAILURE if event.element in self.leaf_of:
                leaf = self.leaf_of[event.element]
                return LeafAnswer(leaf, event.what is What.SUCCESS or leaf.node.id == "Sleep", event)
            case What.SUCCESS | What.FAILURE if self.silent(event.element):
                return None
            case What.DECLARED if (asked := self.asked(event.element)) is not None:
                return LeafAnswer(asked, self.imported.heard[event.element][1], event)
        raise _Unplayable(f"{event} is decided by no leaf alone")

    def asked(self, event: str) -> Instance | None:
        """The leaf that answers otherwise by an event, where it is one alone."""
        block, _ = self.imported.heard.get(event, ("", False))
        origin = self.imported.origins.get(block)
        if origin is None or origin.leaf is None:
            return None
        found = {
            leaf.place: leaf
            for o, leaf in self.leaf_of.items()
            if self.copies.objectives[o].path[-1] == block
        }
        return next(iter(found.values())) if len(found) == 1 else None


def _config(turns: list[tuple[int, bool]], asked: bool) -> Mapping[str, Any]:
    """What a leaf answers when it is ticked: by the number of answers given so far."""
    if not turns:
        return {"return_status": "RUNNING"}
    status, turn = "RUNNING", ">=" if asked else "=="
    for number, good in turns:
        status = f"@{STEP} {turn} {number} ? {SUCCEEDED if good else FAILED} : ({status})"
    counted = " || ".join(f"@{STEP} == {number}" for number, _ in turns)
    count = f"@{STEP} = ({counted}) ? @{STEP} + 1 : @{STEP}"
    config = {"return_status_script": status, "success_script": count, "failure_script": count}
    return config if asked else {**config, "async_delay": 1}


def _document(configs: Mapping[str, Any], rules: Mapping[str, str]) -> Mapping[str, Mapping[str, Any]]:
    return {"TestNodeConfigs": configs, "SubstitutionRules": rules}


def document(found: Mocks, mission: str, tree: str) -> dict[str, Any]:
    """What ``mcpn tests --btcpp`` writes."""
    return {
        "mission": mission,
        "tree": tree,
        "step": STEP,
        "scenarios": [
            {
                "name": each.name,
                "returns": each.returns,
                "never": each.never,
                "answers": [
                    {
                        "leaf": answer.leaf.path,
                        "line": answer.leaf.node.source.line,
                        "answer": answer.status,
                        "event": str(answer.event),
                    }
                    for answer in each.answers
                ],
                "rules": each.rules,
            }
            for each in found.scenarios
        ],
        "left_out": [{"name": name, "why": why} for name, why in found.left_out],
    }
