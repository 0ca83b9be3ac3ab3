"""Which picture of a mission is wanted, by a word."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from mcpn.errors import InputError
from mcpn.net.compose import MissionNet
from mcpn.report.pictures.drawing import Drawing

KINDS = ("mission", "objectives", "net", "alternatives", "controller")


def drawn(mission_net: MissionNet, kind: str = "mission", section: str | None = None) -> Drawing:
    """A picture of a mission.

    Args:
        mission_net: The mission's net.
        kind: One of :data:`KINDS`.
        section: Of this section alone.

    Raises:
        InputError: There is no such kind or section, or no such picture of a section.
        SemanticsError: The mission is not safe or not confluent, so that it has no alternatives graph.
        LimitError: It has too many states.
    """
    known = _WHOLE if section is None else _OF_SECTION
    if kind not in known:
        of = "" if section is None else " of a section"
        raise InputError.at(None, f"found the picture {kind!r}, expected one{of} of {', '.join(known)}")
    return _WHOLE[kind](mission_net) if section is None else _OF_SECTION[kind](mission_net, section)


def _mission(mission_net: MissionNet) -> Drawing:
    from mcpn.report.pictures.mission import mission_drawing

    return mission_drawing(mission_net)


def _objectives(mission_net: MissionNet) -> Drawing:
    from mcpn.report.pictures.objectives import objectives_drawing

    return objectives_drawing(mission_net)


def _net(mission_net: MissionNet) -> Drawing:
    from mcpn.report.pictures.nets import units_drawing

    return units_drawing(mission_net)


def _alternatives(mission_net: MissionNet) -> Drawing:
    from mcpn.report.pictures.machines import alternatives_drawing
    from mcpn.space.stable.alternatives import direct_with_proof
    from mcpn.space.stable.clash_words import in_mission_words
    from mcpn.steps import Doing, step

    step(Doing.LISTING)
    with in_mission_words(mission_net):
        return alternatives_drawing(mission_net, direct_with_proof(mission_net.net))


def _controller(mission_net: MissionNet) -> Drawing:
    from mcpn.controller.generate import generate
    from mcpn.report.pictures.machines import controller_drawing

    return controller_drawing(generate(mission_net))


def _section_net(mission_net: MissionNet, section: str) -> Drawing:
    from mcpn.report.pictures.nets import section_net_drawing

    return section_net_drawing(mission_net, section)


def _local(mission_net: MissionNet, section: str) -> Drawing:
    from mcpn.report.pictures.machines import local_drawing

    return local_drawing(mission_net, section)


def _section_controller(mission_net: MissionNet, section: str) -> Drawing:
    from mcpn.report.pictures.machines import local_drawing

    return local_drawing(mission_net, section, actions=True)


_WHOLE: Mapping[str, Callable[[MissionNet], Drawing]] = {
    "mission": _mission,
    "objectives": _objectives,
    "net": _net,
    "alternatives": _alternatives,
    "controller": _controller,
}
_OF_SECTION: Mapping[str, Callable[[MissionNet, str], Drawing]] = {
    "net": _section_net,
    "alternatives": _local,
    "controller": _section_controller,
}
