"""Hardware that may die: a net in which each resource may be given up for good while it is out of service.

Each hardware resource that can fail gets a place *alive* and a place *dead*; it dies, at any moment, while
it is out of service, and a repair reads that it is alive. Whether a goal can be reached although some
hardware is lost for good is then reachability in this net, and minimal cut sets are a projection on the
places *dead*.
"""

from __future__ import annotations

from dataclasses import replace

from mcpn.net.compose import MissionNet
from mcpn.net.events import Event, What
from mcpn.net.petri import PetriNet, Place, Provenance, Transition


def mortal(mission_net: MissionNet) -> MissionNet:
    """The net of a mission, or of a part of it, whose hardware may die.

    Args:
        mission_net: The net.

    Returns:
        The net with two places and a transition more for each hardware resource that can fail, after all
        others, so that what had an index keeps it. The new places have the roles ``alive`` and ``dead``.
    """
    net = mission_net.net
    places, transitions = list(net.places), list(net.transitions)
    roles, units = dict(mission_net.roles), list(net.units)
    leaving: dict[int, list[int]] = {}
    for t, transition in enumerate(transitions):
        for place, _ in transition.consume:
            leaving.setdefault(place, []).append(t)
    # In the order in which they are drawn, which in the net of a section is not the mission's.
    for name in dict.fromkeys(mission_net.saying("oos").values()):
        hardware, out = mission_net.usage.hardware[name], mission_net.by_role["oos", name]
        origin = Provenance("hardware", hardware.name, hardware.source)
        alive, dead = len(places), len(places) + 1
        places += [Place(f"{hardware.name}_alive", 1, origin), Place(f"{hardware.name}_dead", 0, origin)]
        units.append((alive, dead))
        roles[alive], roles[dead] = ("alive", hardware.name), ("dead", hardware.name)
        for t in dict.fromkeys(t for place in out for t in leaving.get(place, ())):
            transitions[t] = replace(transitions[t], read=(*transitions[t].read, (alive, 1)))
        reads = tuple((place, 1) for place in out)
        lost = Event(What.LOST, hardware.name)
        transitions.append(Transition(str(lost), ((alive, 1),), ((dead, 1),), reads, lost, provenance=origin))
    mortal_net = PetriNet(net.name, tuple(places), tuple(transitions), net.priorities, tuple(units))
    return replace(mission_net, net=mortal_net, roles=roles)
