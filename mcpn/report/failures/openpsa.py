"""Failure causes as a fault tree in the Open-PSA Model Exchange Format, for tools of risk analysis.

Where no activities contend, the tree follows the mission: the mission fails by its objectives, an objective
by its activities, an activity by all of its alternatives, an alternative by its resources, down to hardware.
Elsewhere each top gate is the sum of its minimal cut sets. A tree that follows the mission is written only if
its minimal cut sets are those of the state space; else the sum is written.

Names are Open-PSA identifiers, which know no dots: ``transect.diving`` becomes ``objective-transect-diving``.
A formula holds arguments alone, references and constants: the format has formulas inside formulas, but SCRAM
took them up to its version 0.16.2 only.
Rates become probabilities of being out of service at the ``system-mission-time``. Where some resource has a
failure rate, one without is taken never to fail, as :mod:`mcpn.answers.causes.risk` does, and its basic event
says so; where none has, the tree is qualitative.

Source: Epstein, Rauzy, *Open-PSA Model Exchange Format*, version 2.0d, sections IV and V.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import reduce
from itertools import chain, pairwise
from operator import and_, or_
from typing import Literal, TypeAlias

from lxml import etree

from mcpn._kernel import Zdd
from mcpn.answers.causes.minimal_cut_sets import CutSet
from mcpn.errors import LimitError
from mcpn.mission.core.objectives_graph import (
    Branch,
    ElementarySection,
    ObjectivesGraph,
    ParallelSection,
    Section,
)
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.robot import Crash, Hardware
from mcpn.mission.static.interval_rates import at_their_means
from mcpn.mission.static.resource_use import Usage
from mcpn.report.terminal import plain
from mcpn.sentences import enumeration, shortened
from mcpn.spaces.memoized import memoized
from mcpn.spaces.projections import ImageStore

Reference: TypeAlias = tuple[Literal["gate", "basic-event"], str]
Formula: TypeAlias = Reference | tuple[Literal["and", "or"], Sequence["Formula"]]
"""A reference, or a connective of formulas."""

NEVER: Formula = ("or", ())
MISSION, ROBOT = "mission-lost", "robot-lost"
"""Top gates: the mission can no longer succeed; it can reach no safe end, success or abort."""

MAX_OBJECTIVES = 500
"""Objectives of a mission whose tree follows its text; that of a longer one is flat."""


def open_psa(
    usage: Usage,
    mission: Sequence[CutSet],
    objectives: Mapping[str, Sequence[CutSet]],
    safety: Sequence[CutSet] | None = None,
    unsafe: Collection[str] = (),
    worst: Sequence[CutSet] = (),
) -> bytes:
    """A fault tree whose top gates are the losses of the mission and of its objectives.

    Args:
        usage: The mission's static analysis.
        mission: Minimal cut sets of the mission.
        objectives: Those of each elementary objective, by its name.
        safety: Those of the mission's safe ends, success and abort, of a mission that can abort.
        unsafe: Objectives that should make the robot safe: an abort by their failure is no safe end.
        worst: What defeats the mission only where it is lost at the worst moment: no gate holds it.

    Returns:
        UTF-8 XML: gates ``mission-lost``, of missions that can abort ``robot-lost``, and ``objective-NAME``,
        a basic event for each faulty hardware resource.
    """
    tops = {MISSION: mission} | {_objective(name): cut_sets for name, cut_sets in objectives.items()}
    tops |= {} if safety is None else {ROBOT: safety}
    flat = _flat(usage, tops)
    label = "; ".join(beside_the_tree(usage, chain.from_iterable(tops.values()), worst))
    if len(objectives) > MAX_OBJECTIVES:
        return flat.document(label)
    try:
        tree = structured(usage, unsafe)
        same = all(tree.cut_sets(top) == set(map(frozenset, found)) for top, found in tops.items())
    except LimitError:  # too many products to be read by anybody
        same = False
    return (tree if same else flat).document(label)


SCRAM_ORDER = 20
"""Events of a product beyond which SCRAM leaves it out, unless ``--limit-order`` says otherwise."""


def beside_the_tree(usage: Usage, cut_sets: Iterable[CutSet], worst: Sequence[CutSet] = ()) -> list[str]:
    """What a reader of a fault tree has to know, a sentence each: what it lacks, and how SCRAM is asked.

    Args:
        usage: The mission's static analysis.
        cut_sets: The minimal cut sets of the tree's top gates.
        worst: What defeats the mission only where it is lost at the worst moment.
    """
    mission = usage.core
    sections = list(usage.graph.walk())
    given = {
        "demand_probability": [h.name for h in mission.hardware if h.demand_probability],
        "status at the start": [h.name for h in mission.hardware if h.faulty and h.initial == "oos"],
        "rate": [event.name for event in mission.events if event.rate],
        "detection_rate": [activity.name for activity in mission.activities if activity.detection_rate],
        "failure_probability": [section.name for section in sections if section.failure_probability],
        "duration": [section.name for section in sections if section.duration],
    }
    lacking = [f"no {what} ({shortened(names)})" for what, names in given.items() if names]
    told = [f"the fault tree holds {enumeration(lacking)}"] if lacking else []
    if worst:
        lost = shortened([enumeration(names) for names in worst])
        told.insert(
            0, f"the gate {MISSION} holds losses before the start; at its worst moment {lost} defeats it, too"
        )
    if means := at_their_means(mission):
        told.append(f"the fault tree is {means}")
    if not any(h.failure_rate is not None for h in mission.hardware if h.faulty):
        told.append("no hardware has a failure_rate: the fault tree has no probabilities to ask SCRAM for")
        return told
    order = max(map(len, cut_sets), default=0)
    limit = f" --limit-order {order}" if order > SCRAM_ORDER else ""
    asked = f"scram --probability true --mission-time HOURS{limit}"
    defaults = "a year" + (f" and products of up to {SCRAM_ORDER} events" if limit else "")
    told.append(
        f"ask SCRAM by {asked}, with the hours that the mission takes: by default it takes {defaults}"
    )
    return told


class FaultTree:
    """A fault tree.

    Args:
        usage: The mission's static analysis.

    Attributes:
        gates: By name, formulas of other gates and of basic events.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self.hardware = [hardware for hardware in usage.core.hardware if hardware.faulty]
        self.gates: dict[str, Formula] = {}
        self.images = ImageStore(len(self.hardware))
        self._functions: dict[Reference, Zdd] = {
            ("basic-event", hardware.name): self.images.upward(self.images.store.singleton([number]))
            for number, hardware in enumerate(self.hardware)
        }

    def function(self, formula: Formula) -> Zdd:
        """The sets of hardware whose loss makes a formula true."""
        if formula[0] == "and":
            return reduce(and_, map(self.function, formula[1]), self.images.everything)
        if formula[0] == "or":
            return reduce(or_, map(self.function, formula[1]), self.images.nothing)
        if formula not in self._functions:
            inside = self.gates.get(formula[1], NEVER)  # some hardware never fails
            self._functions[formula] = self.function(inside)
        return self._functions[formula]

    def cut_sets(self, gate: str) -> set[frozenset[str]]:
        """The minimal sets of hardware whose loss makes a gate true."""
        found = self.images.minimal(self.function(("gate", gate)))
        return {frozenset(self.hardware[member].name for member in members) for members in found}

    def document(self, label: str) -> bytes:
        """The whole tree with its basic events, and what is to be said of it."""
        root = etree.Element("opsa-mef")
        tree = etree.SubElement(root, "define-fault-tree", name=_identifier(self.usage.core.name))
        etree.SubElement(tree, "label").text = label
        labels = {MISSION: f"mission {self.usage.core.name} cannot succeed"}
        labels[ROBOT] = f"mission {self.usage.core.name} can reach no safe end, success or abort"
        labels |= {_objective(o.name): f"{o.name} cannot succeed" for o in self.usage.graph.walk()}
        labels |= {_activity(name): f"{name} has no possible alternative" for name in self.usage.started}
        for name in filter(self.gates.__contains__, labels):
            _define(tree, name, self.gates[name], labels[name])
        data = etree.SubElement(root, "model-data")
        quantitative = any(hardware.failure_rate is not None for hardware in self.hardware)
        for hardware in self.hardware:
            _basic_event(data, hardware, quantitative=quantitative)
        return etree.tostring(root, pretty_print=True, xml_declaration=True, encoding="UTF-8")


