"""Questions about missions and nets: verdicts, temporal logic, causes of failure, properties of nets.

The room is also what ``mcpn.check(mission)`` calls.
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcpn.check.engines import Asked
    from mcpn.check.verdicts.mission import MissionCheck
    from mcpn.mission.model import Mission
    from mcpn.net.compose import MissionNet


class Check(ModuleType):
    """The room as something to call."""

    def __call__(
        self, of: Mission | MissionNet, *, engine: Asked = "auto", max_states: int | None = None
    ) -> MissionCheck:
        """Checks a mission or its net: verdicts, each with a run where there is one, and sizes of graphs.

        Args:
            of: The mission, or its net.
            engine: ``explicit``, ``symbolic`` or ``local``; all give the same answers.
            max_states: The most states to list; the default is the engine's own limit.

        Raises:
            LimitError: A limit was hit.

        Examples:
            >>> import mcpn
            >>> found = mcpn.check(mcpn.read_mission("experiments/courier/mission.xml"), engine="local")
            >>> found.passed, found.unselectable[1].message
            (True, 'alternative localisation.dead_reckoning can never be selected')
            >>> [str(event) for event in found.verdicts["failure_reachable"].runs[0].events][0]
            'MISSION_EV_START'
        """
        from mcpn.check.verdicts.mission import check
        from mcpn.net.compose import as_net

        return check(as_net(of), engine=engine, max_states=max_states)


sys.modules[__name__].__class__ = Check
