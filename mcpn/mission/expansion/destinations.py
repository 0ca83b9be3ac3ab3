"""Where the outcomes of blocks lead: by default, and by routes that facts and reasons choose.

:mod:`mcpn.mission.flatten` says where the routes of a block lead by default; :func:`deciding` puts its own
routes before them, with their conditions on facts and their reasons.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from mcpn.mission.conditions import resolved
from mcpn.mission.expansion.routes import Becoming, Condition, FactCase, left_by
from mcpn.mission.graph import TIMED_OUT, UNNAMED, failed_for
from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block
from mcpn.mission.robot import Fact


class Destination(NamedTuple):
    """Where an outcome or a handler leads: to the target of the first case whose facts hold, else ``target``.

    Args:
        target: The default: a section, or an exit of the graph.
        cases: Conditions on facts with their targets, in order.
    """

    target: str
    cases: tuple[FactCase, ...] = ()


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


class Named(NamedTuple):
    """Where a failure for a reason leads.

    Args:
        own: Routes of the block that name the reason, with their conditions.
        otherwise: Where it leads where none of these fits.
    """

    own: tuple[tuple[Condition, Destination], ...]
    otherwise: Destination

    @property
    def lead(self) -> Destination:
        """Both in one."""
        return by_facts(self.own, self.otherwise)


def failing_for(reason: str) -> str:
    """The name of the exit by which blocks are left that fail for a reason; no block is called so."""
    return f"{FAIL} {reason}"


def reasons_led(exits: Iterable[str]) -> list[str]:
    """The reasons that some exits have, of the names of all exits."""
    named = (exit_ for exit_ in exits if exit_.startswith(f"{FAIL} ") and exit_ != UNNAMED)
    return [exit_.removeprefix(f"{FAIL} ") for exit_ in named]


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
    named: Mapping[str, Named] = {}
    becoming: tuple[tuple[Becoming, Destination], ...] = ()

    def failing(self, lead: Destination) -> Destinations:
        """The same of a copy of the block whose failure leads to the next, whatever routes name no reason."""
        named = {reason: each._replace(otherwise=lead) for reason, each in self.named.items()}
        return self._replace(failure=lead, named=named)

    def of_copy(self, named: Mapping[str, Named], *, last: bool) -> Destinations:
        """The same of a copy of a block: its failures for reasons ask first the routes of the whole.

        Args:
            named: Those of the whole.
            last: Whether its failure is that of the whole, and leads to no other copy.
        """
        return self._replace(named=named) if last else self._replace(named=named).failing(self.failure)

    def of_reasons(self, reasons: Iterable[str]) -> Destinations:
        """The same of an objective that fails for these: where nobody asks, as it fails for none."""
        plain = Named((), self.failure)
        return self._replace(named={reason: self.named.get(reason, plain) for reason in reasons})

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
            **{failed_for(reason): each.lead for reason, each in self.named.items()},
            **{left_by(number): lead for number, (_, lead) in enumerate(self.becoming, 1)},
        }
        return tuple((outcome, case) for outcome, lead in leads.items() for case in lead.cases)

    @property
    def exits(self) -> dict[str, Destination]:
        """For the blocks inside: by the name of an exit as their routes say it, where that exit leads."""
        exits = {SUCCEED: self.success, FAIL: self.failure, ABORT: self.abort, UNNAMED: self.failure}
        exits |= {failing_for(reason): each.lead for reason, each in self.named.items()}
        return exits | {TIMED_OUT: self.timed_out}


def deciding(
    block: Block,
    routes: Mapping[str, Destination],
    leads: Destinations,
    exits: Mapping[str, Destination],
    facts: Mapping[str, Fact],
) -> Destinations:
    """The leads of a block, its routes with a condition on facts or a reason put before the others."""
    own = defaultdict[str, list[tuple[Condition, str]]](list)
    named = {reason: list[tuple[Condition, str]]() for reason in reasons_led(exits)}
    for route in block.routes:
        decided = own[route.on] if route.reason is None else named.setdefault(route.reason, [])
        decided.append((resolved(route.when, facts), route.goto))
    if not block.routes and not named:
        return leads

    def led(
        cases: list[tuple[Condition, str]], failing: Destination
    ) -> tuple[tuple[Condition, Destination], ...]:
        return tuple((when, failing if goto == FAIL else routes[goto]) for when, goto in cases)

    success, failure, abort, late = (
        by_facts(led(own[on], routes[FAIL]), lead)
        for on, lead in zip(("success", "failure", "abort", "timeout"), leads[:4], strict=True)
    )
    found = dict[str, Named]()
    for reason, cases in named.items():
        # What fails so fails the block around for the same reason.
        around = exits.get(failing_for(reason), routes[FAIL])
        default = around if block.failure in (None, FAIL) else leads.failure
        found[reason] = Named(led(cases, around), by_facts(led(own["failure"], around), default))
    return Destinations(success, failure, abort, late if block.timeout_goto else failure, found)