def structured(usage: Usage, unsafe: Collection[str] = ()) -> FaultTree:
    """The tree that follows the mission, see :func:`open_psa`."""
    tree = FaultTree(usage)

    def reference(resource: str) -> Reference:
        producer = usage.producer.get(resource)
        return ("basic-event", resource) if producer is None else ("gate", _activity(producer))

    for name in usage.suppliers_first():
        ways = (map(reference, way.consumes) for way in usage.activities[name].alternatives)
        # Alternatives that the same resources defeat are one factor: a formula names each argument once.
        factors = dict.fromkeys(tuple(dict.fromkeys(filter(tree.function, way))) for way in ways)
        lost: Formula = "and", [("or", factor) for factor in factors]
        tree.gates[_activity(name)] = lost if tree.function(lost) else NEVER
    for section in usage.graph.walk():
        tree.gates[_objective(section.name)] = "or", [("gate", _activity(a)) for a in section.activities]
    losses = Losses(usage.graph, unsafe)
    tops = {MISSION: (SUCCEED,), **({ROBOT: (SUCCEED, ABORT)} if usage.graph.aborts else {})}
    for top, ends in tops.items():
        minimal = losses.mission_from(usage.graph.entry, *ends)
        tree.gates[top] = _sum([("gate", _objective(name)) for name in names] for names in minimal)
    return tree


