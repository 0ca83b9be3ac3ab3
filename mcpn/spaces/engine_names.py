"""Names of engines and of graphs, and the arguments by which questions say them."""

from __future__ import annotations

from typing import Final, Literal, TypeAlias, TypedDict, get_args

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
Asked: TypeAlias = Literal["auto", Engine, "search"]
"""An engine by name, or ``auto``; ``search`` answers questions of logic without a space."""
Counting: TypeAlias = Literal["auto", Engine, "pyeda"]
"""Who counts states; ``auto``: the first of the others that answers."""
SPACE_ENGINES: tuple[Engine, ...] = get_args(Engine)
"""Those that build a space."""


class Limited(TypedDict, total=False):
    """What a question may be asked within.

    Args:
        max_states: Limit on states that are listed one by one; by default that of each engine.
    """

    max_states: int | None


class Asking(Limited, total=False):
    """Who is asked a question, and within what: said of a study, of spaces or of one question.

    Args:
        engine: Who answers: ``explicit``, ``symbolic``, ``local``, or ``auto``: the first of them that does.
    """

    engine: Asked
