"""Faults seeded in templates, and what of mcpn's kit finds each, in how many CPU seconds.

Run: python experiments/faults/template_faults.py [--profile ci] [WORDS...] (some fifteen minutes)

Each fault is a set of templates in which, whatever the mission, one kind of transition is not as the paper
draws it. The kit is asked in its order: drawn missions and the corpus, property by property as it says, then
each template alone. WORDS choose faults whose names hold one of them. The right variants come last: of these
nothing may be found. Tests hold the kit to each of them (``tests/kit``).
"""

from __future__ import annotations

import argparse
import re
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from mcpn.drawing.templates import Canvas, PaperTemplates, TemplateSet
from mcpn.drawing.templates.compact import CompactTemplates
from mcpn.events import Event, What
from mcpn.mission.core.objectives_graph import ObjectivesGraph
from mcpn.mission.robot import Activity, Hardware, Software
from mcpn.testing.kit.contract import STATES
from mcpn.testing.kit.running import broken
from mcpn.testing.kit.units import MACHINES, driven


@dataclass(frozen=True)
class Drawn:
    """The arcs of a transition, each with the part of its element that a place is."""

    consume: tuple[tuple[str, str], ...]
    produce: tuple[tuple[str, str], ...]
    read: tuple[tuple[str, str], ...]
    rank: int = 0
    event: Event | None = None


Arcs = tuple[tuple[str, str], ...]
Change = Callable[[Drawn], Drawn | None]
Fault = tuple[str, str, Change]
"""The kind of element, a pattern of its transitions, and what is wrong with them."""


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


def both(first: Change, second: Change) -> Change:
    """One change after the other."""

    def change(drawn: Drawn) -> Drawn | None:
        changed = first(drawn)
        return None if changed is None else second(changed)

    return change


def happens_as(**words: What) -> Change:
    """It is of another event of the same element: by what it should be, what it is."""

    def change(drawn: Drawn) -> Drawn:
        event = drawn.event
        if event is None or event.what.name not in words:
            return drawn
        return replace(drawn, event=replace(event, what=words[event.what.name]))

    return change


def missing(_: Drawn) -> None:
    """It is not drawn."""


def never_taken(drawn: Drawn) -> Drawn | None:
    """An alternative is not selected, and is passed over whether it is possible or not."""
    return None if _split(drawn.produce, "take")[0] else ignores("OOS")(drawn)


def one_less(part: str) -> Change:
    """Of several such places it takes one less."""

    def change(drawn: Drawn) -> Drawn:
        those, others = _split(drawn.consume, part)
        return drawn if len(those) < 2 else replace(drawn, consume=(*others, *those[1:]))

    return change


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

            before = Drawn(side("consume"), side("produce"), side("read"), arcs["rank"], arcs["event"])
            after = self.change(before)
            self.changed += after != before
            if after is not None:
                for name_of_side in ("consume", "produce", "read"):
                    arcs[name_of_side] = [place for _, place in getattr(after, name_of_side)]
                draw(name, **{**arcs, "rank": after.rank, "event": after.event})

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
        """The paper's, with the fault."""
        with self._at_work(canvas):
            super().hardware(canvas, resource)

    def software(self, canvas: Canvas, resource: Software) -> None:
        """The paper's, with the fault."""
        with self._at_work(canvas):
            super().software(canvas, resource)

    def activity(self, canvas: Canvas, activity: Activity) -> None:
        """The paper's, with the fault."""
        with self._at_work(canvas):
            super().activity(canvas, activity)

    def control(self, canvas: Canvas, graph: ObjectivesGraph) -> None:
        """The paper's, with the fault."""
        with self._at_work(canvas):
            super().control(canvas, graph)


