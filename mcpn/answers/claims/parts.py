"""Parts of formulas that kinds of claims share: safe ends, runs on which nothing fails, what helps."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import cached_property, reduce
from operator import or_
from typing import Generic

from mcpn.answers.causes.prospects import Goal, Prospects
from mcpn.answers.verdicts.nominal import meant_to_be_entered, nominal_transitions
from mcpn.events import HELPING, Event, What
from mcpn.spaces.algebra import S
from mcpn.spaces.memoized import memoized
from mcpn.spaces.run import Run, transitions_of

MOST_NAMED = 40
"""Events, or objectives, that one formula names; of more there is no formula."""


class FormulaParts(Generic[S]):
    """The parts of formulas on one mission; empty where no formula says them.

    Args:
        prospects: The mission in a space of its alternatives graph.
    """

    def __init__(self, prospects: Prospects[S]) -> None:
        self.prospects, self.net, self.space = prospects, prospects.mission_net, prospects.space

    def mean_one(self, names: Collection[str]) -> bool:
        """Whether each of a few names means one objective, and not all copies of one."""
        meant = self.net.graph.copies.meant
        return len(names) <= MOST_NAMED and all(meant(name) == [name] for name in names)

    @cached_property
    def helping(self) -> frozenset[int]:
        """Transitions of declared events, and of ends of times."""
        return frozenset(self.space.net.events.carrying(*HELPING))

    @cached_property
    def quiet(self) -> list[str]:
        """The events of these."""
        return self.events(self.helping)

    @cached_property
    def repairs(self) -> list[str]:
        """The events with which hardware comes back."""
        return self.events(self.prospects.everything - self.prospects.unrepaired)

    def events(self, transitions: Iterable[int]) -> list[str]:
        """The events of some transitions."""
        return sorted({str(self.space.net.event(t)) for t in transitions})

    @cached_property
    def sound(self) -> str:
        """That no hardware is out of service."""
        return " & ".join(f"!oos({name})" for name in self.prospects.hardware) or "true"

    @property
    def ends(self) -> str:
        """That the mission has ended."""
        return " | ".join(self.net.ends)

    def reaches(self, goal: Goal[S], left_out: Sequence[str] = ()) -> str:
        """That some run reaches a goal of the mission without some events."""
        steps = " & ".join(f"!happens({event})" for event in left_out) or "true"
        if goal is not self.prospects.safety:
            return f"E(({steps}) U success)"
        if not goal.ends_from:
            return f"E(({steps}) U (success | abort))"
        if not self.bad_ends:
            return ""
        return f"E(({steps}) U (success | ({steps} & !abort & !({self.bad_ends}) & X abort)))"

    @memoized
    def kept_reaching(self, goal: Goal[S], steps: frozenset[int]) -> S:
        """The same as :meth:`reaching`, kept for as long as the object: each loss asks for it again."""
        return self.reaching(goal, steps)

    def reaching(self, goal: Goal[S], steps: frozenset[int]) -> S:
        """States from which a run of some events reaches a goal of the mission."""
        if not goal.ends_from:
            return self.space.reaching(goal.won, transitions=steps)
        # Where some aborts are no safe ends, the others are events from the states in which they happen.
        well = {t: states for t, states in goal.ends_from.items() if t in steps}
        won = reduce(or_, well.values(), self.prospects.mission.won)
        guards = {t: self.space.everything - states for t, states in well.items()}
        return self.space.reaching(won, goal.running, steps, guards or None)

    @cached_property
    def bad_ends(self) -> str:
        """That what should make safe fails now."""
        aborts, said = self.prospects.aborts, dict[str, None]()
        if aborts is None or not self.mean_one(aborts.unsafe):
            return ""
        for name in aborts.unsafe:
            said |= dict.fromkeys(self.failures_of(name))
        return " | ".join(said)

    def failures_of(self, name: str) -> Iterator[str]:
        """That an objective fails now: by itself, or as the time of it or of a block around it is over."""
        for what in (What.FAILURE, What.TIMEOUT):
            for event in self.events(self.prospects.carrying(what, name)):
                yield f"happens({event})"
        for block in self.net.graph.timed_blocks():
            if name in block.held:
                late = Event(What.TIMEOUT, block.name)
                if late in self.space.net.events:
                    yield f"happens({late}) & objective({name})"

    def run_to(self, goal: S, transitions: Collection[int] | None = None) -> Run | None:
        """A short run from the start into some states, by some transitions alone."""
        edges = self.space.run(self.space.initial.pick(), goal, transitions=transitions)
        return None if edges is None else Run(self.space.net, transitions_of(edges), settles=True)

    def run_through(self, before: S, own: Collection[int], after: S) -> Run | None:
        """A short run to some states, and on by one of some events into others."""
        space, begin = self.space, self.space.initial.pick()
        edges = space.run(begin, before)
        if edges is None:
            return None
        last = space.run(edges[-1].target if edges else begin, after, transitions=own)
        return None if last is None else Run(space.net, transitions_of([*edges, *last]), settles=True)

    @cached_property
    def nominal_transitions(self) -> list[int]:
        """The transitions of runs on which nothing fails."""
        return nominal_transitions(self.net)

    @cached_property
    def nominal(self) -> list[str]:
        """The events of these; none where no formula names them."""
        events = {self.space.net.event(t) for t in self.nominal_transitions}
        named = [event for event in events if event is not None]
        ends = [event.element for event in named if event.what is not What.START]
        return sorted(map(str, named)) if self.mean_one(ends) else []

    @property
    def as_meant(self) -> str:
        """That something of these runs happens now."""
        return " | ".join(f"happens({event})" for event in self.nominal)

    def goes_well(self) -> tuple[str, str]:
        """That these runs succeed and enter what they are meant to, and that one goes on for ever."""
        copies, steps = self.net.graph.copies, self.as_meant
        optional, endless = copies.meant_as("optional"), sorted(copies.meant_as("endless"))
        wanted = [name for name in meant_to_be_entered(self.net) if name not in optional]
        named = [*wanted, *endless]
        out = any(h.initial == "oos" and h.repairable for h in self.net.core.hardware)
        if out or not steps or not self.mean_one(named):
            return "", ""
        going = " | ".join(f"event({event})" for event in self.nominal)
        circling = "".join(f" & !objective({name})" for name in endless)
        lasts = f"E(({steps}) U G(({steps})))"
        unmeant = f"E(({steps}) U G(({steps}){circling}))"
        entered = "".join(f" & E(({steps}) U objective({name}))" for name in wanted)
        return f"!E(({steps}) U (!success & !({going}))) & !{unmeant}{entered}", lasts if endless else "false"

    @cached_property
    def shelters(self) -> list[str]:
        """The objectives whose success aborts, or leads to abort and never to success while nothing fails."""
        if self.net.abort is None:
            return []
        space, nominal = self.space, self.nominal_transitions
        ended, won = (space.marked([end]) for end in (self.net.abort, self.net.success))
        to_abort, to_success = (space.reaching(end, transitions=nominal) for end in (ended, won))
        found = list[str]()
        for name in self.prospects.sections:
            own = self.prospects.carrying(What.SUCCESS, name)
            aborts = own and space.before(ended, own) - ended
            leads = own and space.before(to_abort, own) and not space.before(to_success, own)
            if aborts or leads:
                found.append(name)
        return found

    def shelters_by(self, name: str) -> str:
        """That an objective makes safe, as a formula."""
        steps, done = self.as_meant, f"happens({Event(What.SUCCESS, name)})"
        if not any(True for _ in self.prospects.carrying(What.SUCCESS, name)):
            return "false"
        return (
            f"(E(F ({done} & !abort & X abort)) | E(F ({done} & X E(({steps}) U abort)))"
            f" & !E(F ({done} & X E(({steps}) U success))))"
        )


def some(word: str, names: Collection[str]) -> str:
    """That a word is so of one of some names."""
    return " | ".join(f"{word}({name})" for name in names) or "false"
