"""Missions in which an activity, its suppliers, the one beside it and the next objective want the same.

These are rare among missions of any shape. In them a section stops while a producer still looks for another
alternative, what the producer takes last is what the next section asks for first, and a consumer comes
while another one goes.
"""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.model import Mission, Objective
from mcpn.mission.robot import Activity, Alternative, Hardware, Robot, Software


@st.composite
def stacked_missions(draw: st.DrawFn) -> Mission:
    """Two objectives one after the other over a stack of producers with a fallback each.

    Args:
        draw: Given by hypothesis.

    Returns:
        A strategy of missions with at most a few thousand markings.
    """
    below = [f"h{i}" for i in range(draw(st.integers(2, 3)))]

    def one_of_two(name: str, resources: list[str]) -> tuple[Alternative, ...]:
        chosen = draw(st.permutations(resources))[:2]
        return tuple(Alternative(name=f"{name}_{i}", consumes=(one,)) for i, one in enumerate(chosen))

    activities: list[Activity] = []
    made: list[str] = []
    for i in range(draw(st.integers(1, 2))):
        name, product = f"producer{i}", f"s{i}"
        activities.append(
            Activity(name=name, produces=(product,), alternatives=one_of_two(name, below + made))
        )
        made.append(product)
    wanted = draw(st.permutations(below + made))[: draw(st.integers(1, 3))]
    activities.append(
        Activity(name="first", alternatives=(Alternative(name="first", consumes=tuple(wanted)),))
    )
    activities.append(Activity(name="beside", alternatives=one_of_two("beside", below + made)))
    then = draw(st.sampled_from(below + made))
    activities.append(Activity(name="then", alternatives=(Alternative(name="then", consumes=(then,)),)))
    shared = draw(st.sets(st.sampled_from(below)))
    robot = Robot(
        name="robot",
        hardware=tuple(Hardware(name=h, shared=h in shared) for h in below),
        software=tuple(Software(name=s) for s in made),
        activities=tuple(activities),
    )
    together = draw(st.sampled_from([("first",), ("first", "beside"), ("beside", "first")]))
    blocks = (Objective(name="one", activities=together), Objective(name="two", activities=("then",)))
    return Mission(name="mission", blocks=blocks, robots=(robot,))
