"""Hardware and software resources (paper, 6.1; Fig. 6, 7 and 10)."""

from __future__ import annotations

from mcpn.mission.model import Activity, Hardware, Software
from mcpn.net.events import Event, What
from mcpn.net.templates.canvas import Canvas


def draw_hardware(canvas: Canvas, resource: Hardware) -> None:
    """Draws a hardware resource: 9 places and 7 transitions, 6 and 2 where it cannot fail.

    Args:
        canvas: Where to draw.
        resource: The resource.
    """
    r = resource.name
    pen = canvas.of("hardware", r, resource.source)
    free, busy = pen.place("free", initial=1), pen.place("busy")
    if resource.faulty:
        oos, failing = canvas.role(pen.place("OOS"), ("oos", r)), pen.place("failing")
    available, take = pen.place("available", initial=1), pen.place("take")
    answer, release = pen.place("answer"), pen.place("release")
    if resource.faulty:
        error = pen.place("error")
        fails, returns = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
        pen.transition("EV_OOS_f", [free], [failing], event=fails)
        pen.transition("EV_OOS_b", [busy, answer], [failing, error], event=fails)
        pen.transition("3", [failing, available], [oos])
        pen.transition("4", [failing, release], [oos])
        pen.transition("EV_RD", [oos], [free, available], event=returns)
    pen.transition("8", [busy, release], [free, available])
    pen.transition("9", [free, take], [busy, answer])
    canvas.unit([free, busy, *([oos, failing] if resource.faulty else [])])
    canvas.unit([available, take, answer, release, *([error] if resource.faulty else [])])


def draw_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws the only resource of its producer: 11 places, 8 transitions.

    Two places and one transition are added where they are needed: between its consumer's release and its
    producer's stop the producer may bring another activation, or a deactivation, when both were struck by one
    failure or when the producer had waited for a contended resource. The activation of a free resource
    changes nothing; ``quiet`` is marked while no activation is on its way, so that the producer neither stops
    nor refuses before its activation has been taken note of; and ``failed`` tells a resource whose consumer
    has yet to take note of an error from one that is only ordered to stop, so that no release is mistaken.

    Args:
        canvas: Where to draw.
        resource: The resource.
        producer: The activity that produces it.
    """
    s, a = resource.name, producer.name
    pen = canvas.of("software", s, resource.source)
    free, busy = pen.place("free"), pen.place("busy")
    not_available, waiting = pen.place("notAvailable", initial=1), pen.place("waiting")
    activation, deactivation = pen.place("activation"), pen.place("deactivation")
    available, take = pen.place("available", initial=1), pen.place("take")
    answer, release, error = pen.place("answer"), pen.place("release"), pen.place("error")
    pen.transition("1", [take, not_available], [waiting, canvas.place_of("activity", a, "StartByRes")])
    quiet = [pen.place("quiet", initial=1)] if canvas.usage.released_unasked(s) else []
    pen.transition("2", [waiting, activation], [busy, answer, *quiet])
    failed = pen.place("failed") if quiet else deactivation
    pen.transition("3", [waiting, deactivation], [failed, error])
    pen.transition("6", [busy, answer, deactivation], [failed, error])
    pen.transition("8", [failed, release], [not_available, available])
    pen.transition("4", [busy, release], [free])
    pen.transition("5", [free, deactivation], [not_available, available])
    pen.transition("7", [busy, activation], [busy, *quiet])
    if quiet:
        pen.transition("10", [free, activation], [free, *quiet])
    canvas.unit([not_available, waiting, free, busy, *([failed] if quiet else [])])
    canvas.unit([available, take, answer, release, error])


def draw_shared_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws one of several resources of one producer: 11 places.

    The producer is started once, serves whichever of its resources are requested, and stops when none is.
    So it needs no activation and no deactivation of each; instead the place ``unused`` is marked while the
    resource is neither requested nor held, ``deactivation`` while its consumer has yet to take note of an
    error, and ``free`` from its release on until it is known whether the producer goes on: it does while a
    consumer holds another of its resources, and then the resource is available again; otherwise the producer
    stops and takes all its free resources with it.

    Args:
        canvas: Where to draw.
        resource: The resource.
        producer: The activity that produces it and others.
    """
    s, a = resource.name, producer.name
    pen = canvas.of("software", s, resource.source)
    running = canvas.place_of("activity", a, "active1" if len(producer.alternatives) == 1 else "running")
    free, busy = pen.place("free"), pen.place("busy")
    not_available, waiting = pen.place("notAvailable", initial=1), pen.place("waiting")
    deactivation, unused = pen.place("deactivation"), pen.place("unused", initial=1)
    available, take = pen.place("available", initial=1), pen.place("take")
    answer, release, error = pen.place("answer"), pen.place("release"), pen.place("error")
    back = [not_available, available, unused]
    pen.transition("1", [take, not_available, unused], [waiting])
    pen.transition("2", [waiting], [busy, answer], read=[running])
    pen.transition("4", [busy, release], [free])
    for other in producer.produces:
        if other != s:
            pen.transition(("9", other), [free], back, read=[canvas.place_of("software", other, "answer")])
    if canvas.usage.may_wait(a):
        # A request may be given up before the producer has even been started.
        pen.transition("10", [free], back, read=[canvas.place_of("activity", a, "idle")])
    if canvas.usage.refusable(a):
        refusing = canvas.place_of("activity", a, "refusing")
        pen.transition("3", [waiting], [deactivation, error, unused], read=[refusing])
        pen.transition("6", [busy, answer], [deactivation, error, unused], read=[refusing])
        pen.transition("5", [free], back, read=[refusing])
        pen.transition("8", [deactivation, release], [not_available, available])
    canvas.unit([not_available, waiting, free, busy, deactivation])
    canvas.unit([available, take, answer, release, error])
