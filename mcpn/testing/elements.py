"""Missions with all elements of the language, contended and not, by what is drawn most in them."""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.model import Mission
from mcpn.testing import missions
from mcpn.testing.data import data_sharing_missions
from mcpn.testing.ends import nested_ends
from mcpn.testing.shape import UNCONTENDED
from mcpn.testing.stacked import stacked_missions

ANY = missions(sections=6)
INTERRUPTED = missions(sections=5, hardware=2, producers=2, events=2)
ABORTED = missions(sections=6, hardware=2, producers=2, branches=3, events=2, aborts=4)
"""Blocks that abort, and blocks that route what aborts in them."""
EARLY = missions(sections=7, hardware=2, producers=2, branches=3, events=2, aborts=1, early=6)
"""Parallel blocks that do not await all of their branches."""
EARLY_WIDE = missions(sections=8, branches=8, hardware=1, producers=1, objectives=2, events=1, early=8)
COMMON_CAUSES = missions(sections=5, faults=2, aborts=1)
"""One event takes several hardware resources out of service."""
LASTING = missions(sections=5, faults=1, aborts=1, lasting=True)
"""Hardware that is never repaired, or out of service at the start."""
LASTING_APART = missions(UNCONTENDED, sections=5, outputs=3, events=1, lasting=True)
CRASHING = missions(sections=5, faults=1, aborts=1, lasting=True, crashes=True)
"""Activities and alternatives that crash while they run, some of them for good."""
CRASHING_APART = missions(UNCONTENDED, sections=5, outputs=3, hardware=2, events=1, crashes=True)
LATE = missions(sections=5, hardware=2, lasting=True, aborts=1, timeouts=1, late=True)
"""Hardware whose loss is detected late."""
LATE_APART = missions(UNCONTENDED, sections=5, outputs=3, events=1, faults=1, late=True)
RECOVERING = st.integers(0, 1).flatmap(
    lambda facts: missions(
        sections=5,
        objectives=4,
        hardware=2,
        producers=2,
        events=1,
        aborts=1,
        recovers=9,
        facts=facts,
        loops=False,
        timeouts=2,
    )
)
"""Blocks that recover by a sibling."""
PAUSING = missions(
    sections=6, objectives=3, hardware=2, producers=2, events=2, aborts=1, recovers=1, pauses=9, timeouts=1
)
"""Blocks that pause while a sibling is run."""
PAUSING_APART = missions(
    UNCONTENDED,
    sections=7,
    branches=3,
    depth=3,
    events=2,
    aborts=1,
    recovers=1,
    pauses=9,
    early=3,
    timeouts=1,
)
"""Blocks with branches that pause, where nothing contends."""
LED = missions(
    sections=6,
    objectives=4,
    depth=2,
    hardware=1,
    producers=1,
    alternatives=1,
    events=2,
    aborts=3,
    recovers=5,
    pauses=9,
    led=8,
)
"""Siblings that are run for others, by pauses and recoveries, and that routes lead to as well."""
PAUSING_FACTS = missions(
    sections=6,
    depth=3,
    hardware=2,
    producers=1,
    alternatives=2,
    events=2,
    facts=2,
    pauses=9,
    aborts=1,
    early=2,
    rounds=False,
)
TIMED = missions(sections=6, hardware=2, producers=2, branches=3, events=1, aborts=2, timeouts=7)
"""Objectives that end when their time is over."""
IN_TIME = missions(
    sections=6,
    depth=3,
    hardware=1,
    producers=1,
    alternatives=2,
    branches=2,
    events=1,
    aborts=2,
    early=2,
    timeouts=1,
    timed_blocks=8,
    facts=1,
    pauses=3,
    recovers=2,
)
"""Blocks that are left when their time is over."""
PAUSING_IN_TIME = missions(
    UNCONTENDED, sections=7, branches=3, depth=3, events=2, aborts=1, pauses=9, early=3, timed_blocks=6
)
"""The same where nothing contends, with pauses."""
LEFT_BY_FACTS = missions(
    sections=6,
    depth=3,
    hardware=1,
    producers=1,
    alternatives=2,
    branches=3,
    events=1,
    facts=3,
    aborts=2,
    early=2,
    timeouts=1,
    timed_blocks=2,
    reasons=1,
    recovers=1,
    guards=1,
    becoming=6,
)
"""Blocks that are left when facts become so."""
LEFT_BY_FACTS_APART = missions(
    UNCONTENDED, sections=6, branches=3, depth=3, hardware=2, events=1, facts=3, aborts=2, early=3, becoming=7
)
"""The same where nothing contends."""
ENDS_AT_ONCE = nested_ends()
"""Blocks in blocks of which one event, or one fact, ends several branches at the same moment."""
NAMED = st.integers(0, 2).flatmap(
    lambda facts: missions(
        sections=6,
        depth=3,
        hardware=1,
        producers=1,
        alternatives=2,
        events=1,
        facts=min(facts, 1),
        aborts=1,
        early=1,
        recovers=3,
        pauses=1,
        timeouts=1,
        timed_blocks=1,
        guards=2,
        reasons=7,
    )
)
"""Objectives that fail for reasons, and blocks around them that have routes for these."""
NAMED_APART = missions(
    UNCONTENDED, sections=6, depth=3, branches=3, outputs=3, recovers=2, early=2, reasons=7
)
WORLD = missions(sections=5, hardware=2, producers=2, facts=2, events=1)
"""Facts that objectives and events change, and that routes and alternatives read."""
WORLD_ABORTED = missions(sections=6, hardware=2, producers=1, branches=3, facts=2, aborts=4, early=3)
WORLD_APART = missions(UNCONTENDED, sections=5, hardware=2, outputs=3, events=1, facts=2)
GUARDED = missions(
    sections=6, objectives=4, hardware=1, producers=1, alternatives=2, facts=2, events=1, guards=6, aborts=1
)
"""Blocks that are entered only where facts are so."""
MIXED = missions(
    sections=5,
    depth=3,
    hardware=2,
    producers=1,
    alternatives=2,
    branches=2,
    events=1,
    facts=1,
    aborts=1,
    early=2,
    timeouts=1,
    timed_blocks=1,
    reasons=2,
    recovers=2,
    pauses=2,
    led=2,
    guards=2,
    becoming=2,
    faults=1,
    lasting=True,
    crashes=True,
    late=True,
)
"""A little of each, so that any two elements meet."""
MIXED_APART = missions(
    UNCONTENDED,
    sections=5,
    branches=2,
    events=1,
    facts=1,
    aborts=1,
    early=2,
    timed_blocks=1,
    reasons=2,
    recovers=2,
    pauses=2,
    guards=2,
    becoming=2,
    crashes=True,
    late=True,
)
"""The same where nothing contends."""
IN_ROUNDS = missions(
    sections=6, hardware=1, producers=0, activities=2, alternatives=1, events=1, interrupted=True
)
"""Little but blocks: handlers in rounds, tries, values and uses."""
APART = missions(UNCONTENDED, sections=5, outputs=3, events=1)
"""Nothing contends, whatever runs together."""
SHARING = data_sharing_missions()
"""The same, with data that branches share."""
SHARING_FACTS = data_sharing_missions(facts=True)
"""The same, with facts that make a branch give data up as another begins to use it."""
DISJOINT = missions(sections=6, outputs=3, disjoint_branches=True)
WIDE = missions(sections=8, branches=8, hardware=2, producers=1, objectives=2, alternatives=2)
CHAINS = stacked_missions() | missions(sections=4, producers=4, alternatives=2, awkward_names=True)
SAYING = missions(sections=5, hardware=1, producers=1, alternatives=2, text=True)
"""With parameters on blocks, uses and values."""

MISSIONS: st.SearchStrategy[Mission] = st.one_of(
    ANY,
    INTERRUPTED,
    ABORTED,
    EARLY,
    EARLY_WIDE,
    COMMON_CAUSES,
    LASTING,
    LASTING_APART,
    CRASHING,
    CRASHING_APART,
    RECOVERING,
    PAUSING,
    PAUSING_APART,
    PAUSING_FACTS,
    LED,
    TIMED,
    IN_TIME,
    PAUSING_IN_TIME,
    LEFT_BY_FACTS,
    LEFT_BY_FACTS_APART,
    ENDS_AT_ONCE,
    NAMED,
    WORLD,
    WORLD_ABORTED,
    WORLD_APART,
    IN_ROUNDS,
    APART,
    SHARING,
    SHARING_FACTS,
    DISJOINT,
    WIDE,
    CHAINS,
    SAYING,
)
"""Most of them; measured tables are of what is drawn here from fixed seeds."""

WIDEST = st.one_of(MISSIONS, LATE, LATE_APART, NAMED_APART, GUARDED, MIXED, MIXED_APART)
"""All of them."""
