"""Hardware and software resources (paper, 6.1; Fig. 6, 7 and 10)."""

from __future__ import annotations

from collections.abc import Iterator

from mcpn.drawing.templates.canvas import Canvas, Pen
from mcpn.events import Event, What
from mcpn.mission.robot import Activity, Crash, Hardware, Software


def draw_hardware(canvas: Canvas, resource: Hardware) -> None:
    """Draws a hardware resource: 9 places and 7 transitions, 6 and 2 where it cannot fail.

    What stands for a crash fails only while an alternative that consumes it runs.

    Args:
        canvas: Where to draw.
        resource: The resource.
    """
    if resource.detected == "late":
        _draw_late(canvas, resource)
        return
    r = resource.name
    pen, ready = canvas.of("hardware", r, resource.source), _ready(canvas, resource)
    free, busy = pen.place("free", initial=ready), pen.place("busy")
    if resource.faulty:
        oos, failing = _out(canvas, pen, resource)
        watched = _watched(canvas, pen, resource)
    available, take = pen.place("available", initial=ready), pen.place("take")
    answer, release = pen.place("answer"), pen.place("release")
    if resource.faulty:
        error = pen.place("error")
        fails, returns = Event(What.OUT_OF_SERVICE, r), Event(What.REPAIRED, r)
        if isinstance(resource, Crash):
            for place in (free, available, *watched):
                canvas.role(place, ("ready", r))
            for part, running in _running(canvas, resource):
                taken = [busy, answer, *watched]
                pen.transition(f"EV_OOS{part}", taken, [failing, error], read=[running], event=fails)
        else:
            pen.transition("EV_OOS_f", [free, *watched], [failing], event=fails)
            pen.transition("EV_OOS_b", [busy, answer, *watched], [failing, error], event=fails)
        pen.transition("3", [failing, available], [oos])
        pen.transition("4", [failing, release], [oos])
        if resource.repairable:
            pen.transition("EV_RD", [oos], [free, available, *watched], event=returns)
    pen.transition("8", [busy, release], [free, available])
    pen.transition("9", [free, take], [busy, answer])
    canvas.unit([free, busy, *([oos, failing] if resource.faulty else [])])
    canvas.unit([available, take, answer, release, *([error] if resource.faulty else [])])


def _draw_late(canvas: Canvas, resource: Hardware) -> None:
    """Draws hardware whose loss is detected late: 19 places, and 15 transitions or more.

    What the robot knows of the hardware has the places of other hardware. Pairs of places hold what is true:
    whether the hardware is *well* or *gone*; whether it is *misused* (gone and in use) or *fine*; and whether
    it is *suspected* or *trusted*: it is suspected once an objective that may use it has failed while it was
    misused. Suspected hardware is out of service when it is released.

    The end of that objective says only that the hardware is *doubted*. An internal transition makes it
    suspected or drops the doubt, and until then nobody releases or takes it while it is gone. So an end has
    one transition, however much hardware detected late the objective may use.
    """
    r, ready = resource.name, _ready(canvas, resource)
    pen = canvas.of("hardware", r, resource.source)
    free, busy = pen.place("free", initial=ready), pen.place("busy")
    out, failing = pen.place("OOS", initial=1 - ready), pen.place("failing")
    canvas.role(out, ("known", r))
    watched = _watched(canvas, pen, resource)
    available, take = pen.place("available", initial=ready), pen.place("take")
    answer, release, error = pen.place("answer"), pen.place("release"), pen.place("error")
    well, gone = pen.place("well", initial=ready), pen.place("gone", initial=1 - ready)
    canvas.role(gone, ("oos", r))
    for place in (free, available, *watched):
        canvas.role(place, ("presumed", r))
    fine, misused = pen.place("fine", initial=1), pen.place("misused")
    canvas.role(fine, ("fine", r))
    trusted, suspected = pen.place("trusted", initial=1), pen.place("suspected")
    doubted, undoubted = pen.place("doubted"), pen.place("undoubted", initial=1)
    pen.transition("doubt_f", [doubted], [undoubted], read=[fine])
    pen.transition("doubt_m", [doubted, trusted], [undoubted, suspected], read=[misused])
    pen.transition("doubt_s", [doubted], [undoubted], read=[suspected])
    fails, seen, returns = (Event(w, r) for w in (What.OUT_OF_SERVICE, What.DETECTED, What.REPAIRED))
    pen.transition("EV_OOS_f", [well], [gone], read=[free], event=fails)
    pen.transition("EV_OOS_b", [well, fine], [gone, misused], read=[busy], event=fails)
    for number, running in enumerate(_detecting(canvas, r), 1):
        pen.transition(
            f"EV_DETECTED_f{number}", [free, *watched], [failing], read=[gone, running], event=seen
        )
        taken, put = [busy, answer, misused, *watched], [failing, error, fine]
        pen.transition(f"EV_DETECTED_b{number}", taken, put, read=[running, trusted], event=seen)
        taken, put = [*taken, suspected], [*put, trusted]
        pen.transition(f"EV_DETECTED_s{number}", taken, put, read=[running], event=seen)
    pen.transition("3", [failing, available], [out])
    pen.transition("4", [failing, release], [out])
    if resource.repairable:
        pen.transition("EV_RD", [out, gone], [free, available, well, *watched], event=returns)
    pen.transition("8", [busy, release], [free, available], read=[well])
    pen.transition("8g", [busy, release, misused], [free, available, fine], read=[trusted, undoubted])
    taken = [busy, release, misused, suspected, *watched]
    pen.transition("8s", taken, [out, fine, trusted], read=[undoubted])
    pen.transition("9", [free, take], [busy, answer], read=[well])
    pen.transition("9g", [free, take, fine], [busy, answer, misused], read=[gone, undoubted])
    canvas.unit([free, busy, out, failing])
    canvas.unit([available, take, answer, release, error])
    for pair in ([well, gone], [fine, misused], [trusted, suspected], [doubted, undoubted]):
        canvas.unit(pair)


