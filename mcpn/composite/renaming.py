"""Names of one section as those of another of the same type."""

from __future__ import annotations

from mcpn.drawing.sections import LocalPart
from mcpn.drawing.status import Element
from mcpn.mission.core.objectives_graph import ElementarySection, Section, names_in


class Renaming:
    """From the names in one section to those in another of the same type.

    Args:
        old: The section that the names are of.
        new: The other section.

    Attributes:
        activities: By name in the old section.
        alternatives: As ``activity.alternative``.
        hardware: By name.
        once: Handlers that happen once, by where they are written.
        facts: What may be true of facts (:attr:`LocalPart.flags`), and of hardware that is detected late.
        objectives: By name, blocks and branches with them.
        elements: All of them, with software and parallel blocks, each with its kind.
    """

    def __init__(self, old: LocalPart, new: LocalPart) -> None:
        both = list(zip(old.used.activities, new.used.activities, strict=True))
        self.activities = {theirs.name: mine.name for theirs, mine in both}
        self.alternatives = {
            f"{theirs.name}.{a.name}": f"{mine.name}.{b.name}"
            for theirs, mine in both
            for a, b in zip(theirs.alternatives, mine.alternatives, strict=True)
        }
        self.hardware = {a.name: b.name for a, b in zip(old.used.hardware, new.used.hardware, strict=True)}
        self.once, self.facts = dict[str, str](), dict[str, str]()
        told = {"hardware": self.hardware, "once": self.once, "facts": self.facts}
        for theirs, mine in zip(old.flags, new.flags, strict=True):
            told[theirs.told][theirs.text] = mine.text
        sections = zip(old.graph.sections, new.graph.sections, strict=True)
        self.objectives = {
            its: own for pair in sections for its, own in zip(*map(names_in, pair), strict=True)
        }
        software = zip(old.used.software, new.used.software, strict=True)
        by_kind = {
            "hardware": self.hardware,
            "software": {a.name: b.name for a, b in software},
            "activity": self.activities,
            "alternative": self.alternatives,
        }
        self.elements: dict[Element, Element] = (
            {(kind, name): (kind, mine) for kind, names in by_kind.items() for name, mine in names.items()}
            | renamed_statuses(old, new)
            | renamed_sections(old, new)
        )


def renamed_statuses(old: LocalPart, new: LocalPart) -> dict[Element, Element]:
    """From what has a status of its own in a part to that in another one; hardware is what the parts use."""
    both = zip(old.statuses, new.statuses, strict=True)
    return {theirs.element: mine.element for theirs, mine in both if theirs.kind != "hardware"}


def renamed_sections(old: LocalPart, new: LocalPart) -> dict[Element, Element]:
    """From the objectives and blocks of a part to those of another of the same type."""
    both = zip(old.graph.all_sections(), new.graph.all_sections(), strict=True)
    return {(kind_of(theirs), theirs.name): (kind_of(mine), mine.name) for theirs, mine in both}


def kind_of(section: Section) -> str:
    """What the provenances of a section's places call it."""
    return "objective" if isinstance(section, ElementarySection) else "parallel"
