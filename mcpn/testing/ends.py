"""Nested parallel blocks of which one event, or one fact, ends several branches at the same moment."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from hypothesis import strategies as st

from mcpn.mission.model import ABORT, FAIL, SUCCEED, Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Fact, FactChange, Robot

MOST_OBJECTIVES = 6
"""In a block: so many that run at the same time have some hundred states."""

By = Literal["event", "fact"]


class _Drawing:
    """Draws one mission.

    Args:
        draw: Given by hypothesis.
        by: What ends branches.
    """

    def __init__(self, draw: st.DrawFn, by: By) -> None:
        self.draw = draw
        self.by: By = by
        self.activities: list[str] = []
        self.blocks = 0

    def of(self, *values: str) -> str:
        """One of some words; one that stands twice comes twice as often."""
        return self.draw(st.sampled_from(values))

    def ended(self, *siblings: str) -> tuple[Handler, ...]:
        """What ends a block, mostly."""
        if self.of("ended", "goes on") == "goes on":
            return ()
        goto = self.of(SUCCEED, SUCCEED, FAIL, FAIL, ABORT, *siblings)
        return (Handler(event="e", goto=goto) if self.by == "event" else Handler(when=("f",), goto=goto),)

    def objective(self, *siblings: str) -> Objective:
        """An objective with an activity of its own; its success may make the fact true."""
        name, activity = f"o{len(self.activities)}", f"a{len(self.activities)}"
        self.activities.append(activity)
        sets = FactChange(fact="f", to="true", on=self.of("success", "failure"))
        changes = self.by == "fact" and self.of("never", "never", "sets") == "sets"
        return Objective(
            name=name,
            activities=(activity,),
            handlers=self.ended(*siblings),
            sets=(sets,) if changes else (),
        )

    def parallel(self, depth: int) -> Parallel:
        """A block of two or three children, some of which hold such a block."""
        self.blocks += 1
        name, count = f"p{self.blocks}", int(self.of("2", "2", "3"))
        children = tuple(self.child(depth, mandatory=number == 0) for number in range(count))
        numbers = [str(number) for number in range(1, count + 1)]
        return Parallel(
            name=name,
            blocks=children,
            success_when=self.of("any", "any", "all", "all", *numbers),
            failure_when=self.of("any", "any", "all", *numbers),
            impossible=self.of("waits", "waits", "waits", "fails"),
        )

    def child(self, depth: int, *, mandatory: bool) -> Block:
        """An objective, or a series of a block and what it may lead to."""
        block: Block = self.objective()
        if depth and len(self.activities) < MOST_OBJECTIVES - 1 and self.of("block", "objective") == "block":
            block = self.series(depth)
        mandatory = mandatory or self.of("yes", "no") == "yes"
        return replace(block, mandatory=mandatory, abort=self.of(ABORT, ABORT, SUCCEED, FAIL))

    def series(self, depth: int) -> Recursive:
        """A block, and an objective that its ends may lead to."""
        inner, after = self.parallel(depth - 1), self.objective()
        ends = SUCCEED, FAIL, ABORT, after.name
        inner = replace(inner, success=self.of(*ends), failure=self.of(*ends), abort=self.of(*ends))
        around = f"r{self.blocks}_{len(self.activities)}"
        return Recursive(name=around, blocks=(inner, after), handlers=self.ended())

    def mission(self) -> Mission:
        """A block, and where each of its ends leads; one objective is entered after its failure."""
        outer, after = self.parallel(2), self.objective()
        outer = replace(
            outer, success=SUCCEED, failure=self.of(after.name, FAIL), abort=self.of(ABORT, after.name)
        )
        activities = tuple(Activity(name=a, alternatives=(Alternative(name=a),)) for a in self.activities)
        sets = FactChange(fact="f", to="true"), FactChange(fact="f", to="false")
        words = tuple(DeclaredEvent(name=n, sets=(s,)) for n, s in zip("wv", sets, strict=True))
        robot = Robot(
            name="robot",
            activities=activities,
            facts=(Fact(name="f"),) if self.by == "fact" else (),
            events=words if self.by == "fact" else (DeclaredEvent(name="e"),),
        )
        return Mission(name="mission", robots=(robot,), blocks=(outer, after))


@st.composite
def nested_ends(draw: st.DrawFn, by: By | None = None) -> Mission:
    """Blocks in blocks whose branches end at the same moment, each in its own way.

    Args:
        draw: Given by hypothesis.
        by: Whether a declared event ends them, or a fact that becomes true; either by default.
    """
    either: st.SearchStrategy[By] = st.sampled_from(("event", "fact"))
    return _Drawing(draw, draw(either) if by is None else by).mission()
