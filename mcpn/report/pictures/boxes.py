"""The tree of boxes that draws a mission as it was written; protocols are drawn where they are used.

It is the author's mission that is drawn: a core mission has every round, try, run and use by itself, where a
picture shows one box that says how many. The core mission is shown by the picture of the objectives graph.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from mcpn.mission.core.copies import Path
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.model import (
    SUCCEED,
    Block,
    Each,
    FactRoute,
    Handler,
    Mission,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
)
from mcpn.mission.rewriting.siblings import entered, following, helping


@dataclass(frozen=True)
class Box:
    """A block, or the mission itself.

    Args:
        key: A number that no other box has.
        kind: ``mission``, ``objective``, ``recursive``, ``parallel``, ``use`` or ``each``.
        name: As written.
        description: As written.
        notes: Rounds, tries, the protocol, being optional.
        mandatory: False for an optional child of a parallel block.
        activities: What an objective runs.
        success: The route on success as written; ``None`` for the default.
        failure: The same for failure.
        abort: The same for abort.
        recover: The sibling that is run when it fails, before it is entered again.
        timeout_goto: The route where its time is over.
        routes: Where it leads if facts are so.
        handlers: What it does on declared events.
        children: What it holds, in document order.
        after: Where success leads that writes no route: never to a sibling that only helps others; ``None``
            of one that is entered for others alone, to which it leads back.
    """

    key: int
    kind: str
    name: str
    description: str | None = None
    notes: tuple[str, ...] = ()
    mandatory: bool = True
    activities: tuple[str, ...] = ()
    success: str | None = None
    failure: str | None = None
    abort: str | None = None
    recover: str | None = None
    timeout_goto: str | None = None
    routes: tuple[FactRoute, ...] = ()
    handlers: tuple[Handler, ...] = ()
    children: tuple[Box, ...] = ()
    after: str | None = SUCCEED


_KINDS = {
    Objective: "objective",
    Recursive: "recursive",
    Parallel: "parallel",
    Use: "use",
    Each: "each",
}


def boxes(mission: Mission, graph: ObjectivesGraph) -> tuple[Box, Mapping[str, int]]:
    """The boxes of a mission.

    Args:
        mission: The mission.
        graph: Its objectives graph.

    Returns:
        The mission's box, and for each elementary objective of the graph the key of the box that it comes
        from: rounds and tries of one block have the same.
    """
    building = _Building(mission)
    root = building.mission(mission)
    objectives = graph.copies.objectives
    return root, {s.name: building.keys[objectives[s.name].path] for s in graph.walk()}


class _Building:
    def __init__(self, mission: Mission) -> None:
        self.protocols: dict[str, Protocol] = {p.name: p for p in mission.protocols}
        self.count = 0
        self.keys: dict[Path, int] = {}

    def mission(self, mission: Mission) -> Box:
        children = self.series(mission.blocks, (), mission.handlers)
        return Box(
            -1, "mission", mission.name, mission.description, handlers=mission.handlers, children=children
        )

    def series(
        self, siblings: Sequence[Block], uses: Path, around: Sequence[Handler], within: str = ""
    ) -> tuple[Box, ...]:
        """Siblings inside some uses of protocols, under some handlers."""
        after: dict[str, str | None] = {**following(siblings)}
        if within != "parallel" and siblings:
            after |= dict.fromkeys(helping(siblings) - entered(siblings, around))
        return tuple(replace(self.box(block, uses, within), after=after[block.name]) for block in siblings)

    def box(self, block: Block, uses: Path, within: str = "") -> Box:
        """A block inside some uses of protocols: one box for all copies of it and of the blocks around."""
        key, self.count = self.count, self.count + 1
        children: tuple[Block, ...] = ()
        if isinstance(block, Objective):
            self.keys[(*uses, block.name)] = key
        elif isinstance(block, Use):
            children, uses = self.protocols[block.protocol].blocks, (*uses, block.name)
        else:
            children = block.blocks
        kind = _KINDS[type(block)]
        return Box(
            key=key,
            kind=kind,
            name=block.name,
            description=block.description,
            notes=tuple(_notes(block, within)),
            mandatory=block.mandatory or within != "parallel",
            activities=block.activities if isinstance(block, Objective) else (),
            success=block.success,
            failure=block.failure,
            abort=block.abort,
            recover=block.recover,
            timeout_goto=block.timeout_goto,
            routes=block.routes,
            handlers=block.handlers,
            children=self.series(children, uses, block.handlers, kind),
        )


def facts_said(routes: Iterable[FactRoute]) -> Iterator[tuple[FactRoute, str]]:
    """Routes with a condition on facts or a reason, each with a label that says it."""
    for route in routes:
        said = [route.on] if route.on != "success" else []
        said += [f"for {route.reason}"] if route.reason is not None else []
        said += [f"when {' '.join(route.when)}"] if route.when else []
        yield route, " ".join(said)


def _notes(block: Block, within: str) -> Iterator[str]:
    for guard in block.guards:
        yield f"entered when {' '.join(guard.when)}, else {guard.otherwise}"
    if within == "parallel" and not block.mandatory:
        yield "optional"
    if within == "parallel" and block.abort is not None:
        yield f"abort leads to {block.abort}"
    if isinstance(block, Use):
        yield f"protocol {block.protocol}"
    elif isinstance(block, Parallel):
        yield "in parallel"
        if block.success_when != "all":
            yield f"until {'one' if block.success_when == 'any' else block.success_when} succeeded"
        if block.failure_when != "all":
            yield f"until {'one' if block.failure_when == 'any' else block.failure_when} failed"
        if block.failing is not None:
            yield f"until {block.failing} failed"
        if block.impossible == "fails":
            yield "until it cannot succeed"
    elif isinstance(block, Each):
        yield f"for each of {len(block.values)}: {' '.join(block.values)}"
    if block.repeat is not None:
        yield f"{block.repeat} rounds"
    if block.timeout is not None:
        yield f"at most {block.timeout:g} s"
        if within == "parallel" and block.timeout_goto is not None:
            yield f"timeout leads to {block.timeout_goto}"
    if within == "parallel":
        yield from (f"{said} leads to {route.goto}" for route, said in facts_said(block.routes))
    if block.recover:
        yield f"recovers {'once' if block.times == 1 else f'{block.times} times'}"
    if block.retries:
        yield f"up to {block.retries + 1} tries"
    if isinstance(block, Objective):
        yield from (f"{change.occasion} sets {change.fact}={change.to}" for change in block.sets)
