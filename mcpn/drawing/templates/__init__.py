"""The Petri net templates of the paper (sections 6.1 to 6.3), as one object that a caller can replace.

A set of templates is any object with the methods of :class:`TemplateSet`. Each method draws one element of
the mission into the shared :class:`Canvas`. Templates meet at places of agreed parts, the *interface* (paper,
6.1), which :meth:`Canvas.place_of` names: a resource ``R`` offers ``R_available``, ``R_take``, ``R_answer``,
``R_release``, ``R_error`` (hardware ``R_OOS`` besides; software ``R_free``, ``R_notAvailable``,
``R_waiting``, ``R_activation``, ``R_deactivation``), an activity ``A`` its ``A_Start`` and ``A_Stop``, or
``A_StartByRes``.

What later stages must know of the net's places (which one says that an alternative is active, that hardware
is out of service, that an objective runs) they learn from *roles*, which templates declare on the canvas.
"""

from __future__ import annotations

from typing import Protocol

from mcpn.drawing.templates.activities import draw_activity
from mcpn.drawing.templates.canvas import Canvas, Role
from mcpn.drawing.templates.control import draw_control
from mcpn.drawing.templates.resources import (
    draw_hardware,
    draw_served_software,
    draw_shared_hardware,
    draw_software,
)
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.robot import Activity, Hardware, Software

__all__ = ["Canvas", "PaperTemplates", "Role", "TemplateSet"]


class TemplateSet(Protocol):
    """What the composition asks of a set of templates."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        """Draws a hardware resource."""

    def software(self, canvas: Canvas, resource: Software) -> None:
        """Draws a software resource that some objective may ask for."""

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        """Draws an activity that some objective may start, with its alternatives."""

    def control(self, canvas: Canvas, graph: ObjectivesGraph) -> None:
        """Draws the objectives graph."""


class PaperTemplates:
    """The templates of the paper, with what general missions need beyond its example."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        """Paper, 6.1 and Fig. 6; what several activities may use at a time has an interface for each."""
        if resource.name in canvas.usage.sharing.consumers:
            draw_shared_hardware(canvas, resource)
        else:
            draw_hardware(canvas, resource)

    def software(self, canvas: Canvas, resource: Software) -> None:
        """Paper, 6.1 and Fig. 7; what is shared, or one output of several, has a form of its own."""
        producer = canvas.usage.activities[canvas.usage.producer[resource.name]]
        if canvas.usage.sharing.serves(producer.name):
            draw_served_software(canvas, resource, producer)
        else:
            draw_software(canvas, resource, producer)

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        """Paper, 6.2 and Fig. 8."""
        draw_activity(canvas, activity)

    def control(self, canvas: Canvas, graph: ObjectivesGraph) -> None:
        """Paper, 6.3 and Fig. 9."""
        draw_control(canvas, graph)
