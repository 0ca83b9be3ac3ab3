"""What a mission satisfies, told by the interpreter's states one by one: no net, no formula, no name."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass

from mcpn.mission.model import Mission
from mcpn.testing.judge.interpreter import FAILURE, SUCCESS, Happening, Interpreter, State

Which = Callable[[State], bool]


@dataclass(frozen=True)
class Claim:
    """A requirement, and whether the interpreter finds it so.

    Args:
        formula: What is asked, as people write it.
        so: Whether it holds.
    """

    formula: str
    so: bool


class Runs:
    """All runs of a mission; at an end its last state repeats.

    Args:
        mission: A valid mission.
        most: Most states that are played.

    Raises:
        OverflowError: It has more.
        Undetermined: Two activities ask for one thing at the same moment.
    """

    def __init__(self, mission: Mission, most: int) -> None:
        judge = Interpreter(mission)
        self.begin = judge.initial
        self.leads: dict[State, list[tuple[Happening | None, State]]] = {}
        stack = [self.begin]
        while stack:
            if (state := stack.pop()) in self.leads:
                continue
            events = judge.possible(state)
            self.leads[state] = [(event, judge.after(state, event)) for event in events] or [(None, state)]
            stack += [after for _, after in self.leads[state]]
            if len(self.leads) > most:
                raise OverflowError

    def never(self, which: Which) -> bool:
        """No state of any run is one of these."""
        return not any(map(which, self.leads))

    def avoiding(self, which: Which) -> set[State]:
        """States from which some run meets none of these, ever."""
        found = {state for state in self.leads if not which(state)}
        while lost := {s for s in found if not any(after in found for _, after in self.leads[s])}:
            found -= lost
        return found

    def at_last(self, which: Which) -> bool:
        """Every run meets one of these."""
        return self.begin not in self.avoiding(which)

    def entries(self, which: Which, most: int) -> bool:
        """No run enters these more often."""
        begin = self.begin, int(which(self.begin))
        seen, stack = {begin}, [begin]
        while stack:
            state, count = stack.pop()
            if count > most:
                return False
            for _, after in self.leads[state]:
                entered = which(after) and not which(state)
                if (at := (after, count + entered)) not in seen:
                    seen.add(at)
                    stack.append(at)
        return True

    def before(self, which: Which, first: Which) -> bool:
        """No run meets one of these before it has met one of the others, or at that moment."""
        seen, stack = {self.begin}, [self.begin]
        while stack:
            state = stack.pop()
            if first(state):
                continue
            if which(state):
                return False
            new = {after for _, after in self.leads[state]} - seen
            seen |= new
            stack += new
        return True

    def answered(self, which: Which, by: Which) -> bool:
        """Whatever run meets one of these then or later meets one of the others."""
        unanswered = self.avoiding(by)
        return not any(which(state) and state in unanswered for state in self.leads)

    def next(self, which: Which, then: Which) -> bool:
        """After each of these comes one of the others."""
        return all(then(after) for s, ways in self.leads.items() if which(s) for _, after in ways)

    def leads_on(self, which: Which, to: Which) -> bool:
        """Some run meets one of these, then or later one of the others."""
        stack = [state for state in self.leads if which(state)]
        seen = {*stack}
        while stack:
            if to(state := stack.pop()):
                return True
            new = {after for _, after in self.leads[state]} - seen
            seen |= new
            stack += new
        return False

    def happens(self, events: Collection[Happening]) -> bool:
        """Some run takes one of these events."""
        return any(event in events for ways in self.leads.values() for event, _ in ways)


def claims(runs: Runs, x: str, copies: frozenset[str], y: str, others: frozenset[str]) -> Iterator[Claim]:
    """What is claimed of two objectives, each called by one name that means its copies."""

    def one(state: State) -> bool:
        return not state.running.isdisjoint(copies)

    def other(state: State) -> bool:
        return not state.running.isdisjoint(others)

    said, also = f"objective({x})", f"objective({y})"
    yield Claim(f"G !{said}", runs.never(one))
    yield Claim(
        f"G !(pending({x}) | {said})", runs.never(lambda s: one(s) or not s.pending.isdisjoint(copies))
    )
    yield Claim(f"EF ({said} & EF {also})", runs.leads_on(one, other))
    yield Claim(f"F {said}", runs.at_last(one))
    yield Claim(f"!F ({said} & F (!{said} & F {said}))", runs.entries(one, 1))
    twice = f"{said} & F (!{said} & F ({said} & F (!{said} & F {said})))"
    yield Claim(f"!F ({twice})", runs.entries(one, 2))
    yield Claim(f"!{also} W {said}", runs.before(other, one))
    yield Claim(f"G ({said} -> F {also})", runs.answered(one, other))
    yield Claim(f"G ({said} -> X !{also})", runs.next(one, lambda s: not other(s)))
    for what, word in ((SUCCESS, "OK"), (FAILURE, "FAIL")):
        yield Claim(f"G !happens(OBJ_{x}_EV_{word})", not runs.happens({(what, each) for each in copies}))