def _detecting(canvas: Canvas, hardware: str) -> Iterator[str]:
    """The places that say that an alternative runs of an activity that detects the loss of some hardware."""
    for activity in canvas.usage.activities.values():
        if hardware in activity.detects and ("activity", activity.name) not in canvas.left_out:
            for number in range(1, len(activity.alternatives) + 1):
                yield canvas.place_of("activity", activity.name, f"active{number}")


def _ready(canvas: Canvas, resource: Hardware) -> int:
    """1 for hardware that is in service at the start; parts of a mission start with all of it in service."""
    return int(canvas.part or resource.initial == "service")


def _out(canvas: Canvas, pen: Pen, resource: Hardware) -> tuple[str, str]:
    """The places that say that hardware is out of service, and that it fails."""
    out = pen.place("OOS", initial=1 - _ready(canvas, resource))
    return canvas.role(out, ("oos", resource.name)), pen.place("failing")


def _running(canvas: Canvas, crash: Crash) -> Iterator[tuple[str, str]]:
    """The places that say that an alternative runs which may crash, each with its number."""
    if ("activity", crash.activity) not in canvas.left_out:
        for number, way in enumerate(canvas.usage.activities[crash.activity].alternatives, 1):
            if crash.name in way.consumes:
                part = f"active{number}"
                yield str(number), canvas.place_of("activity", crash.activity, part)


def _watched(canvas: Canvas, pen: Pen, resource: Hardware) -> list[str]:
    """The place that says that hardware is in service, where some activity may switch back for it."""
    ready, watched = _ready(canvas, resource), resource.name in canvas.usage.switching.watched
    return [pen.place("service", initial=ready)] if watched else []


def draw_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws the only resource of its producer: 11 places, 8 transitions.

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
    pen.transition("2", [waiting, activation], [busy, answer])
    pen.transition("3", [waiting, deactivation], [deactivation, error])
    pen.transition("6", [busy, answer, deactivation], [deactivation, error])
    pen.transition("8", [deactivation, release], [not_available, available])
    pen.transition("4", [busy, release], [free])
    pen.transition("5", [free, deactivation], [not_available, available])
    pen.transition("7", [busy, activation], [busy])
    canvas.unit([not_available, waiting, free, busy])
    canvas.unit([available, take, answer, release, error])


def draw_served_software(canvas: Canvas, resource: Software, producer: Activity) -> None:
    """Draws a resource whose producer serves: 9 places for each interface, 7 if it cannot be refused.

    The interfaces are those of each consumer, where it is shared, and those of the producer's other products.
    The producer is started with the first request and serves whoever asks while it runs. When it is refused
    each consumer gets the error; the refusal stays marked and answers whoever asks. Of each interface,
    ``unused`` is marked while it is neither asked nor held, and ``failed`` while its owner has yet to take
    note of an error. The producer stops, or leaves its refusal, when nobody evaluates any more and all
    interfaces are unused (:class:`mcpn.drawing.templates.ranks.Ranks`), whoever came and left before.

    Args:
        canvas: Where to draw.
        resource: The resource.
        producer: The activity that produces it.
    """
    s, a = resource.name, producer.name
    running = canvas.place_of("activity", a, "active1" if len(producer.alternatives) == 1 else "running")
    refusing = canvas.place_of("activity", a, "refusing")
    for owner in canvas.owners(s):
        pen = canvas.of_interface("software", s, resource.source, owner)
        busy, waiting, unused = pen.place("busy"), pen.place("waiting"), pen.place("unused", initial=1)
        available, take = pen.place("available", initial=1), pen.place("take")
        answer, release = pen.place("answer"), pen.place("release")
        pen.transition("1", [take, unused], [waiting])
        rank = canvas.ranks.answering(a)
        pen.transition("2", [waiting], [busy, answer], read=[running], rank=rank)
        pen.transition("4", [busy, release], [available, unused])
        interface = [available, take, waiting, answer, release]
        if canvas.usage.refusable(a):
            error, failed = pen.place("error"), pen.place("failed")
            pen.transition("3", [waiting], [failed, error, unused], read=[refusing], rank=rank)
            pen.transition("6", [busy, answer], [failed, error, unused], read=[refusing])
            pen.transition("8", [failed, release], [available])
            interface.append(error)
        canvas.unit(interface)
        canvas.unit([unused, busy, waiting])


def draw_shared_hardware(canvas: Canvas, resource: Hardware) -> None:
    """Draws a hardware resource that several activities may use at a time: 3 places, and 5 for each of them.

    It is *free* as long as it is in service, whoever uses it. If it fails, each activity that uses it gets
    the error; when all of them have given it back it is out of service, and not available to any.

    Args:
        canvas: Where to draw.
        resource: The resource.
    """
    r = resource.name
    pen, ready = canvas.of("hardware", r, resource.source), _ready(canvas, resource)
    free = pen.place("free", initial=ready)
    if resource.faulty:
        oos, failing = _out(canvas, pen, resource)
        watched = _watched(canvas, pen, resource)
    every = []
    for owner in canvas.owners(r):
        its = canvas.of_interface("hardware", r, resource.source, owner)
        available, take = its.place("available", initial=ready), its.place("take")
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
        if resource.repairable:
            pen.transition("EV_RD", [oos], [free, *every, *watched], event=returns)
        canvas.unit([free, failing, oos])