class Losses:
    """Sets of elementary objectives whose loss loses the mission, with all sets that contain them.

    It is a greatest fixpoint on the objectives graph, section by section; no state is explored.

    Args:
        graph: The mission's objectives graph.
        unsafe: Objectives whose failure is no safe end, even where it leads to abort.
    """

    def __init__(self, graph: ObjectivesGraph, unsafe: Collection[str] = ()) -> None:
        self.graph, self.unsafe = graph, unsafe
        self.objectives = [section.name for section in graph.walk()]
        self.images = images = ImageStore(len(self.objectives))
        self.never, self.always = images.nothing, images.everything
        single = map(images.store.singleton, ([number] for number in range(images.levels)))
        self._lost = dict(zip(self.objectives, map(images.upward, single), strict=True))

    def mission_from(self, entry: str, *ends: str) -> list[tuple[str, ...]]:
        """The minimal losses after which no run from the entry of a section of the graph ends as wanted.

        Args:
            entry: The section.
            ends: Ends of the mission that are wanted; success by default.

        Raises:
            LimitError: There are too many.
        """
        lost = self._mission(*(ends or (SUCCEED,)))[entry]
        minimal = sorted(self.images.minimal(lost), key=lambda names: (len(names), names))
        return [tuple(self.objectives[number] for number in names) for names in minimal]

    @memoized
    def _mission(self, *ends: str) -> Mapping[str, Zdd]:
        return self._sections(self.graph, *ends)

    def _sections(self, graph: ObjectivesGraph, *wanted: str) -> Mapping[str, Zdd]:
        """By section, the losses after which no run from its entry leads to a wanted exit of the graph.

        It is the greatest solution of *lost(s) = (s cannot succeed, or lost(section after success)) and (s
        cannot fail, or lost(section after failure))*, and likewise for timeouts and aborts.
        """
        ways = {s.name: (self._succeeding(s), self._failing(s)) for s in graph.sections}
        exits = (SUCCEED, FAIL, ABORT)
        lost = dict.fromkeys((*ways, *exits), self.always) | dict.fromkeys(wanted, self.never)
        changed = True
        while changed:
            changed = False
            for section in reversed(graph.sections):
                well, badly = ways[section.name]
                unsafe = {ABORT: self.always} if section.name in self.unsafe else {}
                failed = unsafe.get(section.failure, lost[section.failure])
                now = (well | lost[section.success]) & (badly | failed)
                named = section.reasons if isinstance(section, ElementarySection) else ()
                late = () if section.timed_out is None else (section.timed_out,)
                for target in (*late, *(target for _, target in named)):
                    now = now & unsafe.get(target, lost[target])  # a time may be over, a reason may apply
                if isinstance(section, ParallelSection) and section.abort is not None:
                    now = now & (self._aborting(section) | lost[section.abort])
                changed |= now != lost[section.name]
                lost[section.name] = now
        return lost

    def _succeeding(self, section: Section) -> Zdd:
        """The losses after which a section cannot succeed."""
        if isinstance(section, ElementarySection):
            return self._lost[section.name]
        if section.needed is not None:
            unwell = [self._ending(branch, (SUCCEED,)) for branch in section.branches]
            return self._at_least(len(unwell) - section.needed + 1, unwell)
        ways = ((SUCCEED,) if branch.mandatory else (SUCCEED, FAIL) for branch in section.branches)
        found = reduce(or_, map(self._ending, section.branches, ways), self.never)
        if section.failing is None:
            return found
        unwell = [self._ending(branch, (SUCCEED,)) for branch in section.branches]
        return found | self._at_least(section.failing + 1, unwell)  # the last of all fails nothing any more

    def _failing(self, section: Section) -> Zdd:
        """The losses after which a section cannot fail; an elementary objective can always fail."""
        if isinstance(section, ElementarySection):
            return self.never
        unended = reduce(or_, (self._ending(b, (SUCCEED, FAIL)) for b in section.branches), self.never)
        failing = [self._ending(b, (FAIL,)) for b in section.branches]
        mandatory = (lost for lost, b in zip(failing, section.branches, strict=True) if b.mandatory)
        hasty = reduce(and_, mandatory, self.always)
        if section.needed is not None:
            late = unended | self._at_least(section.needed, failing)
            found = late & hasty if section.hasty else late
        else:
            found = hasty if section.hasty else unended | hasty
        if section.failing is not None:
            found = found & self._at_least(len(failing) - section.failing + 1, failing)
        return found

    def _at_least(self, number: int, conditions: Iterable[Zdd]) -> Zdd:
        """The losses under which at least ``number`` of some conditions hold (a voting gate)."""
        by_count = [self.always, *[self.never] * number]  # at index k: at least k of those so far hold
        for condition in conditions:
            by_count = [self.always, *(more | (less & condition) for less, more in pairwise(by_count))]
        return by_count[number]

    def _aborting(self, section: ParallelSection) -> Zdd:
        """The losses after which no branch of a block can abort."""
        return reduce(and_, (self._ending(branch, (ABORT,)) for branch in section.branches), self.always)

    def _ending(self, branch: Branch, wanted: tuple[str, ...]) -> Zdd:
        """The losses after which a branch cannot end in a wanted exit."""
        return self._sections(branch.graph, *wanted)[branch.graph.entry]


