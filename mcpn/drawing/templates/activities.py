"""An activity with its prioritised alternatives (paper, 6.2 and Fig. 8).

Alternative ``i`` is tried in its evaluation place (the start place for the first), selected into ``wait_i``,
and runs in ``active_i``. An activity that an objective starts and one that a request starts differ only in
what starts, stops and refuses them, and are drawn by the same code (:class:`_Life`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import field
from itertools import combinations, product
from typing import NamedTuple

from mcpn.drawing.templates.canvas import Canvas, Pen
from mcpn.errors import LimitError
from mcpn.mission.robot import Activity, Alternative
from mcpn.records import record

MAX_TOGETHER = 12
"""Resources of one alternative that may wait for answers: each way in which they may answer is drawn."""

MOST_AT_ONCE = 3
"""Errors that one transition takes at a time, one for each set of them, where no more can come together."""


@record(frozen=True)
class _Ending:
    """A way in which an activity is stopped.

    Args:
        consume: What the stopping transition takes.
        produce: What it puts.
        read: What it tests.
        rank: Its rank.
        moment: What is added to its name, where the activity may be stopped at several moments of a reaction.
    """

    consume: list[str] = field(default_factory=list)
    produce: list[str] = field(default_factory=list)
    read: list[str] = field(default_factory=list)
    rank: int = 0
    moment: str = ""


class _Life(NamedTuple):
    """How an activity begins and ends, whatever its alternatives.

    Args:
        start: The evaluation place of the first alternative.
        refuse: Places marked where no alternative is possible.
        activate: Places marked when an alternative starts to run.
        endings: How it is stopped: one way, or one for each moment of a reaction. All put the same.
    """

    start: str
    refuse: list[str]
    activate: list[str]
    endings: tuple[_Ending, ...]


def draw_activity(
    canvas: Canvas,
    activity: Activity,
    *,
    at_once: int = MOST_AT_ONCE,
    drawing: type[AlternativeDrawing] | None = None,
) -> None:
    """Draws an activity: a driver of one hardware resource takes 3 places and 5 transitions.

    Beyond the paper, and only where it can happen: an activity that may be found waiting in a stable marking
    (another one holds what it needs) can be stopped there, giving up the requests that nobody has answered
    yet; one that may be started again while its last stop is on its way has a place ``idle`` that its starts
    take and its stops fill.

    Args:
        canvas: Where to draw.
        activity: The activity.
        at_once: Errors that one transition takes at a time. What follows is the same whatever their number.
        drawing: What draws each alternative.

    Raises:
        LimitError: An alternative that may wait for answers consumes too many resources.
    """
    drawing = drawing or AlternativeDrawing
    pen = canvas.of("activity", activity.name, activity.source)
    life = _by_request(canvas, pen, activity) if activity.produces else _by_objective(canvas, pen, activity)
    running = pen.place("running") if _counts_running(canvas, activity) else None
    evaluation, last = life.start, len(activity.alternatives) - 1
    for i, alternative in enumerate(activity.alternatives):
        otherwise = life.refuse
        if i < last:
            otherwise = [pen.place(f"eval{i + 2}")]
        elif not canvas.usage.refusable(activity.name):
            otherwise = []
        drawing(
            canvas=canvas,
            activity=activity,
            alternative=alternative,
            index=i,
            evaluation=evaluation,
            otherwise=otherwise,
            life=life,
            running=running,
            at_once=at_once,
        ).all()
        if i < last:
            evaluation = otherwise[0]


def running_place(canvas: Canvas, activity: Activity) -> str | None:
    """The place that says that an activity started by an objective runs, or ``None`` if it always does.

    An activity whose alternatives need nothing cannot be in error, so nobody needs to ask.
    """
    bare = not any(alternative.consumes for alternative in activity.alternatives)
    if bare and activity.name not in canvas.usage.requiring:
        return None
    return canvas.place_of(
        "activity", activity.name, "running" if _counts_running(canvas, activity) else "active1"
    )


def _counts_running(canvas: Canvas, activity: Activity) -> bool:
    """One place must say *running* whatever the alternative, to an objective or to several interfaces."""
    asked = not activity.produces or canvas.usage.sharing.serves(activity.name)
    return asked and len(activity.alternatives) > 1


def _by_objective(canvas: Canvas, pen: Pen, activity: Activity) -> _Life:
    a, usage = activity.name, canvas.usage
    start, stop = pen.place("Start"), pen.place("Stop")
    idle = [pen.place("idle", initial=1)] if a in usage.handover.with_idle else []
    refuse = []
    if usage.refusable(a):
        refuse = [canvas.role(pen.place("error"), ("refused", a))]
        pen.transition("errstop", [*refuse, stop], idle)
    return _Life(start, refuse, [], (_Ending(consume=[stop], produce=idle),))


def _by_request(canvas: Canvas, pen: Pen, activity: Activity) -> _Life:
    a, outputs, place_of = activity.name, activity.produces, canvas.resource
    start = pen.place("StartByRes")
    sharing = canvas.usage.sharing
    if not sharing.serves(a):
        (s,) = outputs
        given = [place_of(s, "deactivation")]
        ending = _Ending(produce=given, read=[place_of(s, "free")])
        return _Life(start, given, [place_of(s, "activation")], (ending,))
    idle = pen.place("idle", initial=1)
    served = [(s, owner) for s in outputs for owner in canvas.owners(s)]
    unused = [place_of(s, "unused", owner) for s, owner in served]
    for number, (s, owner) in enumerate(served):
        pen.transition(f"start{number}", [idle], [start], read=[place_of(s, "waiting", owner)])
    refuse = []
    if canvas.usage.refusable(a):
        refuse = [canvas.role(pen.place("refusing"), ("refused", a))]
        # One that has waited may have passed over an alternative that is possible again: it must be idle when
        # asked anew. Else nothing can have changed since it evaluated, so its refusal answers all who ask.
        waited = canvas.usage.may_wait(a)
        rank = canvas.ranks.answering(a) if waited else canvas.ranks.settling
        pen.transition("refused", refuse, [idle], read=unused, rank=rank)
    return _Life(start, refuse, [], tuple(_when_unused(canvas, activity, idle, unused)))


def _when_unused(canvas: Canvas, activity: Activity, idle: str, unused: list[str]) -> Iterator[_Ending]:
    """How a producer that serves is stopped when nobody uses what it produces.

    One that is kept stops when an objective ends, if nobody needs it then; else only after what follows the
    objective has begun, which may need it again.
    """
    ranks = canvas.ranks
    if not canvas.usage.sharing.kept(activity.name):
        yield _Ending(produce=[idle], read=unused, rank=ranks.settling)
        return
    read = [*unused, *canvas.resting]
    yield _Ending(produce=[idle], read=read, rank=ranks.resting, moment="rest")
    yield _Ending(produce=[idle], read=unused, rank=ranks.settling_kept)


class AlternativeDrawing:
    """One branch of Fig. 8: alternative ``i`` between its evaluation place and what comes otherwise."""

    def __init__(
        self,
        canvas: Canvas,
        activity: Activity,
        alternative: Alternative,
        index: int,
        evaluation: str,
        otherwise: list[str],
        life: _Life,
        running: str | None,
        at_once: int,
    ) -> None:
        self.at_once = at_once
        self.usage = canvas.usage
        self.activity = activity
        self.index = index
        self.evaluation = evaluation
        self.otherwise = otherwise
        self.life = life
        self.consumes = alternative.consumes
        self.hardware = [k for k in self.consumes if k in self.usage.hardware]
        self.canvas = canvas
        required = canvas.usage.world.requires(activity.name, index)
        self.required = [canvas.fact(fact, value) for fact, value in required]
        self.wrong = [(fact, v, p) for fact, value in required for v, p in canvas.others(fact, value)]
        self.pen = canvas.of_alternative(activity, alternative)
        self.number = index + 1
        name = self.pen.provenance.name
        if self.usage.waits_for_release(activity.name, index):
            canvas.role(evaluation, ("want", name))
        self.active = canvas.role(self.pen.place(f"active{self.number}"), ("active", name))
        if self.consumes:
            self.wait = canvas.role(self.pen.place(f"wait{self.number}"), ("wait", name))
        self.runs = [self.active] + ([running] if running else [])
        self.runs_and_says = [*self.runs, *life.activate]

    def all(self) -> None:
        """Draws every transition of the alternative."""
        if self.consumes:
            self.select()
            self.go()
            self.otherwise_out_of_service()
            self.error_while_waiting()
            self.error_while_active()
        else:
            self.draw("sel", [self.evaluation], self.runs_and_says, read=self.required)
        self.not_allowed()
        self.stop()
        self.switch_back()
        if self.usage.waits_for_release(self.activity.name, self.index):
            self.stop_while_evaluated()
        if self.usage.waits_for_answer(self.activity.name, self.index):
            self.stop_while_waiting()

    def select(self) -> None:
        """All resources are available: take them."""
        available = [self.of(k, "available") for k in self.consumes]
        taken = [self.of(k, "take") for k in self.consumes]
        # Shared hardware is available to this activity until it is out of service.
        shared = [k for k in self.hardware if k in self.usage.sharing.consumers]
        in_service = [self.canvas.resource(k, "free") for k in shared]
        read = [*in_service, *self.required]
        self.draw("sel", [self.evaluation, *available], [self.wait, *taken], read=read)

    def go(self) -> None:
        """All resources have answered: run."""
        self.draw("go", [self.wait], self.runs_and_says, read=self.answers(()))

    def otherwise_out_of_service(self) -> None:
        """A hardware resource is out of service: try the next alternative, or refuse."""
        for k in filter(self.usage.can_fail, self.hardware):
            self.draw("else", [self.evaluation], self.otherwise, k, read=[self.canvas.resource(k, "OOS")])

    def not_allowed(self) -> None:
        """A fact has another value than required: try the next alternative, or, where it runs, all again."""
        waits = self.usage.waits_for_answer(self.activity.name, self.index)
        for fact, value, place in self.wrong:
            self.draw("not", [self.evaluation], self.otherwise, fact, value, read=[place])
            running = [*self.runs, *self.answers(())]
            again = [*self.releases(), self.life.start]
            self.handle("lost", running, again, fact, value, read=[place])
            if waits:
                self.not_allowed_while_asking(fact, value, place)

    def not_allowed_while_asking(self, fact: str, value: str, place: str) -> None:
        """A fact is not as it requires, and some resource has not answered yet: give up, try the next."""
        for stages, asking, given in self._while_asking():
            if "error" not in stages:  # else it gives up for that
                given_up, suffixes = [*given, *self.otherwise], (fact, value, _initials(stages))
                self.handle("asklost", [self.wait, *asking], given_up, *suffixes, read=[place])

    def error_while_waiting(self) -> None:
        """Some resources answered with an error, the others are here: give all back, try the next."""
        stable = self.usage.waits_for_answer(self.activity.name, self.index)
        if stable:
            self.error_while_asking()
        failing = tuple(
            k for k in self.consumes if self.usage.can_fail(k) and (stable or k not in self.hardware)
        )
        if stable or len(failing) <= self.at_once:
            self._give_up_at_once("werr", [self.wait], _subsets(failing), self.otherwise)
        else:
            self.give_up_one_by_one("werr", [self.wait], failing, self.otherwise)

    def error_while_active(self) -> None:
        """Resources failed while it ran: give all back, evaluate every alternative again (6.2)."""
        groups = self.usage.fail_together(self.activity.name, self.index)
        if max(map(len, groups), default=0) <= self.at_once:
            sets = {errors for group in groups for errors in _subsets(group)}
            ordered = sorted(sets, key=lambda e: (len(e), [self.consumes.index(k) for k in e]))
            self._give_up_at_once("err", self.runs, ordered, [self.life.start])
        else:
            failing = tuple(k for k in self.consumes if self.usage.can_fail(k))
            self.give_up_one_by_one("err", self.runs, failing, [self.life.start])

    def _give_up_at_once(
        self, verb: str, left: list[str], sets: Iterable[tuple[str, ...]], onward: list[str]
    ) -> None:
        """One transition for each set of resources that may be in error."""
        for errors in sets:
            self.handle(verb, [*left, *self.answers(errors)], [*self.releases(), *onward], *errors)

    def give_up_one_by_one(
        self, verb: str, left: list[str], failing: tuple[str, ...], onward: list[str], alone: bool = False
    ) -> None:
        """Leaves the alternative at the first error, turns each error into an answer, then gives all back.

        Shared hardware is in error as long as it fails, so what gives all back consumes its error; no two
        hardware resources fail at a time. With ``alone`` a better alternative is a reason, too, not an error.
        """
        lost = self.pen.place(f"{verb}{self.number}")
        shared = [k for k in failing if k in self.hardware and k in self.usage.sharing.consumers]
        for k in failing:
            error = self.of(k, "error")
            self.handle(verb, left, [lost], k, read=[error])
            if k not in shared:
                self.handle(f"{verb}_note", [error], [self.of(k, "answer")], k, read=[lost])
        none = [()] if alone or len(shared) < len(failing) else list[tuple[str, ...]]()
        for errors in (*none, *((k,) for k in shared)):
            taken, given = [lost, *self.answers(errors)], [*self.releases(), *onward]
            self.handle(f"{verb}_all", taken, given, *errors)

    def stop(self) -> None:
        """It runs and is stopped: give all back."""
        self.end("stop", [*self.runs, *self.answers(())], self.releases())

    def switch_back(self) -> None:
        """An alternative of higher priority is possible again: evaluate every alternative again."""
        for way in self.usage.switching.better(self.activity.name, self.index):
            taken, given = [*self.runs, *self.answers(())], [*self.releases(), self.life.start]
            self.handle("back", taken, given, *way, read=[self.possible_again(h) for h in way])

    def possible_again(self, hardware: str) -> str:
        """The place that says that hardware is in service, or that a fact has a value."""
        fact, equals, value = hardware.partition("=")
        return self.canvas.fact(fact, value) if equals else self.canvas.resource(hardware, "service")

    def stop_while_evaluated(self) -> None:
        """It waits for another activity's release and is stopped: it holds nothing."""
        self.end("cancel", [self.evaluation], [])

    def error_while_asking(self) -> None:
        """A resource answers with an error while others have not answered yet, for a producer waits itself.

        Nothing but this failure may happen for long, so the activity does not wait on: it gives up what is
        still asked for. Hardware that has failed would else never get out of *failing*.
        """
        for stages, asking, given in self._while_asking():
            if "error" in stages:
                self.handle("askerr", [self.wait, *asking], [*given, *self.otherwise], _initials(stages))

    def stop_while_waiting(self) -> None:
        """It waits for answers and is stopped: give back what came, give up what is still asked for.

        A request given up frees its resource at once, in one step with the stop: were it a release on its
        way, an answer could still come in between and stay behind.
        """
        for stages, asking, given in self._while_asking():
            self.end("giveup", [self.wait, *asking], given, _initials(stages))

    def _while_asking(self) -> Iterator[tuple[tuple[str, ...], list[str], list[str]]]:
        """Stages of its requests, some unanswered, with places marked there and places that give all back."""
        if (number := len(self.consumes)) > MAX_TOGETHER:
            found = f"{number} resources consumed by one alternative that may wait for answers"
            raise LimitError(f"activity {self.activity.name}: {found}, the limit is {MAX_TOGETHER}")
        for stages in product(*(self.stages(k) for k in self.consumes)):
            if "waiting" in stages:
                both = list(zip(self.consumes, stages, strict=True))
                given = [self.of(k, part) for k, stage in both for part in self.given_up(k, stage)]
                yield stages, [self.of(k, stage) for k, stage in both], given

    def given_up(self, resource: str, stage: str) -> list[str]:
        """Places to mark so as to give up a request that has come so far."""
        if stage != "waiting":
            return ["release"]
        serves = self.usage.sharing.serves(self.usage.producer[resource])
        return ["available", "unused"] if serves else ["free"]

    def stages(self, resource: str) -> Iterator[str]:
        """How far the request of a resource may have come."""
        yield "answer"
        if self.usage.can_fail(resource):
            yield "error"
        if resource not in self.hardware and self.usage.may_wait(self.usage.producer[resource]):
            yield "waiting"

    def answers(self, errors: tuple[str, ...]) -> list[str]:
        """Places that say of each resource that it has answered, or is in error."""
        return [self.of(k, "error" if k in errors else "answer") for k in self.consumes]

    def releases(self) -> list[str]:
        """Places that give each resource back."""
        return [self.of(k, "release") for k in self.consumes]

    def of(self, resource: str, part: str) -> str:
        """The name of a place of the interface by which the activity uses a resource."""
        return self.canvas.resource(resource, part, self.usage.sharing.owner(resource, self.activity.name))

    def handle(
        self, verb: str, consume: list[str], produce: list[str], *suffixes: str, read: list[str] | None = None
    ) -> None:
        """Draws what the activity does on an error or a return."""
        rank = self.canvas.ranks.handling(self.activity.name)
        self.draw(verb, consume, produce, *suffixes, read=read, rank=rank)

    def end(self, verb: str, consume: list[str], produce: list[str], *stages: str) -> None:
        """Draws a way in which the activity is stopped."""
        for ending in self.life.endings:
            taken, given = [*consume, *ending.consume], [*produce, *ending.produce]
            self.draw(f"{ending.moment}{verb}", taken, given, *stages, read=ending.read, rank=ending.rank)

    def draw(
        self,
        verb: str,
        consume: list[str],
        produce: list[str],
        *suffixes: str,
        read: list[str] | None = None,
        rank: int = 0,
    ) -> None:
        """Draws a transition of this alternative."""
        self.pen.transition((f"{verb}{self.number}", *suffixes), consume, produce, read=read, rank=rank)


def _initials(stages: tuple[str, ...]) -> str:
    return "".join(stage[0] for stage in stages)


def _subsets(items: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Every non-empty subset, smaller ones first."""
    for size in range(1, len(items) + 1):
        yield from combinations(items, size)
