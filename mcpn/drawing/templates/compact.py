"""Templates of the same behaviour whose nets are small: linear in what the paper's are exponential in.

The paper's templates take in one firing what has come together: the outcomes of all children of a parallel
block, the errors of several resources, how far all requests of an alternative have come. So they have one
transition for each combination. These take note of it one by one, in places and transitions of a number that
is linear in children, consumed resources and alternatives; what follows, from stable state to stable state,
is the same (``papers/templates.md``, "The compact set").
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import product

from mcpn.drawing.templates import PaperTemplates
from mcpn.drawing.templates.activities import AlternativeDrawing, draw_activity
from mcpn.drawing.templates.canvas import Canvas
from mcpn.drawing.templates.control import draw_control
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.robot import Activity

AT_ONCE, COMBINED = 2, 3
"""Errors and children up to which a transition for each combination is the smaller net."""

SHARING_RETURNS = 3
"""Alternatives from which on they share what says that a better one is possible."""


class CompactTemplates(PaperTemplates):
    """Templates whose nets grow with a mission as the mission does.

    Args:
        at_once: Errors that one transition takes at a time.
        combined: Children of a parallel block up to which each combination of outcomes has a transition.
    """

    def __init__(self, at_once: int = AT_ONCE, combined: int = COMBINED) -> None:
        self.at_once = at_once
        self.combined = combined

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        """Errors, requests that are given up and returns to a better alternative go one by one."""
        draw_activity(canvas, activity, at_once=self.at_once, drawing=_CompactAlternative)

    def control(self, canvas: Canvas, graph: ObjectivesGraph) -> None:
        """Outcomes of children are counted one by one."""
        canvas.most_combined = self.combined
        draw_control(canvas, graph)


class _CompactAlternative(AlternativeDrawing):
    """One alternative, drawn with linearly many places and transitions."""

    @cached_property
    def waits(self) -> bool:
        """Whether it may be found waiting for answers in a stable marking."""
        return self.usage.waits_for_answer(self.activity.name, self.index)

    def error_while_waiting(self) -> None:
        """Where it may wait, an error while others have answered or not; else as in the paper."""
        if not self.waits:
            super().error_while_waiting()
            return
        self.give_back()
        for k in self.consumes:
            if self.usage.can_fail(k):
                self.leave_waiting("askerr", k, "error", "onward")

    def not_allowed_while_asking(self, fact: str, value: str, place: str) -> None:
        """A fact is not as it requires, and some resource has not answered yet."""
        for k in self.unanswered():
            self.leave_waiting("asklost", k, "waiting", "onward", fact, value, read=[place])

    def stop_while_waiting(self) -> None:
        """It is stopped while some resource has not answered yet."""
        for ending, k in product(self.life.endings, self.unanswered()):
            taken = [self.wait, self.of(k, "waiting"), *ending.consume]
            put = [*self.after(k, "waiting"), self.place_of("halting")]
            self.draw(f"{ending.moment}giveup", taken, put, k, read=ending.read, rank=ending.rank)

    def unanswered(self) -> Iterator[str]:
        """Resources whose answer may take long."""
        return (k for k in self.consumes if "waiting" in self.stages(k))

    def leave_waiting(
        self, verb: str, k: str, stage: str, whereto: str, *suffixes: str, read: list[str] | None = None
    ) -> None:
        """It waits, and the request of one resource has come so far: give that back, then all others."""
        put = [*self.after(k, stage), self.place_of(whereto)]
        self.handle(verb, [self.wait, self.of(k, stage)], put, *suffixes, k, read=read)

    def after(self, first: str, stage: str) -> list[str]:
        """What is marked when one resource is given back, and the others are to be."""
        given = [self.of(first, part) for part in self.given_up(first, stage)]
        others = [self.place_of("asking", k) for k in self.consumes if k != first]
        return [*given, self.place_of("given", first), *others]

    def give_back(self) -> None:
        """Gives back all that was asked for, however far each request has come, one by one.

        Nobody but the activity waits for them meanwhile: when all are given back it goes on. Each is given
        back by a transition of its own; that another activity may take one before the next is given back, it
        also may where all are released at a time, for a resource is available one firing later.
        """
        given = [self.pen.place(*self.part("given", k)) for k in self.consumes]
        for k, done in zip(self.consumes, given, strict=True):
            asking = self.pen.place(*self.part("asking", k))
            for stage in self.stages(k):
                put = [done, *(self.of(k, part) for part in self.given_up(k, stage))]
                self.draw(f"give{stage[0]}", [asking, self.of(k, stage)], put, k)
        onward = self.pen.place(*self.part("onward"))
        self.draw("onward", [*given, onward], self.otherwise)
        if any(self.unanswered()):
            halting = self.pen.place(*self.part("halting"))
            self.draw("halted", [*given, halting], self.life.endings[0].produce)

    def all(self) -> None:
        """Draws every transition of the alternative."""
        if self.left_for_better:
            of_all = [self.of_activity("steady"), *(self.of_activity(f"from{j}") for j in self.counted)]
            self.runs += of_all
            self.runs_and_says += of_all
        super().all()

    @cached_property
    def left_for_better(self) -> bool:
        """Whether it is left for a better one by places that alternatives share; not where these are few."""
        few = len(self.activity.alternatives) < SHARING_RETURNS
        return not few and bool(self.usage.switching.better(self.activity.name, self.index))

    @cached_property
    def counted(self) -> list[int]:
        """Numbers of the alternatives up to this one for which something more can be better."""
        return [j for j in range(1, self.index + 1) if self.new_ways(j)]

    def new_ways(self, index: int) -> list[tuple[str, ...]]:
        """What makes a better alternative possible for that of a number, and for none before it."""
        better = self.usage.switching.better
        before = better(self.activity.name, index - 1)
        return [way for way in better(self.activity.name, index) if way not in before]

    def error_while_active(self) -> None:
        """It is left for a better alternative as it is for errors, one of which may come at the same time."""
        if not self.left_for_better:
            super().error_while_active()

    def switch_back(self) -> None:
        """An alternative of higher priority is possible again: what says so is drawn once for all."""
        if not self.left_for_better:
            super().switch_back()
            return
        steady, turning = (self.of_activity(part) for part in ("steady", "turning"))
        if self.counted[0] == self.index:
            self.pen.place("steady")
            self.pen.place("turning")
        if self.index in self.counted:
            lower = self.pen.place(f"from{self.index}")
            for way in self.new_ways(self.index):
                read = [lower, *(self.possible_again(h) for h in way)]
                self.handle("turn", [steady], [turning], *way, read=read)
        failing = tuple(k for k in self.consumes if self.usage.can_fail(k))
        self.give_up_one_by_one("err", self.runs, failing, [self.life.start], alone=True)
        ended = [turning, *(place for place in self.runs if place != steady)]
        self.handle("back", ended, [self.place_of("err")])

    def part(self, word: str, *suffixes: str) -> tuple[str, ...]:
        """A part of the activity that belongs to this alternative."""
        return (f"{word}{self.number}", *suffixes)

    def of_activity(self, word: str) -> str:
        """The name of a place that its alternatives share, drawn already or not."""
        return self.canvas.place_of("activity", self.activity.name, word)

    def place_of(self, word: str, *suffixes: str) -> str:
        """The name of a place of this alternative, drawn already or not."""
        return self.canvas.place_of("activity", self.activity.name, *self.part(word, *suffixes))
