"""An activity with its prioritised alternatives (paper, 6.2 and Fig. 8).

Alternative ``i`` is tried in its evaluation place (the start place for the first), selected into ``wait_i``,
and runs in ``active_i``. An activity that an objective starts and one that a request starts differ only in
what starts, stops and refuses them, and are drawn by the same code (:class:`_Life`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import combinations, permutations, product

from mcpn.errors import LimitError
from mcpn.mission.model import Activity, Alternative
from mcpn.net.templates.canvas import Canvas, Pen, interface

MAX_TOGETHER = 12
"""Resources of one alternative, whose subsets each take a transition."""


@dataclass(frozen=True)
class _Ending:
    """How an activity is stopped: what the stopping transition takes, puts and tests."""

    consume: list[str] = field(default_factory=list)
    produce: list[str] = field(default_factory=list)
    read: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class _Life:
    """How an activity begins and ends, whatever its alternatives.

    Args:
        start: The evaluation place of the first alternative.
        refuse: Places marked where no alternative is possible.
        activate: Places marked when an alternative starts to run.
        ending: How it is stopped.
        quiet: The place that says that no activation is on its way, where one is needed.
        again: Interfaces of its products; while one is held it evaluates its alternatives again when another
            is given back.
    """

    start: str
    refuse: list[str]
    activate: list[str]
    ending: _Ending
    quiet: list[str] = field(default_factory=list)
    again: list[str] = field(default_factory=list)


def draw_activity(canvas: Canvas, activity: Activity) -> None:
    """Draws an activity: a driver of one hardware resource takes 3 places and 5 transitions.

    Beyond the paper, and only where it can happen: an activity that may be found waiting in a stable marking
    (another one holds what it needs) can be stopped there, giving up the requests that nobody has answered
    yet; one that may be started again while its last stop is on its way has a place ``idle`` that its starts
    take and its stops fill.

    Args:
        canvas: Where to draw.
        activity: The activity.

    Raises:
        LimitError: An alternative consumes more resources than have subsets that can be drawn one by one.
    """
    _refuse_excess(activity)
    pen = canvas.of("activity", activity.name, activity.source)
    serves = canvas.usage.sharing.serves(activity.name)
    several = len(activity.alternatives) > 1 and (serves or not activity.produces)
    running = f"{activity.name}_running" if several else None
    life = _by_request(canvas, pen, activity) if activity.produces else _by_objective(canvas, pen, activity)
    if running:
        pen.place(running)
    evaluation = life.start
    last = len(activity.alternatives) - 1
    for i, alternative in enumerate(activity.alternatives):
        otherwise = life.refuse
        if i < last:
            otherwise = [pen.place(f"{activity.name}_eval{i + 2}")]
        elif not canvas.usage.refusable(activity.name):
            otherwise = []
        draw = _AlternativeDrawing(canvas, activity, alternative, i, evaluation, otherwise, life, running)
        draw.all()
        if i < last:
            evaluation = otherwise[0]


def running_place(activity: Activity) -> str | None:
    """The place that says that an activity started by an objective runs, or ``None`` if it always does.

    An activity whose alternatives consume nothing cannot be in error, so nobody needs to ask.
    """
    if not any(alternative.consumes for alternative in activity.alternatives):
        return None
    return f"{activity.name}_running" if len(activity.alternatives) > 1 else f"{activity.name}_active1"


def _refuse_excess(activity: Activity) -> None:
    widest = max(len(alternative.consumes) for alternative in activity.alternatives)
    if widest > MAX_TOGETHER:
        raise LimitError(
            f"activity {activity.name}: {widest} resources consumed by one alternative, "
            f"the limit is {MAX_TOGETHER}"
        )


def _by_objective(canvas: Canvas, pen: Pen, activity: Activity) -> _Life:
    a, usage = activity.name, canvas.usage
    start, stop = pen.place(f"{a}_Start"), pen.place(f"{a}_Stop")
    idle = [pen.place(f"{a}_idle", initial=1)] if a in usage.handover.with_idle else []
    refuse = []
    if usage.refusable(a):
        refuse = [canvas.role(pen.place(f"{a}_error"), ("refused", a))]
        pen.transition(f"{a}_errstop", [*refuse, stop], idle)
    return _Life(start, refuse, [], _Ending([stop], idle))


def _by_request(canvas: Canvas, pen: Pen, activity: Activity) -> _Life:
    a, outputs = activity.name, activity.produces
    start = pen.place(f"{a}_StartByRes")
    if not canvas.usage.sharing.serves(a):
        s = outputs[0]
        quiet = [f"{s}_quiet"] if canvas.usage.released_unasked(s) else []
        ending = _Ending(produce=[f"{s}_deactivation"], read=[f"{s}_free", *quiet])
        return _Life(start, [f"{s}_deactivation"], [f"{s}_activation"], ending, quiet)
    idle = pen.place(f"{a}_idle", initial=1)
    served = [i for s in outputs for i, _ in canvas.interfaces(s)]
    unused = [f"{i}_unused" for i in served]
    for i in served:
        pen.transition(f"{a}_start_{i}", [idle], [start], read=[f"{i}_waiting"])
    refuse = []
    if canvas.usage.refusable(a):
        refuse = [canvas.role(pen.place(f"{a}_refusing"), ("refused", a))]
        pen.transition(f"{a}_refused", refuse, [idle], read=unused)
    again = served if canvas.usage.sharing.evaluated_on_release(a) else []
    return _Life(start, refuse, [], _Ending(produce=[idle], read=unused), again=again)


class _AlternativeDrawing:
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
    ) -> None:
        self.usage = canvas.usage
        self.activity = activity
        self.index = index
        self.evaluation = evaluation
        self.otherwise = otherwise
        self.life = life
        self.consumes = alternative.consumes
        self.hardware = [k for k in self.consumes if k in self.usage.hardware]
        owner = self.usage.sharing.owner
        self.at = {k: interface(k, owner(k, activity.name)) for k in self.consumes}
        qualified = f"{activity.name}.{alternative.name}"
        self.pen = canvas.of("alternative", qualified, alternative.source)
        number = index + 1
        self.prefix = activity.name
        self.number = number
        self.active = canvas.role(self.pen.place(f"{activity.name}_active{number}"), ("active", qualified))
        if self.consumes:
            self.wait = canvas.role(self.pen.place(f"{activity.name}_wait{number}"), ("wait", qualified))
        self.runs = [self.active] + ([running] if running else [])

        self.runs_and_says = [*self.runs, *life.activate]
        # Only a refusal marks places of others; the next evaluation place is the activity's own.
        self.quiet_to_refuse = life.quiet if otherwise == life.refuse else []

    def all(self) -> None:
        """Draws every transition of the alternative."""
        if self.consumes:
            self.select()
            self.go()
            self.otherwise_out_of_service()
            self.error_while_waiting()
            self.error_while_active()
        else:
            self._draw("sel", [self.evaluation, *self.life.quiet], self.runs_and_says)
        self.stop()
        self.evaluate_again()
        if self.usage.waits_for_release(self.activity.name, self.index):
            self.stop_while_evaluated()
        if self.usage.waits_for_answer(self.activity.name, self.index):
            self.stop_while_waiting()

    def select(self) -> None:
        """All resources are available: take them."""
        asked = [f"{i}_available" for i in self.at.values()]
        taken = [f"{i}_take" for i in self.at.values()]
        in_service = [f"{k}_free" for k in self.hardware if k in self.usage.sharing.consumers]
        self._draw("sel", [self.evaluation, *asked], [self.wait, *taken], read=in_service)

    def go(self) -> None:
        """All resources have answered: run."""
        answers = [f"{i}_answer" for i in self.at.values()]
        self._draw("go", [self.wait, *self.life.quiet], self.runs_and_says, read=answers)

    def otherwise_out_of_service(self) -> None:
        """A hardware resource is out of service: try the next alternative, or refuse."""
        for k in self.hardware:
            if self.usage.can_fail(k):
                read = [f"{k}_OOS", *self.quiet_to_refuse]
                self._draw("else", [self.evaluation], self.otherwise, k, read=read)

    def error_while_waiting(self) -> None:
        """Some resources answered with an error, the others are here: give all back, try the next."""
        stable = self.usage.waits_for_answer(self.activity.name, self.index)
        if stable:
            self.error_while_asking()
        failing = [k for k in self.consumes if self.usage.can_fail(k) and (stable or k not in self.hardware)]
        for errors in _subsets(failing):
            self._draw(
                "werr",
                [self.wait, *self._answers(errors)],
                [*self._releases(), *self.otherwise],
                *errors,
                read=self.quiet_to_refuse,
            )

    def error_while_active(self) -> None:
        """Resources failed while it ran: give all back, evaluate every alternative again (6.2)."""
        for errors in self.usage.fail_together(self.activity.name, self.index):
            self._draw(
                "err", [*self.runs, *self._answers(errors)], [*self._releases(), self.life.start], *errors
            )

    def stop(self) -> None:
        """It runs and is stopped: give all back."""
        self._end("stop", [*self.runs, *self._answers(())], self._releases())

    def stop_while_evaluated(self) -> None:
        """It waits for another activity's release and is stopped: it holds nothing."""
        self._end("cancel", [self.evaluation], [])

    def error_while_asking(self) -> None:
        """A resource answers with an error while others have not answered yet, for a producer waits itself.

        Nothing but this failure may happen for long, so the activity does not wait on: it gives up what is
        still asked for. Hardware that has failed would else never get out of *failing*.
        """
        for places, given in self._while_asking():
            if any(place.endswith("_error") for place in places):
                stages = "_".join(place.rsplit("_", 1)[1] for place in places)
                self._draw(
                    "werr",
                    [self.wait, *places],
                    [*given, *self.otherwise],
                    stages,
                    read=self.quiet_to_refuse,
                )

    def stop_while_waiting(self) -> None:
        """It waits for answers and is stopped: give back what came, give up what is still asked for.

        A request given up frees its resource at once, in one step with the stop: were it a release on its
        way, an answer could still come in between and stay behind.
        """
        for places, given in self._while_asking():
            stages = [place.rsplit("_", 1)[1] for place in places]
            self._end("giveup_" + "_".join(stages), [self.wait, *places], given)

    def _while_asking(self) -> Iterator[tuple[tuple[str, ...], list[str]]]:
        """How far its requests may be, not all answered: the places, and those that give everything back."""
        for places in product(*(self._stages(k) for k in self.consumes)):
            if not any(place.endswith("_waiting") for place in places):
                continue
            given: list[str] = []
            for (k, i), place in zip(self.at.items(), places, strict=True):
                if place != f"{i}_waiting":
                    given.append(f"{i}_release")
                elif self.usage.sharing.serves(self.usage.producer[k]):
                    given += [f"{i}_free", f"{i}_unused"]
                else:
                    given.append(f"{i}_free")
            yield places, given

    def evaluate_again(self) -> None:
        """A product is given back while another is held: evaluate every alternative again."""
        for back, held in permutations(self.life.again, 2):
            self._draw(
                "again",
                [*self.runs, *self._answers(()), f"{back}_free"],
                [*self._releases(), self.life.start, f"{back}_available"],
                back,
                held,
                read=[f"{held}_answer"],
            )

    def _stages(self, resource: str) -> Iterator[str]:
        """Places that say how far the request of a resource has come."""
        i = self.at[resource]
        yield f"{i}_answer"
        if self.usage.can_fail(resource):
            yield f"{i}_error"
        if resource not in self.hardware and self.usage.may_wait(self.usage.producer[resource]):
            yield f"{i}_waiting"

    def _answers(self, errors: tuple[str, ...]) -> list[str]:
        return [f"{i}_error" if k in errors else f"{i}_answer" for k, i in self.at.items()]

    def _releases(self) -> list[str]:
        return [f"{i}_release" for i in self.at.values()]

    def _end(self, verb: str, consume: list[str], produce: list[str]) -> None:
        name = f"{verb}{self.number}" if verb in ("stop", "cancel") else f"{verb}_{self.number}"
        ending = self.life.ending
        self.pen.transition(
            f"{self.prefix}_{name}",
            [*consume, *ending.consume],
            [*produce, *ending.produce],
            read=ending.read,
        )

    def _draw(
        self, verb: str, consume: list[str], produce: list[str], *of: str, read: list[str] | None = None
    ) -> None:
        name = "_".join([f"{self.prefix}_{verb}{self.number}", *of])
        self.pen.transition(name, consume, produce, read=read)


def _subsets(items: list[str] | tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Every non-empty subset, smaller ones first."""
    for size in range(1, len(items) + 1):
        yield from combinations(items, size)
