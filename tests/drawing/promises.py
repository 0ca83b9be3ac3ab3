"""What every composed mission owes, whatever its engine: the kit's promises, in its whole markings graph."""

from __future__ import annotations

from mcpn.answers.verdicts.modes import Situation
from mcpn.drawing.compose import MissionNet
from mcpn.robot.runtime.controller_tables import Inside
from mcpn.spaces.markings.graph import StateGraph
from mcpn.testing.kit import promises
from mcpn.testing.kit.subject import Subject


def check_promises(found: MissionNet, graph: StateGraph) -> None:
    """Checks unit invariants in every marking, hardware and activities in stable ones, idleness at the ends.

    Args:
        found: The mission's net.
        graph: Its markings graph.
    """
    promises.check_promises(Subject.known(found, graph))


def check_each_is_one_thing(found: MissionNet, now: Situation | Inside) -> None:
    """Checks that each activity of an objective that runs does so, waits, or is refused: one of three."""
    assert promises.not_one_thing(found, now) is None
