"""Clashes in the words of the mission: who wants what at the same moment, and what a designer can change."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from mcpn.composite.clash import Clash, Rival, find_clash
from mcpn.drawing.compose import MissionNet
from mcpn.drawing.permanent_loss import crashed_idle
from mcpn.errors import ConfluenceError
from mcpn.events import What
from mcpn.sentences import enumeration

_RESOURCE = ("let one of them use another resource", "give one of them an alternative without {wanted}")
REMEDIES = {
    "hardware": (*_RESOURCE, 'declare {wanted} with shared="true"'),
    "software": (*_RESOURCE, 'declare {wanted} without exclusive="true"'),
    "activity": (
        "give one of them an activity of its own",
        "let it produce software that the activities of both consume",
    ),
    "producer": ("put in sequence what needs its resources", "produce them by activities of their own"),
    "stop": ("put in sequence what uses the same resources", "give it resources of its own"),
}
"""What a designer can change, by what is wanted."""

SEQUENCE = {
    "branches": "put the two in sequence",
    "objective": "start them by two objectives in sequence",
}
"""What else, by where both run; activities of which one supplies the other cannot run in sequence."""


def explained(mission_net: MissionNet, error: ConfluenceError) -> ConfluenceError:
    """The error in the words of the mission.

    Args:
        mission_net: The net of the mission, or of a part of it, that the error's runs are of.
        error: The error.

    Returns:
        An error with the same runs; the same error where its runs are of a net in which more may happen,
        and which has explained it.
    """
    net = mission_net.net
    if not all(name in net.transition_index for run in error.runs for name in run):
        return error
    fired = [net.transitions[net.transition_index[name]] for name in error.runs[0]]
    # What is lost for good is only not repaired: without that it is a run as well.
    events = [str(t.event) for t in fired if t.event is not None and t.event.what is not What.LOST]
    said = sentence(find_clash(mission_net, error))
    if idle := crashed_idle(mission_net, fired):
        said += (
            f"; this comes of a crash of {enumeration(idle)} while it does not run, for causes are asked of "
            "losses at any moment"
        )
    return ConfluenceError(said, error.runs, events)


@contextmanager
def in_mission_words(mission_net: MissionNet | None) -> Iterator[None]:
    """Explains an error of the mission's net that is raised inside; nets of no mission have no such words."""
    try:
        yield
    except ConfluenceError as error:
        raise error if mission_net is None else explained(mission_net, error) from error


def sentence(clash: Clash) -> str:
    """Who wants what, and what can be changed."""
    who, wanted = _who(clash), enumeration(clash.wanted)
    match clash.kind:
        case "hardware" | "software":
            said = f"{who} ask for {wanted} at the same moment"
        case "activity":
            said = f"{who} start {_plural('activity', 'activities', clash.wanted)} at the same moment"
        case "producer":
            asked = next((r.name for r in clash.rivals if r.kind == "software"), "its resource")
            said = f"activity {wanted} may stop at the moment at which {asked} is asked for"
        case "stop":
            said = f"activity {wanted} may be stopped at the moment at which it changes its alternative"
        case _:
            said = f"{who} act at the same moment"
    remedies = [remedy.format(wanted=wanted) for remedy in REMEDIES.get(clash.kind, ())]
    if clash.kind not in ("producer", "stop") and clash.where in SEQUENCE:
        remedies.insert(0, SEQUENCE[clash.where])
    advice = f"; to change this, {', or '.join(remedies)}" if remedies else ""
    return f"not confluent: {said}, and what follows depends on which comes first{advice}"


def _who(clash: Clash) -> str:
    one, other = clash.rivals
    if clash.where != "branches" and one.objectives:
        return f"{one.name} and {other.name}, both for {_objectives(one.objectives)},"
    who = f"{_rival(one)} and {_rival(other)}"
    if one.kind == other.kind == "objective":
        who = f"objectives {one.name} and {other.name}"
    return f"{who}, both in parallel block {clash.block}," if clash.block is not None else who


def _rival(rival: Rival) -> str:
    if rival.kind == "objective":
        return f"objective {rival.name}"
    return f"{rival.name} ({_objectives(rival.objectives)})" if rival.objectives else rival.name


def _objectives(names: Sequence[str]) -> str:
    return _plural("objective", "objectives", names)


def _plural(one: str, several: str, names: Sequence[str]) -> str:
    return f"{one if len(names) == 1 else several} {enumeration(names)}"
