"""An abort that is reached by the failure of what should make the robot safe.

Such an abort is no safe end. So neither the verdict nor the cut sets of safe ends take a route's word for it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Generic

from mcpn.answers.verdicts.nominal import nominal_transitions
from mcpn.drawing.compose import MissionNet
from mcpn.nets.events import Event, What
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run, transitions_of


@dataclass(frozen=True, eq=False)
class Aborts(Generic[S]):
    """How a mission comes to its abort.

    Args:
        unsafe: The objectives that should make the robot safe and by whose failure it aborts, in document
            order.
        badly: By transition, the states from which it aborts by such a failure.
        well: By transition, the states from which it aborts by anything else.
    """

    unsafe: tuple[str, ...]
    badly: Mapping[int, S]
    well: Mapping[int, S]


def aborts(mission_net: MissionNet, space: Space[S]) -> Aborts[S]:
    """How a mission that can abort comes to its abort.

    An objective should make the robot safe if the mission aborts by its success; or if after its success
    objectives that succeed lead to abort, and never to success.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
    """
    assert mission_net.abort is not None, "it can abort"
    abort, success = (space.marked([end]) for end in (mission_net.abort, mission_net.success))
    into = dict(space.crossing(space.everything - abort, abort))
    carrying: dict[Event, list[int]] = {}
    for t, transition in enumerate(space.net.transitions):
        if transition.event is not None:
            carrying.setdefault(transition.event, []).append(t)
    failing = {
        section.name: [
            t for what in _FAILURES for t in carrying.get(Event(what, section.name), ()) if t in into
        ]
        for section in mission_net.graph.walk()
    }
    failing = {name: transitions for name, transitions in failing.items() if transitions}
    if not failing:
        return Aborts((), {}, into)
    nominal = nominal_transitions(mission_net)
    to_abort, to_success = (space.reaching(end, transitions=nominal) for end in (abort, success))

    def shelters(name: str) -> bool:
        succeeding = carrying.get(Event(What.SUCCESS, name), [])
        if any(t in into for t in succeeding):
            return True
        return bool(space.before(to_abort, succeeding)) and not space.before(to_success, succeeding)

    unsafe = tuple(name for name in failing if shelters(name))
    bad = {t for name in unsafe for t in failing[name]}
    badly, well = ({t: s for t, s in into.items() if (t in bad) is kind} for kind in (True, False))
    return Aborts(unsafe, badly, well)


_FAILURES = (What.FAILURE, What.TIMEOUT)


def abort_by_failure(
    mission_net: MissionNet, space: Space[S], *, settles: bool
) -> tuple[tuple[str, ...], Run | None]:
    """The objectives that should make the robot safe, and by whose failure the mission aborts.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
        settles: Whether it is the alternatives graph.

    Returns:
        The objectives in document order, and a run to the first that ends so.
    """
    found = aborts(mission_net, space)
    if not found.unsafe:
        return (), None
    first = found.unsafe[0]
    ends = (Event(what, first) for what in _FAILURES)
    events = [transition.event for transition in space.net.transitions]
    t = next(t for event in ends for t in found.badly if events[t] == event)
    edges = space.run(space.initial.pick(), found.badly[t]) or []
    return found.unsafe, Run(space.net, (*transitions_of(edges), t), settles=settles)
