"""Failure causes in sentences: cut sets, losses that are survived, numbers of risk.

A mission that can abort has sentences for two goals: that it is accomplished (success), and that it ends
safely (success or abort).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from mcpn.answers.causes.cutsets import CutSet
from mcpn.answers.causes.find import Causes, Survival
from mcpn.report.words import folded
from mcpn.sentences import enumeration, shortened

if TYPE_CHECKING:
    from mcpn.answers.causes.risk import Risk


IMPORTANCE = (
    "importance: how much more probable success is if a resource never fails than if it is lost before the "
    "start and not repaired; so of one without a rate, too"
)
ROUNDING = 1e-12
"""Differences of probabilities up to which they are equal."""


def condition(name: str, cut_sets: Sequence[CutSet]) -> str:
    """When something fails, by its minimal cut sets.

    >>> condition("going_up", [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")])
    'going_up can no longer succeed after the loss of thruster_actuator, or of GPS_sensor and IMU_sensor'
    >>> condition("filming", [])
    'filming can succeed whatever hardware fails'
    """
    if not cut_sets:
        return f"{name} can succeed whatever hardware fails"
    if () in cut_sets:
        return f"{name} can never succeed"
    return f"{name} can no longer succeed after the loss of {', or of '.join(map(enumeration, cut_sets))}"


def safe(name: str, cut_sets: Sequence[CutSet]) -> str:
    """When a mission can end neither in success nor in abort, by its minimal cut sets.

    >>> safe("survey", [("motor",)])
    'survey cannot end safely, in success or abort, after the loss of motor'
    """
    if not cut_sets:
        return f"{name} can end safely, in success or abort, whatever hardware fails"
    if () in cut_sets:
        return f"{name} can never end safely, in success or abort"
    lost = ", or of ".join(map(enumeration, cut_sets))
    return f"{name} cannot end safely, in success or abort, after the loss of {lost}"


def by_word_alone(causes: Causes) -> str:
    """The aborts that are no safe end: those by the failure of what should make the robot safe."""
    names = folded(causes.mission_net, causes.unsafe_aborts)
    return f"an abort by the failure of {shortened(names)}"


def headlines(causes: Causes) -> Iterator[str]:
    """What keeps the mission from success, and from a safe end if it can abort: first where nothing helps."""
    goals = [(causes.mission, condition)] + [(causes.safety, safe)] * (causes.safety is not None)
    for goal, sentence in goals:
        assert goal is not None
        said, alone = sentence(goal.name, goal.cut_sets), goal.unaided
        if alone is None or not alone.helpers:
            yield said
        else:
            yield f"{sentence(goal.name, alone.cut_sets)}, without the help of {enumeration(alone.helpers)}"
            yield f"with this help {said}"
    if causes.unsafe_aborts:
        yield f"{by_word_alone(causes)} is no safe end"


def survived(found: Survival) -> Iterator[str]:
    """The losses that the goals survive from one moment on: success and, with aborts, a safe end."""
    told, losses = _told(found.always, found.at_most), _losses(found)
    if found.safety is None:
        if told is None:
            yield "the mission can no longer succeed"
        elif not losses:
            yield "no loss of hardware defeats the mission"
        else:
            yield f"the loss of {losses} defeats it; it survives {told}"
        return
    if told is None:
        yield "the mission can no longer succeed"
    elif not losses:
        yield "no loss of hardware keeps it from success"
    else:
        yield f"the loss of {losses} keeps it from success, which survives {told}"
    told, losses = _told(found.safety.always, found.safety.at_most), _losses(found.safety)
    if told is None:
        yield "it can no longer end safely, in success or abort"
    elif not losses:
        yield "no loss of hardware keeps it from a safe end, success or abort"
    else:
        yield f"the loss of {losses} keeps it from a safe end, success or abort, which survives {told}"


def _losses(found: Survival) -> str:
    return ", or of ".join(enumeration(names) for names in found.cut_sets if names)


def _told(always: int | None, at_most: int | None) -> str | None:
    """How many losses are survived; ``None`` where the goal is out of reach."""
    if always is None or at_most is None:
        return None

    def losses(number: int) -> str:
        return "1 loss" if number == 1 else f"{number} losses"

    if always == at_most:
        return f"any {losses(always)}" if always else "none"
    together = f"at best {losses(at_most)}{' together' if at_most > 1 else ''}"
    return f"any {losses(always)}, and {together}" if always else f"{together}, but not every single loss"


def risk_counts(numbers: Risk) -> Iterator[tuple[str, float]]:
    """Probabilities, degraded modes and importances, each with its name, in the order people read them.

    Importances are differences of probabilities: one within rounding errors of 0 is given as 0.
    """
    yield "success", numbers.success
    if numbers.abort is not None:
        yield "abort", numbers.abort
    yield "failure", numbers.failure
    yield "degraded modes", numbers.degraded_modes
    for found, end in ((numbers.importance, ""), (numbers.safety_importance or {}, " for a safe end")):
        for hardware, value in sorted(found.items(), key=lambda pair: -pair[1]):
            yield f"importance of {hardware}{end}", value if abs(value) > ROUNDING else 0.0


def ranked(values: Mapping[str, float]) -> list[str]:
    """Hardware by falling values; of values that differ by rounding alone the first comes first."""

    def size(name: str) -> float:
        return float(f"{values[name]:.9g}") if abs(values[name]) > ROUNDING else 0.0

    return sorted(values, key=size, reverse=True)


def without_a_rate(numbers: Risk) -> str:
    """Says of events without a rate that the numbers leave them out."""
    several = len(numbers.unrated) > 1
    names = f"event{'s' * several} {', '.join(numbers.unrated)}"
    return f"{names} {'have' if several else 'has'} no rate: not counted in these numbers"
