"""Data of the objectives graph on facts: cases of routes, and changes of facts by objectives.

How routes are chosen by facts is in :mod:`mcpn.mission.flatten` (``deciding``) and
:mod:`mcpn.mission.expansion.leads`; facts and ``<route>`` are declared in :mod:`mcpn.mission.robot` and
:mod:`mcpn.mission.model`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Condition: TypeAlias = tuple[tuple[str, str], ...]
"""Facts, each with the value that it must have: all of them at once."""


@dataclass(frozen=True, slots=True)
class FactCase:
    """A target that a route leads to if facts have some values.

    Args:
        when: What they must be.
        target: The next section, or one of the graph's own exits.
    """

    when: Condition
    target: str

    @property
    def words(self) -> str:
        """What facts must be, as missions say it."""
        short = {"true": "{}", "false": "!{}"}
        return " ".join(short.get(value, f"{{}}={value}").format(fact) for fact, value in self.when)


@dataclass(frozen=True, slots=True)
class Setting:
    """A fact that an objective changes.

    Args:
        fact: Its name.
        value: The value that it has then.
        on: When: ``success``, ``failure`` or ``start``.
    """

    fact: str
    value: str
    on: str
