"""A small mission for each form of template: where a drawn mission shows nothing, one of these does."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import Mission, Objective, Parallel
from mcpn.testing.small import activity, hw, mission, robot


def wide(number: int) -> Mission:
    """An activity that consumes many data, each of hardware of its own or of the datum before."""
    names = [f"h{i}" for i in range(number)]
    makers = [
        activity(f"make{i}", (h,), *([(f"d{i - 1}",)] if i else []), produces=(f"d{i}",))
        for i, h in enumerate(names)
    ]
    fuse = activity("fuse", tuple(f"d{i}" for i in range(number)), ("d0",))
    return mission(robot(hw(*names), *makers, fuse), Objective(name="x", activities=("fuse",)))


def objective(name: str, *activities: str, failure: str | None = None) -> Objective:
    """An objective by its activities."""
    return Objective(name=name, activities=activities, failure=failure)


SHARED_C = replace(hw("c")[0], shared=True)

MISSIONS: dict[str, Mission] = {
    "driver": mission(
        robot(
            hw("h", "g", "w"),
            activity("drive", ("h",), ("g",), produces=("s",)),
            activity("go", ("s", "w"), ("w",)),
        ),
        objective("x", "go"),
        objective("y", "go"),
    ),
    "branches": mission(
        robot(
            hw("h", "g"),
            activity("p", ("h",), ("g",), produces=("s",)),
            activity("a", ("s",)),
            activity("b", ("s",), ()),
        ),
        Parallel(name="both", blocks=(objective("x", "a"), objective("y", "b"))),
    ),
    "asks again": mission(
        robot(hw("h", "c"), activity("p", ("h",), (), produces=("s",)), activity("a", ("c", "s"), ("s",))),
        objective("x", "a"),
    ),
    "one after the other": mission(
        robot(
            (*hw("h"), SHARED_C),
            activity("p", ("h",), ("c",), (), produces=("s",)),
            activity("a", ("c", "s"), ("s",)),
            activity("b", ("s", "c"), ("c",), ()),
        ),
        objective("x", "a", "b"),
        objective("y", "b"),
    ),
    "shared hardware": mission(
        robot((SHARED_C, *hw("h")), activity("a", ("c", "h")), activity("b", ("c",), ())),
        Parallel(name="both", blocks=(objective("x", "a"), objective("y", "b"))),
    ),
    "retried": mission(
        robot(hw("h", "g"), replace(activity("a", ("h",), ("g",)), switch_back=True)),
        objective("x", "a", failure="x"),
    ),
    "four data": wide(4),
}
"""A producer that does not serve; one that does; an activity that gives back and asks again in one reaction;
gates; hardware of several; an activity that stops as it starts, and returns; many errors at a time."""

NEEDED_WHOLE = ("retried", "asks again", "shared hardware", "branches", "driver")
"""Those in which every transition that the paper's templates draw fires in some run."""
