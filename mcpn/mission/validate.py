"""What is wrong with a mission that the schema cannot say: references, routing, attributes beside others."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping

from mcpn.did_you_mean import Hints
from mcpn.errors import InputError, Problem, Source
from mcpn.mission.expansion.crashes import Crash, crash_errors
from mcpn.mission.expansion.detection import detected_twice, detection_errors
from mcpn.mission.expansion.faults import failure_errors
from mcpn.mission.expansion.guards import guard_problems, of_branches
from mcpn.mission.expansion.helpers import problems as recoveries
from mcpn.mission.expansion.left_by_facts import becoming_problems, of_missions
from mcpn.mission.expansion.pauses import no_siblings, pause_problems
from mcpn.mission.fact_errors import fact_errors
from mcpn.mission.field_types import wrong_types
from mcpn.mission.graph import TIMED_OUT, UNNAMED
from mcpn.mission.language.datatypes import CORE_NAME, NAME, Interval
from mcpn.mission.language.forms import form_of
from mcpn.mission.language.references import cycles, duplicates, repeats, unseen
from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    Block,
    BlockElement,
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
from mcpn.mission.passes.name_clashes import clashes
from mcpn.mission.reason_errors import ReasonChecks
from mcpn.mission.requirement import Requirement
from mcpn.mission.robot import Activity, Described, Element, Parameter

_INTERNAL = (
    "; handlers are for declared events: losses are answered by alternatives, ends by success and failure"
)
MAX_CONSUMED = 1_000
"""Resources of one alternative: the net has arcs from the loss of each to all the others."""

_VALUE = re.compile(r"[A-Za-z0-9_]{1,64}")


def find_errors(mission: Mission, *, read: bool = False, before: Mission | None = None) -> list[Problem]:
    """What makes a mission invalid, what the schema says of files included.

    Args:
        mission: Any mission, read or built in Python.
        read: Whether it was read of files that fit the schema, so that its values are of the right types.
        before: The mission before an edit, valid; attributes of elements kept from it are not checked again.

    Returns:
        Every problem, with its line; empty for a valid mission, which is not checked again. Where values
        are of wrong types nothing else is checked. Nearly linear in the mission's size.
    """
    if mission.checked:
        return []
    problems = [] if read else list(wrong_types(mission))
    problems = problems or list(_Checks(mission, before).errors())
    if not problems:
        object.__setattr__(mission, "checked", True)
    return problems


def valid(mission: Mission) -> Mission:
    """Returns the mission if it is valid.

    Raises:
        InputError: It is no mission, or it is not valid, with every problem.
    """
    if not isinstance(mission, Mission):
        raise InputError.at(None, f"expected a mission, found {type(mission).__name__}")
    if problems := find_errors(mission):
        raise InputError(problems)
    return mission


class _Checks:
    def __init__(self, mission: Mission, before: Mission | None = None) -> None:
        self.mission = mission
        self.before = before
        self.activities: Mapping[str, Activity] = {a.name: a for a in mission.activities}
        # As declared: mission.hardware also has the resources of faults and crashes, which nobody names.
        self.hardware = {h.name: h for robot in mission.robots for h in robot.hardware}
        self.software = {s.name: s for s in mission.software}
        self.resources: Mapping[str, Element] = {**self.hardware, **self.software}
        self.named = {*self.resources, *(fault.name for fault in mission.faults)}
        self.protocols: Mapping[str, Protocol] = {p.name: p for p in mission.protocols}
        self.events = {e.name: e for e in mission.events}
        self.reasons = ReasonChecks(self.activities, self.protocols)
        self.parameters: dict[str, frozenset[str]] = {}
        self.hints = Hints()
        self.producers: dict[str, list[Activity]] = {}
        for activity in mission.activities:
            for resource in dict.fromkeys(activity.produces):
                self.producers.setdefault(resource, []).append(activity)
        self.scopes: list[tuple[Element, tuple[Block, ...]]] = [
            (mission, mission.blocks),
            *((protocol, protocol.blocks) for protocol in mission.protocols),
        ]

    def errors(self) -> Iterator[Problem]:
        mission = self.mission
        for element in unseen(mission, self.before):
            yield from self.attributes(element)
        yield from duplicates("robot", mission.robots)
        resources = (*mission.hardware, *mission.software)
        yield from duplicates("resource", (r for r in resources if not isinstance(r, Crash)))
        yield from duplicates("activity", mission.activities)
        yield from duplicates("fact", mission.facts)
        yield from duplicates("event", mission.events)
        yield from duplicates("protocol", mission.protocols)
        for requirements in (mission.requirements, *(p.requirements for p in mission.protocols)):
            yield from duplicates("requirement", requirements)
        for requirement in mission.all_requirements:
            yield from self.requirement(requirement)
        yield from failure_errors(mission.robots, self.hints)
        yield from detected_twice(mission.activities)
        yield from self.products()
        yield from fact_errors(mission, self.hints)
        for robot in mission.robots:
            for activity in robot.activities:
                yield from self.activity(activity)
                yield from crash_errors(activity, self.named)
                yield from self.reasons.activity(activity)
                yield from detection_errors(activity, self.hardware, self.named, self.hints)
        yield from cycles(
            "activities need each other's resources",
            self.activities,
            lambda name: [
                p.name for k in _consumed(self.activities[name]) for p in self.producers.get(k, ())
            ],
        )
        for owner, blocks in self.scopes:
            yield from self.blocks(owner, blocks)
        yield from cycles(
            "protocols use each other",
            self.protocols,
            lambda name: [b.protocol for b in walk(self.protocols[name].blocks) if isinstance(b, Use)],
        )

    def attributes(self, element: Element) -> Iterator[Problem]:
        """What one element says, by itself."""
        datatype = CORE_NAME if self.mission.core and isinstance(element, BlockElement) else NAME
        if not datatype.matches(element.name):
            found = f"the name {element.name!r} is not allowed"
            yield Problem(element.source, f"{found}, expected {datatype.expected}")
        if isinstance(element, BlockElement):
            yield from self.copy(element)
        yield from self.values(element, element.name)
        for content in form_of(type(element)).contents:
            if content.classes == (Parameter,):
                yield from duplicates("parameter", getattr(element, content.name))

    def copy(self, block: BlockElement) -> Iterator[Problem]:
        """What is wrong with what a block says of itself as a copy, as core missions do."""
        core = form_of(type(block)).core
        said = [field.tag for field in core if getattr(block, field.name) != field.default]
        if said and not self.mission.core:
            message = f"{block.name} has {said[0]}, though the mission is no core mission"
            yield Problem(block.source, message)
        elif block.copy and not block.own.endswith("".join(f"_{suffix}" for suffix in block.copy)):
            message = f"the copy {' '.join(block.copy)} of {block.name} is not what its name ends in"
            yield Problem(block.source, message)

    def values(self, element: Described, name: str) -> Iterator[Problem]:
        """Values of its attributes that are not allowed."""
        for attribute in form_of(type(element)).attributes:
            value, datatype = getattr(element, attribute.name), attribute.datatype
            if value is attribute.default:
                continue
            if attribute.several:
                yield from repeats(element.source, f"{attribute.tag} of {name}", value)
            elif value is not None and not datatype.allows(value):
                whole = isinstance(value, float) and not isinstance(value, Interval)
                shown = f"{value:g}" if whole else value
                message = f"{attribute.tag} of {name} is {shown}, expected {datatype.allowed}"
                yield Problem(element.source, message)

    def requirement(self, requirement: Requirement) -> Iterator[Problem]:
        """Checks a requirement by itself; its formulas are parsed later, when the mission has its net."""
        if requirement.misuse:
            yield Problem(requirement.source, f"requirement {requirement.name} has {requirement.misuse}")
        for pattern in requirement.patterns:
            said = f"<{pattern.TAG}> of requirement {requirement.name}"
            yield from self.values(pattern, said)
            if pattern.misuse:
                yield Problem(pattern.source, f"{said} has {pattern.misuse}")

    def products(self) -> Iterator[Problem]:
        for software in self.mission.software:
            producers = self.producers.get(software.name, [])
            if len(producers) != 1:
                names = ", ".join(a.name for a in producers) or "none"
                wanted = f'produces="{software.name}"'
                remedy = f"give {wanted} to the one that makes it"
                if producers:
                    remedy = f"leave {wanted} on one of them"
                needed = f"software {software.name} needs exactly one activity that produces it"
                yield Problem(software.source, f"{needed}, found {names}: {remedy}")

    def activity(self, activity: Activity) -> Iterator[Problem]:
        yield from duplicates("alternative", activity.alternatives)
        if not activity.alternatives:
            yield Problem(activity.source, f"activity {activity.name} has no alternative")
        if activity.switch_back and len(activity.alternatives) == 1:
            message = f"activity {activity.name} has one alternative: it cannot switch back to a better one"
            yield Problem(activity.source, message)
        for resource in dict.fromkeys(activity.produces):
            if resource in self.hardware:
                message = f"activity {activity.name} produces {resource}, which is a hardware resource"
                yield Problem(activity.source, message)
            elif resource not in self.software:
                yield self.unknown(
                    activity.source, f"activity {activity.name} produces", resource, self.software
                )
        for alternative in activity.alternatives:
            if (number := len(alternative.consumes)) > MAX_CONSUMED:
                who = f"alternative {alternative.name} of activity {activity.name} consumes"
                message = f"{who} {number} resources, expected at most {MAX_CONSUMED}"
                yield Problem(alternative.source, message)
            for resource in dict.fromkeys(alternative.consumes):
                if resource not in self.resources:
                    who = f"alternative {alternative.name} of activity {activity.name} consumes"
                    yield self.unknown(alternative.source, who, resource, self.resources)

    def unknown(self, source: Source | None, who: str, name: str, known: Collection[str]) -> Problem:
        return Problem(source, f"{who} {name}, which is not declared{self.hints.known(name, known)}")

    def blocks(self, owner: Element, blocks: tuple[Block, ...]) -> Iterator[Problem]:
        all_blocks = list(walk(blocks))
        if not blocks:
            yield Problem(owner.source, f"{owner.name} has no blocks")
        yield from duplicates("block", all_blocks)
        yield from clashes(blocks)
        around = owner.handlers if isinstance(owner, Mission) else ()
        for siblings in _families(blocks):
            yield from self.routing(siblings)
            yield from recoveries(siblings, around if siblings is blocks else ())
            yield from pause_problems(siblings, blocks)
            yield from guard_problems(siblings)
        if isinstance(owner, Mission):
            yield from self.handlers(owner.name, owner.handlers, {block.name: None for block in blocks})
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
                yield from self.objective(block)
                yield from self.reasons.objective(block)
            elif isinstance(block, Use):
                yield from self.use(block)
            elif isinstance(block, Parallel):
                yield from self.parallel(block)
            elif isinstance(block, Each):
                yield from self.each(block)

    def routing(self, siblings: tuple[Block, ...]) -> Iterator[Problem]:
        names = {block.name: None for block in siblings}
        for block in siblings:
            yield from self.handlers(block.name, block.handlers, names)
            if not block.mandatory:
                message = f"{block.name} is not mandatory, though it is no child of a parallel block"
                yield Problem(block.source, message)
            for exit_name in ("success", "failure", "abort", "timeout_goto"):
                route = getattr(block, exit_name)
                if route is not None:
                    yield from self.route(block.source, f"{exit_name} of {block.name}", route, names)
            for guard in block.guards:
                what = f"the guard of {block.name} when {' '.join(guard.when)}"
                yield from self.route(guard.source, what, guard.otherwise, names)
            for each in block.routes:
                asked = f" when {' '.join(each.when)}" if each.when else f" for {each.reason}"
                what = f"the route of {block.name}{asked}"
                yield from self.route(each.source, what, each.goto, names)

    def route(
        self, source: Source | None, what: str, route: str, names: Mapping[str, None]
    ) -> Iterator[Problem]:
        exits = (SUCCEED, FAIL, ABORT, *([TIMED_OUT, UNNAMED] if self.mission.core else ()))
        if route not in exits and route not in names:
            shown = [*names] if len(names) <= 10 else [f"its {len(names)} siblings"]
            expected = f"expected one of {', '.join([*shown, *exits])}"
            near = self.hints.near(route, names, *exits)
            more = "" if names else ": only the parallel block around it can lead elsewhere"
            yield Problem(source, f"{what} leads to {route}; {expected}{near}{more}")

    def handlers(
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
                problem = self.unknown(
                    handler.source, f"{owner} handles the event", handler.event, self.events
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
            elif handler.goto is not None:
                yield from self.route(handler.source, what, handler.goto, names)

    def each(self, block: Each) -> Iterator[Problem]:
        if not block.values:
            yield Problem(block.source, f"each {block.name} names no value")
        if not NAME.matches(block.bound):
            yield Problem(block.source, f"the parameter of {block.name}, {block.bound!r}, is no name")
        for value in block.values:
            if not _VALUE.fullmatch(value):
                expected = "expected letters, digits and _, at most 64 characters"
                yield Problem(block.source, f"each {block.name} names the value {value!r}, {expected}")

    def objective(self, block: Objective) -> Iterator[Problem]:
        if not block.activities:
            yield Problem(block.source, f"objective {block.name} names no activity")
        for name in dict.fromkeys(block.activities):
            if name not in self.activities:
                yield self.unknown(block.source, f"objective {block.name} runs", name, self.activities)
            elif self.activities[name].produces:
                product = self.activities[name].produces[0]
                message = f"objective {block.name} runs {name}, which produces {product}"
                reason = "an activity that produces is started by request, not by an objective"
                yield Problem(block.source, f"{message}: {reason}")

    def use(self, block: Use) -> Iterator[Problem]:
        protocol = self.protocols.get(block.protocol)
        if protocol is None:
            yield self.unknown(
                block.source, f"{block.name} uses the protocol", block.protocol, self.protocols
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

    def parallel(self, block: Parallel) -> Iterator[Problem]:
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
            yield from self.handlers(child.name, child.handlers, {})
            yield from no_siblings(child.name, child.handlers, "put it into an objective in its branch")
            for exit_name, route in (("abort", child.abort), ("timeout_goto", child.timeout_goto)):
                if route is not None:
                    yield from self.route(child.source, f"{exit_name} of {child.name}", route, {})
            for each in child.routes:
                message = f"{child.name} has a route, though it is a child of a parallel block"
                yield Problem(each.source, f"{message}: routes stand on {block.name}")
            if any(route is not None for route in (child.success, child.failure, child.recover)):
                routes = (("success", child.success), ("failure", child.failure), ("recover", child.recover))
                route = " and ".join(name for name, target in routes if target is not None)
                message = f"{child.name} has a route ({route}), though it is a child of a parallel block"
                remedy = f'routes stand on {block.name}; a child that may fail has mandatory="false"'
                yield Problem(child.source, f"{message}: {remedy}")


def _consumed(activity: Activity) -> list[str]:
    return list(dict.fromkeys(k for alternative in activity.alternatives for k in alternative.consumes))


def _families(blocks: tuple[Block, ...]) -> Iterator[tuple[Block, ...]]:
    """Every series of sibling blocks, whose routes may name one another; not children of parallel blocks."""
    yield blocks
    for block in walk(blocks):
        if isinstance(block, Recursive | Each):
            yield block.blocks
