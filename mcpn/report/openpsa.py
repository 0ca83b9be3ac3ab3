"""Failure causes as a fault tree in the Open-PSA Model Exchange Format, for tools of risk analysis.

Where nothing contends the tree follows the mission: it fails by objectives, these by activities, these by all
of their alternatives, these by resources, down to hardware. Elsewhere each top gate is the sum of its minimal
cut sets. Both have the minimal cut sets that the state space gives; writing refuses a tree that has not.

Names are Open-PSA identifiers, which know no dots: ``transect.diving`` becomes ``objective-transect-diving``.
Rates become probabilities of being out of service at the ``system-mission-time``. Where some resource has a
failure rate, one without is taken never to fail, as :mod:`mcpn.check.risk` does, and its basic event says so;
where none has, the tree is qualitative.

Source: Epstein, Rauzy, *Open-PSA Model Exchange Format*, version 2.0d, sections IV and V.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from lxml import etree

from mcpn._kernel import Zdd
from mcpn.check.causes.availability import Availability, Losses
from mcpn.check.causes.cutsets import CutSet
from mcpn.mission.facts.usage import Usage
from mcpn.mission.model import Hardware

MAX_OBJECTIVES = 500
"""Objectives of a mission whose tree follows its text; that of a longer one is flat."""


def open_psa(usage: Usage, mission: Sequence[CutSet], objectives: Mapping[str, Sequence[CutSet]]) -> bytes:
    """A fault tree whose top gates are the losses of the mission and of its objectives.

    Args:
        usage: The mission's static facts.
        mission: Minimal cut sets of the mission.
        objectives: Those of each elementary objective, by its name.

    Returns:
        UTF-8 XML: gates ``mission-lost`` and ``objective-NAME``, a basic event for each faulty hardware
        resource.
    """
    text = Availability(usage)
    if len(objectives) <= MAX_OBJECTIVES and _says(text, mission, objectives):
        return _Structured(usage, text).document()
    return _Flat(usage, mission, objectives).document()


def _says(text: Availability, mission: Sequence[CutSet], objectives: Mapping[str, Sequence[CutSet]]) -> bool:
    """Whether the text of the mission has just these cut sets."""

    def same(function: Zdd, cut_sets: Sequence[CutSet]) -> bool:
        return set(map(frozenset, text.minimal(function))) == set(map(frozenset, cut_sets))

    return same(text.mission, mission) and all(
        same(text.objective(section), objectives[section.name]) for section in text.usage.graph.walk()
    )


class _Tree:
    """A fault tree under construction.

    Args:
        usage: The mission's static facts.
    """

    def __init__(self, usage: Usage) -> None:
        self.usage = usage
        self.root = etree.Element("opsa-mef")
        self.tree = etree.SubElement(self.root, "define-fault-tree", name=_identifier(usage.mission.name))

    def document(self) -> bytes:
        """The whole tree with its basic events."""
        self.draw()
        data = etree.SubElement(self.root, "model-data")
        faulty = [hardware for hardware in self.usage.mission.hardware if hardware.faulty]
        quantitative = any(hardware.failure_rate is not None for hardware in faulty)
        for hardware in faulty:
            _basic_event(data, hardware, quantitative=quantitative)
        return etree.tostring(self.root, pretty_print=True, xml_declaration=True, encoding="UTF-8")

    def draw(self) -> None:
        """Draws every gate."""
        raise NotImplementedError

    def gate(self, name: str, label: str) -> etree._Element:
        """Begins the definition of a gate, whose formula is to follow."""
        element = etree.SubElement(self.tree, "define-gate", name=name)
        etree.SubElement(element, "label").text = label
        return element


class _Structured(_Tree):
    """The tree that follows the mission."""

    def __init__(self, usage: Usage, text: Availability) -> None:
        super().__init__(usage)
        self.text = text

    def draw(self) -> None:
        losses = Losses(self.usage, (section.name for section in self.usage.graph.walk()))
        minimal = losses.minimal(losses.mission)
        products = ([("gate", f"objective-{_identifier(name)}") for name in m] for m in minimal)
        _sum(self.gate("mission-lost", f"mission {self.usage.mission.name} cannot succeed"), products)
        for section in self.usage.graph.walk():
            gate = self.gate(f"objective-{_identifier(section.name)}", f"{section.name} cannot succeed")
            _sum(gate, ([("gate", f"activity-{a}")] for a in section.activities))
        for name in self.usage.started:
            gate = self.gate(f"activity-{name}", f"{name} has no possible alternative")
            self.alternatives(gate, name)

    def alternatives(self, gate: etree._Element, activity: str) -> None:
        """All alternatives are lost, each by one of its resources."""
        ways = self.usage.activities[activity].alternatives
        if not self.text.activities[activity] or not ways:
            etree.SubElement(gate, "constant", value="false")
            return
        # Alternatives that the same resources defeat are one factor: a formula names each argument once.
        factors = dict.fromkeys(
            tuple(dict.fromkeys(self.resource(k) for k in way.consumes if self.may_fail(k))) for way in ways
        )
        holder = etree.SubElement(gate, "and") if len(factors) > 1 else gate
        for factor in factors:
            _sum(holder, ([reference] for reference in factor))

    def may_fail(self, resource: str) -> bool:
        return bool(self.text.resources[resource])

    def resource(self, name: str) -> tuple[str, str]:
        if name in self.usage.hardware:
            return "basic-event", name
        return "gate", f"activity-{self.usage.producer[name]}"


class _Flat(_Tree):
    """Each top gate as the sum of its minimal cut sets."""

    def __init__(
        self, usage: Usage, mission: Sequence[CutSet], objectives: Mapping[str, Sequence[CutSet]]
    ) -> None:
        super().__init__(usage)
        name = usage.mission.name
        self.tops = [("mission-lost", f"mission {name} cannot succeed", mission)]
        self.tops += [
            (f"objective-{_identifier(o)}", f"{o} cannot succeed", cut_sets)
            for o, cut_sets in objectives.items()
        ]

    def draw(self) -> None:
        for name, label, cut_sets in self.tops:
            _sum(self.gate(name, label), ([("basic-event", h) for h in names] for names in cut_sets))


def _identifier(name: str) -> str:
    return name.replace(".", "-")


def _sum(parent: etree._Element, products: Iterable[Sequence[tuple[str, str]]]) -> None:
    """A sum of products of references, constants where there is nothing to sum or to multiply."""
    listed = list(products)
    if not listed:
        etree.SubElement(parent, "constant", value="false")
        return
    holder = etree.SubElement(parent, "or") if len(listed) > 1 else parent
    for product in listed:
        if not product:
            etree.SubElement(holder, "constant", value="true")
            continue
        inner = etree.SubElement(holder, "and") if len(product) > 1 else holder
        for kind, name in product:
            etree.SubElement(inner, kind, name=name)


def _basic_event(parent: etree._Element, hardware: Hardware, *, quantitative: bool) -> None:
    element = etree.SubElement(parent, "define-basic-event", name=hardware.name)
    etree.SubElement(element, "label").text = hardware.description or f"{hardware.name} is out of service"
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
