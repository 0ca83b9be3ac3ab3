"""A mission with other names: it says the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mcpn.mission.model import FAIL, SUCCEED, Activity, Alternative, Block, Handler, Mission, Objective, Use


def renamed(mission: Mission, rename: Callable[[str, str], str]) -> Mission:
    """The mission with other names.

    Args:
        mission: A valid mission.
        rename: From a kind (``resource``, ``activity``, ``alternative``, ``block``, ``protocol``, ``event``)
            and a name to the new one, each new name once in its kind. An alternative of its activity's name
            is given that of the activity.
    """

    def alternative(a: Alternative, activity: str) -> Alternative:
        name = rename("activity", activity) if a.name == activity else rename("alternative", a.name)
        return replace(a, name=name, consumes=tuple(rename("resource", k) for k in a.consumes))

    def activity(a: Activity) -> Activity:
        return replace(
            a,
            name=rename("activity", a.name),
            produces=tuple(rename("resource", s) for s in a.produces),
            alternatives=tuple(alternative(way, a.name) for way in a.alternatives),
        )

    def route(target: str | None) -> str | None:
        return target if target in (None, SUCCEED, FAIL) else rename("block", target)

    def handler(h: Handler) -> Handler:
        return replace(h, event=rename("event", h.event), goto=route(h.goto) or h.goto)

    def block(b: Block) -> Block:
        b = replace(b, name=rename("block", b.name), success=route(b.success), failure=route(b.failure))
        b = replace(b, handlers=tuple(map(handler, b.handlers)))
        match b:
            case Objective():
                return replace(b, activities=tuple(rename("activity", a) for a in b.activities))
            case Use():
                return replace(b, protocol=rename("protocol", b.protocol))
        return replace(b, blocks=tuple(map(block, b.blocks)))

    robots = (
        replace(
            robot,
            hardware=tuple(replace(h, name=rename("resource", h.name)) for h in robot.hardware),
            software=tuple(replace(s, name=rename("resource", s.name)) for s in robot.software),
            activities=tuple(map(activity, robot.activities)),
            events=tuple(replace(e, name=rename("event", e.name)) for e in robot.events),
        )
        for robot in mission.robots
    )
    protocols = (
        replace(p, name=rename("protocol", p.name), blocks=tuple(map(block, p.blocks)))
        for p in mission.protocols
    )
    blocks = tuple(map(block, mission.blocks))
    handlers = tuple(map(handler, mission.handlers))
    return replace(
        mission, blocks=blocks, robots=tuple(robots), protocols=tuple(protocols), handlers=handlers
    )
