"""Where the outcomes of blocks lead once they are written out, and what facts decide of that."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from mcpn.mission.graph import TIMED_OUT
from mcpn.mission.model import ABORT, FAIL, SUCCEED
from mcpn.mission.world.decisions import Condition, FactCase


class Lead(NamedTuple):
    """Where something leads, sections or exits of the graph: the first case that fits, else the default."""

    target: str
    cases: tuple[FactCase, ...] = ()


def by_facts(cases: Iterable[tuple[Condition, Lead]], default: Lead) -> Lead:
    """A lead that facts decide between others."""
    found = list[FactCase]()
    for when, lead in cases:
        inner = ((_both(when, case.when), case.target) for case in lead.cases)
        found += (FactCase(both, target) for both, target in inner if both is not None)
        found.append(FactCase(when, lead.target))
    return Lead(default.target, (*found, *default.cases)) if found else default


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
        """What facts decide, with its outcome."""
        leads = {
            "success": self.success,
            "failure": self.failure,
            "abort": self.abort,
            TIMED_OUT: self.timed_out,
        }
        return tuple((outcome, case) for outcome, lead in leads.items() for case in lead.cases)

    @property
    def exits(self) -> dict[str, Lead]:
        """Where each exit leads, by the route to it that blocks inside name."""
        exits = {SUCCEED: self.success, FAIL: self.failure, ABORT: self.abort}
        return exits | {TIMED_OUT: self.timed_out}
