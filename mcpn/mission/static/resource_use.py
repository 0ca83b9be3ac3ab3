"""The static analysis of a mission as one object: its demands, with what is shared and handed over."""

from __future__ import annotations

from functools import cached_property

from mcpn.mission.static.demands import ConcurrentDemands
from mcpn.mission.static.handover import Handover
from mcpn.mission.static.sharing import Sharing


class Usage(ConcurrentDemands):
    """The static analysis of a mission; computed once, read by templates, checks and the composition.

    Args:
        mission: A valid mission.
        graph: Its objectives graph.
    """

    @cached_property
    def sharing(self) -> Sharing:
        """Which resources several activities may use at a time."""
        return Sharing(self)

    @cached_property
    def handover(self) -> Handover:
        """What an objective must wait for before it begins."""
        return Handover(self, self.sharing)
