"""Valid missions that say less than a given one: what is left when no smaller one shows the same is needed.

Hypothesis shrinks what was drawn, in the order in which it was drawn; what nothing refers to any more may be
left over. Here elements are taken out of the mission itself, and attributes are set back to their defaults.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass, replace
from typing import Any

from mcpn.mission.model import Mission
from mcpn.mission.validate import find_errors


def smaller_missions(mission: Mission) -> Iterator[Mission]:
    """Valid missions with one element, or one attribute, less; those that leave out most first.

    Args:
        mission: A valid mission.
    """
    for smaller in _smaller(mission):
        if not find_errors(smaller):
            yield smaller


def _smaller(element: Any) -> Iterator[Any]:
    """An element with one thing less: first a whole element inside, then an attribute, then inside these."""
    own = [f for f in fields(element) if f.init and f.name not in ("source", "name")]
    for field in own:
        value = getattr(element, field.name)
        if isinstance(value, tuple):
            for number in range(len(value)):
                yield replace(element, **{field.name: (*value[:number], *value[number + 1 :])})
    for field in own:
        value = getattr(element, field.name)
        default = field.default if field.default is not MISSING else None
        if field.default is not MISSING and value != default and not isinstance(value, tuple):
            yield replace(element, **{field.name: default})
    for field in own:
        value = getattr(element, field.name)
        if isinstance(value, tuple):
            for number, inner in enumerate(value):
                for less in _smaller(inner) if is_dataclass(inner) else ():
                    yield replace(element, **{field.name: (*value[:number], less, *value[number + 1 :])})
