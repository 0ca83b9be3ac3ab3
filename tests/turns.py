"""A space of diagrams that takes turns of saturation and chaining from the first step on."""

from __future__ import annotations

from mcpn.space.diagrams.spaces import DiagramMarkings


class ByTurns(DiagramMarkings):
    """Diagrams whose closures never come to an end in the first turn."""

    first_steps = 1
