"""Small missions written down by hand: hardware, an activity, a robot, a mission, each by one call."""

from __future__ import annotations

from mcpn.mission.model import Block, Mission
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Hardware, Robot, Software


def hw(*names: str, faulty: bool = True) -> tuple[Hardware, ...]:
    """Hardware by its names."""
    return tuple(Hardware(name=name, faulty=faulty) for name in names)


def activity(name: str, *ways: tuple[str, ...], produces: tuple[str, ...] = ()) -> Activity:
    """An activity by what each of its alternatives consumes; the only one has the activity's name."""
    names = [name] if len(ways) == 1 else [f"{name}_{i}" for i in range(len(ways))]
    alternatives = tuple(Alternative(name=n, consumes=way) for n, way in zip(names, ways, strict=True))
    return Activity(name=name, alternatives=alternatives, produces=produces)


def robot(hardware: tuple[Hardware, ...], *activities: Activity, events: tuple[str, ...] = ()) -> Robot:
    """A robot with some hardware, and with the software that its activities produce."""
    software = tuple(Software(name=s) for a in activities for s in a.produces)
    declared = tuple(DeclaredEvent(name=name) for name in events)
    return Robot(name="r", hardware=hardware, software=software, activities=activities, events=declared)


def mission(robot: Robot, *blocks: Block) -> Mission:
    """A mission of one robot."""
    return Mission(name="m", robots=(robot,), blocks=blocks)
