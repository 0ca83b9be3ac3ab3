"""A machine that drives an activity alone, and plays the objective that starts it and its resources."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.stateful import invariant, precondition, rule

from mcpn.testing.kit.alone import CHOICE, TemplateMachine


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
        (self.drawn,) = (a for a in self.alone.usage.core.activities if a.name == self.element[1])
        self.consumed = list(dict.fromkeys(k for way in self.drawn.alternatives for k in way.consumes))

    def resource(self, k: str) -> tuple[str, str]:
        """Kind and name of a resource."""
        return ("hardware" if k in self.alone.usage.hardware else "software"), k

    def with_token(self, part: str) -> list[str]:
        """Resources of which a place is marked."""
        return [k for k in self.consumed if self.has(part, element=self.resource(k))]

    def passes_on(self, k: str, before: str, after: str, said: str) -> None:
        """A resource takes a token of its interface and puts another."""
        places = (self.at(part, element=self.resource(k)) for part in (before, after))
        taken, put = places
        self.alone.move(f"{k} {said}", (taken,), (put,))

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return bool(self.with_token("take") or self.with_token("release"))

    def something_happens(self) -> None:
        """From here on a reaction is looked at."""
        self.impossible.clear()
        self.begun = len(self.alone.run)
        self.was_refused = self.has("error")

    @precondition(lambda self: not self.started and self.at_rest)
    @rule()
    def starts(self) -> None:
        """An objective starts it."""
        self.something_happens()
        self.started = True
        self.alone.move("starts", (), (self.at("Start"),))

    @precondition(lambda self: self.started and self.at_rest)
    @rule()
    def stops(self) -> None:
        """An objective stops it."""
        self.something_happens()
        self.started = False
        self.alone.move("stops", (), (self.at("Stop"),))

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
            self.alone.require(
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
        self.alone.require(
            said == self.started, f"it runs or is refused in {said} ways, started: {self.started}"
        )
        held = {k for i in running for k in self.drawn.alternatives[i].consumes}
        self.alone.require({*self.with_token("answer")} == held, "it does not hold what it runs with")
        left = [part for part in ("Start", "Stop", "running") if self.has(part) and not running]
        self.alone.require(not left, f"{' and '.join(left)} is left")
        self.alone.require(not self.with_token("error"), "it does not take note of an error")
        selected = [name for name in self.alone.run[self.begun :] if "_sel" in name]
        refused = self.has("error") and not self.was_refused
        if (running and selected) or refused:
            out = self.impossible | {*self.with_token("OOS")}
            passed = self.drawn.alternatives[: None if refused else running[0]]
            missed = [way.name for way in passed if not out & {*way.consumes}]
            does = "is refused and passes" if refused else "passes"
            self.alone.require(not missed, f"it {does} over {' and '.join(missed)}, which was possible")
