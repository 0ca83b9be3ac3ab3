"""Monitors as files: a JSON document for Python and for logs, and C99."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mcpn.answers.requirements import asked_of
from mcpn.answers.spaces_by_engine import MissionSpaces
from mcpn.controller.monitors.watched import Monitor, Watcher, on_one_path
from mcpn.errors import InputError
from mcpn.robot.runtime.documents import MONITORS, MONITORS_VERSION
from mcpn.robot.runtime.file_schema import digest_of
from mcpn.robot.runtime.monitors import VALUES
from mcpn.robot.targets.c import LONGEST_PREFIX, Array
from mcpn.robot.targets.identifiers import C_PREFIX_RESERVED, C_SIGNIFICANT, c_string, comment, identifiers
from mcpn.robot.targets.render import render
from mcpn.spaces.engine_names import EXPLICIT
from mcpn.spaces.engines import Choice


@dataclass(frozen=True)
class MissionMonitors:
    """The monitors of a mission.

    Args:
        mission: Its name.
        events: All of its events, by text.
        monitors: One for each requirement that speaks of each run by itself.
        unwatched: The others, by name.
    """

    mission: str
    events: tuple[str, ...]
    monitors: tuple[Monitor, ...]
    unwatched: tuple[str, ...]


def monitors_of(spaces: MissionSpaces, within: bool = False) -> MissionMonitors:
    """The monitors of a mission's requirements, made of its stable states, which are listed.

    Args:
        spaces: Of the mission.
        within: Whether the mission's own continuations decide; as of :meth:`Watcher.monitor`.

    Raises:
        InputError: It has no requirements, or one of them is none.
        SemanticsError: The mission is not safe or not confluent.
        LimitError: It has too many stable states, or a monitor has too many.
    """
    mission_net = spaces.mission
    asked = [(each, on_one_path(each)) for each in asked_of(mission_net)]
    if not asked:
        message = f"mission {mission_net.core.name} has no requirements to watch: expected <requirement>"
        raise InputError.at(mission_net.core.source, message)
    if not any(formula for _, formula in asked):
        message = "no requirement speaks of each run by itself, as formulas of LTL and patterns do"
        raise InputError.at(mission_net.core.source, f"{message}: there is nothing to watch")
    stable, _ = spaces.stable(Choice(EXPLICIT, max_states=spaces.max_states))
    watcher = Watcher(stable, mission_net.ends.values())
    return MissionMonitors(
        mission_net.core.name,
        tuple(sorted(map(str, mission_net.net.events))),
        tuple(watcher.monitor(each, formula, within) for each, formula in asked if formula is not None),
        tuple(each.name for each, formula in asked if formula is None),
    )


def files(monitors: MissionMonitors, *, btcpp: bool = False) -> dict[str, str]:
    """The files by name: ``monitors.json``, and a header and a source in C99.

    Args:
        monitors: The monitors.
        btcpp: Whether a header with conditions of behaviour trees is one of them.
    """
    number = {event: i for i, event in enumerate(monitors.events)}
    document: dict[str, Any] = {
        "format": MONITORS,
        "version": MONITORS_VERSION,
        "mission": monitors.mission,
        "events": list(monitors.events),
        "monitors": [
            {
                "name": each.name,
                "words": each.words,
                "formula": each.formula,
                "within_mission": each.within,
                "values": [VALUES.index(value) for value in each.values],
                "moves": [[[number[event], to] for event, to in moves.items()] for moves in each.moves],
            }
            for each in monitors.monitors
        ],
        "unwatched": list(monitors.unwatched),
    }
    document["digest"] = digest_of(document)
    return {"monitors.json": json.dumps(document, indent=1) + "\n", **_in_c(monitors, number, btcpp)}


def _in_c(monitors: MissionMonitors, number: dict[str, int], btcpp: bool) -> dict[str, str]:
    prefix = identifiers([monitors.mission], keywords=C_PREFIX_RESERVED, longest=LONGEST_PREFIX)[
        monitors.mission
    ]
    lower, upper = prefix.lower(), prefix.upper()
    first, moves_first = [0], [0]
    values: list[int] = []
    events: list[int] = []
    targets: list[int] = []
    for each in monitors.monitors:
        for value, moves in zip(each.values, each.moves, strict=True):
            values.append(VALUES.index(value))
            events += [number[event] for event in moves]
            targets += [first[-1] + to for to in moves.values()]
            moves_first.append(len(events))
        first.append(len(values))
    arrays = [
        Array("first", first[:-1], "By monitor: the state in which it begins."),
        Array("value", values, "By state: what is known."),
        Array("move_start", moves_first, "By state: its first move; behind the last state, the end."),
        Array("move_event", events, "By move: the event."),
        Array("move_target", targets, "By move: the state after it."),
    ]

    def enum(kind: str, names: Sequence[str]) -> list[tuple[str, int, str]]:
        known = identifiers(names, prefix=f"{upper}_{kind}_", longest=C_SIGNIFICANT)
        return [(known[name], i, comment(name)) for i, name in enumerate(names)]

    said = {
        "p": lower,
        "P": upper,
        "mission": comment(monitors.mission),
        "monitors": enum("MONITOR", [each.name for each in monitors.monitors]),
        "events": enum("HAPPENS", monitors.events),
        "names": [c_string(each.name) for each in monitors.monitors],
        "words": [c_string(each.words) for each in monitors.monitors],
        "texts": [c_string(event) for event in monitors.events],
        "arrays": arrays,
    }
    found = {
        f"{lower}_monitors.h": render("monitors.h.jinja", **said),
        f"{lower}_monitors.c": render("monitors.c.jinja", **said),
    }
    if btcpp:
        names = c_string(" or ".join(each.name for each in monitors.monitors))
        node = render("monitors_node.hpp.jinja", **{**said, "names": names})
        found[f"{lower}_monitors_node.hpp"] = node
    return found
