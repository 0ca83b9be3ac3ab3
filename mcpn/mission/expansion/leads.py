"""Where the outcomes of blocks lead once routes are resolved, and how facts choose between routes.

:mod:`mcpn.mission.flatten` makes leads of the routes of blocks; :func:`by_facts` puts conditions before them.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from mcpn.mission.graph import TIMED_OUT
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.world.decisions import Condition, FactCase


class Lead(NamedTuple):
    """Where an outcome or a handler leads: to the target of the first case whose facts hold, else ``target``.

    Args:
        target: The default: a section, or an exit of the graph.
        cases: Conditions on facts with their targets, in order.
    """

    target: str
    cases: tuple[FactCase, ...] = ()


def by_facts(cases: Iterable[tuple[Condition, Lead]], default: Lead) -> Lead:
    """One lead that chooses by facts: the lead of the first condition that holds, else the default.

    Cases of the leads chosen from are joined with the condition before them, so that the result is one list.
    """
    flat = list[FactCase]()
    for when, lead in cases:
        inner = ((_both(when, case.when), case.target) for case in lead.cases)
        flat += (FactCase(both, target) for both, target in inner if both is not None)
        flat.append(FactCase(when, lead.target))
    return Lead(default.target, (*flat, *default.cases)) if flat else default


def _both(one: Condition, other: Condition) -> Condition | None:
    """Two conditions at once; ``None`` where they exclude each other."""
    both = dict(one)
    if any(both.setdefault(fact, value) != value for fact, value in other):
        return None
    return tuple(both.items())


class Leads(NamedTuple):
    """Where the outcomes of a block lead."""

    success: Lead
    failure: Lead
    abort: Lead
    timed_out: Lead

    @property
    def cases(self) -> tuple[tuple[str, FactCase], ...]:
        """The cases of every outcome, each with the outcome."""
        leads = {
            "success": self.success,
            "failure": self.failure,
            "abort": self.abort,
            TIMED_OUT: self.timed_out,
        }
        return tuple((outcome, case) for outcome, lead in leads.items() for case in lead.cases)

    @property
    def exits(self) -> dict[str, Lead]:
        """For the blocks inside: by the name of an exit as their routes say it, where that exit leads."""
        exits = {SUCCEED: self.success, FAIL: self.failure, ABORT: self.abort}
        return exits | {TIMED_OUT: self.timed_out}
