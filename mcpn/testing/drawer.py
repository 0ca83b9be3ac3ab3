"""Draws what all parts of a mission have: names, numbers, chances, texts and parameters."""

from __future__ import annotations

from hypothesis import strategies as st

from mcpn.mission.robot import Parameter
from mcpn.testing.shape import PARAMETERS, Shape

TEXTS = st.text(
    st.characters(codec="utf-8", exclude_categories=("Cc", "Cs", "Cn", "Co")) | st.sampled_from("\t\n\r"),
    max_size=12,
)
MAYBE_TEXT = st.none() | TEXTS
"""Made once: hypothesis takes longer to look at a new strategy than to draw from it."""


class MissionDrawer:
    """Draws one mission, part by part; names are numbered.

    Args:
        draw: Given by hypothesis.
        shape: Bounds on the mission.
    """

    def __init__(self, draw: st.DrawFn, shape: Shape) -> None:
        self.draw = draw
        self.shape = shape
        self.count = 0

    def number(self, low: int, high: int) -> int:
        """A whole number."""
        return self.draw(st.integers(low, high))

    def chance(self) -> bool:
        """Yes or no."""
        return self.draw(st.booleans())

    def name(self, prefix: str) -> str:
        """A name that no other element has."""
        self.count += 1
        return f"{prefix}{self.count}"

    def description(self) -> str | None:
        """A text or none."""
        return self.draw(MAYBE_TEXT) if self.shape.text else None

    def parameters(self) -> tuple[Parameter, ...]:
        """A parameter or none."""
        if not self.shape.text or not self.chance():
            return ()
        unit = self.draw(MAYBE_TEXT)
        name = self.draw(st.sampled_from(PARAMETERS))
        return (Parameter(name=name, value=self.draw(TEXTS), unit=unit),)

    def rarely(self, of_ten: int) -> bool:
        """Whether something is to be that is so some times of ten; nothing is drawn where it never is."""
        return of_ten > 0 and self.number(0, 9) >= 10 - of_ten

    def value(self, least: float, most: float) -> float | None:
        """A number for numbers of risk, or none."""
        return self.draw(st.none() | st.floats(least, most)) if self.shape.numbers else None
