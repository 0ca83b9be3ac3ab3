"""A small mission for each form of template: where a drawn mission shows nothing, one of these does."""

from __future__ import annotations

from dataclasses import replace

from mcpn.mission.model import (
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
)
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Fact, FactChange, Fault, Software
from mcpn.testing.by_hand import activity, hw, mission, robot


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


def _requiring(name: str, first: tuple[str, ...], then: tuple[str, ...], fact: str) -> Activity:
    """An activity whose first alternative requires a fact, and whose second requires that it is not so."""
    drawn = activity(name, first, then)
    one, other = drawn.alternatives
    both = (replace(one, requires=(fact,)), replace(other, requires=(f"!{fact}",)))
    return replace(drawn, alternatives=both)


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
    "facts": mission(
        replace(
            robot(hw("h"), _requiring("a", ("h",), (), "lit"), activity("b", ()), events=("dusk",)),
            facts=(Fact(name="lit", initial="true"), Fact(name="way", values=("left", "right"))),
            events=(DeclaredEvent(name="dusk", sets=(FactChange(fact="lit", to="false"),)),),
        ),
        replace(
            objective("x", "a"),
            sets=(FactChange(fact="way", to="right", on="success"),),
            routes=(FactRoute(when=("!lit",), goto="y", on="failure"),),
        ),
        replace(objective("y", "b"), sets=(FactChange(fact="lit", to="true", on="start"),)),
        Parallel(
            name="both",
            blocks=(
                replace(objective("u", "a"), sets=(FactChange(fact="way", to="left", on="failure"),)),
                replace(objective("v", "b"), sets=(FactChange(fact="lit", to="false", on="start"),)),
            ),
            routes=(FactRoute(when=("way=left",), goto="fail", on="success"),),
        ),
    ),
    "left by facts": mission(
        replace(
            robot(hw("h"), activity("a", ("h",)), activity("b", ()), events=("dusk",)),
            facts=(Fact(name="lit", initial="true"),),
            events=(DeclaredEvent(name="dusk", sets=(FactChange(fact="lit", to="false"),)),),
        ),
        Recursive(
            name="walk",
            success="succeed",
            handlers=(Handler(when=("!lit",), goto="shade"),),
            blocks=(
                replace(objective("x", "a"), sets=(FactChange(fact="lit", to="false", on="success"),)),
                objective("y", "b"),
            ),
        ),
        replace(objective("shade", "b"), sets=(FactChange(fact="lit", to="true", on="success"),)),
    ),
    "found late": mission(
        robot(
            (replace(hw("h")[0], detected="late"), *hw("g")),
            activity("a", ("h",), ("g",)),
            replace(activity("look", ()), detects=("h",)),
            events=("leave",),
        ),
        replace(objective("x", "a", "look", failure="y"), handlers=(Handler(event="leave", goto="y"),)),
        objective("y", "a"),
    ),
    "found late by another": mission(
        robot(
            (replace(hw("h")[0], detected="late"),),
            activity("p", ("h",), produces=("s",)),
            activity("a", ("s",)),
            activity("b", ("s",)),
            replace(activity("look", ()), detects=("h",)),
        ),
        Parallel(name="all", blocks=(objective("u", "a"), objective("v", "b"), objective("w", "look"))),
    ),
    "kept": mission(
        replace(
            robot(
                hw("h", "g"),
                activity("p", ("h",), ("g",), produces=("s",)),
                activity("a", ("s",)),
                _requiring("b", ("s",), (), "lit"),
            ),
            facts=(Fact(name="lit", initial="true"),),
        ),
        Parallel(
            name="both",
            blocks=(
                Recursive(
                    name="r",
                    blocks=(
                        replace(objective("x", "a"), sets=(FactChange(fact="lit", to="false"),)),
                        objective("y", "a"),
                    ),
                ),
                objective("z", "b"),
            ),
        ),
    ),
    "crashes": mission(
        robot(
            hw("h"),
            replace(activity("a", ("h",), ()), faulty=True),
            replace(activity("b", ()), faulty=True, recovers=False),
        ),
        objective("x", "a", failure="y"),
        objective("y", "b"),
    ),
    "hardware that is lost": mission(
        replace(
            robot(
                (replace(hw("h")[0], repairable=False), replace(hw("g")[0], initial="oos")),
                activity("a", ("h",), ("g",)),
            ),
            faults=(Fault(name="water", affects=("h", "g")),),
        ),
        objective("x", "a"),
    ),
    "interrupted": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ()), events=("leak", "low")),
        replace(
            objective("x", "a"),
            handlers=(Handler(event="leak", goto="y", once=True), Handler(event="low", goto="x")),
        ),
        Parallel(
            name="y",
            failure="x",
            handlers=(Handler(event="leak", goto="fail"),),
            blocks=(
                objective("u", "a"),
                replace(objective("v", "b"), handlers=(Handler(event="low", goto="succeed"),)),
            ),
        ),
    ),
    "ends before all": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ()), activity("c", ())),
        Parallel(
            name="early",
            success_when="any",
            failure_when="any",
            failure="over",
            blocks=(objective("u", "a"), objective("v", "b")),
        ),
        Parallel(
            name="over",
            abort="succeed",
            failure_when="2",
            impossible="fails",
            blocks=(
                Recursive(name="r", blocks=(objective("m", "a", failure="abort"),)),
                objective("n", "b"),
                objective("o", "c"),
            ),
        ),
    ),
    "its time is over": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ())),
        replace(objective("x", "a"), timeout=5.0, timeout_goto="y", failure="fail"),
        objective("y", "b"),
    ),
    "fails for reasons": mission(
        robot(hw("h"), replace(activity("a", ("h",)), failures=("lost",)), activity("b", ())),
        Recursive(
            name="r",
            blocks=(replace(objective("x", "a"), failures=("stuck",), retries=1),),
            routes=(FactRoute(on="failure", reason="lost", goto="y"),),
        ),
        objective("y", "b"),
    ),
    "pauses": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ()), events=("rain",)),
        replace(objective("x", "a"), handlers=(Handler(event="rain", pause="shelter"),)),
        Parallel(
            name="both",
            handlers=(Handler(event="rain", pause="shelter", once=True),),
            blocks=(objective("u", "a"), objective("v", "b")),
        ),
        objective("shelter", "b"),
    ),
    "pauses in a branch": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ()), activity("c", ()), events=("rain", "stop")),
        Parallel(
            name="all",
            handlers=(Handler(event="stop", pause="shelter"),),
            blocks=(
                Recursive(
                    name="r",
                    blocks=(
                        Parallel(
                            name="both",
                            handlers=(Handler(event="rain", pause="inside"),),
                            blocks=(objective("u", "a"), objective("v", "b")),
                        ),
                        objective("inside", "b"),
                    ),
                ),
                objective("w", "c"),
            ),
        ),
        objective("shelter", "b"),
    ),
    "contends": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ("h",)), activity("c", ()), events=("stop",)),
        Parallel(
            name="both",
            handlers=(Handler(event="stop", goto="succeed"),),
            blocks=(
                Recursive(
                    name="r",
                    blocks=(
                        objective("z", "c", failure="w"),
                        objective("x", "a", failure="x"),
                        objective("w", "b"),
                    ),
                ),
                objective("y", "b"),
            ),
        ),
    ),
    "makes two": mission(
        robot(
            hw("h", "g"),
            activity("p", ("h",), ("g",), produces=("s", "t")),
            activity("a", ("s",)),
            activity("b", ("t",), ()),
            events=("stop",),
        ),
        Parallel(
            name="both",
            blocks=(
                Recursive(name="r", blocks=(objective("x", "a"), objective("z", "a"))),
                replace(objective("y", "b"), handlers=(Handler(event="stop", goto="succeed"),)),
            ),
        ),
    ),
    "guarded and recovered": mission(
        replace(
            robot(
                hw("h"),
                activity("a", ("h",)),
                activity("b", ()),
                replace(activity("c", ()), requires=("lit",)),
                events=("dusk",),
            ),
            facts=(Fact(name="lit", initial="true"),),
            events=(DeclaredEvent(name="dusk", sets=(FactChange(fact="lit", to="false"),)),),
        ),
        objective("x", "b", failure="y"),
        replace(objective("y", "a"), guards=(EntryGuard(when=("lit",), otherwise="z"),)),
        replace(objective("z", "c", failure="fail"), recover="back_off", times=2, success="succeed"),
        objective("back_off", "b"),
    ),
    "done in rounds": replace(
        mission(
            robot(hw("h"), activity("a", ("h",)), activity("b", ()), events=("home",)),
            Each(name="site", values=("n", "s"), parameter="where", blocks=(objective("x", "a"),)),
            replace(Use(name="u", protocol="twice"), retries=1),
            objective("back", "b"),
        ),
        protocols=(Protocol(name="twice", blocks=(replace(objective("y", "b"), repeat=2),)),),
        handlers=(Handler(event="home", goto="back", once=True),),
    ),
    "lost for good": mission(
        replace(
            robot(
                (*hw("h"), *hw("g", faulty=False)),
                Activity(
                    name="a",
                    alternatives=(
                        Alternative(name="by_h", consumes=("h",), faulty=True, recovers=False),
                        Alternative(name="by_g", consumes=("g",), faulty=True),
                    ),
                ),
                activity("b", ()),
            ),
            faults=(Fault(name="water", affects=("h",), repairable=False),),
        ),
        Parallel(name="both", blocks=(objective("x", "a"), replace(objective("y", "b"), mandatory=False))),
    ),
    "reserved": mission(
        replace(
            robot(
                hw("h"), activity("p", ("h",), produces=("s",)), activity("a", ("s",)), activity("b", ("s",))
            ),
            software=(Software(name="s", exclusive=True),),
        ),
        objective("x", "a"),
        objective("y", "b"),
    ),
    "waits for what is made": mission(
        replace(
            robot(
                hw("h", "g"),
                activity("p", ("h",), produces=("s",)),
                activity("c", ("h",)),
                activity("b", ()),
                replace(activity("a", ("s", "g"), ()), requires=("lit",)),
                events=("dusk",),
            ),
            facts=(Fact(name="lit", initial="true"),),
            events=(DeclaredEvent(name="dusk", sets=(FactChange(fact="lit", to="false"),)),),
        ),
        Parallel(
            name="both",
            blocks=(
                objective("y", "c"),
                Recursive(name="r", blocks=(objective("w", "b"), objective("x", "a"))),
            ),
        ),
    ),
    "counts failures": mission(
        robot(hw("h"), activity("a", ("h",)), activity("b", ()), activity("c", ()), events=("end",)),
        Parallel(
            name="of_three",
            success_when="2",
            failure_when="2",
            failure="of_two",
            blocks=(objective("u", "a"), objective("v", "b"), objective("w", "c")),
        ),
        Parallel(
            name="of_two",
            success_when="1",
            failure_when="1",
            blocks=(
                replace(objective("x", "b"), handlers=(Handler(event="end", goto="fail"),)),
                replace(objective("y", "c"), handlers=(Handler(event="end", goto="succeed"),)),
                objective("z", "a"),
            ),
        ),
    ),
    "happens once inside": replace(
        mission(
            robot(hw("h"), activity("a", ("h",)), activity("b", ()), events=("rain",)),
            replace(objective("x", "a"), handlers=(Handler(event="rain", goto="x", once=True),)),
            Parallel(
                name="both",
                handlers=(Handler(event="rain", goto="x", once=True),),
                blocks=(objective("u", "a"), objective("v", "b")),
            ),
            objective("home", "b"),
        ),
        handlers=(Handler(event="rain", goto="home"),),
    ),
}
"""A producer that does not serve; one that does; an activity that gives back and asks again in one reaction;
gates; hardware of several; an activity that stops as it starts, and returns; many errors at a time. Then each
other element of the language once."""

NEEDED_WHOLE = ("retried", "asks again", "shared hardware", "branches", "driver")
"""Those in which every transition that the paper's templates draw fires in some run."""
