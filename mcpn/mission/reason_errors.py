"""What is wrong with the reasons of a mission: those that are named, and those that are routed."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from math import fsum

from mcpn.did_you_mean import did_you_mean
from mcpn.errors import Problem
from mcpn.mission.language.datatypes import REASON, REASONS, SHARES
from mcpn.mission.model import Block, Each, Objective, Parallel, Protocol, Recursive, Use
from mcpn.mission.reasons import is_whole, reason, reasons_of
from mcpn.mission.robot import Activity


class ReasonChecks:
    """Checks the reasons of a mission.

    Args:
        activities: Its activities by name.
        protocols: Its protocols by name.
    """

    def __init__(self, activities: Mapping[str, Activity], protocols: Mapping[str, Protocol]) -> None:
        self.activities = activities
        self.protocols = protocols
        self._of_protocols: dict[str, dict[str, None]] = {}

    def activity(self, activity: Activity) -> Iterator[Problem]:
        """What is wrong with the reasons that an activity names."""
        for name in dict.fromkeys(activity.failures):
            if not REASON.allows(name) or not REASONS.matches(name):
                found = f"failures of activity {activity.name} names {name!r}"
                yield Problem(activity.source, f"{found}, expected {REASON.allowed}")
        if activity.failures and activity.produces:
            message = f"activity {activity.name} names failures, though it produces {activity.produces[0]}"
            yield Problem(activity.source, f"{message}: no objective runs it, which could fail for them")

    def objective(self, objective: Objective) -> Iterator[Problem]:
        """What is wrong with the reasons that an objective names."""
        who, source, met = f"failures of {objective.name}", objective.source, set[str]()
        for text in dict.fromkeys(objective.failures):
            if not SHARES.matches(text) or not text:
                yield Problem(source, f"{who} names {text!r}, expected {SHARES.expected}")
                return
            said = reason(text)
            if not REASON.allows(said.name):
                yield Problem(source, f"{who} names {said.name!r}, expected {REASON.allowed}")
            if said.name in met:
                yield Problem(source, f"{who} names {said.name} twice")
            if said.probability is not None and not 0 <= said.probability <= 1:
                message = f"the probability of {said.name} of {objective.name} is {said.probability:g}"
                yield Problem(source, f"{message}, expected a number from 0 to 1")
            met.add(said.name)
        whole = objective.failure_probability
        shares = [reason(text).probability or 0.0 for text in objective.failures]
        parts = fsum(share for share in shares if share <= 1)
        if parts > 0 and parts > (1.0 if whole is None else whole) * (1 + 1e-12):
            most = "1" if whole is None else f"its failure_probability, {whole:g}"
            yield Problem(
                source, f"the probabilities of {who} are {parts:g} together, expected at most {most}"
            )

    def routes(self, block: Block) -> Iterator[Problem]:
        """What is wrong with the routes of a block that name a reason, or nothing."""
        always, known = set[str](), self.of((block,)) if any(r.reason for r in block.routes) else {}
        for route in block.routes:
            what = f"a route of {block.name}"
            if route.reason is None:
                if not route.when:
                    yield Problem(route.source, f"{what} asks for no fact and names no reason")
                continue
            if not REASON.matches(route.reason) or not REASON.allows(route.reason):
                yield Problem(
                    route.source, f"{what} names the reason {route.reason!r}, expected {REASON.allowed}"
                )
            elif route.on != "failure":
                message = f"{what} names the reason {route.reason}, though it is one on {route.on}"
                yield Problem(route.source, f'{message}: only failures have reasons, on="failure"')
            elif is_whole(block):
                kind = "holds blocks and has a timeout"
                if isinstance(block, Parallel):
                    kind = "is a parallel block"
                elif block.left_by_facts:
                    kind = "has <on when>"
                message = f"{what} names the reason {route.reason}, though {block.name} {kind}"
                remedy = "it fails as a whole, for no reason: put the route on a block inside"
                yield Problem(route.source, f"{message}; {remedy}")
            elif route.reason in always:
                message = f"{what} names the reason {route.reason} behind one that always counts"
                yield Problem(route.source, f"{message}: put routes with when before the one without")
            elif route.reason not in known:
                near = did_you_mean(route.reason, known)
                some = f"expected one of {', '.join(known)}" if known else 'declare it by failures="..."'
                message = f"{what} names the reason {route.reason}, for which nothing in {block.name} fails"
                yield Problem(route.source, f"{message}; {some}{near}")
            if not route.when:
                always.add(route.reason)

    def of(self, blocks: Iterable[Block]) -> dict[str, None]:
        """The reasons for which blocks may fail, as far as it can be seen in their texts."""
        found, stack = dict[str, None](), [*blocks][::-1]
        while stack:
            match stack.pop():
                case block if is_whole(block):
                    pass
                case Objective() as block:
                    found |= {known.name: None for known in reasons_of(block, self.activities)}
                case Recursive() | Each() as block:
                    stack.extend(reversed(block.blocks))
                case Use() as block if block.protocol not in self._of_protocols:
                    self._of_protocols[block.protocol] = {}  # protocols may use each other in a circle
                    if block.protocol in self.protocols:
                        inside = self.of(self.protocols[block.protocol].blocks)
                        self._of_protocols[block.protocol] = inside
                        found |= inside
                case Use() as block:
                    found |= self._of_protocols[block.protocol]
                case _:
                    pass
        return found
