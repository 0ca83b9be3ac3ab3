"""Runs a mission's text as its words say, without an objectives graph or a net: an oracle for both."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from mcpn.mission.model import (
    FAIL,
    SUCCEED,
    Block,
    Each,
    Handler,
    Mission,
    Objective,
    Parallel,
    Recursive,
    Use,
)

Written: TypeAlias = tuple[str, str, str]
"""A handler as it is written: the protocol, its block and its event; nothing for the mission's."""


@dataclass(frozen=True)
class Spent:
    """Handlers that happen once and have happened, as seen by the blocks of one text.

    Args:
        text: The protocol; nothing for the mission.
        before: Those that have happened by earlier events.
        now: Those that happen by this one: it is one moment for all branches.
    """

    text: str = ""
    before: set[Written] = field(default_factory=set)
    now: set[Written] = field(default_factory=set)

    def takes(self, block: str, handlers: tuple[Handler, ...], event: str) -> Handler | None:
        """The handler of a block, or of the mission, that the event finds."""
        for handler in handlers:
            written = self.text, block, event
            if handler.event == event and not (handler.once and written in self.before):
                self.now.add(written)
                return handler
        return None


class Series:
    """Sibling blocks of which one runs.

    Args:
        mission: The mission.
        blocks: The siblings.
        place: What stands before and after the names of the blocks.
        spent: Handlers that have happened.
        around: Handlers of the mission itself.
    """

    def __init__(
        self,
        mission: Mission,
        blocks: tuple[Block, ...],
        place: tuple[str, str],
        spent: Spent,
        around: tuple[Handler, ...] = (),
    ) -> None:
        self.mission, self.blocks, self.place, self.spent = mission, blocks, place, spent
        self.around = around
        self.at = 0
        self.current = Rounds(mission, blocks[0], place, spent)

    def running(self) -> Iterator[str]:
        yield from self.current.running()

    def end(self, name: str, well: bool) -> bool | None:
        return self.go_on(self.current.end(name, well))

    def go_on(self, outcome: bool | None) -> bool | None:
        if outcome is None:
            return None
        block = self.blocks[self.at]
        following = self.blocks[self.at + 1].name if self.at + 1 < len(self.blocks) else SUCCEED
        return self.go((block.success or following) if outcome else (block.failure or FAIL))

    def go(self, route: str) -> bool | None:
        if route in (SUCCEED, FAIL):
            return route == SUCCEED
        self.at = next(i for i, block in enumerate(self.blocks) if block.name == route)
        self.current = Rounds(self.mission, self.blocks[self.at], self.place, self.spent)
        return None

    def happens(self, name: str) -> tuple[bool, bool | None]:
        """Gives the mission an event: whether it is handled, and how the mission ends by it."""
        found = self.event(name)
        self.spent.before.update(self.spent.now)
        self.spent.now.clear()
        return found

    def event(self, name: str) -> tuple[bool, bool | None]:
        """Whether the event is handled, and how the series ends by it."""
        handled, outcome = self.current.event(name)
        if handled:
            return True, self.go_on(outcome)
        block = self.blocks[self.at]
        for owner, handlers in ((block.name, block.handlers), ("", self.around)):
            handler = self.spent.takes(owner, handlers, name)
            if handler is not None:
                return True, self.go(handler.goto or "")  # none pauses in what this plays
        return False, None


class Rounds:
    """A block with its rounds and tries."""

    def __init__(self, mission: Mission, block: Block, place: tuple[str, str], spent: Spent) -> None:
        self.mission, self.block, self.place, self.spent = mission, block, place, spent
        self.round = self.attempt = 1
        self.current = self.begin()

    def begin(self) -> Once:
        before, after = self.place
        if self.block.repeat is not None:
            after += f"_{self.round}"
        if self.block.retries:
            after += f"_try{self.attempt}"
        return Once(self.mission, self.block, (before, after), self.spent)

    def running(self) -> Iterator[str]:
        yield from self.current.running()

    def end(self, name: str, well: bool) -> bool | None:
        return self.go_on(self.current.end(name, well))

    def go_on(self, outcome: bool | None) -> bool | None:
        if outcome is False and self.attempt <= self.block.retries:
            self.attempt += 1
        elif outcome and self.round < (self.block.repeat or 1):
            self.round, self.attempt = self.round + 1, 1
        else:
            return outcome
        self.current = self.begin()
        return None

    def event(self, name: str) -> tuple[bool, bool | None]:
        handled, outcome = self.current.event(name)
        return handled, self.go_on(outcome)


class Once:
    """A block done once."""

    def __init__(self, mission: Mission, block: Block, place: tuple[str, str], spent: Spent) -> None:
        self.mission, self.block, self.spent = mission, block, spent
        self.name = place[0] + block.name + place[1]
        self.inside = f"{self.name}." if place[1] else place[0]
        self.value = 0
        self.series = self.begin()
        self.branches: list[tuple[Block, Rounds]] = []
        self.outcomes: dict[str, bool] = {}
        if isinstance(block, Parallel):
            self.branches = [(b, Rounds(mission, b, (self.inside, ""), spent)) for b in block.blocks]

    def begin(self) -> Series | None:
        block, mission = self.block, self.mission
        if isinstance(block, Use):
            (protocol,) = [p for p in mission.protocols if p.name == block.protocol]
            spent = replace(self.spent, text=protocol.name)
            return Series(mission, protocol.blocks, (f"{self.name}.", ""), spent)
        if isinstance(block, Recursive):
            return Series(mission, block.blocks, (self.inside, ""), self.spent)
        if isinstance(block, Each):
            place = (self.inside, f"_{block.values[self.value]}")
            return Series(mission, block.blocks, place, self.spent)
        return None

    def running(self) -> Iterator[str]:
        if isinstance(self.block, Objective):
            yield self.name
        if self.series:
            yield from self.series.running()
        for block, branch in self.branches:
            if block.name not in self.outcomes:
                yield from branch.running()

    def end(self, name: str, well: bool) -> bool | None:
        if self.series:
            return self.go_on(self.series.end(name, well))
        for block, branch in self.branches:
            if block.name not in self.outcomes and name in branch.running():
                self.note(block, branch.end(name, well))
                return self.outcome()
        return well

    def go_on(self, outcome: bool | None) -> bool | None:
        if outcome and isinstance(self.block, Each) and self.value + 1 < len(self.block.values):
            self.value += 1
            self.series = self.begin()
            return None
        return outcome

    def note(self, block: Block, outcome: bool | None) -> None:
        if outcome is not None:
            self.outcomes[block.name] = outcome

    def outcome(self) -> bool | None:
        if len(self.outcomes) < len(self.branches):
            return None
        return all(self.outcomes[block.name] for block, _ in self.branches if block.mandatory)

    def event(self, name: str) -> tuple[bool, bool | None]:
        if self.series:
            handled, outcome = self.series.event(name)
            return handled, self.go_on(outcome)
        found = False
        for block, branch in self.branches:
            if block.name in self.outcomes:
                continue
            handled, outcome = branch.event(name)
            own = None if handled else self.spent.takes(block.name, block.handlers, name)
            if own is not None:
                handled, outcome = True, own.goto == SUCCEED
            if handled:
                found = True
                self.note(block, outcome)
        return found, self.outcome() if self.branches else None
