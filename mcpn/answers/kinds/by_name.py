"""All kinds of claims by name, in the order in which they are shown, and those of verdicts by verdict."""

from __future__ import annotations

from collections.abc import Mapping

from mcpn.answers.kinds.kind import ClaimKind
from mcpn.answers.kinds.of_causes import OF_CAUSES
from mcpn.answers.kinds.of_cells import OF_CELLS
from mcpn.answers.kinds.of_events import HANDLED, INTERRUPTING
from mcpn.answers.kinds.of_help import OF_HELP
from mcpn.answers.kinds.of_losses import BEFORE_AND_WORST, DURING_OBJECTIVES, NOTICED_LATE
from mcpn.answers.kinds.of_reach import OF_REACH
from mcpn.answers.kinds.of_verdicts import REQUIREMENTS, VERDICTS

KINDS: Mapping[str, ClaimKind] = {
    kind.name: kind
    for kind in (
        *VERDICTS,
        *BEFORE_AND_WORST,
        *HANDLED,
        *NOTICED_LATE,
        *INTERRUPTING,
        *REQUIREMENTS,
        *DURING_OBJECTIVES,
        *OF_REACH,
        *OF_CAUSES,
        *OF_HELP,
        *OF_CELLS,
    )
}
"""By name, in the order in which they are shown."""

OF_VERDICTS: Mapping[str, ClaimKind] = {kind.verdict: kind for kind in VERDICTS if kind.verdict}
"""By verdict, in the order in which they are read."""
