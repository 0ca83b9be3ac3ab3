"""Announces which step of the work is under way, for whoever shows progress.

Code that takes long calls :func:`step`. Steps are messages of the logger ``mcpn.steps`` at level INFO: each
is a :class:`WorkStep`, whose text is its words. A program that uses the package as a library adds a handler
to this logger. Whoever wants to know how far a step is, too, listens (:func:`heard_by`): the command line
does, and needs no logging.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from typing import NamedTuple, Protocol


class Doing(Enum):
    """Kinds of steps, and the words for them; what stands in braces is a field of :class:`WorkStep`."""

    ANSWERING = "answering {question}"
    CHECKING_EXITS = "checking what section {section} hands on"
    COMPUTING_RISK = "computing the numbers of risk"
    COUNTING = "counting what happens, and looking for what is never used"
    DRAWING = "drawing section {section}"
    DECIDING = "looking for a run that decides {question}"
    EXPLAINING = "explaining an event with two outcomes"
    EXPLORING = "exploring section {section}"
    FINDING_CAUSES = "finding the causes of failure of {objective}"
    FINDING_CLASH = "looking for a clash near the start of the mission"
    FINDING_EFFECTS = "finding what the failure of {hardware} does during {objective}"
    FINDING_MODES = "finding the functioning modes"
    FINDING_NEEDS = "finding what hardware the mission needs"
    FINDING_STUCK = "looking for states from which the mission cannot end"
    FINDING_SURVIVAL = "finding what the mission survives from the start on"
    FINDING_SURVIVAL_FROM = "finding what the mission survives from section {section} on"
    JOINING = "joining the sections"
    LEFT_OPEN = "answering what is open: {question}"
    LISTING = "listing the stable states, and proving that each event has one outcome"
    LISTING_SECTION = "listing the states of section {section}"
    LISTING_MARKINGS = "listing the markings"
    MAKING_DIAGRAM = "making a diagram of all markings"
    PREPARING = "preparing {question}"
    PROVING = "proving that each event has one outcome"
    PROVING_JUNCTION = "proving the way from section {section} to {successor} confluent"
    PROVING_SECTION = "proving section {section} confluent"
    READING = "reading {question}"


class WorkStep(NamedTuple):
    """A step of the work, and what it is about.

    Args:
        doing: What is being done.
        section: The section of the mission that it is about.
        successor: The section after that one.
        objective: The objective that it is about, or ``the mission``.
        hardware: The hardware resource that it is about.
        question: The verdict, formula or part of a report that it is for.
        number: Its number among the steps of its kind.
        total: How many steps of its kind there are.
    """

    doing: Doing
    section: str | None = None
    successor: str | None = None
    objective: str | None = None
    hardware: str | None = None
    question: str | None = None
    number: int = 1
    total: int = 1

    def __str__(self) -> str:
        said = self.doing.value.format(
            section=self.section,
            successor=self.successor,
            objective=self.objective,
            hardware=self.hardware,
            question=self.question,
        )
        return f"{said} (type {self.number} of {self.total})" if self.total > 1 else said


class Hearer(Protocol):
    """Who listens to the work."""

    def begins(self, step: WorkStep) -> None:
        """A step is under way."""

    def comes_to(self, states: int, edges: int) -> None:
        """So much has been explored in the step that is under way; told now and then."""


_hearers: list[Hearer] = []


@contextmanager
def heard_by(hearer: Hearer) -> Iterator[None]:
    """Has somebody listen meanwhile.

    An error of the hearer ends the work, and is the work's.
    """
    _hearers.append(hearer)
    try:
        yield
    finally:
        _hearers.remove(hearer)


def tell(states: int, edges: int) -> None:
    """Tells how far the exploration is that is under way."""
    for hearer in _hearers:
        hearer.comes_to(states, edges)


def telling() -> Callable[[int, int], None] | None:
    """:func:`tell`, for an exploration in the kernel; ``None`` where nobody listens."""
    return tell if _hearers else None


def step(
    doing: Doing,
    *,
    section: str | None = None,
    successor: str | None = None,
    objective: str | None = None,
    hardware: str | None = None,
    question: str | None = None,
    number: int = 1,
    total: int = 1,
) -> None:
    """Announces a step, by the fields of :class:`WorkStep`."""
    if not _hearers and "logging" not in sys.modules:  # nobody has a handler
        return
    announced = WorkStep(doing, section, successor, objective, hardware, question, number, total)
    for hearer in _hearers:
        hearer.begins(announced)
    if "logging" in sys.modules:
        import logging

        logging.getLogger("mcpn.steps").info("%s", announced)
