"""Drawn missions: blocks, protocols and handlers over a drawn robot."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, TypeVar

from hypothesis import strategies as st

from mcpn.mission.model import (
    ABORT,
    FAIL,
    SUCCEED,
    Block,
    Each,
    EntryGuard,
    FactRoute,
    Handler,
    Mission,
    Objective,
    Parallel,
    Protocol,
    Recursive,
    Use,
    walk,
)
from mcpn.mission.passes.facts_and_timeouts import becoming_problems
from mcpn.mission.passes.guards import guard_problems
from mcpn.mission.passes.pauses import pause_problems
from mcpn.mission.passes.recovery import recovery_problems
from mcpn.mission.reason_errors import ReasonChecks
from mcpn.mission.reasons import is_whole, reason
from mcpn.mission.rewriting.siblings import helping
from mcpn.mission.robot import DeclaredEvent, Robot
from mcpn.testing.drawer import TEXTS
from mcpn.testing.robots import Island, RobotDrawing
from mcpn.testing.shape import PARAMETERS, Shape

Route = TypeVar("Route", str, str | None)

NARROW = 3
"""Branches of a parallel block that may hold blocks themselves."""


class MissionDrawing(RobotDrawing):
    """Draws a whole mission."""

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        super().__init__(draw, shape)
        # Each protocol with the islands that it needs and how many elementary objectives it has.
        self.protocols: list[tuple[Protocol, list[Island], int]] = []
        self.unused: list[str] = []
        self.events: tuple[str, ...] = ()

    def mission(self) -> Mission:
        """The mission."""
        self.world()
        hardware, software = self.resources()
        for i in range(self.number(len(self.islands), max(self.shape.activities, len(self.islands)))):
            self.startable(self.islands[i] if i < len(self.islands) else self.island())
        self.events = tuple(f"e{i}" for i in range(self.number(0, self.shape.events)))
        budget = self.shape.sections
        for _ in range(self.draw(st.sampled_from([0, 1, 1, 2])) if self.shape.protocols else 0):
            blocks, size = self.series(1, self.islands, self.number(1, budget))
            protocol = Protocol(name=self.name("proto"), blocks=blocks, parameters=self.parameters())
            self.protocols.append((protocol, self.islands, size))
            self.unused.append(protocol.name)
        blocks, _ = self.series(self.shape.depth, self.islands, budget)
        handlers = self.handlers([b.name for b in blocks])
        return Mission(
            name="mission",
            description=self.description(),
            blocks=blocks,
            robots=(
                Robot(
                    name="robot",
                    hardware=hardware,
                    faults=self.faults(hardware),
                    software=software,
                    activities=tuple(self.activities),
                    facts=self.facts,
                    events=(*map(self.event, self.events), *self.changing_events()),
                ),
            ),
            protocols=tuple(protocol for protocol, _, _ in self.protocols),
            handlers=() if any(recovery_problems(blocks, handlers)) else handlers,
        )

    def event(self, name: str) -> DeclaredEvent:
        """An event, with a rate where numbers are drawn."""
        return DeclaredEvent(name=name, description=self.description(), rate=self.value(0, 1e6))

    def handlers(self, siblings: list[str]) -> tuple[Handler, ...]:
        """What a block that stands among some siblings does on events."""
        targets = st.sampled_from([SUCCEED, FAIL, *siblings])
        return tuple(
            Handler(
                event=event,
                goto=self.aborting(self.draw(targets)),
                once=(self.number(0, 3) == 0) != self.shape.interrupted,
                description=self.description(),
            )
            for event in self.events
            if (self.number(0, 2) == 0) != self.shape.interrupted
        )

    # Each draws within islands and a budget of elementary objectives, and says how many it took.

    def series(self, depth: int, islands: list[Island], budget: int) -> tuple[tuple[Block, ...], int]:
        """Blocks that run one after the other."""
        blocks: list[Block] = []
        taken = 0
        for left in range(self.number(1, min(self.shape.objectives, budget)) - 1, -1, -1):
            block, size = self.block(depth, islands, budget - taken - left)
            blocks.append(block)
            taken += size
        routed = tuple(self.routed(block, i, blocks) for i, block in enumerate(blocks))
        found = self.guarded(self.led(self.pausing(self.recovering(routed))))
        for place, each in enumerate(found):
            leaving = self.becoming(each, [b.name for b in found])
            others = (*found[:place], leaving, *found[place + 1 :])
            found = others if leaving is not each and not any(recovery_problems(others, ())) else found
        return found, taken

    def left_inside(self, block: Block) -> bool:
        """Whether facts may leave a block, or something in it: no event pauses it then."""
        uses = self.shape.becoming > 0
        return any(inner.left_by_facts or (uses and isinstance(inner, Use)) for inner in walk((block,)))

    def becoming(self, block: Block, siblings: list[str]) -> Block:
        """A block that stands among some siblings, perhaps left when facts become so, where it may be."""
        if not self.facts or not self.rarely(self.shape.becoming):
            return block
        targets = st.sampled_from([SUCCEED, FAIL, *siblings])
        handlers = (
            Handler(when=self.becomes(), goto=self.aborting(self.draw(targets)))
            for _ in range(self.draw(st.sampled_from([1, 1, 2])))
        )
        found = replace(block, handlers=(*block.handlers, *handlers))
        by_reason = any(route.reason is not None for route in block.routes)
        paused = any(handler.pause is not None for handler in block.handlers)
        unfit = paused or (by_reason and is_whole(found)) or any(becoming_problems(found))
        return block if unfit else found

    def guarded(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """A series, perhaps with guards on blocks, where they may be."""
        for place in range(1, len(blocks) if self.facts else 1):
            if not self.rarely(self.shape.guards):
                continue
            targets = [SUCCEED, FAIL, *(b.name for b in blocks[0 if self.shape.loops else place + 1 :])]
            guards = (EntryGuard(when=self.condition(), otherwise=self.draw(st.sampled_from(targets))),)
            block = replace(blocks[place], guards=guards)
            found = (*blocks[:place], block, *blocks[place + 1 :])
            blocks = blocks if any((*guard_problems(found), *recovery_problems(found, ()))) else found
        return blocks

    def recovering(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """A series, perhaps with a block that recovers by another one, where it may."""
        if len(blocks) < 2 or not self.rarely(self.shape.recovers):
            return blocks
        block, by = self.draw(st.permutations(blocks))[:2]
        found = replace(block, recover=by.name, times=self.number(1, 2))
        recovering = tuple(found if other is block else other for other in blocks)
        return blocks if any(recovery_problems(recovering, ())) else recovering

    def pausing(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """A series, perhaps with a block that pauses while another one is run, where it may."""
        if len(blocks) < 2 or not self.events or not self.rarely(self.shape.pauses):
            return blocks
        able = [block for block in blocks if not self.left_inside(block)]
        if not able:
            return blocks
        apart = [block for block in able if any(isinstance(b, Parallel) for b in walk((block,)))]
        block = self.draw(st.sampled_from(apart if apart and self.number(0, 3) else able))
        by = self.draw(st.sampled_from([other for other in blocks if other is not block]))
        on = self.draw(st.sampled_from(self.events))
        once = self.number(0, 3) == 0
        handler = Handler(event=on, pause=by.name, once=once, description=self.description())
        handlers = (*(other for other in block.handlers if other.event != on), handler)
        pausing = tuple(replace(b, handlers=handlers) if b is block else b for b in blocks)
        return blocks if any((*pause_problems(pausing, ()), *recovery_problems(pausing, ()))) else pausing

    def led(self, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
        """A series, perhaps with a route to a block that is run for another, where it may be."""
        helpers = sorted(helping(blocks))
        if not helpers or not self.rarely(self.shape.led):
            return blocks
        by, way = self.draw(st.sampled_from(helpers)), self.draw(st.sampled_from(["failure", "abort"]))
        block = self.draw(st.sampled_from([other for other in blocks if other.name != by]))
        led = tuple(replace(b, **{way: by}) if b is block else b for b in blocks)  # type: ignore[arg-type]
        return blocks if any(recovery_problems(led, ())) else led

    def routed(self, block: Block, index: int, blocks: list[Block]) -> Block:
        """A block of a series with its routes and handlers."""
        targets = [None, SUCCEED, FAIL, *(b.name for b in blocks[0 if self.shape.loops else index + 1 :])]
        route = st.sampled_from(targets)
        success, failure = self.draw(st.none() | route), self.aborting(self.draw(route))
        handlers = self.handlers([b.name for b in blocks])
        abort = self.draw(route) if self.rarely(self.shape.aborts) else None
        block = replace(block, success=success, failure=failure, abort=abort, handlers=handlers)
        siblings = [b.name for b in blocks[0 if self.shape.loops else index + 1 :]]
        timed = self.timed(block, targets)
        return replace(timed, routes=(*self.routes(siblings), *self.for_reasons(timed, siblings)))

    def timed(self, block: Block, targets: list[str | None]) -> Block:
        """A block that leads to some of these where its time is over, if it has one."""
        if not isinstance(block, Objective) and self.rarely(self.shape.timed_blocks):
            block = replace(block, timeout=self.number(1, 90) / 2)
        if block.timeout is None:
            return block
        return replace(block, timeout_goto=self.aborting(self.draw(st.sampled_from(targets))))

    def routes(self, siblings: list[str]) -> tuple[FactRoute, ...]:
        """Where a block leads if facts are so, none or a few routes."""
        targets, outcomes = (
            st.sampled_from([SUCCEED, FAIL, *siblings]),
            st.sampled_from(["success", "failure"]),
        )
        return tuple(
            FactRoute(when=self.condition(), goto=self.aborting(self.draw(targets)), on=self.draw(outcomes))
            for _ in range(self.number(0, 5) - 3 if self.facts else 0)
        )

    def for_reasons(self, block: Block, siblings: list[str]) -> tuple[FactRoute, ...]:
        """Where a block leads that fails for some reason, none or a few routes."""
        if is_whole(block) or not self.rarely(self.shape.reasons):
            return ()
        reasons = [*self.failing.of((block,))]
        found = list[FactRoute]()
        for why in self.draw(st.permutations(reasons))[:2]:
            goto = st.sampled_from([SUCCEED, FAIL, *siblings])
            if self.facts and self.chance():
                route = FactRoute(when=self.condition(), goto=self.draw(goto), on="failure", reason=why)
                found.append(route)
            if len(found) < 2 and self.number(0, 3):
                found.append(FactRoute(goto=self.aborting(self.draw(goto)), on="failure", reason=why))
        return tuple(found)

    @property
    def failing(self) -> ReasonChecks:
        """Says for which reasons blocks may fail."""
        protocols = {protocol.name: protocol for protocol, _, _ in self.protocols}
        return ReasonChecks({activity.name: activity for activity in self.activities}, protocols)

    def aborting(self, route: Route) -> Route | Literal["abort"]:
        """A route, or abort in its place."""
        return ABORT if self.rarely(self.shape.aborts) else route

    def block(self, depth: int, islands: list[Island], budget: int) -> tuple[Block, int]:
        """A block, once or in rounds and tries."""
        # The rounds of a block follow one another: where nothing contends they do not either.
        apart = self.shape.own_hardware or self.shape.shared_activities
        if not self.shape.rounds or not apart or self.number(0, 1 if self.shape.interrupted else 3):
            return self.once(depth, islands, budget)
        if depth and self.chance():
            values = [f"v{i}" for i in range(self.number(1, min(3, budget)))]
            blocks, size = self.series(depth - 1, islands, budget // len(values))
            parameter = self.draw(st.none() | st.sampled_from(PARAMETERS))
            drawn = Each(name=self.name("each"), values=tuple(values), blocks=blocks, parameter=parameter)
            return drawn, size * len(values)
        repeat = self.draw(st.none() | st.integers(1, min(3, budget)))
        retries = self.number(0, min(2, budget // (repeat or 1) - 1))
        copies = (repeat or 1) * (retries + 1)
        block, size = self.once(depth, islands, budget // copies)
        return replace(block, repeat=repeat, retries=retries), size * copies

    def once(self, depth: int, islands: list[Island], budget: int) -> tuple[Block, int]:
        """A block of any kind without rounds."""
        usable = self.usable(islands, budget)
        kinds = ["objective", "objective"]
        kinds += ["recursive"] if depth else []
        kinds += ["parallel"] if depth and self.shape.parallel else []
        kinds += ["use"] if usable else []
        kind = self.draw(st.sampled_from(kinds))
        if kind == "use":
            return self.use(*self.draw(st.sampled_from(usable)))
        if kind == "recursive":
            blocks, size = self.series(depth - 1, islands, budget)
            return Recursive(name=self.name("rec"), blocks=blocks, parameters=self.parameters()), size
        if kind == "parallel":
            blocks, size = self.children(depth - 1, islands, budget)
            counts = ["any", *map(str, range(1, len(blocks) + 1))]
            needed = self.draw(st.sampled_from(counts)) if self.rarely(self.shape.early) else "all"
            most = self.draw(st.sampled_from(["any", *counts])) if self.rarely(self.shape.early) else "all"
            impossible = "fails" if self.rarely(self.shape.early) and self.chance() else "waits"
            block = Parallel(name=self.name("par"), blocks=blocks, success_when=needed, failure_when=most)
            return replace(block, impossible=impossible), size
        return self.objective(islands), 1

    def usable(self, islands: list[Island], budget: int) -> list[tuple[Protocol, int]]:
        """Protocols that may be used here, with how many objectives they have."""
        return [
            (protocol, size)
            for protocol, needed, size in self.protocols
            if size <= budget
            and all(island in islands for island in needed)
            and (self.shape.shared_activities or protocol.name in self.unused)
        ]

    def use(self, protocol: Protocol, size: int) -> tuple[Block, int]:
        """A use of a protocol."""
        if protocol.name in self.unused:
            self.unused.remove(protocol.name)
        overrides = protocol.parameters if self.shape.text and self.chance() else ()
        parameters = tuple(replace(p, value=self.draw(TEXTS)) for p in overrides)
        return Use(name=self.name("use"), protocol=protocol.name, parameters=parameters), size

    def objective(self, islands: list[Island]) -> Objective:
        """An elementary objective."""
        activities: list[str] = []
        for _ in range(self.number(1, 2)):
            if self.shape.disjoint_branches:
                islands = [i for i in islands if not set(i.startable) & set(activities)]
            if not islands:
                break
            island = self.draw(st.sampled_from(islands))
            left = [a for a in island.startable if a not in activities]
            if not left and not self.shape.shared_activities:
                self.startable(island)
                left = island.startable[-1:]
            if left:
                activities.append(self.draw(st.sampled_from(left)))
        if not self.shape.shared_activities:
            for island in self.islands:
                island.startable = [a for a in island.startable if a not in activities]
        name, sets = self.name("obj"), self.changes(("success", "failure", "start"))
        self.done.append(name)
        failures = self.reasons(shares=True)
        least = sum(reason(text).probability or 0.0 for text in failures)
        return Objective(
            name=name,
            sets=sets,
            activities=tuple(activities),
            parameters=self.parameters(),
            description=self.description(),
            duration=self.value(1e-6, 1e6),
            failures=failures,
            failure_probability=self.value(least, 1),
            timeout=self.draw(st.integers(1, 90)) / 2 if self.rarely(self.shape.timeouts) else None,
        )

    def children(self, depth: int, islands: list[Island], budget: int) -> tuple[tuple[Block, ...], int]:
        """The children of a parallel block."""
        apart = self.shape.disjoint_branches
        most = min(self.shape.branches, budget, len(islands) if apart else budget)
        number = self.number(1, most)
        shares = [islands] * number
        if apart:
            cuts = sorted(self.draw(st.permutations(range(1, len(islands))))[: number - 1])
            shares = [islands[i:j] for i, j in zip([0, *cuts], [*cuts, len(islands)], strict=True)]
        if number > NARROW:  # so many branches have too many states unless each is small
            depth = 0
        children: list[Block] = []
        taken = 0
        for i, share in enumerate(shares):
            child, size = self.block(depth, share, budget - taken - (number - 1 - i))
            if isinstance(child, Parallel):
                child = Recursive(name=self.name("rec"), blocks=(child,))
            mandatory = i == 0 or self.chance()
            abort = self.draw(st.sampled_from([SUCCEED, FAIL])) if self.rarely(self.shape.aborts) else None
            child = replace(child, mandatory=mandatory, abort=abort, handlers=self.handlers([]))
            children.append(self.becoming(self.timed(child, [None, SUCCEED, FAIL]), []))
            taken += size
        return tuple(children), taken
