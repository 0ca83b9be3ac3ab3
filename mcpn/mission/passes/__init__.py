"""From what an author writes to the core mission, one construct after the other.

Each pass reads a mission and gives one without its construct. What is left are objectives that hold others
one after the other, parallel blocks and elementary objectives, each with the name that it has from then on
(``visit_12.travel_try2``). Such a mission is a *core mission* (``core="true"`` in files): its names may be
qualified, and blocks say by ``copy`` which copy of what is written they are.

Nothing that an author writes is left to the objectives graph (:mod:`mcpn.mission.core.flattening`), which
resolves what a core mission says: where exits of blocks lead, as facts are, and which handlers are in effect
where.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from mcpn.mission.model import Mission
from mcpn.mission.passes.crashes import crashes
from mcpn.mission.passes.done import done
from mcpn.mission.passes.each import each
from mcpn.mission.passes.early_ends import early_ends
from mcpn.mission.passes.facts_and_timeouts import becoming, timeouts
from mcpn.mission.passes.faults import faults
from mcpn.mission.passes.guards import guards
from mcpn.mission.passes.named_failures import named_failures
from mcpn.mission.passes.parameters import parameters
from mcpn.mission.passes.pauses import pauses
from mcpn.mission.passes.reasons import reasons
from mcpn.mission.passes.recovery import recovery
from mcpn.mission.passes.repeat import repeat
from mcpn.mission.passes.retries import retries
from mcpn.mission.passes.successors import successors
from mcpn.mission.passes.uses import uses
from mcpn.mission.rewriting.limits import measure

PASSES: tuple[Callable[[Mission], Mission], ...] = (
    done,
    successors,
    uses,
    becoming,
    repeat,
    retries,
    each,
    timeouts,
    recovery,
    guards,
    early_ends,
    parameters,
    reasons,
    faults,
    crashes,
    pauses,
    named_failures,
)
"""In the order in which they run."""


def core(mission: Mission, until: str = "") -> Mission:
    """The core mission of a valid mission.

    Args:
        mission: The mission.
        until: The name of a pass, the last that runs; all run by default.

    Raises:
        LimitError: It would be too large.
    """
    measure(mission)
    for rewrite in PASSES:
        mission = rewrite(mission)
        if rewrite.__name__ == until:
            break
    return replace(mission, core=True)
