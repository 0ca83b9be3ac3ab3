"""The engines, and the graphs that they are asked for, by name."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias

EXPLICIT: Final = "explicit"
"""Lists states in arrays."""
SYMBOLIC: Final = "symbolic"
"""Holds them in decision diagrams."""
LOCAL: Final = "local"
"""Explores sections by type, and glues them: composition."""
PYEDA: Final = "pyeda"
"""The reference of binary decision diagrams, which only counts markings."""

On: TypeAlias = Literal["markings", "alternatives"]
Engine: TypeAlias = Literal["explicit", "symbolic", "local"]
Asked: TypeAlias = Literal["auto", "explicit", "symbolic", "local", "search"]
"""An engine by name, or ``auto``; ``search`` answers questions of logic without a space."""
Counting: TypeAlias = Literal["auto", "explicit", "symbolic", "local", "pyeda"]
"""Who counts states; ``auto``: the first of the others that answers."""
