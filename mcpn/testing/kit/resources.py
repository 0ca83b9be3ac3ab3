"""Machines that drive a resource alone, hardware or software, and play its consumers and its producer."""

from __future__ import annotations

from typing import ClassVar

from hypothesis import strategies as st
from hypothesis.stateful import invariant, precondition, rule

from mcpn.events import What
from mcpn.testing.kit.alone import CHOICE, TemplateMachine, told
from mcpn.testing.kit.contract import states_of


class ResourceMachine(TemplateMachine):
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
        self.alone.move(said, (self.at(before, owner),), (self.at(after, owner),))

    def owed(self) -> bool:
        """Whether others must act before an event may happen."""
        return self.any_has("error")

    def one(self, said: int, message: str) -> None:
        """Sees that one place of several is marked, or none while the template goes from one to another."""
        self.alone.require(said == 1 or (said == 0 and bool(self.alone.internal)), message)

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


class HardwareMachine(ResourceMachine):
    """Hardware between its consumers; nobody asks while it fails."""

    def may_ask(self) -> bool:
        """Whether a consumer may ask now."""
        return self.any_has("available") and not self.between and not self.any_has("error")

    @property
    def between(self) -> bool:
        """Whether it is on its way from one state to another."""
        return any(map(self.has, states_of(self.templates)["between"]))

    @invariant()
    def it_is_in_one_state(self) -> None:
        """One of free, busy, failing, out of service."""
        said = sum(self.has(part) for parts in states_of(self.templates).values() for part in parts)
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
            self.alone.require(not self.any_has("take"), "a request is not answered")
            self.alone.require(not self.any_has("release"), "a release is not answered")
            self.alone.require(not self.between, "it fails for ever")
            out = sorted(event.what.name for event in self.alone.events)
            expected = [what.name for what in self.expected()]
            self.alone.require(out == expected, f"{told(out)} may happen, expected {told(expected)}")

    def expected(self) -> list[What]:
        """The events that are possible at rest."""
        return [What.REPAIRED if self.has("OOS") else What.OUT_OF_SERVICE]


class SoftwareMachine(ResourceMachine):
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
        return super().may_give_back() and not self.asked and not self.alone.internal

    @precondition(lambda self: self.asked and not self.has("activation"))
    @rule(runs=st.booleans())
    def producer_decides(self, runs: bool) -> None:
        """The producer, which has been started or evaluates again, runs or refuses."""
        self.runs = runs
        said, part = ("it runs", "activation") if runs else ("it refuses", "deactivation")
        self.alone.move(said, (self.at("StartByRes", element=self.producer),), (self.at(part),))

    @precondition(lambda self: self.runs and self.at_rest)
    @rule()
    def producer_evaluates(self) -> None:
        """The producer has lost something and evaluates again."""
        self.alone.move("it evaluates again", (), (self.at("StartByRes", element=self.producer),))

    @precondition(lambda self: self.runs and self.has("free") and not self.asked)
    @rule()
    def producer_stops(self) -> None:
        """Nobody holds the product: the producer stops."""
        self.runs = False
        self.alone.move("it stops", (), (self.at("deactivation"),))

    @invariant()
    def its_interface_is_in_one_state(self) -> None:
        """One token of the interface, or it waits, or is free."""
        parts = ("available", "take", "answer", "release", "error", "waiting", "free")
        said = sum(map(self.has, parts))
        self.one(said, f"the interface of {self.element[1]} holds {said} tokens")

    @invariant()
    def it_answers(self) -> None:
        """At rest nothing is on its way; it is held if its producer runs, and available otherwise."""
        if self.at_rest:
            left = [part for part in ("take", "release", "waiting", "activation") if self.has(part)]
            self.alone.require(not left, f"{' and '.join(left)} is left")
            part = "answer" if self.runs else "available"
            self.alone.require(
                self.has(part), f"no {part}, though its producer {'runs' if self.runs else 'stopped'}"
            )
