"""An abort that is reached by the failure of a safing objective.

Such an abort is no safe end. So neither the verdict nor the cut sets of safe ends take a route's word for it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import reduce
from itertools import product
from operator import or_
from typing import Generic, NamedTuple

from mcpn.answers.verdicts.nominal import nominal_transitions
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ElementarySection
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run, transitions_of


class Aborts(NamedTuple, Generic[S]):
    """How a mission reaches its abort.

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
    """How a mission that can abort reaches its abort.

    An objective should make the robot safe if the mission aborts by its success; or if after its success
    objectives that succeed lead to abort, and never to success. Where the time of a block is over, what runs
    in it fails.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
    """
    assert mission_net.abort is not None, "it can abort"
    abort, success = (space.marked([end]) for end in (mission_net.abort, mission_net.success))
    into = dict(space.crossing(space.everything - abort, abort))
    carrying = space.net.events.of
    failing: dict[str, dict[int, S]] = {
        section.name: {t: into[t] for t in carrying(*_failures(section)) if t in into}
        for section in mission_net.graph.walk()
    }
    for block in mission_net.graph.timed_blocks():
        late = [t for t in carrying(Event(What.TIMEOUT, block.name)) if t in into]
        for name, t in product(block.held, late):
            if states := into[t] & _running(mission_net, space, name):
                failing[name][t] = states
    failing = {name: transitions for name, transitions in failing.items() if transitions}
    if not failing:
        return Aborts((), {}, into)
    nominal = nominal_transitions(mission_net)
    to_abort, to_success = (space.reaching(end, transitions=nominal) for end in (abort, success))

    def shelters(name: str) -> bool:
        succeeding = carrying(Event(What.SUCCESS, name))
        if any(t in into for t in succeeding):
            return True
        return bool(space.before(to_abort, succeeding)) and not space.before(to_success, succeeding)

    unsafe = tuple(name for name in failing if shelters(name))
    badly = dict[int, S]()
    for t, states in (each for name in unsafe for each in failing[name].items()):
        badly[t] = badly[t] | states if t in badly else states
    left = ((t, states - badly[t] if t in badly else states) for t, states in into.items())
    return Aborts(unsafe, badly, {t: states for t, states in left if states})


def without_safe_end(mission_net: MissionNet, space: Space[S]) -> S:
    """States from which no run succeeds, or aborts by anything but the failure of a safing objective.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
    """
    assert mission_net.abort is not None, "it can abort"
    abort, success = (space.marked([end]) for end in (mission_net.abort, mission_net.success))
    found = aborts(mission_net, space)
    if not found.unsafe:
        return space.everything - space.reaching(success | abort)
    running = space.everything - abort
    return running - space.reaching(reduce(or_, found.well.values(), success), running)


def _failures(section: ElementarySection) -> Iterator[Event]:
    """The events by which an objective fails."""
    yield from (Event(What.FAILURE, section.name, why) for why, _ in section.failures)
    yield Event(What.TIMEOUT, section.name)


def _running(mission_net: MissionNet, space: Space[S], objective: str) -> S:
    return space.marked(mission_net.by_role.get(("objective", objective), ()))


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
    ends = [e for section in mission_net.graph.walk() if section.name == first for e in _failures(section)]
    own = next((t for t in space.net.events.of(*ends) if t in found.badly), None)
    running = _running(mission_net, space, first)
    # Else the time of a block around it is over.
    t = next(t for t, states in found.badly.items() if states & running) if own is None else own
    edges = space.run(space.initial.pick(), found.badly[t] & running) or []
    return found.unsafe, Run(space.net, (*transitions_of(edges), t), settles=settles)
