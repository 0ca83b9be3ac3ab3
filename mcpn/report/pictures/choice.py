"""Makes the picture of a mission, or of a section, that a word names."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from mcpn.answers.spaces_by_engine import MissionSpaces, MissionSubject, spaces_of
from mcpn.errors import InputError
from mcpn.report.pictures.drawing import Drawing

KINDS = ("mission", "objectives", "net", "alternatives", "controller", "run")


def drawn(subject: MissionSubject, kind: str = "mission", section: str | None = None) -> Drawing:
    """A picture of a mission.

    Args:
        subject: The mission's spaces, or its net.
        kind: One of :data:`KINDS`.
        section: Of this section alone.

    Raises:
        InputError: There is no such kind or section, or no such picture of a section.
        SemanticsError: The mission is not safe or not confluent, so that it has no alternatives graph.
        LimitError: It has too many states.
    """
    known = _WHOLE if section is None else _OF_SECTION
    if kind not in known:
        what = "" if section is None else " of a section"
        raise InputError.at(None, f"found the picture {kind!r}, expected one{what} of {', '.join(known)}")
    spaces = spaces_of(subject)
    return _WHOLE[kind](spaces) if section is None else _OF_SECTION[kind](spaces, section)


def _mission(spaces: MissionSpaces) -> Drawing:
    from mcpn.report.pictures.objectives import mission_drawing

    return mission_drawing(spaces.mission)


def _run(spaces: MissionSpaces) -> Drawing:
    from mcpn.report.pictures.runs import run_drawing

    return run_drawing(spaces)


def _objectives(spaces: MissionSpaces) -> Drawing:
    from mcpn.report.pictures.objectives_graph import objectives_drawing

    return objectives_drawing(spaces.mission)


def _net(spaces: MissionSpaces) -> Drawing:
    from mcpn.report.pictures.nets import units_drawing

    return units_drawing(spaces.mission)


def _alternatives(spaces: MissionSpaces) -> Drawing:
    from mcpn.composite.clash_sentences import in_mission_words
    from mcpn.report.pictures.machines import alternatives_drawing

    with in_mission_words(spaces.mission):
        return alternatives_drawing(spaces.mission, spaces.listed())


def _controller(spaces: MissionSpaces) -> Drawing:
    from mcpn.controller.generate import generate
    from mcpn.report.pictures.machines import controller_drawing

    return controller_drawing(generate(spaces))


def _section_net(spaces: MissionSpaces, section: str) -> Drawing:
    from mcpn.report.pictures.nets import section_net_drawing

    return section_net_drawing(spaces, section)


def _local(spaces: MissionSpaces, section: str) -> Drawing:
    from mcpn.report.pictures.machines import local_drawing

    return local_drawing(spaces, section)


def _section_controller(spaces: MissionSpaces, section: str) -> Drawing:
    from mcpn.report.pictures.machines import local_drawing

    return local_drawing(spaces, section, actions=True)


_WHOLE: Mapping[str, Callable[[MissionSpaces], Drawing]] = {
    "mission": _mission,
    "objectives": _objectives,
    "net": _net,
    "alternatives": _alternatives,
    "controller": _controller,
    "run": _run,
}
_OF_SECTION: Mapping[str, Callable[[MissionSpaces, str], Drawing]] = {
    "net": _section_net,
    "alternatives": _local,
    "controller": _section_controller,
}
