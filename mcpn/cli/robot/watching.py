"""Monitors of a mission's requirements, for commands that play or run it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mcpn.runtime.monitors import Monitors
    from mcpn.study import Study


def monitors_for(study: Study, max_states: int | None) -> Monitors:
    """The monitors of a mission, at its start."""
    from mcpn.controller.monitors.writing import files, monitors_of
    from mcpn.runtime.monitors import Monitors

    return Monitors(json.loads(files(monitors_of(study.spaces, max_states))["monitors.json"]))
