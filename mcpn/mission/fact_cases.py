"""Where something leads as facts decide: cases in their order, of which the first whose facts hold counts.

Passes write routes with them (:mod:`mcpn.mission.passes.guards`), and sections have them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from mcpn.mission.fact_conditions import Condition


class FactCase(NamedTuple):
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


class Destination(NamedTuple):
    """Where an outcome or a handler leads: to the target of the first case whose facts hold, else ``target``.

    Args:
        target: The default: a section, or an exit of the graph.
        cases: Conditions on facts with their targets, in order.
    """

    target: str
    cases: tuple[FactCase, ...] = ()

    def once(self) -> Destination:
        """The same without cases that never count, for one before them holds whenever they do."""
        kept = list[FactCase]()
        for case in self.cases:
            if not any({*before.when} <= {*case.when} for before in kept):
                kept.append(case)
        return Destination(self.target, tuple(kept))


def by_facts(cases: Iterable[tuple[Condition, Destination]], default: Destination) -> Destination:
    """One lead that chooses by facts: the lead of the first condition that holds, else the default.

    A condition that asks for nothing always holds.
    Cases of the leads chosen from are joined with the condition before them, so that the result is one list.
    """
    flat = list[FactCase]()
    for when, lead in cases:
        if not when:
            default = lead
            break
        inner = ((_both(when, case.when), case.target) for case in lead.cases)
        flat += (FactCase(both, target) for both, target in inner if both is not None)
        flat.append(FactCase(when, lead.target))
    return Destination(default.target, (*flat, *default.cases)) if flat else default


def _both(one: Condition, other: Condition) -> Condition | None:
    """Two conditions at once; ``None`` where they exclude each other."""
    both = dict(one)
    if any(both.setdefault(fact, value) != value for fact, value in other):
        return None
    return tuple(both.items())
