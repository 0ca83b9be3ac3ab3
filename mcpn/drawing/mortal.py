"""Hardware that may die: a net in which each resource may be given up for good while it is out of service.

Each hardware resource that can fail gets a place *alive* and a place *dead*; it dies, at any moment, while
it is out of service, and a repair reads that it is alive. Whether a goal can be reached although some
hardware is lost for good is then reachability in this net, and minimal cut sets are a projection on the
places *dead*.

The resource that stands for a crash of an activity (:class:`mcpn.mission.expansion.faults.Crash`) fails only
while the activity runs. Two analyses need it to fail at other moments: a part of a mission may be entered
after the crash (:func:`crashed_before`), and what its loss leads to is asked of any moment, as of hardware
(:func:`crashing_anytime`). In the same way a part may be entered after the robot has learned of a loss that
is detected late (:func:`noticed_before`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from mcpn.drawing.compose import MissionNet
from mcpn.drawing.templates.names import names_of
from mcpn.nets.events import Event, What
from mcpn.nets.petri import PetriNet, Place, Provenance, Transition


def mortal(mission_net: MissionNet) -> MissionNet:
    """The net of a mission, or of a part of it, whose hardware may die.

    What may crash may do so at any moment there (:func:`crashing_anytime`).

    Args:
        mission_net: The net.

    Returns:
        The net with two places and a transition more for each hardware resource that can fail, after all
        others, so that what had an index keeps it. The new places have the roles ``alive`` and ``dead``.
    """
    mission_net = crashing_anytime(mission_net)
    net = mission_net.net
    places, transitions = list(net.places), list(net.transitions)
    roles, units = dict(mission_net.roles), list(net.units)
    consumers: dict[int, list[int]] = {}
    for t, transition in enumerate(transitions):
        for place, _ in transition.consume:
            consumers.setdefault(place, []).append(t)
    # In the order in which they are drawn, which in the net of a section is not the mission's.
    for name in dict.fromkeys(mission_net.saying("oos").values()):
        hardware, out = mission_net.usage.hardware[name], mission_net.by_role["oos", name]
        origin = Provenance("hardware", hardware.name, hardware.source)
        alive, dead = len(places), len(places) + 1
        places += [Place(f"{hardware.name}_alive", 1, origin), Place(f"{hardware.name}_dead", 0, origin)]
        units.append((alive, dead))
        roles[alive], roles[dead] = ("alive", hardware.name), ("dead", hardware.name)
        for t in dict.fromkeys(t for place in out for t in consumers.get(place, ())):
            transitions[t] = replace(transitions[t], read=(*transitions[t].read, (alive, 1)))
        reads = tuple((place, 1) for place in out)
        lost = Event(What.LOST, hardware.name)
        transitions.append(Transition(str(lost), ((alive, 1),), ((dead, 1),), reads, lost, provenance=origin))
    mortal_net = PetriNet(net.name, tuple(places), tuple(transitions), net.priorities, tuple(units))
    return replace(mission_net, net=mortal_net, roles=roles)


def crashed_before(mission_net: MissionNet) -> MissionNet:
    """The net of a mission, or of a part of it, before which activities may have crashed.

    Args:
        mission_net: The net.

    Returns:
        The net with a transition more for each crash, after all others; the net itself where it has none.
    """
    mission = mission_net.mission
    origin = Provenance("mission", mission.name, mission.source)
    begin = ((mission_net.beginning, 1),)
    earlier = [replace(t, read=begin, provenance=origin) for t in _crashes_while_idle(mission_net)]
    return _with(mission_net, [*mission_net.net.transitions, *earlier]) if earlier else mission_net


def noticed_before(mission_net: MissionNet) -> MissionNet:
    """The net of a part of a mission, before which the robot may have learned of losses detected late.

    Args:
        mission_net: The net.

    Returns:
        The net with a transition more for each resource that is detected late, after all others; the net
        itself where it has none.
    """
    known, mission = mission_net.saying("known"), mission_net.mission
    if not known:
        return mission_net
    names, begin = names_of(mission_net.usage), mission_net.beginning
    origin = Provenance("mission", mission.name, mission.source)
    earlier = []
    for out, name in known.items():
        consume = tuple((place, 1) for place in mission_net.by_role["presumed", name])
        read = tuple((place, 1) for place in (begin, *mission_net.by_role["oos", name]))
        noticed = Event(What.DETECTED, name)
        transition_name = names.of("hardware", name, "noticed")
        earlier.append(Transition(transition_name, consume, ((out, 1),), read, noticed, provenance=origin))
    return _with(mission_net, [*mission_net.net.transitions, *earlier])


def crashing_anytime(mission_net: MissionNet) -> MissionNet:
    """The net in which an activity that may crash does so at any moment, whether it runs or not.

    Args:
        mission_net: The net of a mission, or of a part of it as :func:`crashed_before` gives it.

    Returns:
        The net with a transition more for each crash, instead of those of :func:`crashed_before`.
    """
    crashes = list(_crashes_while_idle(mission_net))
    if not crashes:
        return mission_net
    names = {t.name for t in crashes}
    kept = [t for t in mission_net.net.transitions if t.name not in names]
    return _with(mission_net, [*kept, *crashes])


def _crashes_while_idle(mission_net: MissionNet) -> Iterator[Transition]:
    """One transition for each crash: its resource fails while its activity does not run."""
    names = names_of(mission_net.usage)
    for name in dict.fromkeys(mission_net.saying("ready").values()):
        crash = mission_net.usage.hardware[name]
        ready, out = (mission_net.by_role[role, name] for role in ("ready", "oos"))
        consume, produce = (tuple((place, 1) for place in places) for places in (ready, out))
        origin = Provenance("hardware", name, crash.source)
        event = Event(What.OUT_OF_SERVICE, name)
        transition_name = names.of("hardware", name, "earlier")
        yield Transition(transition_name, consume, produce, (), event, provenance=origin)


def _with(mission_net: MissionNet, transitions: list[Transition]) -> MissionNet:
    return replace(mission_net, net=replace(mission_net.net, transitions=tuple(transitions)))
