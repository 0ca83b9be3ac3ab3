"""Faults seeded in templates: whatever the mission, one kind of transition is not as the paper draws it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

from mcpn.drawing.templates import Canvas, PaperTemplates
from mcpn.mission.flatten import ObjectivesGraph
from mcpn.mission.robot import Activity, Hardware, Software


@dataclass(frozen=True)
class Drawn:
    """The arcs of a transition, each with the part of its element that a place is."""

    consume: tuple[tuple[str, str], ...]
    produce: tuple[tuple[str, str], ...]
    read: tuple[tuple[str, str], ...]
    rank: int = 0


Arcs = tuple[tuple[str, str], ...]
Change = Callable[[Drawn], Drawn | None]


def _split(arcs: Arcs, part: str) -> tuple[Arcs, Arcs]:
    """Arcs of places that are some part, and the others."""
    return tuple(a for a in arcs if a[0] == part), tuple(a for a in arcs if a[0] != part)


def keeps(part: str) -> Change:
    """It reads what it should take."""

    def change(drawn: Drawn) -> Drawn:
        kept, taken = _split(drawn.consume, part)
        return replace(drawn, consume=taken, read=(*drawn.read, *kept))

    return change


def takes(part: str) -> Change:
    """It takes what it should read."""

    def change(drawn: Drawn) -> Drawn:
        taken, read = _split(drawn.read, part)
        return replace(drawn, consume=(*drawn.consume, *taken), read=read)

    return change


def ignores(part: str) -> Change:
    """It neither takes nor reads it."""
    return lambda drawn: replace(
        drawn, consume=_split(drawn.consume, part)[1], read=_split(drawn.read, part)[1]
    )


def forgets(part: str) -> Change:
    """It does not put it."""
    return lambda drawn: replace(drawn, produce=_split(drawn.produce, part)[1])


def missing(_: Drawn) -> None:
    """It is not drawn."""


def ranked(more: int) -> Change:
    """It fires so many ranks later, or earlier."""
    return lambda drawn: replace(drawn, rank=max(drawn.rank + more, 0))


class Faulty(PaperTemplates):
    """The paper's templates with one fault.

    Args:
        kind: The kind of element whose transitions are not as they should be.
        transition: A pattern of their parts.
        change: What is wrong with them.
    """

    def __init__(self, kind: str, transition: str, change: Change) -> None:
        self.kind, self.transition, self.change = kind, transition, change
        self.changed = 0

    @contextmanager
    def _at_work(self, canvas: Canvas) -> Iterator[None]:
        draw = canvas.transition

        def transition(name: str, **arcs: Any) -> None:
            kind, _, part, *_ = (*(canvas.names.meaning(name) or ()), "", "", "")
            if kind != self.kind or not re.fullmatch(self.transition, part):
                draw(name, **arcs)
                return

            def side(name: str) -> Arcs:
                return tuple((self._part(canvas, place), place) for place in arcs[name])

            before = Drawn(side("consume"), side("produce"), side("read"), arcs["rank"])
            after = self.change(before)
            self.changed += after != before
            if after is not None:
                for name_of_side in ("consume", "produce", "read"):
                    arcs[name_of_side] = [place for _, place in getattr(after, name_of_side)]
                draw(name, **{**arcs, "rank": after.rank})

        vars(canvas)["transition"] = transition
        try:
            yield
        finally:
            del vars(canvas)["transition"]

    @staticmethod
    def _part(canvas: Canvas, place: str) -> str:
        _, _, part, *_ = (*(canvas.names.meaning(place) or ("", "")), "")
        return re.sub(r"\d+$", "", part)

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        with self._at_work(canvas):
            super().hardware(canvas, resource)

    def software(self, canvas: Canvas, resource: Software) -> None:
        with self._at_work(canvas):
            super().software(canvas, resource)

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        with self._at_work(canvas):
            super().activity(canvas, activity)

    def control(self, canvas: Canvas, graph: ObjectivesGraph) -> None:
        with self._at_work(canvas):
            super().control(canvas, graph)


FAULTS: dict[str, tuple[str, str, Change]] = {
    # --- hardware
    "it forgets its acknowledgement": ("hardware", "9|7", forgets("answer")),
    "it is taken and asked for still": ("hardware", "9", keeps("take")),
    "it is given back again and again": ("hardware", "8", keeps("release")),
    "it is given back and not free": ("hardware", "8", forgets("free")),
    "it is given back and not available": ("hardware", "8", forgets("available")),
    "it fails and answers still": ("hardware", "EV_OOS_b", keeps("answer")),
    "it fails, and who holds it is not told": ("hardware", "EV_OOS_b", forgets("error")),
    "it may fail and be free": ("hardware", "EV_OOS_f", keeps("free")),
    "it fails and nobody is told that it is out": ("hardware", "3", forgets("OOS")),
    "it is given back, and fails without having failed": ("hardware", "4", ignores("failing")),
    "it has failed and is given back: a race is missing": ("hardware", "4", missing),
    "it returns and is not available": ("hardware", "EV_RD", forgets("available")),
    "shared, it fails and the first who is told takes it": ("hardware", "6", takes("failing")),
    # --- software
    "it does not start its producer": ("software", "1", forgets("StartByRes")),
    "it is never answered": ("software", "2", forgets("answer")),
    "it waits for ever when its producer refuses": ("software", "3", missing),
    "it is lost and its consumer is not told": ("software", "6", forgets("error")),
    "it is never given back": ("software", "4", missing),
    "its producer stops, and it is not available": ("software", "5", forgets("available")),
    "its producer starts again while it is held: a race is missing": ("software", "7", missing),
    "it answers whether its producer runs or not": ("software", "2", ignores("running")),
    "it refuses whether its producer does or not": ("software", "3", ignores("refusing")),
    # --- activities
    "it selects and does not ask": ("activity", r"sel\d+", forgets("take")),
    "it runs before it is answered": ("activity", r"go\d+", ignores("answer")),
    "it stops and gives nothing back": ("activity", r"stop\d+", forgets("release")),
    "it stops again and again": ("activity", r"stop\d+", keeps("Stop")),
    "it passes over what is possible": ("activity", r"else\d+", ignores("OOS")),
    "it never passes over what is not": ("activity", r"else\d+", missing),
    "it loses a resource and does not evaluate again": ("activity", r"err\d+", missing),
    "it gives up while it waits and goes nowhere": ("activity", r"werr\d+", forgets("eval")),
    "it is refused and cannot be stopped": ("activity", "errstop", missing),
    "it stops before anybody has decided: swapped ranks": ("activity", r"stop\d+", ranked(-9)),
    "it returns to what is not possible": ("activity", r"back\d+", ignores("service")),
    "a retry begins before what stops is idle": ("objective", "begin", keeps("idle")),
    # --- control
    "an objective succeeds and stops nothing": ("objective", "EV_OK", forgets("Stop")),
    "an objective fails and runs still": ("objective", "EV_FAIL", keeps("")),
    "a block never ends": ("parallel", "exit_.*", missing),
    "a block ends again and again": ("parallel", "exit_.*", keeps("ok")),
}
"""By what is wrong: the kind of element, the transitions, and the change."""

HARMLESS: dict[str, tuple[str, str, Change]] = {
    # Who asks has read that it is free as it selected, and nothing fails within a reaction.
    "shared, it answers without looking whether it fails": ("hardware", "7", ignores("free")),
    # With hardware as it is, who asks a producer that has left its refusal is refused again.
    "it leaves its refusal before all have decided": ("activity", "refused", ignores("unused")),
}
"""Faults that change nothing that anybody sees, and why."""
