"""A machine that drives an activity alone, and plays the objective that starts it and its resources.

State machines that drive one template alone, in the most general environment of its contract.

A property of whole missions sees a template where some mission brings it. A machine of hypothesis brings it
everywhere: it plays all others at once, does in any order whatever the contract (``docs/templates.md``)
allows them, and looks after each step at what the template promises. What breaks is shrunk to a short
series of steps.

Hardware, shared or not, is driven, software whose producer does not serve, and an activity that an objective
starts. What waits for another activity's release, serving producers, returns to better alternatives, facts
and control are left to whole missions.

>>> from mcpn.drawing.templates import PaperTemplates
>>> driven(PaperTemplates(), profile="dev") is None
True
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, ClassVar

from hypothesis import Phase, settings
from hypothesis import strategies as st
from hypothesis.stateful import invariant, precondition, rule, run_state_machine_as_test

from mcpn.drawing.templates import TemplateSet
from mcpn.mission.model import Objective, Parallel
from mcpn.testing.kit.contract import CHOICE, TemplateMachine
from mcpn.testing.kit.corpus import objective
from mcpn.testing.kit.running import PROFILES
from mcpn.testing.kit.subject import Violation
from mcpn.testing.shape import activity, hw, mission, robot


class ActivityMachine(TemplateMachine):
    """An activity between an objective and the resources that it consumes."""

    def __init__(self) -> None:
        super().__init__()
        self.started = False
        self.failing: set[str] = set()
        self.impossible: set[str] = set()
        """Resources that were refused since something happened last."""
        self.begun = 0
        """Length of the run when something happened last."""
        self.was_refused = False
        """Whether it was refused then."""
        (self.drawn,) = (a for a in self.mission.activities if a.name == self.element[1])
        self.consumed = list(dict.fromkeys(k for way in self.drawn.alternatives for k in way.consumes))

    def resource(self, k: str) -> tuple[str, str]:
        """Kind and name of a resource."""
        return ("hardware" if k in self.of.usage.hardware else "software"), k

    def with_token(self, part: str) -> list[str]:
        """Resources of which a place is marked."""
        return [k for k in self.consumed if self.has(part, element=self.resource(k))]

    def passes_on(self, k: str, before: str, after: str, said: str) -> None:
        """A resource takes a token of its interface and puts another."""
        places = (self.at(part, element=self.resource(k)) for part in (before, after))
        taken, put = places
        self.of.move(f"{k} {said}", (taken,), (put,))

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return bool(self.with_token("take") or self.with_token("release"))

    def something_happens(self) -> None:
        """From here on a reaction is looked at."""
        self.impossible.clear()
        self.begun = len(self.of.run)
        self.was_refused = self.has("error")

    @precondition(lambda self: not self.started and self.at_rest)
    @rule()
    def starts(self) -> None:
        """An objective starts it."""
        self.something_happens()
        self.started = True
        self.of.move("starts", (), (self.at("Start"),))

    @precondition(lambda self: self.started and self.at_rest)
    @rule()
    def stops(self) -> None:
        """An objective stops it."""
        self.something_happens()
        self.started = False
        self.of.move("stops", (), (self.at("Stop"),))

    @precondition(lambda self: self.with_token("take"))
    @rule(choice=CHOICE, granted=st.booleans())
    def answers(self, choice: int, granted: bool) -> None:
        """A resource answers; software may be refused."""
        asked = self.with_token("take")
        k = asked[choice % len(asked)]
        if granted or self.resource(k)[0] == "hardware":
            self.passes_on(k, "take", "answer", "answers")
        else:
            self.impossible.add(k)
            self.passes_on(k, "take", "error", "is refused")

    @precondition(lambda self: self.with_token("release"))
    @rule(choice=CHOICE)
    def is_given_back(self, choice: int) -> None:
        """A resource is given back."""
        released = self.with_token("release")
        k = released[choice % len(released)]
        self.passes_on(k, "release", "OOS" if k in self.failing else "available", "is given back")
        self.failing.discard(k)

    @precondition(lambda self: self.at_rest and self.with_token("answer"))
    @rule(choice=CHOICE)
    def is_lost(self, choice: int) -> None:
        """A resource that is held fails."""
        self.something_happens()
        held = self.with_token("answer")
        k = held[choice % len(held)]
        if self.resource(k)[0] == "hardware":
            self.failing.add(k)
        self.passes_on(k, "answer", "error", "is lost")

    @precondition(lambda self: self.at_rest and self.toggled())
    @rule(choice=CHOICE)
    def changes_unused(self, choice: int) -> None:
        """Hardware that is not in use fails, or returns."""
        self.something_happens()
        k = self.toggled()[choice % len(self.toggled())]
        out = self.has("OOS", element=self.resource(k))
        self.passes_on(
            k, *(("OOS", "available") if out else ("available", "OOS")), "returns" if out else "fails"
        )

    def toggled(self) -> list[str]:
        """Hardware that nobody uses."""
        unused = {*self.with_token("OOS"), *self.with_token("available")}
        return [k for k in self.consumed if k in unused and self.resource(k)[0] == "hardware"]

    @invariant()
    def it_runs_with_what_it_holds(self) -> None:
        """While an alternative runs, all that it consumes has answered; some may be in error."""
        for i, way in enumerate(self.drawn.alternatives, 1):
            held = {*self.with_token("answer"), *self.with_token("error")}
            self.of.require(
                not self.has(f"active{i}") or held >= {*way.consumes},
                f"{way.name} runs before it is answered",
            )

    @invariant()
    def it_is_one_thing(self) -> None:
        """At rest it runs, or is refused, if it is started; and else is nothing and holds nothing."""
        if not self.at_rest:
            return
        running = [i for i in range(len(self.drawn.alternatives)) if self.has(f"active{i + 1}")]
        said = len(running) + self.has("error")
        self.of.require(
            said == self.started, f"it runs or is refused in {said} ways, started: {self.started}"
        )
        held = {k for i in running for k in self.drawn.alternatives[i].consumes}
        self.of.require({*self.with_token("answer")} == held, "it does not hold what it runs with")
        left = [part for part in ("Start", "Stop", "running") if self.has(part) and not running]
        self.of.require(not left, f"{' and '.join(left)} is left")
        self.of.require(not self.with_token("error"), "it does not take note of an error")
        selected = [name for name in self.of.run[self.begun :] if "_sel" in name]
        refused = self.has("error") and not self.was_refused
        if (running and selected) or refused:
            out = self.impossible | {*self.with_token("OOS")}
            passed = self.drawn.alternatives[: None if refused else running[0]]
            missed = [way.name for way in passed if not out & {*way.consumes}]
            does = "is refused and passes" if refused else "passes"
            self.of.require(not missed, f"it {does} over {' and '.join(missed)}, which was possible")


# Machines that drive a resource alone, hardware or software, and play its consumers and its producer.


class _ResourceMachine(TemplateMachine):
    """The consumers of a resource, each by an interface."""

    owners: ClassVar[tuple[str | None, ...]] = (None,)

    def chosen(self, part: str, choice: int) -> str | None:
        """An owner at whose interface a place is marked."""
        owners = [owner for owner in self.owners if self.has(part, owner)]
        return owners[choice % len(owners)]

    def any_has(self, part: str) -> bool:
        """Whether a place is marked at some interface."""
        return any(self.has(part, owner) for owner in self.owners)

    def passes_on(self, choice: int, before: str, after: str, said: str) -> None:
        """A consumer takes a token of its interface and puts another."""
        owner = self.chosen(before, choice)
        self.of.move(said, (self.at(before, owner),), (self.at(after, owner),))

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return self.any_has("error")

    def one(self, said: int, message: str) -> None:
        """Sees that one place of several is marked, or none while the template goes from one to another."""
        self.of.require(said == 1 or (said == 0 and bool(self.of.internal)), message)

    def may_ask(self) -> bool:
        """Whether a consumer may ask now."""
        return self.any_has("available")

    def may_give_back(self) -> bool:
        """Whether a consumer may give back now."""
        return self.any_has("answer")

    @precondition(lambda self: self.may_ask())
    @rule(choice=CHOICE)
    def asks(self, choice: int) -> None:
        """A consumer asks."""
        self.passes_on(choice, "available", "take", "asks")

    @precondition(lambda self: self.may_give_back())
    @rule(choice=CHOICE)
    def gives_back(self, choice: int) -> None:
        """A consumer gives back."""
        self.passes_on(choice, "answer", "release", "gives back")

    @precondition(lambda self: self.any_has("error"))
    @rule(choice=CHOICE)
    def notes_the_error(self, choice: int) -> None:
        """A consumer takes note of an error, and gives back."""
        self.passes_on(choice, "error", "release", "notes the error")


class HardwareMachine(_ResourceMachine):
    """Hardware between its consumers; nobody asks while it fails."""

    def may_ask(self) -> bool:
        """Whether a consumer may ask now."""
        return self.any_has("available") and not self.has("failing") and not self.any_has("error")

    @invariant()
    def it_is_in_one_state(self) -> None:
        """One of free, busy, failing, out of service."""
        said = sum(self.has(part) for part in ("free", "busy", "failing", "OOS"))
        self.one(said, f"{self.element[1]} is in {said} states")

    @invariant()
    def each_interface_is_in_one_state(self) -> None:
        """One token of an interface, or the hardware is out of service."""
        for owner in self.owners:
            parts = ("available", "take", "answer", "release", "error")
            said = sum(self.has(part, owner) for part in parts) + self.has("OOS")
            self.one(said, f"an interface of {self.element[1]} holds {said} tokens")

    @invariant()
    def it_answers(self) -> None:
        """At rest every request and release has been answered, and its status is known."""
        if self.at_rest:
            self.of.require(not self.any_has("take"), "a request is not answered")
            self.of.require(not self.any_has("release"), "a release is not answered")
            self.of.require(not self.has("failing"), "it fails for ever")
            out = [event.what.name for event in self.of.events]
            expected = ["REPAIRED"] if self.has("OOS") else ["OUT_OF_SERVICE"]
            self.of.require(out == expected, f"{out} may happen, expected {expected}")


class SoftwareMachine(_ResourceMachine):
    """Software between its consumer and its producer, which does not serve."""

    producer: ClassVar[tuple[str, str]]

    def __init__(self) -> None:
        super().__init__()
        self.runs = False

    @property
    def asked(self) -> bool:
        """Whether the producer evaluates."""
        return self.has("StartByRes", element=self.producer)

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return super().owed() or self.asked or (self.runs and self.has("free"))

    def may_give_back(self) -> bool:
        """Whether a consumer may give back now."""
        return super().may_give_back() and not self.asked and not self.of.internal

    @precondition(lambda self: self.asked and not self.has("activation"))
    @rule(runs=st.booleans())
    def producer_decides(self, runs: bool) -> None:
        """The producer, which has been started or evaluates again, runs or refuses."""
        self.runs = runs
        said, part = ("it runs", "activation") if runs else ("it refuses", "deactivation")
        self.of.move(said, (self.at("StartByRes", element=self.producer),), (self.at(part),))

    @precondition(lambda self: self.runs and self.at_rest)
    @rule()
    def producer_evaluates(self) -> None:
        """The producer has lost something and evaluates again."""
        self.of.move("it evaluates again", (), (self.at("StartByRes", element=self.producer),))

    @precondition(lambda self: self.runs and self.has("free") and not self.asked)
    @rule()
    def producer_stops(self) -> None:
        """Nobody holds the product: the producer stops."""
        self.runs = False
        self.of.move("it stops", (), (self.at("deactivation"),))

    @invariant()
    def its_interface_is_in_one_state(self) -> None:
        """One token of the interface, or it waits, or is free."""
        parts = ("available", "take", "answer", "release", "error", "waiting", "free")
        said = sum(map(self.has, parts))
        self.one(said, f"the interface of {self.element[1]} holds {said} tokens")

    @invariant()
    def it_answers(self) -> None:
        """At rest nothing is on its way; it is held if its producer runs, and else to be had."""
        if self.at_rest:
            left = [part for part in ("take", "release", "waiting", "activation") if self.has(part)]
            self.of.require(not left, f"{' and '.join(left)} is left")
            part = "answer" if self.runs else "available"
            self.of.require(
                self.has(part), f"no {part}, though its producer {'runs' if self.runs else 'stopped'}"
            )


# --- State machines that drive one template alone, in the most general environment of its contract --------

STEPS = 40
"""Steps of one series at most."""

_SHARED = replace(hw("h")[0], shared=True)
_HARDWARE = mission(robot(hw("h"), activity("a", ("h",), ())), objective("x", "a"))
_OF_TWO = mission(
    robot((_SHARED,), activity("a", ("h",), ()), activity("b", ("h",), ())),
    Parallel(
        name="both", blocks=(Objective(name="x", activities=("a",)), Objective(name="y", activities=("b",)))
    ),
)
_DRIVER = mission(
    robot(
        hw("h", "w", "v"), activity("p", ("h",), produces=("s",)), activity("a", ("s", "w"), ("w",), ("v",))
    ),
    objective("x", "a"),
)

MACHINES: Mapping[str, tuple[type[TemplateMachine], Mapping[str, object]]] = {
    "hardware": (HardwareMachine, {"mission": _HARDWARE, "element": ("hardware", "h")}),
    "shared hardware": (
        HardwareMachine,
        {"mission": _OF_TWO, "element": ("hardware", "h"), "owners": ("a", "b")},
    ),
    "software": (
        SoftwareMachine,
        {"mission": _DRIVER, "element": ("software", "s"), "producer": ("activity", "p")},
    ),
    "activity": (ActivityMachine, {"mission": _DRIVER, "element": ("activity", "a")}),
}
"""By template, the machine that drives it, and of which mission the template is."""


def machine_of(templates: TemplateSet | None, name: str) -> type[TemplateMachine]:
    """The class of machines that drive one template of a set, for a test of one's own.

    Args:
        templates: The set.
        name: One of :data:`MACHINES`.
    """
    base, known = MACHINES[name]
    return type(base.__name__, (base,), {**known, "templates": templates})


def driven(
    templates: TemplateSet | None, *, profile: str = "dev", only: str | None = None, shrink: bool = True
) -> Violation | None:
    """Drives each template of a set alone.

    Args:
        templates: The set.
        profile: One of :data:`mcpn.testing.kit.running.PROFILES`; how many series of steps are tried.
        only: One of :data:`MACHINES`; all of them by default.
        shrink: Whether a shortest series is looked for, once one is found.

    Returns:
        What the first template that breaks a promise does, after a short series of steps.
    """
    phases = [Phase.generate, Phase.shrink] if shrink else [Phase.generate]
    within = settings(PROFILES[profile], stateful_step_count=STEPS, phases=phases)
    for name in [only] if only else MACHINES:
        machine: Any = machine_of(templates, name)
        try:
            run_state_machine_as_test(machine, settings=within)
        except Violation as violation:
            return violation
    return None
