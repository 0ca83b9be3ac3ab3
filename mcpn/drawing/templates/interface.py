"""Where templates meet: the places of an element that others may touch, declared once.

A place at which templates meet has an *owner*, the element whose template draws it. What a token in it says,
and who else may take, put or read one, is its :class:`Meeting`. The parts that all sets of templates agree on
are declared here (:data:`MEETINGS`); a set declares others where it draws them
(:meth:`mcpn.drawing.templates.canvas.Canvas.meet`). All other places are private to who draws them.

Sides: the ``consumer`` of a resource, an activity; its ``producer``, an activity; ``control``, the objectives
graph; a ``product`` of an activity; the ``loss`` of hardware that an activity detects, or of what stands for
its crash; a ``reader``, an activity with an alternative that requires the fact, or has a supplier that does;
a ``watcher``, an activity that may return to a better alternative; an ``event`` that changes several facts.

The contract of the kit (:mod:`mcpn.testing.kit.contract`) and its tables in the documentation follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from mcpn.events import What


class Meeting(NamedTuple):
    """What a place says that templates meet at, and who may touch it.

    Args:
        says: What a token in it says.
        allowed: By side, what it may do: letters of ``take``, ``put`` and ``read``, as ``tpr``.
    """

    says: str
    allowed: Mapping[str, str]


MEETINGS: dict[str, dict[str, Meeting]] = {
    "hardware": {
        "available": Meeting("nobody uses it, or asks for it", {"owner": "tp", "consumer": "t"}),
        "take": Meeting("it is asked for", {"owner": "t", "consumer": "p"}),
        "answer": Meeting("it is held, and works", {"owner": "tp", "consumer": "tpr"}),
        "error": Meeting("it is held, and has failed", {"owner": "p", "consumer": "tr"}),
        "release": Meeting("it is given back", {"owner": "t", "consumer": "p"}),
        "OOS": Meeting("it is out of service", {"owner": "tp", "consumer": "r"}),
        "free": Meeting("it is in service (exclusive: and not in use)", {"owner": "tpr", "consumer": "r"}),
        "service": Meeting(
            "it is in service, for who may return", {"owner": "tp", "consumer": "r", "watcher": "r"}
        ),
        "fine": Meeting(
            "detected late: it is not in use though it is gone", {"owner": "tpr", "control": "r"}
        ),
        "doubted": Meeting(
            "detected late: an objective has failed that may use it", {"owner": "t", "control": "p"}
        ),
        "undoubted": Meeting("detected late: there is no such doubt", {"owner": "pr", "control": "t"}),
    },
    "software": {
        "available": Meeting("the consumer neither holds it nor asks", {"owner": "p", "consumer": "tp"}),
        "take": Meeting("it is asked for", {"owner": "t", "consumer": "p"}),
        "answer": Meeting("it is held, and produced", {"owner": "tp", "consumer": "tpr"}),
        "error": Meeting("it is refused, or is no longer produced", {"owner": "p", "consumer": "tr"}),
        "release": Meeting("it is given back", {"owner": "t", "consumer": "p"}),
        "waiting": Meeting("its producer is to answer", {"owner": "tp", "consumer": "t", "producer": "r"}),
        "free": Meeting("its producer may stop", {"owner": "tp", "consumer": "p", "producer": "r"}),
        "unused": Meeting("no request is open", {"owner": "tp", "consumer": "p", "producer": "r"}),
        "activation": Meeting("its producer runs now", {"owner": "t", "producer": "p"}),
        "deactivation": Meeting("its producer has stopped, or refuses", {"owner": "tp", "producer": "p"}),
    },
    "activity": {
        "Start": Meeting("it is started, or evaluates again", {"owner": "tp", "control": "p"}),
        "Stop": Meeting("an objective stops it", {"owner": "t", "control": "p"}),
        "StartByRes": Meeting("a request starts it, or it evaluates again", {"owner": "tp", "product": "p"}),
        "error": Meeting("no alternative is possible", {"owner": "tp"}),
        "refusing": Meeting("the same of a producer that serves", {"owner": "tp", "product": "r"}),
        "running": Meeting("some alternative runs", {"owner": "tp", "control": "r", "product": "r"}),
        "active1": Meeting(
            "its first alternative runs",
            {"owner": "tp", "control": "r", "product": "r", "loss": "r"},
        ),
        "active": Meeting("another alternative runs", {"owner": "tp", "loss": "r"}),
        "idle": Meeting("it is not started, nor stopping", {"owner": "tp", "control": "t"}),
    },
    "fact": {
        "value": Meeting(
            "the fact has this value",
            {"owner": "tpr", "control": "tpr", "reader": "r", "event": "tpr"},
        )
    },
    "mission": {
        "resting": Meeting("an objective has ended in this reaction", {"control": "tp", "activity": "r"}),
    },
}
"""By kind of element and part of it, the places that all sets of templates agree on.

An alternative has its number in its part: what is said of *active* is said of *active2*.
"""

SAYING: Mapping[str, tuple[str, str]] = {
    "fact": ("fact", "value"),
    "oos": ("hardware", "OOS"),
    "active": ("activity", "active"),
    "refused": ("activity", "refusing"),
}
"""By role the declaration for a place that a set calls otherwise: it is known by what it says."""

CONTROL = frozenset({"objective", "parallel", "mission", "once"})
"""Kinds of elements that the template of the objectives graph draws."""

HAPPENING: Mapping[What, frozenset[str]] = {
    **dict.fromkeys((What.START, What.SUCCESS, What.FAILURE, What.TIMEOUT), CONTROL),
    What.DECLARED: CONTROL | {"fact"},
    **dict.fromkeys((What.OUT_OF_SERVICE, What.REPAIRED, What.DETECTED), frozenset({"hardware"})),
}
"""By what an event says, for elements of which kinds the transitions are drawn that fire with it.

Hardware has transitions for events of its own alone. Any other event is one that a set has named itself.
"""
