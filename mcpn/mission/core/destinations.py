"""Where the outcomes of blocks lead: by default, and by routes that facts and reasons choose.

:mod:`mcpn.mission.core.flattening` says where the routes of a block lead by default; :func:`deciding` puts
its own routes before them, with their conditions on facts and their reasons.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from mcpn.mission.core.objectives_graph import failed_for
from mcpn.mission.core.routes import Becoming, left_by
from mcpn.mission.fact_cases import Destination, FactCase, by_facts
from mcpn.mission.fact_conditions import Condition, resolved
from mcpn.mission.model import ABORT, FAIL, SUCCEED, TIMED_OUT, UNNAMED, Block, failing_for
from mcpn.mission.robot import Fact


class Destinations(NamedTuple):
    """Where the outcomes of a block lead.

    Args:
        success: Its success.
        failure: Its failure.
        abort: That something in it aborts.
        timed_out: That its time is over.
        named: By reason, its failure for that reason, where this may lead elsewhere.
        becoming: By what facts become it is left, each with where that leads.
    """

    success: Destination
    failure: Destination
    abort: Destination
    timed_out: Destination
    named: Mapping[str, Destination] = {}
    becoming: tuple[tuple[Becoming, Destination], ...] = ()

    def of_reasons(self, reasons: Iterable[str]) -> Destinations:
        """The same of an objective that fails for these: where nobody asks, as it fails for none."""
        return self._replace(named={reason: self.named.get(reason, self.failure) for reason in reasons})

    @property
    def becomes(self) -> tuple[Becoming, ...]:
        """By what facts become it is left, as its section says it."""
        return tuple(each for each, _ in self.becoming)

    @property
    def cases(self) -> tuple[tuple[str, FactCase], ...]:
        """The cases of every outcome, each with the outcome."""
        leads = {
            "success": self.success,
            "failure": self.failure,
            "abort": self.abort,
            TIMED_OUT: self.timed_out,
            **{failed_for(reason): lead for reason, lead in self.named.items()},
            **{left_by(number): lead for number, (_, lead) in enumerate(self.becoming, 1)},
        }
        return tuple((outcome, case) for outcome, lead in leads.items() for case in lead.cases)

    @property
    def exits(self) -> dict[str, Destination]:
        """For the blocks inside: by the name of an exit as their routes say it, where that exit leads."""
        exits = {SUCCEED: self.success, FAIL: self.failure, ABORT: self.abort, UNNAMED: self.failure}
        exits |= {failing_for(reason): lead for reason, lead in self.named.items()}
        return exits | {TIMED_OUT: self.timed_out}


def deciding(
    block: Block,
    routes: Mapping[str, Destination],
    leads: Destinations,
    facts: Mapping[str, Fact],
    *,
    copy: bool = False,
) -> Destinations:
    """The leads of a block, its routes with a condition on facts or a reason put before the others.

    A copy of the block around repeats conditions of its routes for reasons: each of them counts once.
    """
    if not block.routes:
        return leads
    own = defaultdict[str, list[tuple[Condition, Destination]]](list)
    named = dict[str, list[tuple[Condition, Destination]]]()
    for route in block.routes:
        decided = own[route.on] if route.reason is None else named.setdefault(route.reason, [])
        unnamed = FAIL if route.goto == failing_for(route.reason or "") else route.goto
        decided.append((resolved(route.when, facts), routes.get(route.goto) or routes[unnamed]))
    success, failure, abort, late = (
        by_facts(own[on], lead)
        for on, lead in zip(("success", "failure", "abort", "timeout"), leads[:4], strict=True)
    )
    found = {reason: by_facts(cases, leads.failure) for reason, cases in named.items()}
    if copy:
        found = {reason: lead.once() for reason, lead in found.items()}
    return Destinations(success, failure, abort, late if block.timeout_goto else failure, found)