BY_ELEMENT: dict[str, dict[str, Fault]] = {
    "hardware": {
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
        "it is out of service, and available as well": ("hardware", "3", keeps("available")),
        "its repair is told as a failure": ("hardware", "EV_RD", happens_as(REPAIRED=What.OUT_OF_SERVICE)),
    },
    "software": {
        "it does not start its producer": ("software", "1", forgets("StartByRes")),
        "it is never answered": ("software", "2", forgets("answer")),
        "it waits for ever when its producer refuses": ("software", "3", missing),
        "it is lost and its consumer is not told": ("software", "6", forgets("error")),
        "it is never given back": ("software", "4", missing),
        "its producer stops, and it is not available": ("software", "5", forgets("available")),
        "its producer starts again while it is held: a race is missing": ("software", "7", missing),
        "it answers whether its producer runs or not": ("software", "2", ignores("running")),
        "it refuses whether its producer does or not": ("software", "3", ignores("refusing")),
        "it is given back, and its producer asked for still": ("software", "4", forgets("unused")),
    },
    "activities": {
        "it selects and does not ask": ("activity", r"sel\d+", forgets("take")),
        "it runs before it is answered": ("activity", r"go\d+", ignores("answer")),
        "it stops and gives nothing back": ("activity", r"stop\d+", forgets("release")),
        "it stops again and again": ("activity", r"stop\d+", keeps("Stop")),
        "it passes over what is possible": ("activity", r"else\d+", ignores("OOS")),
        "it never passes over what is not": ("activity", r"else\d+", missing),
        "it is refused and its second alternative possible": ("activity", r"(sel|else)2", never_taken),
        "it loses a resource and does not evaluate again": ("activity", r"err\d+", missing),
        "it gives up while it waits and goes nowhere": ("activity", r"werr\d+", forgets("eval")),
        "it is refused and cannot be stopped": ("activity", "errstop", missing),
        "it stops before anybody has decided: swapped ranks": ("activity", r"stop\d+", ranked(-9)),
        "it returns to what is not possible": ("activity", r"back\d+", ignores("service")),
        "a retry begins before what stops is idle": ("objective", "begin", keeps("idle")),
        "it never tries its first alternative": ("activity", r"(sel|else)1", never_taken),
        "it never returns to what is better": ("activity", r"back\d+", missing),
        "it loses a resource and gives nothing back": ("activity", r"err\d+", forgets("release")),
    },
    "control": {
        "an objective succeeds and stops nothing": ("objective", "EV_OK", forgets("Stop")),
        "an objective fails and runs still": ("objective", "EV_FAIL", keeps("")),
        "a block never ends": ("parallel", "exit_.*", missing),
        "a block ends again and again": ("parallel", "exit_.*", keeps("ok")),
        "success is told as failure, and failure as success": (
            "objective",
            r"EV_(OK|FAIL)\d*",
            happens_as(SUCCESS=What.FAILURE, FAILURE=What.SUCCESS),
        ),
        "an objective succeeds whatever runs": (
            "objective",
            r"EV_OK\d*",
            both(ignores("active"), ignores("running")),
        ),
        "the mission starts, and may start again": ("mission", "EV_START", keeps("begin")),
        "what an objective has ended rests for ever": ("mission", "rested", missing),
    },
    "facts": {
        "an event changes nothing and ends what was": ("fact", "EV.*", forgets("false")),
        "an event leaves what was": ("fact", "EV.*", keeps("true")),
        "an event that changes facts never happens": ("fact", "EV.*", missing),
        "it runs whatever it requires": ("activity", r"sel\d+", ignores("true")),
        "it is not passed over, whatever it requires": ("activity", r"not\d+", missing),
        "it goes on though what it requires is no more": ("activity", r"lost\d+", missing),
        "an objective succeeds and changes nothing": (
            "objective",
            r"EV_OK\d+",
            both(keeps("left"), forgets("right")),
        ),
        "an objective begins and changes nothing": (
            "objective",
            r"start\d+",
            both(keeps("false"), forgets("true")),
        ),
        "a route looks at no fact": ("objective", r"EV_FAIL\d+", ignores("false")),
        "the route of a block looks at no fact": ("parallel", "exit_.*", ignores("left")),
        "what begins changes facts after activities have looked": ("objective", r"start\d+", ranked(99)),
    },
    "late loss": {
        "its loss is seen though nobody looks": ("hardware", "EV_DETECTED_.*", ignores("active")),
        "its loss is never seen": ("hardware", "EV_DETECTED_.*", missing),
        "it is misused and cannot be given back": ("hardware", "8g", missing),
        "it is suspected and cannot be given back": ("hardware", "8s", missing),
        "it is misused and never suspected": (
            "hardware",
            "doubt_m",
            both(keeps("trusted"), forgets("suspected")),
        ),
        "it is gone and not misused": ("hardware", "9g", both(keeps("fine"), forgets("misused"))),
        "it is repaired and gone still": ("hardware", "EV_RD", both(keeps("gone"), forgets("well"))),
        "a doubt is never dropped": ("hardware", "doubt_f", missing),
        "it is noticed, and suspected still": (
            "hardware",
            r"EV_DETECTED_s\d+",
            both(keeps("suspected"), forgets("trusted")),
        ),
    },
    "crashes": {
        "it crashes while it does not run": ("hardware", r"EV_OOS\d+", ignores("active")),
        "what is lost never returns": ("hardware", "EV_RD", missing),
        "it crashes, and runs on": ("hardware", r"EV_OOS\d+", forgets("error")),
    },
    "timeout": {
        "its time is never over": ("objective", r"EV_TIMEOUT\d*", missing),
        "its time is over and it runs on": ("objective", r"EV_TIMEOUT\d*", keeps("")),
        "its time is over and nothing stops": ("objective", r"EV_TIMEOUT\d*", forgets("Stop")),
        "its time is over, and that is told as a failure": (
            "objective",
            r"EV_TIMEOUT\d*",
            happens_as(TIMEOUT=What.FAILURE),
        ),
    },
    "handlers, once": {
        "what happens once happens again": (
            "objective",
            r"EV\d+_.*",
            both(keeps("open"), forgets("happened")),
        ),
        "it is interrupted and nothing stops": ("objective", r"EV\d+_.*", forgets("Stop")),
        "it is interrupted and runs on": ("objective", r"EV\d+_.*", keeps("")),
        "a block is interrupted and halts no branch": ("parallel", r"EV\d+_.*", forgets("halt")),
        "a branch is halted and nothing stops": ("parallel", r"halt\d+", forgets("Stop")),
        "an interrupted block is never left": ("parallel", "left_.*", missing),
        "what happened inside once is handled outside while it may happen": (
            "objective",
            r"EV\d+_.*",
            ignores("happened"),
        ),
        "the same of a block": ("parallel", r"EV\d+_.*", ignores("happened")),
    },
    "abort, early ends": {
        "a block that needs one branch awaits all": ("parallel", "succeed", missing),
        "a block aborts and halts no branch": ("parallel", "abort", forgets("halt")),
        "a block never aborts": ("parallel", "abort", missing),
        "a block is decided and never left": ("parallel", "succeeded|failed", missing),
        "a block that failures decide awaits all": ("parallel", "fail", missing),
        "a block fails and halts no branch": ("parallel", "fail", forgets("halt")),
        "a block fails by one failure less": ("parallel", "fail", one_less("fail")),
        "failures count before successes of the same moment": ("parallel", "fail", ranked(-9)),
        "successes count after failures of the same moment": ("parallel", "succeed", ranked(9)),
    },
    "guards, recovery, rounds": {
        "who may not enter enters": ("objective", r"EV_(OK|FAIL)\d+", ignores("true")),
        "who may not enter goes nowhere": ("objective", r"EV_(OK|FAIL)2", missing),
        "who enters uses up the fact": ("objective", r"EV_(OK|FAIL)\d+", takes("true")),
        "after a success nothing is entered": ("objective", r"EV_OK\d*", forgets("enter")),
        "the next round starts nothing": ("objective", r"EV_OK\d*", forgets("Start")),
        "a gate opens again and again": ("objective", "begin", keeps("enter")),
    },
    "shared producers": {
        "it is asked for, and may be asked for again": ("software", "1", keeps("unused")),
        "a refusal leaves its request open": ("software", "3", forgets("unused")),
        "it starts though nobody asks": ("activity", r"start\d+", ignores("waiting")),
        "it starts, and may start again": ("activity", r"start\d+", keeps("idle")),
        "it stops while somebody uses what it produces": ("activity", r"stop\d+", ignores("unused")),
        "it has refused, and is asked no more": ("activity", "refused", missing),
        # Told where it has waited for hardware: who asks anew may find possible what it has passed over.
        "it leaves its refusal before all have decided": ("activity", "refused", ignores("unused")),
        "it is kept, and never let go": ("activity", r"reststop\d+", missing),
        "it is kept, and let go while nothing ends": ("activity", r"reststop\d+", ignores("resting")),
    },
    "reserved data": {
        "it is given to the next though it is held": ("software", "5", ignores("free")),
        "it is produced, and asked for again": ("software", "1", keeps("notAvailable")),
    },
    "pause": {
        "a block pauses and nothing stops": ("parallel", r"pause\d+", forgets("Stop")),
        "after a pause nothing goes on": ("parallel", "over.*", forgets("resume")),
        "a paused branch is not entered again": ("parallel", r"resume\d+", forgets("enter")),
        "what runs during a pause never ends it": ("parallel", "over.*", missing),
        "a block that pauses is never halted": ("parallel", r"paused\d+", missing),
    },
    "gates": {
        "what begins does not wait for what stops": ("objective", "begin", ignores("idle")),
        "a gate never opens": ("objective", "begin", missing),
        "a gate opens before what stops has stopped: swapped ranks": ("objective", "begin", ranked(-99)),
    },
    "contention": {
        "it waits and cannot be stopped": ("activity", r"cancel\d+", missing),
        "it waits, is stopped, and waits on": ("activity", r"cancel\d+", keeps("Start")),
        "it waits for a producer and cannot be stopped": ("activity", r"giveup\d+", missing),
        "it waits for a producer, gives up, and gives nothing back": (
            "activity",
            r"giveup\d+",
            forgets("release"),
        ),
        "it waits for a producer, whatever else fails": ("activity", r"askerr\d+", missing),
        "it waits for a producer, whatever it requires": ("activity", r"asklost\d+", missing),
    },
}
"""By element and by what is wrong: the kind of element, the transitions, and the change."""

