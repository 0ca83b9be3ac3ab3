"""Names of two files under the name of the one that they were."""

from mcpn.robot.runtime.actions import START, Action, ParameterValue, Refused, spelled
from mcpn.robot.runtime.controller_tables import Inside, Laws, RuntimePosition, Tables, TableSection, read

__all__ = [
    "START",
    "Action",
    "Inside",
    "Laws",
    "ParameterValue",
    "Refused",
    "RuntimePosition",
    "TableSection",
    "Tables",
    "read",
    "spelled",
]
