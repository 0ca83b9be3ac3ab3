"""Errors of blocks that the schema cannot say: where they lead, what they name, attributes beside others."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

from mcpn.did_you_mean import Hints
from mcpn.errors import Problem, Source
from mcpn.mission.language.datatypes import NAME
from mcpn.mission.language.references import duplicates
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    TIMED_OUT,
    UNNAMED,
    Block,
    Each,
    Handler,
    Holder,
    Mission,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
    walk,
)
from mcpn.mission.passes.facts_and_timeouts import becoming_problems, of_missions
from mcpn.mission.passes.guards import guard_problems, of_branches
from mcpn.mission.passes.name_clashes import clashes
from mcpn.mission.passes.pauses import no_siblings, pause_problems
from mcpn.mission.passes.recovery import recovery_problems
from mcpn.mission.reason_errors import ReasonChecks
from mcpn.mission.robot import Activity, Element

_INTERNAL = (
    "; handlers are for declared events: losses are answered by alternatives, ends by success and failure"
)
_VALUE = re.compile(r"[A-Za-z0-9_]{1,64}")


def undeclared(hints: Hints, source: Source | None, who: str, name: str, known: Collection[str]) -> Problem:
    """The problem that a name is not one of those that are known."""
    return Problem(source, f"{who} {name}, which is not declared{hints.known(name, known)}")


class BlockErrors:
    """Finds what is wrong with the blocks of one mission.

    Args:
        mission: The mission.
        hints: Finds what unknown names may have been meant as.
    """

    def __init__(self, mission: Mission, hints: Hints) -> None:
        self.mission = mission
        self.hints = hints
        self.activities: Mapping[str, Activity] = {a.name: a for a in mission.activities}
        self.protocols: Mapping[str, Protocol] = {p.name: p for p in mission.protocols}
        self.events = {e.name: e for e in mission.events}
        self.reasons = ReasonChecks(self.activities, self.protocols)
        self.parameters: dict[str, frozenset[str]] = {}

    def text(self, owner: Element, blocks: tuple[Block, ...]) -> Iterator[Problem]:
        """What is wrong with the blocks of the mission, or of a protocol, its owner."""
        all_blocks = list(walk(blocks))
        if not blocks:
            yield Problem(owner.source, f"{owner.name} has no blocks")
        yield from duplicates("block", all_blocks)
        yield from clashes(blocks)
        around = owner.handlers if isinstance(owner, Mission) else ()
        for siblings in _families(blocks):
            yield from self._routing(siblings)
            yield from recovery_problems(siblings, around if siblings is blocks else ())
            yield from pause_problems(siblings, blocks)
            yield from guard_problems(siblings)
        if isinstance(owner, Mission):
            yield from self._handlers(owner.name, owner.handlers, {block.name: None for block in blocks})
            yield from no_siblings(owner.name, owner.handlers, "put its blocks into an objective")
            yield from of_missions(owner)
        for block in all_blocks:
            if isinstance(block, Holder) and not block.blocks:
                yield Problem(block.source, f"{block.name} has no blocks")
            if block.timeout_goto is not None and block.timeout is None and not self.mission.core:
                message = f"{block.name} has a timeout_goto, though it has no timeout"
                yield Problem(block.source, message)
            if block.name in (SUCCEED, FAIL, ABORT):
                yield Problem(block.source, f"a block cannot be called {block.name}, the name of a route")
            yield from becoming_problems(block)
            yield from self.reasons.routes(block)
            if isinstance(block, Objective):
                yield from self._objective(block)
                yield from self.reasons.objective(block)
            elif isinstance(block, Use):
                yield from self._use(block)
            elif isinstance(block, Parallel):
                yield from self._parallel(block)
            elif isinstance(block, Each):
                yield from self._each(block)

    def _routing(self, siblings: tuple[Block, ...]) -> Iterator[Problem]:
        names = {block.name: None for block in siblings}
        for block in siblings:
            yield from self._handlers(block.name, block.handlers, names)
            if not block.mandatory:
                message = f"{block.name} is not mandatory, though it is no child of a parallel block"
                yield Problem(block.source, message)
            if block.resumes is not None and not self.mission.core:
                message = f"{block.name} has resumes, though the mission is no core mission"
                yield Problem(block.source, message)
            for exit_name in ("success", "failure", "abort", "timeout_goto"):
                route = getattr(block, exit_name)
                if route is not None:
                    yield from self._route(block.source, f"{exit_name} of {block.name}", route, names)
            for guard in block.guards:
                what = f"the guard of {block.name} when {' '.join(guard.when)}"
                yield from self._route(guard.source, what, guard.otherwise, names)
            for each in block.routes:
                asked = f" when {' '.join(each.when)}" if each.when else f" for {each.reason}"
                what = f"the route of {block.name}{asked}"
                if not (self.mission.core and each.reason and each.goto == f"{FAIL} {each.reason}"):
                    yield from self._route(each.source, what, each.goto, names)

    def _route(
        self, source: Source | None, what: str, route: str, names: Mapping[str, None]
    ) -> Iterator[Problem]:
        exits = (SUCCEED, FAIL, ABORT, *([TIMED_OUT, UNNAMED] if self.mission.core else ()))
        if route not in exits and route not in names:
            shown = [*names] if len(names) <= 10 else [f"its {len(names)} siblings"]
            expected = f"expected one of {', '.join([*shown, *exits])}"
            near = self.hints.near(route, names, *exits)
            more = "" if names else ": only the parallel block around it can lead elsewhere"
            yield Problem(source, f"{what} leads to {route}; {expected}{near}{more}")

    def _handlers(
        self, owner: str, handlers: tuple[Handler, ...], names: Mapping[str, None]
    ) -> Iterator[Problem]:
        handled: set[str] = set()
        for handler in handlers:
            what = f"the event {handler.event} of {owner}"
            if (handler.event is None) != bool(handler.when):
                found = "neither event nor when" if handler.event is None else "both event and when"
                yield Problem(handler.source, f"an <on> of {owner} has {found}; expected one of them")
                continue
            if handler.event is None:
                what = f"<on when> of {owner}"
                for attribute in ("pause", "once"):
                    if getattr(handler, attribute):
                        found = f"{what} has {attribute}"
                        yield Problem(handler.source, f"{found}: as facts become so a block is left, by goto")
                if handler.pause is not None:
                    continue
            elif handler.event not in self.events:
                problem = undeclared(
                    self.hints, handler.source, f"{owner} handles the event", handler.event, self.events
                )
                own = _INTERNAL if "_EV_" in handler.event else ""
                yield Problem(problem.source, f"{problem.message}{own}")
            elif handler.event in handled:
                yield Problem(handler.source, f"{owner} handles the event {handler.event} twice")
            handled.add(handler.event or "")
            if handler.fails_as is not None and not self.mission.core:
                message = f"{what} has fails_as, though the mission is no core mission"
                yield Problem(handler.source, message)
            if (handler.goto is None) == (handler.pause is None):
                found = "nowhere" if handler.goto is None else f"to {handler.goto} and pauses"
                yield Problem(handler.source, f"{what} leads {found}; expected one of goto and pause")
            for target in handler.targets if handler.pause is None else ():
                yield from self._route(handler.source, what, target, names)
            yield from self._chosen(what, handler)

    def _chosen(self, what: str, handler: Handler) -> Iterator[Problem]:
        """What is wrong with the routes of a handler, as core missions have them."""
        for each in handler.routes:
            if not self.mission.core:
                yield Problem(each.source, f"{what} has a route, though the mission is no core mission")
            elif handler.pause is not None or not each.when or (each.on, each.reason) != ("success", None):
                expected = "expected one with goto and when alone, of a handler that leaves its block"
                yield Problem(each.source, f"{what} has a route that is none of a handler; {expected}")

    def _each(self, block: Each) -> Iterator[Problem]:
        if not block.values:
            yield Problem(block.source, f"each {block.name} names no value")
        if not NAME.matches(block.bound):
            yield Problem(block.source, f"the parameter of {block.name}, {block.bound!r}, is no name")
        for value in block.values:
            if not _VALUE.fullmatch(value):
                expected = "expected letters, digits and _, at most 64 characters"
                yield Problem(block.source, f"each {block.name} names the value {value!r}, {expected}")

    def _objective(self, block: Objective) -> Iterator[Problem]:
        if not block.activities:
            yield Problem(block.source, f"objective {block.name} names no activity")
        for name in dict.fromkeys(block.activities):
            if name not in self.activities:
                yield undeclared(
                    self.hints, block.source, f"objective {block.name} runs", name, self.activities
                )
            elif self.activities[name].produces:
                product = self.activities[name].produces[0]
                message = f"objective {block.name} runs {name}, which produces {product}"
                reason = "an activity that produces is started by request, not by an objective"
                yield Problem(block.source, f"{message}: {reason}")

    def _use(self, block: Use) -> Iterator[Problem]:
        protocol = self.protocols.get(block.protocol)
        if protocol is None:
            yield undeclared(
                self.hints, block.source, f"{block.name} uses the protocol", block.protocol, self.protocols
            )
            return
        declared = self.parameters.setdefault(
            protocol.name, frozenset(parameter.name for parameter in protocol.parameters)
        )
        for parameter in block.parameters:
            if parameter.name not in declared:
                message = f"{block.name} overrides the parameter {parameter.name}, which protocol"
                remedy = "declare it there with its default, before the first block"
                yield Problem(parameter.source, f"{message} {protocol.name} does not have: {remedy}")

    def _parallel(self, block: Parallel) -> Iterator[Problem]:
        for attribute in ("success_when", "failure_when", "failing"):
            if (count := str(getattr(block, attribute))).isdecimal() and int(count) > len(block.blocks):
                children = f"{len(block.blocks)} children" if len(block.blocks) != 1 else "1 child"
                message = f"{attribute} of {block.name} is {count}, though it has {children}"
                yield Problem(block.source, message)
        if not any(child.mandatory for child in block.blocks):
            yield Problem(block.source, f"parallel block {block.name} has no mandatory child")
        yield from of_branches(block)
        for child in block.blocks:
            if isinstance(child, Parallel) and not self.mission.core:
                message = f"parallel block {block.name} holds the parallel block {child.name} directly"
                yield Problem(child.source, f"{message}; expected an objective or a use")
            yield from self._handlers(child.name, child.handlers, {})
            yield from no_siblings(child.name, child.handlers, "put it into an objective in its branch")
            for exit_name, route in (("abort", child.abort), ("timeout_goto", child.timeout_goto)):
                if route is not None:
                    yield from self._route(child.source, f"{exit_name} of {child.name}", route, {})
            for each in child.routes:
                message = f"{child.name} has a route, though it is a child of a parallel block"
                yield Problem(each.source, f"{message}: routes stand on {block.name}")
            if any(route is not None for route in (child.success, child.failure, child.recover)):
                routes = (("success", child.success), ("failure", child.failure), ("recover", child.recover))
                route = " and ".join(name for name, target in routes if target is not None)
                message = f"{child.name} has a route ({route}), though it is a child of a parallel block"
                remedy = f'routes stand on {block.name}; a child that may fail has mandatory="false"'
                yield Problem(child.source, f"{message}: {remedy}")


def _families(blocks: tuple[Block, ...]) -> Iterator[tuple[Block, ...]]:
    """Every series of sibling blocks, whose routes may name one another; not children of parallel blocks."""
    yield blocks
    for block in walk(blocks):
        if isinstance(block, Recursive | Each):
            yield block.blocks