FAULTS: dict[str, Fault] = {name: fault for some in BY_ELEMENT.values() for name, fault in some.items()}

HARMLESS: dict[str, Fault] = {
    # Who asks has read that it is free as it selected, and nothing fails within a reaction.
    "shared, it answers without looking whether it fails": ("hardware", "7", ignores("free")),
    # Who halts a block takes the tokens of the gates inside, in an earlier rank than that of gates.
    "a gate opens in a block that is halted": ("objective", "begin", ignores("running")),
}
"""Faults that change nothing that anybody sees, and why."""


class Warming(PaperTemplates):
    """Hardware that is warmed up after each use, before it is free: a transient place more."""

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        """The paper's, but for what is given back."""
        if resource.detected == "late" or resource.name in canvas.usage.sharing.consumers:
            super().hardware(canvas, resource)
            return
        draw, r = canvas.transition, resource.name
        free, available = (canvas.place_of("hardware", r, part) for part in ("free", "available"))
        warming = canvas.of("hardware", r, resource.source).place("warming")

        def transition(name: str, **arcs: Any) -> None:
            if name == canvas.names.of("hardware", r, "8"):
                warmed = {**arcs, "consume": [warming], "produce": [free, available], "read": []}
                draw(canvas.names.of("hardware", r, "warm"), **warmed)
                arcs["produce"] = [warming]
            draw(name, **arcs)

        vars(canvas)["transition"] = transition
        try:
            super().hardware(canvas, resource)
        finally:
            del vars(canvas)["transition"]


