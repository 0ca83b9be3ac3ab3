"""The controller: a finite state machine made from the alternatives graph.

The room is also what ``mcpn.controller(mission)`` calls.

>>> import mcpn
>>> machine = mcpn.controller(mcpn.read_mission("experiments/ulysse/mission.xml"))
>>> len(machine.sections), len(machine.types)
(5, 2)
"""

from __future__ import annotations

import sys
from types import ModuleType
from typing import TYPE_CHECKING, Literal, overload

if TYPE_CHECKING:
    from mcpn.controller.generate import Form
    from mcpn.controller.hierarchy import TableController
    from mcpn.controller.modular import AnyController, ModularController
    from mcpn.mission.model import Mission
    from mcpn.net.compose import MissionNet


class Generate(ModuleType):
    """The room as something to call."""

    @overload
    def __call__(
        self,
        of: Mission | MissionNet,
        form: Literal["flat", "hierarchical"] = "hierarchical",
        *,
        max_states: int | None = None,
    ) -> TableController: ...
    @overload
    def __call__(
        self, of: Mission | MissionNet, form: Literal["modular"], *, max_states: int | None = None
    ) -> ModularController: ...
    def __call__(
        self, of: Mission | MissionNet, form: Form = "hierarchical", *, max_states: int | None = None
    ) -> AnyController:
        """Generates the controller of a mission: finite state machines that do what was verified.

        Args:
            of: The mission, or its net.
            form: ``hierarchical``, a machine for each type of section; ``modular``, rules for each; or
                ``flat``, one machine for the mission.
            max_states: The most states of a machine.

        Raises:
            SemanticsError: The mission is not safe or not confluent.
            LimitError: A machine would have more states than allowed.

        Examples:
            >>> import mcpn
            >>> mission = mcpn.read_mission("experiments/ulysse/mission.xml")
            >>> flat = mcpn.controller(mission, "flat")
            >>> [len(machine.states) for machine in flat.types]
            [236]
        """
        from mcpn.controller.generate import generate
        from mcpn.net.compose import as_net

        return generate(as_net(of), form, max_states=max_states)


sys.modules[__name__].__class__ = Generate
