"""What missions are drawn from: their size, their parts, names of parameters and reasons."""

from __future__ import annotations

from dataclasses import dataclass

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
