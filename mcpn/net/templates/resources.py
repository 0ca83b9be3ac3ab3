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


def draw_served_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws a resource whose producer serves several interfaces: 10 places for each interface.

    The interfaces are those of each consumer, where it is shared, and those of the producer's other products.
    The producer is started with the first request, serves whoever asks while it runs, and is stopped when
    nobody asks or holds; if it fails, each consumer gets the error. So it needs no activation and no
    deactivation; instead, of each interface, ``unused`` is marked while it is neither asked nor held, and
    ``deactivation`` while its owner has yet to take note of an error. ``free`` is marked from its release on
    until it is known whether the producer goes on, because another interface is held; then it is available
    again. Otherwise the producer stops first. Where that must not depend on who comes first, the producer
    that goes on evaluates its alternatives again (:meth:`mcpn.mission.sharing.Sharing.evaluated_on_release`),
    which is drawn with these.

    Args:
        canvas: Where to draw.
        resource: The resource.
        producer: The activity that produces it.
    """
    s, a = resource.name, producer.name
    pen = canvas.of("software", s, resource.source)
    running = f"{a}_active1" if len(producer.alternatives) == 1 else f"{a}_running"
    every = [i for product in producer.produces for i, _ in canvas.interfaces(product)]
    for i, _ in canvas.interfaces(s):
        free, busy = pen.place(f"{i}_free"), pen.place(f"{i}_busy")
        waiting, unused = pen.place(f"{i}_waiting"), pen.place(f"{i}_unused", initial=1)
        available, take = pen.place(f"{i}_available", initial=1), pen.place(f"{i}_take")
        answer, release = pen.place(f"{i}_answer"), pen.place(f"{i}_release")
        pen.transition(f"{i}_1", [take, unused], [waiting])
        pen.transition(f"{i}_2", [waiting], [busy, answer], read=[running])
        pen.transition(f"{i}_4", [busy, release], [free, unused])
        pen.transition(f"{i}_10", [free], [available], read=[f"{a}_idle"])
        if not canvas.usage.sharing.evaluated_on_release(a):
            for other in every:
                if other != i:
                    pen.transition(f"{i}_9_{other}", [free], [available], read=[f"{other}_answer"])
        if canvas.usage.refusable(a):
            refusing, error = f"{a}_refusing", pen.place(f"{i}_error")
            deactivation = pen.place(f"{i}_deactivation")
            pen.transition(f"{i}_3", [waiting], [deactivation, error, unused], read=[refusing])
            pen.transition(f"{i}_6", [busy, answer], [deactivation, error, unused], read=[refusing])
            pen.transition(f"{i}_5", [free], [available], read=[refusing])
            pen.transition(f"{i}_8", [deactivation, release], [available])
            canvas.unit([available, take, waiting, answer, release, error, free])
        else:
            canvas.unit([available, take, waiting, answer, release, free])
        canvas.unit([unused, waiting, busy])


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
    free, oos, failing = pen.place(f"{r}_free", initial=1), f"{r}_OOS", f"{r}_failing"
    interfaces = [i for i, _ in canvas.interfaces(r)]
    for i in interfaces:
        available, take = pen.place(f"{i}_available", initial=1), pen.place(f"{i}_take")
        answer, release, error = pen.place(f"{i}_answer"), pen.place(f"{i}_release"), f"{i}_error"
        pen.transition(f"{i}_7", [take], [answer], read=[free])
        pen.transition(f"{i}_8", [release], [available])
        if resource.faulty:
            pen.place(error)
            pen.transition(f"{i}_6", [answer], [error], read=[failing])
    if not resource.faulty:
        return
    canvas.role(pen.place(oos), ("oos", r))
    pen.place(failing)
    every = [f"{i}_available" for i in interfaces]
    fails, recovers = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
    pen.transition(f"{fails}", [free], [failing], event=fails)
    pen.transition(f"{r}_3", [failing, *every], [oos])
    pen.transition(f"{recovers}", [oos], [free, *every], event=recovers)
    canvas.unit([free, failing, oos])
    for i in interfaces:
        canvas.unit([f"{i}_available", f"{i}_take", f"{i}_answer", f"{i}_release", f"{i}_error", oos])
