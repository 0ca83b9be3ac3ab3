"""Families of missions whose events concern everything at once: crashes, one sensor for all, pauses.

Usage: ``python experiments/growth/walls.py FAMILY SIZE OUT.xml`` writes a member as a mission file;
``growth.py`` measures them. It takes about a second.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterable, Sequence
from functools import partial
from pathlib import Path

from mcpn.mission.model import SUCCEED, Block, Handler, Mission, Objective, Parallel, Recursive
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Fault, Hardware, Robot, Software
from mcpn.mission.writer import save_mission


def activity(
    name: str, *ways: Sequence[str], produces: tuple[str, ...] = (), crashing: bool = False
) -> Activity:
    """An activity whose alternatives consume what each way names, and may crash."""
    alternatives = tuple(
        Alternative(name=f"{name}_{i}", consumes=tuple(way), faulty=crashing) for i, way in enumerate(ways)
    )
    return Activity(name=name, alternatives=alternatives, produces=produces)


def mission(
    hardware: Iterable[str],
    activities: Sequence[Activity],
    blocks: Sequence[Block],
    handlers: tuple[Handler, ...] = (),
    events: tuple[str, ...] = (),
    faults: tuple[Fault, ...] = (),
) -> Mission:
    """A mission of one robot."""
    robot = Robot(
        name="robot",
        hardware=tuple(Hardware(name=h) for h in hardware),
        faults=faults,
        software=tuple(Software(name=s) for a in activities for s in a.produces),
        activities=tuple(activities),
        events=tuple(DeclaredEvent(name=e) for e in events),
    )
    return Mission(name="grown", robots=(robot,), blocks=tuple(blocks), handlers=handlers)


def crashing(size: int) -> Mission:
    """Producers with two ways of their own, each of which may crash, and one consumer of all."""
    makers = [
        activity(f"make{i}", (f"a{i}",), (f"b{i}",), produces=(f"d{i}",), crashing=True) for i in range(size)
    ]
    use = activity("use", tuple(f"d{i}" for i in range(size)))
    hardware = [f"{side}{i}" for i in range(size) for side in "ab"]
    return mission(hardware, [*makers, use], [Objective(name="go", activities=("use",))])


def fused(size: int) -> Mission:
    """Data of one camera, each with a fallback of its own, which one activity fuses."""
    capture = activity("capture", ("cam",), produces=("image",))
    makers = [activity(f"see{i}", ("image",), (f"h{i}",), produces=(f"d{i}",)) for i in range(size)]
    fuse = activity("fuse", tuple(f"d{i}" for i in range(size)))
    hardware = ["cam", *(f"h{i}" for i in range(size))]
    return mission(hardware, [capture, *makers, fuse], [Objective(name="go", activities=("fuse",))])


def overlapping(size: int) -> Mission:
    """Common causes that each take two neighbours out of service, and one activity with a way for each."""
    hardware = [f"h{i}" for i in range(size + 1)]
    faults = tuple(Fault(name=f"f{i}", affects=(f"h{i}", f"h{i + 1}")) for i in range(size))
    work = activity("work", *((f"h{i}",) for i in range(size)))
    return mission(hardware, [work], [Objective(name="go", activities=("work",))], faults=faults)


LOCALISATION = activity("localise", ("gps",), ("imu",), produces=("position",))


def chains(branches: int, tasks: int, shared: bool = True) -> Mission:
    """Branches of tasks in a row, each with hardware of its own, which all need one localisation."""
    work = []
    blocks: list[Block] = []
    for b in range(branches):
        of = [
            activity(f"work{b}_{t}", ("position", f"h{b}_{t % 3}") if shared else (f"h{b}_{t % 3}",))
            for t in range(min(tasks, 3))
        ]
        work += of
        inside = tuple(Objective(name=f"o{b}_{t}", activities=(f"work{b}_{t % 3}",)) for t in range(tasks))
        blocks.append(Recursive(name=f"branch{b}", blocks=inside))
    hardware = ["gps", "imu", *(f"h{b}_{t}" for b in range(branches) for t in range(min(tasks, 3)))]
    return mission(hardware, [LOCALISATION, *work], [Parallel(name="all", blocks=tuple(blocks))])


def pausing(size: int) -> Mission:
    """Branches of two tasks that an event pauses all at once."""
    work = [activity(f"work{b}_{t}", (f"h{b}_{t}",)) for b in range(size) for t in range(2)]
    hide = activity("hide", ("hatch",))
    branches = tuple(
        Recursive(
            name=f"branch{b}",
            blocks=tuple(Objective(name=f"o{b}_{t}", activities=(f"work{b}_{t}",)) for t in range(2)),
        )
        for b in range(size)
    )
    block = Parallel(
        name="all", blocks=branches, handlers=(Handler(event="storm", pause="shelter"),), success=SUCCEED
    )
    shelter = Objective(name="shelter", activities=("hide",))
    hardware = ["hatch", *(f"h{b}_{t}" for b in range(size) for t in range(2))]
    return mission(hardware, [hide, *work], [block, shelter], events=("storm",))


def inspecting(sites: int) -> Mission:
    """Sites that are each inspected with a retry, and may be skipped; 10,000 are the most that may be."""
    pose = activity("locate", ("gps",), ("imu",), produces=("pose",))
    look = activity("look", ("camera", "pose"), ("lidar",))
    go = activity("go", ("wheels", "pose"), ("wheels",))
    onward = [*(f"site{i + 1}" for i in range(sites - 1)), SUCCEED]
    blocks = [
        Objective(name=f"site{i}", activities=("go", "look"), retries=1, success=to, failure=to)
        for i, to in enumerate(onward)
    ]
    return mission(("wheels", "gps", "imu", "camera", "lidar"), [pose, go, look], blocks)


def passing(size: int, contending: bool = True) -> Mission:
    """Branches of which two could want one winch, and never do, as one is past it before the other begins."""
    work = [activity(f"work{i}", ("position", f"h{i}"), ("position",)) for i in range(size)]
    winch = [
        activity("lower", ("winch", "position")),
        activity("raise", ("winch" if contending else "winch2", "position")),
    ]
    first = Recursive(
        name="first",
        blocks=tuple(Objective(name=f"o{i}", activities=(f"work{i}",)) for i in range(size)),
    )
    down = Objective(name="down", activities=("lower",))
    up = Objective(name="up", activities=("raise",))
    block = Parallel(name="all", blocks=(first, down))
    hardware = ["gps", "imu", "winch", "winch2", *(f"h{i}" for i in range(size))]
    return mission(hardware, [LOCALISATION, *work, *winch], [block, up])


def quadruped(sites: int) -> Mission:
    """Fourteen hardware resources; six sites make 37 sections of eight types."""
    legs = [f"leg{i}" for i in range(4)]
    limping = [[*legs[:i], *legs[i + 1 :], "pose", "map"] for i in range(4)]
    activities = [
        activity("estimate", ("imu", "gps"), ("imu",), produces=("pose",)),
        activity("chart", ("lidar",), ("stereo",), produces=("map",)),
        activity("walk", (*legs, "pose", "map"), *limping),
        activity("inspect", ("thermal", "pose"), ("lamp", "pose")),
        activity("watch", ("radio",)),
        activity("grasp", ("arm", "gripper", "stereo"), ("arm", "gripper", "lidar", "lamp")),
        activity("tell", ("radio",), ("modem",)),
    ]
    blocks: list[Block] = []
    for i in range(sites):
        onward = f"site{i + 1}" if i + 1 < sites else "home"
        beside = (
            Objective(name=f"inspect{i}", activities=("inspect",)),
            Objective(name=f"watch{i}", activities=("watch",)),
        )
        inside: tuple[Block, ...] = (
            Objective(name=f"reach{i}", activities=("walk",)),
            Objective(name=f"first{i}", activities=("inspect", "tell") if i else ("watch",)),
            Parallel(name=f"both{i}", blocks=beside),
            Objective(name=f"sample{i}", activities=("grasp",)),
            Objective(name=f"tell{i}", activities=("tell",)),
            Objective(name=f"leave{i}", activities=("walk", "watch")),
        )
        blocks.append(Recursive(name=f"site{i}", blocks=inside, success=onward, failure=onward))
    blocks.append(Objective(name="home", activities=("walk", "tell")))
    hardware = (*legs, "imu", "gps", "lidar", "stereo", "thermal", "arm", "gripper", "radio", "lamp", "modem")
    handlers = (Handler(event="battery_low", goto="home"),)
    return mission(hardware, activities, blocks, handlers, ("battery_low",))


WALLS: dict[str, tuple[Callable[[int], Mission], tuple[int, ...]]] = {
    "crashing": (crashing, (4, 6, 8, 12)),
    "fused": (fused, (6, 8, 10, 12)),
    "overlapping": (overlapping, (8, 10, 12, 16)),
    "chains": (partial(chains, tasks=3), (2, 3, 4)),
    "tasks": (partial(chains, 3), (4, 8, 16)),
    "pausing": (pausing, (4, 6, 8, 10)),
    "inspecting": (inspecting, (10, 100, 1000)),
    "passing": (passing, (2, 4, 8)),
    "past": (partial(passing, contending=False), (2, 4, 8)),
    "quadruped": (quadruped, (2, 6)),
}
"""By name, a family and the sizes that are measured."""


def main() -> None:
    """Writes a member of a family."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("family", choices=WALLS)
    parser.add_argument("size", type=int)
    parser.add_argument("out", type=Path)
    options = parser.parse_args()
    save_mission(WALLS[options.family][0](options.size), options.out)


if __name__ == "__main__":
    main()