class Held(PaperTemplates):
    """Hardware whose private places have names of its own, which it maps to the states of hardware."""

    hardware_states: ClassVar = {**STATES, "used": ("held",), "between": ("going_down",)}

    def hardware(self, canvas: Canvas, resource: Hardware) -> None:
        """The paper's, by other names."""
        named, own = canvas.place_of, {"busy": "held", "failing": "going_down"}

        def place_of(kind: str, element: str, *part: str) -> str:
            return named(kind, element, *(own.get(word, word) for word in part))

        vars(canvas)["place_of"] = place_of
        try:
            super().hardware(canvas, resource)
        finally:
            del vars(canvas)["place_of"]


class Noted(PaperTemplates):
    """Software with a place of its own that says nothing."""

    def software(self, canvas: Canvas, resource: Software) -> None:
        """The paper's, with a place beside it that nobody needs."""
        super().software(canvas, resource)
        canvas.of("software", resource.name, resource.source).place("note", initial=1)


RIGHT: Mapping[str, Callable[[], TemplateSet]] = {
    "paper": PaperTemplates,
    "compact": CompactTemplates,
    "compact, nothing combined": lambda: CompactTemplates(at_once=0, combined=0),
    "hardware that warms up": Warming,
    "software with a place that nobody needs": Noted,
    "hardware whose places have other names": Held,
}
"""Sets of templates that are right."""


def found_by(templates: TemplateSet, profile: str) -> str | None:
    """What of the kit finds something in some templates first; ``None`` where nothing does."""
    finding = broken(templates, profile=profile)
    if finding is not None:
        return finding.property
    alone = next((name for name in MACHINES if driven(templates, profile=profile, only=name)), None)
    return alone and f"alone: {alone}"


def main() -> None:
    """Prints a row for each fault, then for each right variant."""
    plain = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=plain)
    parser.add_argument("words", nargs="*", help="words of the names of faults")
    parser.add_argument("--profile", default="ci")
    asked = parser.parse_args()
    rows: list[tuple[str, str, Callable[[], TemplateSet]]] = [
        (element, name, lambda fault=fault: Faulty(*fault))  # type: ignore[misc]
        for element, faults in BY_ELEMENT.items()
        for name, fault in faults.items()
    ]
    rows += [("right", name, made) for name, made in RIGHT.items()]
    print("| element | what is wrong | found by | CPU s |\n|---|---|---|---|")
    missed = []
    for element, name, made in rows:
        if asked.words and not any(word in f"{element} {name}" for word in asked.words):
            continue
        begun = time.process_time()
        by = found_by(made(), asked.profile)
        print(f"| {element} | {name} | {by or 'nothing'} | {time.process_time() - begun:.1f} |", flush=True)
        if (by is None) != (element == "right"):
            missed.append(name)
    print(f"wrong: {', '.join(missed) or 'none'}")


if __name__ == "__main__":
    main()
