"""Hardware and software resources (paper, 6.1; Fig. 6, 7 and 10)."""

from __future__ import annotations

from mcpn.mission.model import Activity, Hardware, Software
from mcpn.net.events import Event, What
from mcpn.net.templates.canvas import Canvas, Pen


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
        watched = _watched(canvas, pen, resource)
    available, take = pen.place("available", initial=1), pen.place("take")
    answer, release = pen.place("answer"), pen.place("release")
    if resource.faulty:
        error = pen.place("error")
        fails, returns = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
        pen.transition("EV_OOS_f", [free, *watched], [failing], event=fails)
        pen.transition("EV_OOS_b", [busy, answer, *watched], [failing, error], event=fails)
        pen.transition("3", [failing, available], [oos])
        pen.transition("4", [failing, release], [oos])
        pen.transition("EV_RD", [oos], [free, available, *watched], event=returns)
    pen.transition("8", [busy, release], [free, available])
    pen.transition("9", [free, take], [busy, answer])
    canvas.unit([free, busy, *([oos, failing] if resource.faulty else [])])
    canvas.unit([available, take, answer, release, *([error] if resource.faulty else [])])


def _watched(canvas: Canvas, pen: Pen, resource: Hardware) -> list[str]:
    """The place that says that hardware is in service, where some activity may switch back for it."""
    return [pen.place("service", initial=1)] if resource.name in canvas.usage.switching.watched else []


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


def draw_served_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws a resource whose producer serves several interfaces: 10 places for each interface.

    The interfaces are those of each consumer, where it is shared, and those of the producer's other products.
    The producer is started with the first request, serves whoever asks while it runs, and is stopped when
    nobody asks or holds; if it fails, each consumer gets the error. So it needs no activation and no
    deactivation; instead, of each interface, ``unused`` is marked while it is neither asked nor held, and
    ``deactivation`` while its owner has yet to take note of an error. ``free`` is marked from its release on
    until it is known whether the producer goes on, because another interface is held; then it is available
    again. Otherwise the producer stops first. Where that must not depend on who comes first, the producer
    always runs its best alternative (:meth:`mcpn.mission.facts.sharing.Sharing.order_matters`).

    Args:
        canvas: Where to draw.
        resource: The resource.
        producer: The activity that produces it.
    """
    s, a = resource.name, producer.name
    running = canvas.place_of("activity", a, "active1" if len(producer.alternatives) == 1 else "running")
    idle, refusing = (canvas.place_of("activity", a, part) for part in ("idle", "refusing"))
    every = [(product, owner) for product in producer.produces for owner in canvas.owners(product)]
    for owner in canvas.owners(s):
        pen = canvas.of_interface("software", s, resource.source, owner)
        free, busy = pen.place("free"), pen.place("busy")
        waiting, unused = pen.place("waiting"), pen.place("unused", initial=1)
        available, take = pen.place("available", initial=1), pen.place("take")
        answer, release = pen.place("answer"), pen.place("release")
        pen.transition("1", [take, unused], [waiting])
        pen.transition("2", [waiting], [busy, answer], read=[running])
        pen.transition("4", [busy, release], [free, unused])
        pen.transition("10", [free], [available], read=[idle])
        for other in every:
            if other != (s, owner):
                part = ("9", *(name for name in other if name))
                pen.transition(part, [free], [available], read=[canvas.answer(*other)])
        interface = [available, take, waiting, answer, release, free]
        if canvas.usage.refusable(a):
            error, deactivation = pen.place("error"), pen.place("deactivation")
            pen.transition("3", [waiting], [deactivation, error, unused], read=[refusing])
            pen.transition("6", [busy, answer], [deactivation, error, unused], read=[refusing])
            pen.transition("5", [free], [available], read=[refusing])
            pen.transition("8", [deactivation, release], [available])
            interface.append(error)
        canvas.unit(interface)
        canvas.unit([unused, busy])


def draw_shared_hardware(canvas: Canvas, resource: Hardware) -> None:
    """Draws a hardware resource that several activities may use at a time: 3 places, and 5 for each of them.

    It is *free* as long as it is in service, whoever uses it. If it fails, each activity that uses it gets
    the error; when all of them have given it back it is out of service, and not available to any.

    Args:
        canvas: Where to draw.
        resource: The resource.
    """
    r = resource.name
    pen = canvas.of("hardware", r, resource.source)
    free = pen.place("free", initial=1)
    if resource.faulty:
        oos, failing = canvas.role(pen.place("OOS"), ("oos", r)), pen.place("failing")
        watched = _watched(canvas, pen, resource)
    every = []
    for owner in canvas.owners(r):
        its = canvas.of_interface("hardware", r, resource.source, owner)
        available, take = its.place("available", initial=1), its.place("take")
        answer, release = its.place("answer"), its.place("release")
        its.transition("7", [take], [answer], read=[free])
        its.transition("8", [release], [available])
        every.append(available)
        interface = [available, take, answer, release]
        if resource.faulty:
            error = its.place("error")
            its.transition("6", [answer], [error], read=[failing])
            interface.append(error)
        canvas.unit(interface)
    if resource.faulty:
        fails, returns = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
        pen.transition("EV_OOS", [free, *watched], [failing], event=fails)
        pen.transition("3", [failing, *every], [oos])
        pen.transition("EV_RD", [oos], [free, *every, *watched], event=returns)
        canvas.unit([free, failing, oos])
