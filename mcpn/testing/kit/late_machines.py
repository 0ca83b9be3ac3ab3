"""What is lost at times that only others tell: while it runs, or before anybody knows."""

from __future__ import annotations

from typing import ClassVar

from hypothesis.stateful import invariant, precondition, rule

from mcpn.events import What
from mcpn.testing.kit.alone import CHOICE
from mcpn.testing.kit.resources import HardwareMachine


class CrashMachine(HardwareMachine):
    """What stands for the crash of an activity, which holds it while it runs: only then it may fail."""

    activity: ClassVar[tuple[str, str]]

    @property
    def runs(self) -> bool:
        """Whether the activity runs."""
        return self.has("active1", element=self.activity)

    def may_give_back(self) -> bool:
        """An activity that runs ends before it gives back."""
        return super().may_give_back() and not self.runs

    @precondition(lambda self: self.any_has("answer") and not self.runs and self.at_rest)
    @rule()
    def begins(self) -> None:
        """The activity, which has been answered, runs."""
        self.alone.move("runs", (), (self.at("active1", element=self.activity),))

    @precondition(lambda self: self.runs)
    @rule()
    def ends(self) -> None:
        """The activity no longer runs: it has been stopped, or takes note that it has crashed."""
        self.alone.move("runs no more", (self.at("active1", element=self.activity),), ())

    def expected(self) -> list[What]:
        """The events that are possible at rest."""
        if self.has("OOS"):
            return [What.REPAIRED]
        return [What.OUT_OF_SERVICE] if self.runs and self.any_has("answer") else []


class LateMachine(HardwareMachine):
    """Hardware whose loss is detected late: by an activity that looks, or as an objective fails.

    What is true is followed beside it: whether the hardware is gone, whether that is known, and whether it is
    suspected, since an objective that may use it has failed while it was gone and in use.
    """

    looking: ClassVar[tuple[str, str]]

    def __init__(self) -> None:
        super().__init__()
        self.gone = self.known = self.suspected = False

    @property
    def looks(self) -> bool:
        """Whether the activity runs that detects the loss."""
        return self.has("active1", element=self.looking)

    @precondition(lambda self: self.at_rest and self.alone.events)
    @rule(choice=CHOICE)
    def happens(self, choice: int) -> None:
        """An event of the template happens."""
        events = list(self.alone.events.items())
        event, transition = events[choice % len(events)]
        self.alone.fire(transition)
        self.gone = event.what is not What.REPAIRED
        self.known = event.what is What.DETECTED
        self.suspected = self.suspected and event.what is What.OUT_OF_SERVICE

    @precondition(lambda self: self.at_rest)
    @rule()
    def begins_or_ends_to_look(self) -> None:
        """The activity that detects the loss is started, or stopped."""
        place = (self.at("active1", element=self.looking),)
        said = "nobody looks" if self.looks else "somebody looks"
        self.alone.move(said, *((place, ()) if self.looks else ((), place)))

    @precondition(lambda self: self.at_rest and self.has("undoubted"))
    @rule()
    def an_objective_fails(self) -> None:
        """An objective that may use the hardware fails."""
        self.suspected |= self.gone and not self.known and self.any_has("answer")
        self.alone.move("an objective fails", (self.at("undoubted"),), (self.at("doubted"),))

    @precondition(lambda self: self.may_give_back())
    @rule(choice=CHOICE)
    def gives_back(self, choice: int) -> None:
        """A consumer gives back, and what was suspected is known."""
        self.known, self.suspected = self.known or self.suspected, False
        self.passes_on(choice, "answer", "release", "gives back")

    def expected(self) -> list[What]:
        """The events that are possible at rest."""
        if self.known:
            return [What.REPAIRED]
        if self.gone:
            return [What.DETECTED] if self.looks else []
        return [What.OUT_OF_SERVICE]

    @invariant()
    def it_says_what_is_true(self) -> None:
        """At rest no doubt is left, and it is available unless it is held, or known to be gone."""
        if self.at_rest:
            self.alone.require(not self.has("doubted") and self.has("undoubted"), "a doubt is left")
            self.alone.require(self.has("OOS") == self.known, f"its loss is known: {self.has('OOS')}")
            had = self.any_has("answer")
            self.alone.require(self.has("available") != (had or self.known), "it is available, and it is not")
            said = self.alone.says("oos", self.element[1])
            self.alone.require(said == self.gone, f"it is out of service: {said}")
