"""Hypothesis strategies for users of mcpn: valid missions of any shape, small enough to be explored in full.

>>> from hypothesis import HealthCheck, given, settings
>>> from mcpn.drawing.compose import compose
>>> @settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
... @given(missions(max_objectives=2))
... def composes(mission):
...     compose(mission)
>>> composes()
"""

from __future__ import annotations

from dataclasses import replace

try:
    from hypothesis import strategies as st
except ImportError as error:
    raise ImportError("mcpn.testing needs hypothesis: pip install 'mcpn[testing]'") from error

from mcpn.mission.model import Mission
from mcpn.testing.awkward_names import awkwardly_named
from mcpn.testing.blocks import MissionDrawing
from mcpn.testing.printing import register
from mcpn.testing.shape import Shape as Shape

register()


def missions(shape: Shape | None = None, **bounds: int | bool) -> st.SearchStrategy[Mission]:
    """Valid missions.

    Args:
        shape: Bounds on the missions; the defaults of :class:`Shape` keep most under 100,000 markings.
        **bounds: Bounds to replace in it, by name (``max_`` or ``allow_`` before a name is allowed).

    Returns:
        A strategy. Unless ``disjoint_branches`` is set, its missions may contend for resources;
        :attr:`mcpn.mission.static.resource_use.Usage.contentions` says whether one does.
    """
    fields = {key.removeprefix("max_").removeprefix("allow_"): value for key, value in bounds.items()}
    chosen = replace(shape or Shape(), **fields)  # type: ignore[arg-type]

    @st.composite
    def drawn(draw: st.DrawFn) -> Mission:
        mission = MissionDrawing(draw, chosen).mission()
        return draw(awkwardly_named(mission)) if chosen.awkward_names else mission

    return drawn()
