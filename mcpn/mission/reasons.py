"""Named failures: the reasons for which objectives and blocks may fail.

An objective fails for the reasons that it names and for those that its activities do; a block fails for a
reason where the failure of an objective in it leads, by ``fail``, out of every block up to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from mcpn.mission.model import Block, Objective, Parallel
from mcpn.mission.robot import Activity


class Reason(NamedTuple):
    """A reason for which an elementary objective may fail.

    Args:
        name: Its name.
        probability: How probable it is that the objective fails for it though it could succeed.
    """

    name: str
    probability: float | None = None


def reason(text: str) -> Reason:
    """A reason as ``failures`` of an objective says it: ``no_path``, or ``no_path=0.02``."""
    name, said, probability = text.partition("=")
    return Reason(name, float(probability) if said else None)


def reasons_of(objective: Objective, activities: Mapping[str, Activity]) -> tuple[Reason, ...]:
    """The reasons for which an objective may fail: those of its activities, then its own.

    Args:
        objective: An elementary objective.
        activities: The activities of the mission by name; one that is not there is passed over.
    """
    found = {
        name: Reason(name) for a in objective.activities if a in activities for name in activities[a].failures
    }
    return tuple((found | {named.name: named for named in map(reason, objective.failures)}).values())


def probabilities(objective: Objective, reasons: Sequence[Reason]) -> tuple[float, tuple[float, ...]]:
    """How probable it is that an objective fails though it could succeed, and the parts of that.

    Args:
        objective: A valid one.
        reasons: Those for which it may fail.

    Returns:
        The whole, where it is not said the sum of what is said of reasons; and its parts: failures for no
        reason, then those for each of the reasons.
    """
    if not reasons:
        return objective.failure_probability or 0.0, (objective.failure_probability or 0.0,)
    from fractions import Fraction

    parts = tuple(each.probability or 0.0 for each in reasons)
    said = objective.failure_probability
    named = sum(Fraction(repr(part)) for part in parts)
    whole = named if said is None else Fraction(repr(said))  # as the file says them, and not nearly so
    return float(whole), (float(max(whole - named, Fraction(0))), *parts)


def is_whole(block: Block) -> bool:
    """Whether a block fails as a whole, for no reason: a parallel one, or one that is stopped as a whole.

    What holds others is, by its time, or as facts become so; an objective with copies holds these.
    """
    if isinstance(block, Parallel):
        return True
    by_facts = block.left_by_facts
    if isinstance(block, Objective):
        return by_facts and bool(block.retries or block.repeat)
    return by_facts or block.timeout is not None
