"""An abort that is reached by the failure of what should make the robot safe."""

from __future__ import annotations

from mcpn.drawing.compose import MissionNet
from mcpn.nets.events import Event, What
from mcpn.spaces.algebra import S, Space
from mcpn.spaces.run import Run, transitions_of


def abort_by_failure(
    mission_net: MissionNet, space: Space[S], abort: S, *, settles: bool
) -> tuple[list[str], Run | None]:
    """The objectives by whose failure the mission aborts as it does by their success.

    Such an objective makes the robot safe, and a route says that it is safe all the same where that fails.

    Args:
        mission_net: The mission's net.
        space: Its alternatives graph, or its markings graph.
        abort: The states in which it has been aborted.
        settles: Whether it is the alternatives graph.

    Returns:
        The objectives in document order, and a run to the first that ends so.
    """
    events = [transition.event for transition in space.net.transitions]
    ended: dict[Event, tuple[int, S]] = {}
    for t, before in space.crossing(space.everything - abort, abort):
        if (event := events[t]) is not None:
            ended.setdefault(event, (t, before))
    names, run = list[str](), None
    for section in mission_net.graph.walk():
        if Event(What.SUCCESS, section.name) not in ended:
            continue
        for what in (What.FAILURE, What.TIMEOUT):
            if (found := ended.get(Event(what, section.name))) is not None:
                names.append(section.name)
                if run is None:
                    edges = space.run(space.initial.pick(), found[1]) or []
                    run = Run(space.net, (*transitions_of(edges), found[0]), settles=settles)
                break
    return names, run
