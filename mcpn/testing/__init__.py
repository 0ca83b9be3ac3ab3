"""Hypothesis strategies for users of mcpn: valid missions of any shape, small enough to be explored in full.

>>> from hypothesis import HealthCheck, given, settings
>>> from mcpn.net.compose import compose
>>> @settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
... @given(missions(max_objectives=2))
... def composes(mission):
...     compose(mission)
>>> composes()
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

try:
    from hypothesis import strategies as st
except ImportError as error:
    raise ImportError("mcpn.testing needs hypothesis: pip install 'mcpn[testing]'") from error

from mcpn.mission.model import (
    FAIL,
    SUCCEED,
    Activity,
    Alternative,
    Block,
    DeclaredEvent,
    Each,
    Handler,
    Hardware,
    Mission,
    Objective,
    Parallel,
    Parameter,
    Protocol,
    Recursive,
    Robot,
    Software,
    Use,
)
from mcpn.testing.names import awkwardly_named
from mcpn.testing.shape import PARAMETERS
from mcpn.testing.shape import Shape as Shape
from mcpn.testing.shown import register

register()

TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co")) | st.sampled_from("\t\n\r"),
    max_size=12,
)


@dataclass
class _Island:
    """A part of the robot that shares no resource with another; without disjoint branches, all of it.

    Args:
        number: Its rank.
        below: Its resources, each with all that its producer may need, itself included.
        groups: Its resources, each with those that the same activity produces.
        startable: Its activities that objectives may start.
    """

    number: int
    below: dict[str, frozenset[str]] = field(default_factory=dict)
    groups: dict[str, tuple[str, ...]] = field(default_factory=dict)
    startable: list[str] = field(default_factory=list)


class _Drawing:
    """Draws one mission, part by part; names are numbered."""

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        self.draw = draw
        self.shape = shape
        self.count = 0
        self.islands: list[_Island] = []
        self.activities: list[Activity] = []
        # Each protocol with the islands that it needs and how many elementary objectives it has.
        self.protocols: list[tuple[Protocol, list[_Island], int]] = []
        self.unused: list[str] = []
        # Hardware that one activity may use at a time; who uses it, where no other may at all.
        self.exclusive_hardware: set[str] = set()
        self.users: dict[str, str] = {}
        self.events: tuple[str, ...] = ()

    def number(self, low: int, high: int) -> int:
        return self.draw(st.integers(low, high))

    def chance(self) -> bool:
        return self.draw(st.booleans())

    def name(self, prefix: str) -> str:
        self.count += 1
        return f"{prefix}{self.count}"

    def description(self) -> str | None:
        return self.draw(st.none() | TEXTS) if self.shape.text else None

    def parameters(self) -> tuple[Parameter, ...]:
        if not self.shape.text or not self.chance():
            return ()
        unit = self.draw(st.none() | TEXTS)
        name = self.draw(st.sampled_from(PARAMETERS))
        return (Parameter(name=name, value=self.draw(TEXTS), unit=unit),)

    def value(self, least: float, most: float) -> float | None:
        return self.draw(st.none() | st.floats(least, most)) if self.shape.numbers else None

    def mission(self) -> Mission:
        hardware, software = self.resources()
        for i in range(self.number(len(self.islands), max(self.shape.activities, len(self.islands)))):
            self.startable(self.islands[i] if i < len(self.islands) else self.island())
        self.events = tuple(f"e{i}" for i in range(self.number(0, self.shape.events)))
        budget = self.shape.sections
        if self.shape.protocols and self.chance():
            blocks, size = self.series(1, self.islands, self.number(1, budget))
            protocol = Protocol(name=self.name("proto"), blocks=blocks, parameters=self.parameters())
            self.protocols.append((protocol, self.islands, size))
            self.unused.append(protocol.name)
        blocks, _ = self.series(self.shape.depth, self.islands, budget)
        return Mission(
            name="mission",
            description=self.description(),
            blocks=blocks,
            robots=(
                Robot(
                    name="robot",
                    hardware=hardware,
                    software=software,
                    activities=tuple(self.activities),
                    events=tuple(map(self.event, self.events)),
                ),
            ),
            protocols=tuple(protocol for protocol, _, _ in self.protocols),
            handlers=self.handlers([b.name for b in blocks]),
        )

    def event(self, name: str) -> DeclaredEvent:
        return DeclaredEvent(name=name, description=self.description(), rate=self.value(0, 1e6))

    def handlers(self, siblings: list[str]) -> tuple[Handler, ...]:
        """What a block that stands among some siblings does on events."""
        targets = st.sampled_from([SUCCEED, FAIL, *siblings])
        return tuple(
            Handler(
                event=event,
                goto=self.draw(targets),
                once=self.number(0, 3) == 0,
                description=self.description(),
            )
            for event in self.events
            if self.number(0, 2) == 0
        )

    # --- the robot -------------------------------------------------------------------------------------

    def island(self) -> _Island:
        return self.islands[self.number(0, len(self.islands) - 1)]

    def resources(self) -> tuple[tuple[Hardware, ...], tuple[Software, ...]]:
        hardware = tuple(self.hardware(f"h{i}") for i in range(self.number(1, self.shape.hardware)))
        self.exclusive_hardware = {h.name for h in hardware if not h.shared}
        islands = self.number(1, len(hardware)) if self.shape.disjoint_branches else 1
        self.islands = [_Island(i) for i in range(islands)]
        for i, h in enumerate(hardware):
            island = self.islands[i] if i < islands else self.island()
            island.below[h.name] = frozenset({h.name})
            island.groups[h.name] = (h.name,)
        software: list[Software] = []
        for i in range(self.number(0, self.shape.producers)):
            produced = tuple(f"s{i}{letter}" for letter in "abcd"[: self.number(1, self.shape.outputs)])
            island = self.island()
            producer = self.activity(f"producer{i}", island, produced)
            self.activities.append(producer)
            software += [
                Software(name=s, description=self.description(), exclusive=self.exclusive()) for s in produced
            ]
            needs = [island.below[k] for a in producer.alternatives for k in a.consumes]
            for s in produced:
                island.below[s] = frozenset(produced).union(*needs)
                island.groups[s] = produced
        return hardware, tuple(software)

    def exclusive(self) -> bool:
        return not self.shape.own_hardware and self.number(0, 3) == 0

    def hardware(self, name: str) -> Hardware:
        faulty = self.number(0, 4) > 0
        rates = (self.value(0, 1e6), self.value(0, 1e6)) if faulty else (None, None)
        return Hardware(
            name=name,
            faulty=faulty,
            shared=self.number(0, 1 if self.shape.own_hardware else 3) == 0,
            description=self.description(),
            failure_rate=rates[0],
            repair_rate=rates[1],
        )

    def startable(self, island: _Island) -> None:
        name = f"activity{len(self.activities)}"
        self.activities.append(self.activity(name, island, ()))
        island.startable.append(name)

    def activity(self, name: str, island: _Island, produces: tuple[str, ...]) -> Activity:
        ways: list[Alternative] = []
        for i in range(self.number(1, self.shape.alternatives)):
            # Fallbacks mostly use something else than what has failed.
            before = {k for way in ways for k in way.consumes}
            consumes = self.consumed(name, island, before, before if self.number(0, 3) else set())
            ways.append(Alternative(name=f"{name}_way{i}", consumes=consumes, parameters=self.parameters()))
        if len(ways) == 1 and self.chance():
            ways = [Alternative(name=name, consumes=ways[0].consumes)]  # the short form
        return Activity(
            name=name,
            produces=produces,
            switch_back=len(ways) > 1 and self.number(0, 3) == 0,
            alternatives=tuple(ways),
            parameters=self.parameters(),
            description=self.description(),
        )

    def consumed(
        self, activity: str, island: _Island, before: set[str], avoided: set[str]
    ) -> tuple[str, ...]:
        chosen: list[str] = []
        for _ in range(self.draw(st.sampled_from([0, 1, 1, 1, 2, 2]))):
            left = [
                k
                for k in island.below
                if self.may_join(island, k, chosen) and self.may_follow(island, k, before)
            ]
            if self.shape.own_hardware:
                left = [k for k in left if self.users.get(k, activity) == activity]
            left = [k for k in left if k not in avoided] or left
            # What a supplier of this very alternative may take too, itself or through others.
            under = frozenset[str]().union(*(island.below[k] for k in chosen))
            near = [k for k in left if any(not under.isdisjoint(island.below[j]) for j in island.groups[k])]
            if near and self.chance():
                left = near
            # Chains of activities come of software alone.
            made = [k for k in left if k.startswith("s")]
            if made and self.chance():
                left = made
            if left:
                chosen.append(self.draw(st.sampled_from(left)))
        self.users |= {k: activity for k in chosen if k in self.exclusive_hardware}
        return tuple(chosen)

    def may_join(self, island: _Island, resource: str, chosen: list[str]) -> bool:
        """Whether a resource may be consumed beside the chosen ones: disjoint below, or of one producer."""
        if not self.shape.disjoint_branches:
            return resource not in chosen
        return resource not in chosen and all(
            resource in island.groups[k] or island.below[resource].isdisjoint(island.below[k]) for k in chosen
        )

    def may_follow(self, island: _Island, resource: str, before: set[str]) -> bool:
        """Whether a resource may be consumed after other alternatives, whose producers may be ending yet."""
        if not self.shape.disjoint_branches:
            return True
        return all(
            (resource == k and len(island.below[k]) == 1)
            or island.below[resource].isdisjoint(island.below[k])
            for k in before
        )

    # --- blocks ----------------------------------------------------------------------------------------
    # Each draws within islands and a budget of elementary objectives, and says how many it took.

    def series(self, depth: int, islands: list[_Island], budget: int) -> tuple[tuple[Block, ...], int]:
        blocks: list[Block] = []
        taken = 0
        for left in range(self.number(1, min(self.shape.objectives, budget)) - 1, -1, -1):
            block, size = self.block(depth, islands, budget - taken - left)
            blocks.append(block)
            taken += size
        return tuple(self.routed(block, i, blocks) for i, block in enumerate(blocks)), taken

    def routed(self, block: Block, index: int, blocks: list[Block]) -> Block:
        targets = [None, SUCCEED, FAIL, *(b.name for b in blocks[0 if self.shape.loops else index + 1 :])]
        route = st.sampled_from(targets)
        success, failure = self.draw(st.none() | route), self.draw(route)
        handlers = self.handlers([b.name for b in blocks])
        return replace(block, success=success, failure=failure, handlers=handlers)

    def block(self, depth: int, islands: list[_Island], budget: int) -> tuple[Block, int]:
        # The rounds of a block follow one another: where nothing contends they do not either.
        apart = self.shape.own_hardware or self.shape.shared_activities
        if not self.shape.rounds or not apart or self.number(0, 3):
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

    def once(self, depth: int, islands: list[_Island], budget: int) -> tuple[Block, int]:
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
            return Parallel(name=self.name("par"), blocks=blocks), size
        return self.objective(islands), 1

    def usable(self, islands: list[_Island], budget: int) -> list[tuple[Protocol, int]]:
        return [
            (protocol, size)
            for protocol, needed, size in self.protocols
            if size <= budget
            and all(island in islands for island in needed)
            and (self.shape.shared_activities or protocol.name in self.unused)
        ]

    def use(self, protocol: Protocol, size: int) -> tuple[Block, int]:
        if protocol.name in self.unused:
            self.unused.remove(protocol.name)
        overrides = protocol.parameters if self.shape.text and self.chance() else ()
        parameters = tuple(replace(p, value=self.draw(TEXTS)) for p in overrides)
        return Use(name=self.name("use"), protocol=protocol.name, parameters=parameters), size

    def objective(self, islands: list[_Island]) -> Objective:
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
        return Objective(
            name=self.name("obj"),
            activities=tuple(activities),
            parameters=self.parameters(),
            description=self.description(),
            duration=self.value(1e-6, 1e6),
            failure_probability=self.value(0, 1),
        )

    def children(self, depth: int, islands: list[_Island], budget: int) -> tuple[tuple[Block, ...], int]:
        apart = self.shape.disjoint_branches
        number = self.number(1, min(2, budget, len(islands) if apart else 2))
        shares = [islands] * number
        if apart and number == 2:
            cut = self.number(1, len(islands) - 1)
            shares = [islands[:cut], islands[cut:]]
        children: list[Block] = []
        taken = 0
        for i, share in enumerate(shares):
            child, size = self.block(depth, share, budget - taken - (number - 1 - i))
            if isinstance(child, Parallel):
                child = Recursive(name=self.name("rec"), blocks=(child,))
            mandatory = i == 0 or self.chance()
            children.append(replace(child, mandatory=mandatory, handlers=self.handlers([])))
            taken += size
        return tuple(children), taken


def missions(shape: Shape | None = None, **bounds: int | bool) -> st.SearchStrategy[Mission]:
    """Valid missions.

    Args:
        shape: Bounds on the missions; the defaults of :class:`Shape` keep most under 100,000 markings.
        **bounds: Bounds to replace in it, by name (``max_`` or ``allow_`` before a name is allowed).

    Returns:
        A strategy. Unless ``disjoint_branches`` is set, its missions may contend for resources;
        :attr:`mcpn.mission.facts.usage.Usage.contentions` says whether one does.
    """
    fields = {key.removeprefix("max_").removeprefix("allow_"): value for key, value in bounds.items()}
    chosen = replace(shape or Shape(), **fields)  # type: ignore[arg-type]

    @st.composite
    def drawn(draw: st.DrawFn) -> Mission:
        mission = _Drawing(draw, chosen).mission()
        return draw(awkwardly_named(mission)) if chosen.awkward_names else mission

    return drawn()
