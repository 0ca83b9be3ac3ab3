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
    free, busy = pen.place(f"{r}_free", initial=1), pen.place(f"{r}_busy")
    oos, failing = f"{r}_OOS", f"{r}_failing"
    if resource.faulty:
        canvas.role(pen.place(oos), ("oos", r))
        pen.place(failing)
    available, take = pen.place(f"{r}_available", initial=1), pen.place(f"{r}_take")
    answer, release = pen.place(f"{r}_answer"), pen.place(f"{r}_release")
    if resource.faulty:
        error = pen.place(f"{r}_error")
        fails, returns = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
        pen.transition(f"{fails}_f", [free], [failing], event=fails)
        pen.transition(f"{fails}_b", [busy, answer], [failing, error], event=fails)
        pen.transition(f"{r}_3", [failing, available], [oos])
        pen.transition(f"{r}_4", [failing, release], [oos])
        pen.transition(f"{returns}", [oos], [free, available], event=returns)
    pen.transition(f"{r}_8", [busy, release], [free, available])
    pen.transition(f"{r}_9", [free, take], [busy, answer])
    canvas.unit([free, busy, oos, failing] if resource.faulty else [free, busy])
    canvas.unit(
        [available, take, answer, release, f"{r}_error"]
        if resource.faulty
        else [available, take, answer, release]
    )


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
    free, busy = pen.place(f"{s}_free"), pen.place(f"{s}_busy")
    not_available, waiting = pen.place(f"{s}_notAvailable", initial=1), pen.place(f"{s}_waiting")
    activation, deactivation = pen.place(f"{s}_activation"), pen.place(f"{s}_deactivation")
    available, take = pen.place(f"{s}_available", initial=1), pen.place(f"{s}_take")
    answer, release, error = pen.place(f"{s}_answer"), pen.place(f"{s}_release"), pen.place(f"{s}_error")
    pen.transition(f"{s}_1", [take, not_available], [waiting, f"{a}_StartByRes"])
    quiet = [pen.place(f"{s}_quiet", initial=1)] if canvas.usage.released_unasked(s) else []
    pen.transition(f"{s}_2", [waiting, activation], [busy, answer, *quiet])
    failed = pen.place(f"{s}_failed") if quiet else deactivation
    pen.transition(f"{s}_3", [waiting, deactivation], [failed, error])
    pen.transition(f"{s}_6", [busy, answer, deactivation], [failed, error])
    pen.transition(f"{s}_8", [failed, release], [not_available, available])
    pen.transition(f"{s}_4", [busy, release], [free])
    pen.transition(f"{s}_5", [free, deactivation], [not_available, available])
    pen.transition(f"{s}_7", [busy, activation], [busy, *quiet])
    if quiet:
        pen.transition(f"{s}_10", [free, activation], [free, *quiet])
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
    running = f"{a}_active1" if len(producer.alternatives) == 1 else f"{a}_running"
    free, busy = pen.place(f"{s}_free"), pen.place(f"{s}_busy")
    not_available, waiting = pen.place(f"{s}_notAvailable", initial=1), pen.place(f"{s}_waiting")
    deactivation, unused = pen.place(f"{s}_deactivation"), pen.place(f"{s}_unused", initial=1)
    available, take = pen.place(f"{s}_available", initial=1), pen.place(f"{s}_take")
    answer, release, error = pen.place(f"{s}_answer"), pen.place(f"{s}_release"), pen.place(f"{s}_error")
    back = [not_available, available, unused]
    pen.transition(f"{s}_1", [take, not_available, unused], [waiting])
    pen.transition(f"{s}_2", [waiting], [busy, answer], read=[running])
    pen.transition(f"{s}_4", [busy, release], [free])
    for other in producer.produces:
        if other != s:
            pen.transition(f"{s}_9_{other}", [free], back, read=[f"{other}_answer"])
    if canvas.usage.may_wait(a):
        # A request may be given up before the producer has even been started.
        pen.transition(f"{s}_10", [free], back, read=[f"{a}_idle"])
    if canvas.usage.refusable(a):
        refusing = f"{a}_refusing"
        pen.transition(f"{s}_3", [waiting], [deactivation, error, unused], read=[refusing])
        pen.transition(f"{s}_6", [busy, answer], [deactivation, error, unused], read=[refusing])
        pen.transition(f"{s}_5", [free], back, read=[refusing])
        pen.transition(f"{s}_8", [deactivation, release], [not_available, available])
    canvas.unit([not_available, waiting, free, busy, deactivation])
    canvas.unit([available, take, answer, release, error])