def _flat(usage: Usage, tops: Mapping[str, Sequence[CutSet]]) -> FaultTree:
    """Each top gate as the sum of its minimal cut sets."""
    tree = FaultTree(usage)
    for top, cut_sets in tops.items():
        tree.gates[top] = _sum([("basic-event", h) for h in names] for names in cut_sets)
    return tree


def _sum(products: Iterable[Sequence[Reference]]) -> Formula:
    return "or", [("and", product) for product in products]


def _define(tree: etree._Element, name: str, formula: Formula, label: str = "") -> None:
    """Writes a gate; each connective inside its own is a gate, too, for a formula holds arguments alone."""
    gate = etree.SubElement(tree, "define-gate", name=name)
    if label:
        etree.SubElement(gate, "label").text = label
    formula = _collapsed(formula)
    if formula[0] not in ("and", "or") or not formula[1]:
        _argument(gate, formula)
        return
    holder = etree.SubElement(gate, formula[0])
    for number, operand in enumerate(map(_collapsed, formula[1]), start=1):
        if operand[0] in ("and", "or") and operand[1]:
            inner = f"{name}-{number}"  # no name of a mission has a part that begins with a digit
            _argument(holder, ("gate", inner))
            _define(tree, inner, operand)
        else:
            _argument(holder, operand)


def _collapsed(formula: Formula) -> Formula:
    """A formula without connectives of one argument at its top."""
    while formula[0] in ("and", "or") and len(formula[1]) == 1:
        formula = formula[1][0]
    return formula


def _argument(parent: etree._Element, formula: Formula) -> None:
    """Writes a reference, or a connective of nothing as a constant."""
    kind, operands = formula
    if isinstance(operands, str):
        etree.SubElement(parent, kind, name=_identifier(operands))
    else:
        etree.SubElement(parent, "constant", value="true" if kind == "and" else "false")


def _objective(name: str) -> str:
    return f"objective-{_identifier(name)}"


def _activity(name: str) -> str:
    return f"activity-{name}"


def _identifier(name: str) -> str:
    return name.replace(".", "-")


def _basic_event(parent: etree._Element, hardware: Hardware, *, quantitative: bool) -> None:
    element = etree.SubElement(parent, "define-basic-event", name=_identifier(hardware.name))
    status = "has crashed" if isinstance(hardware, Crash) else "is out of service"
    label = plain(hardware.description or f"{hardware.name} {status}")
    etree.SubElement(element, "label").text = label
    rate, repair = hardware.failure_rate, hardware.repair_rate
    if rate is None:
        attributes = etree.SubElement(element, "attributes")
        etree.SubElement(attributes, "attribute", name="failure-rate", value="not given")
    if not rate:
        if quantitative:
            etree.SubElement(element, "float", value="0.0")
        return
    law = etree.SubElement(element, "GLM" if repair else "exponential")
    for value in (0.0, rate, repair) if repair else (rate,):
        etree.SubElement(law, "float", value=repr(float(value)))
    etree.SubElement(law, "system-mission-time", unit="hours")
