"""Missions whose branches share data: producers go on, stop and change their alternatives beside one another.

These are rare among missions of any shape. Nothing in them contends: hardware belongs to one activity or is
shared, and no two branches start the same activity. A branch goes on while another needs the same producer,
consumers leave and come on one failure or on one declared event, and a producer has several products.
"""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.model import FAIL, SUCCEED, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import (
    BOOLEAN_VALUES,
    Activity,
    Alternative,
    DeclaredEvent,
    Fact,
    FactChange,
    Hardware,
    Robot,
    Software,
)

EVENT = "event"


FACT = "fact"


@st.composite
def data_sharing_missions(draw: st.DrawFn, *, facts: bool = False) -> Mission:
    """One parallel block over one or two producers that its branches share.

    Args:
        draw: Given by hypothesis.
        facts: Whether objectives change a fact as they begin or end, and alternatives require it.

    Returns:
        A strategy of missions with at most a few hundred stable states, in which nothing contends.
    """
    hardware = [Hardware(name="common", shared=True)]
    activities: list[Activity] = []
    made: list[str] = []
    for i in range(draw(st.integers(1, 2))):
        own = Hardware(name=f"h{i}")
        hardware.append(own)
        products = tuple(f"s{i}{letter}" for letter in "ab"[: draw(st.integers(1, 2))])
        spare = draw(st.sampled_from([(), (), ("common",), *((s,) for s in made)]))
        ways = (
            Alternative(name="best", consumes=(own.name,), requires=draw(_requires(facts))),
            Alternative(name="spare", consumes=spare),
        )
        back = draw(st.integers(0, 5)) == 0
        activities.append(
            Activity(name=f"producer{i}", produces=products, alternatives=ways, switch_back=back)
        )
        made += products
    branches = []
    for i in range(draw(st.integers(2, 3 if len(made) < 3 else 2))):
        names = [f"a{i}{letter}" for letter in "xy"[: draw(st.integers(1, 2))]]
        wanted = st.sampled_from(
            [(s,) for s in made] * 2 + [("common",), ("common", made[0]), (), tuple(made)]
        )
        for name in names:
            tried = draw(st.lists(wanted, min_size=1, max_size=2, unique=True))
            each = tuple(
                Alternative(name=f"{name}{n}", consumes=way, requires=draw(_requires(facts)))
                for n, way in enumerate(tried)
            )
            activities.append(Activity(name=name, alternatives=each))
        blocks = tuple(
            Objective(
                name=f"o{i}{letter}",
                activities=tuple(draw(st.sampled_from([names, names[:1], names[-1:]]))),
                failure=draw(st.sampled_from([None, None, SUCCEED])),
                handlers=draw(_handlers),
                sets=draw(_changes(facts)),
            )
            for letter in "xyz"[: draw(st.integers(1, 2))]
        )
        branches.append(Recursive(name=f"r{i}", blocks=blocks, retries=draw(st.sampled_from([0, 0, 0, 1]))))
    robot = Robot(
        name="robot",
        hardware=tuple(hardware),
        software=tuple(Software(name=s) for s in made),
        activities=tuple(activities),
        events=(DeclaredEvent(name=EVENT),),
        facts=(Fact(name=FACT),) if facts else (),
    )
    return Mission(name="mission", robots=(robot,), blocks=(Parallel(name="both", blocks=tuple(branches)),))


def _requires(facts: bool) -> st.SearchStrategy[tuple[str, ...]]:
    """What an alternative requires."""
    return st.sampled_from([(), (FACT,), (f"!{FACT}",)]) if facts else st.just(())


def _changes(facts: bool) -> st.SearchStrategy[tuple[FactChange, ...]]:
    """How an objective changes the fact, if it does."""
    if not facts:
        return st.just(())
    drawn = st.builds(
        FactChange,
        fact=st.just(FACT),
        to=st.sampled_from(BOOLEAN_VALUES),
        on=st.sampled_from(["success", "success", "failure", "start"]),
    )
    return drawn.map(lambda change: (change,)) | st.just(())


_handlers = st.sampled_from([(), (), (), SUCCEED, FAIL]).map(
    lambda goto: (Handler(event=EVENT, goto=goto),) if isinstance(goto, str) else ()
)
