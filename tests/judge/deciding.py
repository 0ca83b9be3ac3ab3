"""Missions in which facts choose routes, and routes inside others: little else, so that each case counts."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import strategies as st

from mcpn.mission.model import Block, EntryGuard, FactRoute, Mission, Objective, Recursive
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Fact, FactChange, Robot

DOOR = st.sampled_from(["closed open", "closed ajar open", "closed ajar open stuck"]).map(
    lambda values: Fact(name="door", values=tuple(values.split()))
)
HELD = Fact(name="held")


@st.composite
def deciding(draw: st.DrawFn, guards: bool = False) -> Mission:
    """Blocks in blocks, with routes of conditions at each depth; events change the facts at any moment.

    With guards most blocks behind the first of a series have one or two.
    """
    door = draw(DOOR)
    words = [*(f"door={value}" for value in door.values), "held", "!held"]

    def condition() -> tuple[str, ...]:
        """One word, or one of each fact."""
        first = draw(st.sampled_from(words))
        other = [word for word in words if ("door" in word) != ("door" in first)]
        return (first, draw(st.sampled_from(other))) if draw(st.booleans()) else (first,)

    def routed(block: Block, targets: list[str]) -> Block:
        count = draw(st.integers(0, 3))
        on = st.sampled_from(["success", "success", "failure"])
        routes = tuple(
            FactRoute(when=condition(), goto=draw(st.sampled_from(targets)), on=draw(on))
            for _ in range(count)
        )
        return replace(block, routes=routes)

    def guarded(targets: list[str]) -> tuple[EntryGuard, ...]:
        """None, one, or one for each fact: no two that exclude each other."""
        count = draw(st.integers(0, 2))
        whens = [condition()] if count == 1 else [(draw(st.sampled_from(words[:-2])),), ("held",)][:count]
        return tuple(EntryGuard(when=when, otherwise=draw(st.sampled_from(targets))) for when in whens)

    def series(depth: int, prefix: str) -> tuple[Block, ...]:
        names = [f"{prefix}{letter}" for letter in "ab"[: draw(st.integers(1, 2))] + "c" * (not prefix)]
        blocks: list[Block] = []
        for index, name in enumerate(names):
            block: Block = Objective(name=name, activities=("go",))
            if depth and not index:
                block = Recursive(name=name, blocks=series(depth - 1, name))
            block = routed(block, ["succeed", "fail", *names[index + 1 :]])
            if guards and index:
                block = replace(block, guards=guarded(["succeed", "fail", *names[index + 1 :]]))
            blocks.append(block)
        return tuple(blocks)

    changes = [(door.name, value) for value in door.values] + [("held", "true"), ("held", "false")]
    chosen = draw(st.lists(st.sampled_from(changes), min_size=1, max_size=3, unique=True))
    events = tuple(
        DeclaredEvent(name=f"e{i}", sets=(FactChange(fact=fact, to=value),))
        for i, (fact, value) in enumerate(chosen)
    )
    go = Activity(name="go", alternatives=(Alternative(name="go"),))
    of = Robot(name="r", activities=(go,), facts=(door, HELD), events=events)
    return Mission(name="m", robots=(of,), blocks=series(draw(st.integers(1, 2)), ""))
