"""mcpn: a symbolic and compositional verifier of robot missions.

What a Python user types first; each name is loaded when it is first used.

>>> import mcpn
>>> study = mcpn.open("experiments/ulysse/mission.xml")
>>> study.check().passed, study.states().states
(True, 44299)
>>> study.ctl("AG EF (success | failure)").holds
True

A study keeps what it has built for one question for the next.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from mcpn.version import VERSION

if TYPE_CHECKING:
    from mcpn.mission.xml import read_mission
    from mcpn.study import Study
    from mcpn.study import open_study as open

__all__ = ["Study", "open", "read_mission"]
__version__ = VERSION

_FROM = {
    "Study": ("mcpn.study", "Study"),
    "open": ("mcpn.study", "open_study"),
    "read_mission": ("mcpn.mission.xml", "read_mission"),
}
"""By name the module that defines it, and its name there."""


def __getattr__(name: str) -> object:
    if name not in _FROM:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module, defined = _FROM[name]
    return getattr(import_module(module), defined)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
