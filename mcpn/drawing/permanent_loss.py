"""Hardware that may die: a net in which each resource may be given up for good while it is out of service.

Each hardware resource that can fail gets a place *alive* and a place *dead*; it dies, at any moment, while
it is out of service, and a repair reads that it is alive. Whether a goal can be reached although some
hardware is lost for good is then reachability in this net, and minimal cut sets are a projection on the
places *dead*.

The resource that stands for a crash of an activity (:class:`mcpn.mission.robot.Crash`) fails only
while the activity runs. Two analyses need it to fail at other moments: a part of a mission may be entered
after the crash, as with any other status (:func:`entered_otherwise`), and what its loss leads to is asked of
any moment, as of hardware (:func:`crashing_anytime`).
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace

from mcpn.drawing.compose import MissionNet
from mcpn.drawing.templates.interface import CONTROL
from mcpn.drawing.templates.net_names import names_of
from mcpn.events import Event, What
from mcpn.nets.petri import PetriNet, Place, Transition
from mcpn.nets.provenance import Provenance


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
    net, roles = mission_net.net, dict(mission_net.roles)
    places, transitions, units = list[Place](), list[Transition](), list[tuple[int, ...]]()
    consumers, changed = net.consuming(mission_net.saying("oos")), dict[int, Transition]()
    # In the order in which they are drawn, which in the net of a section is not the mission's.
    for name in dict.fromkeys(mission_net.saying("oos").values()):
        hardware, out = mission_net.usage.hardware[name], mission_net.by_role["oos", name]
        origin = Provenance("hardware", hardware.name, hardware.source)
        alive = len(net.places) + len(places)
        dead = alive + 1
        places += [Place(f"{hardware.name}_alive", 1, origin), Place(f"{hardware.name}_dead", 0, origin)]
        units.append((alive, dead))
        roles[alive], roles[dead] = ("alive", hardware.name), ("dead", hardware.name)
        for t in dict.fromkeys(t for place in out for t in consumers.get(place, ())):
            repaired = changed.get(t, net.transitions[t])
            changed[t] = replace(repaired, read=(*repaired.read, (alive, 1)))
        reads = tuple((place, 1) for place in out)
        lost = Event(What.LOST, hardware.name)
        transitions.append(Transition(str(lost), ((alive, 1),), ((dead, 1),), reads, lost, provenance=origin))
    return replace(mission_net, net=net.extended(changed, places, transitions, units), roles=roles)


def entered_otherwise(mission_net: MissionNet, what: Collection[What] = tuple(What)) -> MissionNet:
    """The net of a mission, or of a part of it, before which any status may have become another one.

    Args:
        mission_net: The net; it begins with hardware in service, and all else as at the start of the mission.
        what: What of all that may have happened is to be there.

    Returns:
        The net with a transition more for each such change (:class:`mcpn.drawing.status.Before`); the net
        itself where nothing may have changed.
    """
    mission, names = mission_net.core, names_of(mission_net.usage)
    own, origin = ("mission", mission.name), Provenance("mission", mission.name, mission.source)
    earlier: dict[bool, list[Transition]] = {True: [], False: []}  # of hardware, and of other elements
    every = [(status, before) for status in mission_net.statuses for before in status.before]
    for status, before in every:
        taken, put, asked = (
            tuple((place, 1) for role in roles for place in mission_net.by_role.get(role, ()))
            for roles in ((before.taken,), (before.put,), before.asked)
        )
        if before.event.what in what and put:
            hardware = status.kind == "hardware"
            name = names.of(*(status.element if hardware else own), *before.part)
            read = ((mission_net.beginning, 1), *asked)
            transition = Transition(name, taken, put, read, before.event, provenance=origin)
            earlier[hardware].append(transition)
    if not every:
        return mission_net
    # The states of controllers are numbered in the order of transitions.
    drawn = mission_net.net.transitions
    control = (
        t for t, one in enumerate(drawn) if one.provenance and one.provenance.kind in (*CONTROL, "fact")
    )
    first = next(control, len(drawn))
    return _with(mission_net, [*drawn[:first], *earlier[False], *drawn[first:], *earlier[True]])


def crashing_anytime(mission_net: MissionNet) -> MissionNet:
    """The net in which an activity that may crash does so at any moment, whether it runs or not.

    Args:
        mission_net: The net of a mission, or of a part of it as :func:`entered_otherwise` gives it.

    Returns:
        The net with a transition more for each crash, instead of those of :func:`entered_otherwise`.
    """
    crashes, net = list(_crashes_while_idle(mission_net)), mission_net.net
    names = {t.name for t in crashes}
    failing = net.events.of(*(t.event for t in crashes if t.event is not None))
    if not any(net.transitions[t].name in names for t in failing):  # it is the net of the whole mission
        return replace(mission_net, net=net.extended({}, (), crashes)) if crashes else mission_net
    kept = [t for t in net.transitions if t.name not in names]
    return _with(mission_net, [*kept, *crashes])


def crashed_idle(mission_net: MissionNet, run: Iterable[Transition]) -> tuple[str, ...]:
    """What crashes in a run while its activity does not run, as :func:`crashing_anytime` allows.

    Args:
        mission_net: The net.
        run: Transitions of it.
    """
    idle = {t.name: t.provenance for t in _crashes_while_idle(mission_net)}
    return tuple(origin.name for t in run if (origin := idle.get(t.name)) and origin == t.provenance)


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
    net = mission_net.net
    return replace(
        mission_net, net=PetriNet(net.name, net.places, tuple(transitions), net.priorities, net.units)
    )
