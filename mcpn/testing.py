"""Hypothesis strategies for users of mcpn: valid missions of any shape, small enough to be explored in full.

>>> from hypothesis import given
>>> from mcpn.net.compose import compose
>>> @given(missions(max_objectives=2))
... def composes(mission):
...     compose(mission)
>>> composes()
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from hypothesis import strategies as st

from mcpn.mission.model import (
    FAIL,
    SUCCEED,
    Activity,
    Alternative,
    Block,
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


@dataclass(frozen=True)
class Shape:
    """Bounds on generated missions.

    Args:
        hardware: Most hardware resources.
        producers: Most activities that produce; later ones may consume what earlier ones produce.
        alternatives: Most alternatives of an activity.
        outputs: Most resources that one activity produces.
        activities: Most activities that objectives start.
        objectives: Most blocks in a series.
        depth: How deep blocks nest.
        parallel: Whether parallel blocks are drawn.
        protocols: Whether protocols are drawn and used.
        loops: Whether routes may go back.
        text: Whether descriptions and parameters are drawn.
    """

    hardware: int = 3
    producers: int = 3
    alternatives: int = 3
    outputs: int = 2
    activities: int = 4
    objectives: int = 3
    depth: int = 2
    parallel: bool = True
    protocols: bool = True
    loops: bool = True
    text: bool = False


TEXTS = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co")), max_size=12)


class _Drawing:
    """Draws one mission, part by part; names are numbered."""

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        self.draw = draw
        self.shape = shape
        self.count = 0
        self.protocols: list[Protocol] = []
        self.startable: list[str] = []

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
        return (Parameter(name=self.name("par"), value=self.draw(TEXTS), unit=unit),)

    def mission(self) -> Mission:
        robot = self.robot()
        if self.shape.protocols and self.chance():
            blocks = self.series(1)
            name = self.name("proto")
            self.protocols.append(Protocol(name=name, blocks=blocks, parameters=self.parameters()))
        blocks = self.series(self.shape.depth)
        return Mission(
            name="mission",
            description=self.description(),
            blocks=blocks,
            robots=(robot,),
            protocols=tuple(self.protocols),
        )

    def robot(self) -> Robot:
        shape = self.shape
        hardware = tuple(
            Hardware(name=f"h{i}", faulty=self.number(0, 4) > 0, description=self.description())
            for i in range(self.number(1, shape.hardware))
        )
        resources = [h.name for h in hardware]
        software, activities = [], []
        for i in range(self.number(0, shape.producers)):
            produced = tuple(f"s{i}{letter}" for letter in "abcd"[: self.number(1, shape.outputs)])
            activities.append(self.activity(f"producer{i}", resources, produced))
            software += [Software(name=s, description=self.description()) for s in produced]
            resources += produced
        for i in range(self.number(1, shape.activities)):
            activities.append(self.activity(f"activity{i}", resources, ()))
            self.startable.append(f"activity{i}")
        return Robot(name="robot", hardware=hardware, software=tuple(software), activities=tuple(activities))

    def activity(self, name: str, resources: list[str], produces: tuple[str, ...]) -> Activity:
        alternatives = []
        for i in range(self.number(1, self.shape.alternatives)):
            size = min(self.draw(st.sampled_from([0, 1, 1, 1, 2])), len(resources))
            consumes = st.lists(st.sampled_from(resources), min_size=size, max_size=size, unique=True)
            alternatives.append(
                Alternative(
                    name=f"{name}_way{i}", consumes=tuple(self.draw(consumes)), parameters=self.parameters()
                )
            )
        return Activity(
            name=name,
            produces=produces,
            alternatives=tuple(alternatives),
            parameters=self.parameters(),
            description=self.description(),
        )

    def series(self, depth: int) -> tuple[Block, ...]:
        blocks = [self.block(depth) for _ in range(self.number(1, self.shape.objectives))]
        return tuple(self.routed(block, i, blocks) for i, block in enumerate(blocks))

    def routed(self, block: Block, index: int, blocks: list[Block]) -> Block:
        targets = [None, SUCCEED, FAIL, *(b.name for b in blocks[0 if self.shape.loops else index + 1 :])]
        route = st.sampled_from(targets)
        return replace(block, success=self.draw(st.none() | route), failure=self.draw(route))

    def block(self, depth: int) -> Block:
        kinds = ["objective", "objective"]
        kinds += ["recursive"] if depth else []
        kinds += ["parallel"] if depth and self.shape.parallel else []
        kinds += ["use"] if self.protocols else []
        kind = self.draw(st.sampled_from(kinds))
        if kind == "use":
            protocol = self.draw(st.sampled_from(self.protocols))
            return Use(name=self.name("use"), protocol=protocol.name)
        if kind == "recursive":
            return Recursive(
                name=self.name("rec"), blocks=self.series(depth - 1), parameters=self.parameters()
            )
        if kind == "parallel":
            return Parallel(name=self.name("par"), blocks=self.children(depth - 1))
        activities = st.lists(st.sampled_from(self.startable), min_size=1, max_size=2, unique=True)
        return Objective(
            name=self.name("obj"),
            activities=tuple(self.draw(activities)),
            parameters=self.parameters(),
            description=self.description(),
        )

    def children(self, depth: int) -> tuple[Block, ...]:
        children: list[Block] = []
        for i in range(self.number(1, 2)):
            child = self.block(depth)
            if isinstance(child, Parallel):
                child = Recursive(name=self.name("rec"), blocks=(child,))
            children.append(replace(child, mandatory=i == 0 or self.chance()))
        return tuple(children)


def missions(shape: Shape | None = None, **bounds: int | bool) -> st.SearchStrategy[Mission]:
    """Valid missions.

    Args:
        shape: Bounds on the missions; the defaults of :class:`Shape` keep most under 100,000 markings.
        **bounds: Bounds to replace in it, by name (``max_`` before a name is allowed).

    Returns:
        A strategy. Its missions may contend for resources; :attr:`mcpn.mission.usage.Usage.contentions` says
        whether one does.
    """
    fields = {key.removeprefix("max_"): value for key, value in bounds.items()}
    chosen = replace(shape or Shape(), **fields)  # type: ignore[arg-type]

    @st.composite
    def drawn(draw: st.DrawFn) -> Mission:
        return _Drawing(draw, chosen).mission()

    return drawn()
