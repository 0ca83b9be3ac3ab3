"""What missions are drawn from, their size and parts, and small missions to write down by hand."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any

from hypothesis import strategies as st
from hypothesis.vendor.pretty import for_type_by_name

from mcpn.mission.model import Block, Mission, Objective
from mcpn.mission.robot import Activity, Alternative, DeclaredEvent, Hardware, Parameter, Robot, Software
from mcpn.mission.writer import written

PARAMETERS = ("speed", "depth", "round")
"""Names of parameters that are drawn: few, so that blocks one in the other say the same."""
REASONS = ("stuck", "no_path", "blocked")
"""Reasons for failures that are drawn: few, so that objectives fail for the same."""


@dataclass(frozen=True)
class Shape:
    """Bounds on generated missions.

    Args:
        hardware: Most hardware resources.
        producers: Most activities that produce; later ones may consume what earlier ones produce.
        alternatives: Most alternatives of an activity.
        outputs: Most resources that one activity produces.
        activities: Most activities that objectives start, unless ``shared_activities`` asks for more.
        sections: Most elementary objectives in all, uses expanded.
        objectives: Most blocks in a series.
        depth: How deep blocks nest.
        parallel: Whether parallel blocks are drawn.
        branches: Most children of a parallel block; the more of them, the fewer blocks each has.
        protocols: Whether protocols are drawn and used, also by one another.
        loops: Whether routes may go back.
        rounds: Whether blocks are retried, repeated and done for each of some values, with activities that
            may be shared, or hardware of one activity alone.
        aborts: How many of ten routes lead to abort that might lead to succeed or fail, and how many of ten
            blocks route what aborts in them: with none nothing aborts.
        timeouts: How many of ten objectives end by themselves when their time is over.
        timed_blocks: The same of blocks that hold others.
        becoming: How many of ten blocks are left when facts become so.
        reasons: How many of ten objectives and activities fail for reasons, how many of ten blocks around
            them have a route for one.
        recovers: How many of ten series have a block that recovers by another one.
        pauses: How many of ten series have a block that pauses on an event, while another one is run.
        led: In how many of ten series with a block that is run for another a route leads to it as well.
        early: How many of ten parallel blocks end as soon as some children have, how many of ten fail so.
        events: Most declared events; with some, blocks and the mission handle them.
        interrupted: Whether most blocks handle each event, most handlers happen once, and half of the blocks
            are done in rounds; else a third, a quarter and a quarter.
        guards: How many of ten blocks behind the first of a series have a guard, where there are facts.
        facts: Most facts of the world; with some, objectives and events change them, routes and alternatives
            read them.
        shared_activities: Whether two objectives may start the same activity.
        disjoint_branches: Whether what runs together (branches of a parallel block, activities of one
            objective, the chain under one activity) shares no resource and no activity, so that nothing
            contends.
        own_hardware: Whether hardware that one activity consumes is consumed by no other unless it is shared,
            as half of it is then, and all software is shared; with ``shared_activities`` off as well nothing
            contends, whatever runs together: an activity is then shared by the rounds of one block alone.
        faults: Most common causes of failures, each of some hardware.
        lasting: Whether some hardware is never repaired, and some is out of service at the start.
        crashes: Whether some activities and alternatives may crash, and some of those never recover.
        late: Whether the loss of some hardware is detected late, by an activity or as an objective fails.
        text: Whether descriptions and parameters are drawn.
        numbers: Whether rates, durations and probabilities are drawn, each or none.
        awkward_names: Whether names are drawn that look like parts of one another and of what nets and
            events are called, the same one for elements of different kinds.
    """

    hardware: int = 3
    producers: int = 3
    alternatives: int = 3
    outputs: int = 2
    activities: int = 4
    sections: int = 16
    objectives: int = 3
    depth: int = 2
    parallel: bool = True
    branches: int = 2
    protocols: bool = True
    loops: bool = True
    rounds: bool = True
    aborts: int = 0
    timeouts: int = 0
    timed_blocks: int = 0
    becoming: int = 0
    reasons: int = 0
    early: int = 0
    recovers: int = 0
    pauses: int = 0
    led: int = 0
    events: int = 0
    interrupted: bool = False
    guards: int = 0
    facts: int = 0
    shared_activities: bool = True
    disjoint_branches: bool = False
    own_hardware: bool = False
    faults: int = 0
    lasting: bool = False
    crashes: bool = False
    late: bool = False
    text: bool = False
    numbers: bool = False
    awkward_names: bool = False


UNCONTENDED = Shape(own_hardware=True, shared_activities=False)
"""Missions in which nothing contends, whatever runs together."""


# Missions in which an activity, its suppliers, the one beside it and the next objective want the same.
#
# These are rare among missions of any shape. In them a section stops while a producer still looks for another
# alternative, what the producer takes last is what the next section asks for first, and a consumer comes
# while another one goes.


@st.composite
def stacked_missions(draw: st.DrawFn) -> Mission:
    """Two objectives one after the other over a stack of producers with a fallback each.

    Args:
        draw: Given by hypothesis.

    Returns:
        A strategy of missions with at most a few thousand markings.
    """
    below = [f"h{i}" for i in range(draw(st.integers(2, 3)))]

    def one_of_two(name: str, resources: list[str]) -> tuple[Alternative, ...]:
        chosen = draw(st.permutations(resources))[:2]
        return tuple(Alternative(name=f"{name}_{i}", consumes=(one,)) for i, one in enumerate(chosen))

    activities: list[Activity] = []
    made: list[str] = []
    for i in range(draw(st.integers(1, 2))):
        name, product = f"producer{i}", f"s{i}"
        activities.append(
            Activity(name=name, produces=(product,), alternatives=one_of_two(name, below + made))
        )
        made.append(product)
    wanted = draw(st.permutations(below + made))[: draw(st.integers(1, 3))]
    activities.append(
        Activity(name="first", alternatives=(Alternative(name="first", consumes=tuple(wanted)),))
    )
    activities.append(Activity(name="beside", alternatives=one_of_two("beside", below + made)))
    then = draw(st.sampled_from(below + made))
    activities.append(Activity(name="then", alternatives=(Alternative(name="then", consumes=(then,)),)))
    shared = draw(st.sets(st.sampled_from(below)))
    robot = Robot(
        name="robot",
        hardware=tuple(Hardware(name=h, shared=h in shared) for h in below),
        software=tuple(Software(name=s) for s in made),
        activities=tuple(activities),
    )
    together = draw(st.sampled_from([("first",), ("first", "beside"), ("beside", "first")]))
    blocks = (Objective(name="one", activities=together), Objective(name="two", activities=("then",)))
    return Mission(name="mission", blocks=blocks, robots=(robot,))


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


# What hypothesis prints of the mission or net of a failing property: a mission as a file, a net whole.
#
# Releases of hypothesis before 6.125 print dataclasses by their repr; with these printers all print the same.


def as_xml(mission: Mission) -> str:
    """A mission as the file that says it, valid or not.

    Raises:
        ValueError: A text holds a character that XML cannot.
    """
    return written(mission).decode().partition("?>")[2].strip()


def print_mission(example: Mission, printer: Any, cycle: bool) -> None:
    """Prints a mission as its file, to save and to read again."""
    try:
        lines = as_xml(example).splitlines()
    except (ValueError, TypeError, AttributeError):  # what no file can say
        print_whole(example, printer, cycle)
        return
    for number, line in enumerate(lines):
        if number:
            printer.break_()
        printer.text(line)


def print_whole(example: Any, printer: Any, cycle: bool) -> None:
    """Prints a dataclass with the fields that make it, whatever its repr says."""
    name = type(example).__name__
    if cycle:
        printer.text(f"{name}(...)")
        return
    with printer.group(4, f"{name}(", ")"):
        for number, field in enumerate(f for f in fields(example) if f.init):
            if number:
                printer.text(",")
                printer.breakable()
            printer.text(f"{field.name}=")
            printer.pretty(getattr(example, field.name))


def register() -> None:
    """Tells hypothesis to print missions and nets so."""
    for_type_by_name("mcpn.mission.model", "Mission", print_mission)
    for_type_by_name("mcpn.nets.petri", "PetriNet", print_whole)


TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co")) | st.sampled_from("\t\n\r"),
    max_size=12,
)
MAYBE_TEXT = st.none() | TEXTS
"""Made once: hypothesis takes longer to look at a new strategy than to draw from it."""


class MissionDrawer:
    """Draws one mission, part by part; names are numbered.

    Args:
        draw: Given by hypothesis.
        shape: Bounds on the mission.
    """

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        self.draw = draw
        self.shape = shape
        self.count = 0

    def number(self, low: int, high: int) -> int:
        """A whole number."""
        return self.draw(st.integers(low, high))

    def chance(self) -> bool:
        """Yes or no."""
        return self.draw(st.booleans())

    def name(self, prefix: str) -> str:
        """A name that no other element has."""
        self.count += 1
        return f"{prefix}{self.count}"

    def description(self) -> str | None:
        """A text or none."""
        return self.draw(MAYBE_TEXT) if self.shape.text else None

    def parameters(self) -> tuple[Parameter, ...]:
        """A parameter or none."""
        if not self.shape.text or not self.chance():
            return ()
        unit = self.draw(MAYBE_TEXT)
        name = self.draw(st.sampled_from(PARAMETERS))
        return (Parameter(name=name, value=self.draw(TEXTS), unit=unit),)

    def rarely(self, of_ten: int) -> bool:
        """Whether something is to be that is so some times of ten; nothing is drawn where it never is."""
        return of_ten > 0 and self.number(0, 9) >= 10 - of_ten

    def value(self, least: float, most: float) -> float | None:
        """A number for numbers of risk, or none."""
        return self.draw(st.none() | st.floats(least, most)) if self.shape.numbers else None
