"""What each kind of claim means, told by the interpreter's states one by one: no net, no formula."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable

from mcpn.mission.model import Mission
from mcpn.testing.judge.interpreter import (
    ABORTED,
    DECLARED,
    DETECTED,
    FAILURE,
    OUT_OF_SERVICE,
    REPAIRED,
    SUCCESS,
    TIMEOUT,
    Happening,
    Interpreter,
    State,
)
from mcpn.testing.judge.robot import Acting
from tests.judge.asked import Runs
from tests.judge.test_ignored import around, led_to

HARDWARE = (OUT_OF_SERVICE, REPAIRED, DETECTED)


class Judged:
    """All states of a mission, and what claims say of them.

    Args:
        mission: A valid mission.
        most: Most states that are played.
        hardware: All that may be out of service, and is not in a state that claims call sound.
        meant: The copies of an objective that a name means, which ``test_names.py`` judges.
    """

    def __init__(
        self,
        mission: Mission,
        most: int,
        hardware: Collection[str],
        meant: Callable[[str], Iterable[str]],
    ) -> None:
        self.mission, self.runs, self.hardware = mission, Runs(mission, most), hardware
        self.leads = self.runs.leads
        self.meant = meant
        self.events = [e.name for e in mission.events if not e.sets]
        self.interpreter = interpreter = Interpreter(mission)
        leads = {event: led_to(interpreter, event) for event in self.events}
        self.led = {
            event: {
                name
                for name, leaf in interpreter.objectives.items()
                if not blocks.isdisjoint(node.written for node in around(leaf))
            }
            for event, blocks in leads.items()
        }
        self._from: dict[object, set[State]] = {}
        self._sound = {state for state in self.leads if state.out.isdisjoint(hardware)}

    def of(self, name: str) -> frozenset[str]:
        """The copies of an objective that a name means."""
        return frozenset(self.meant(name))

    def runs_in(self, name: str, state: State) -> bool:
        """Whether an objective runs in a state, in some copy."""
        return not state.running.isdisjoint(self.of(name))

    # --- what may still be reached ---

    def reaching(self, ends: Iterable[str], without: Iterable[Happening] = ()) -> set[State]:
        """States from which the mission may end so, though some events never happen."""
        left_out, wanted = frozenset(without), frozenset(ends)
        key = wanted, left_out
        if key not in self._from:
            before: dict[State, list[State]] = {}
            for state, ways in self.leads.items():
                for event, after in ways:
                    if event is not None and event not in left_out:
                        before.setdefault(after, []).append(state)
            found = {state for state in self.leads if state.outcome in wanted}
            stack = [*found]
            while stack:
                new = {*before.get(stack.pop(), ())} - found
                found |= new
                stack += new
            self._from[key] = found
        return self._from[key]

    def helping(self) -> set[Happening]:
        """Declared events and ends of times."""
        events = (event for ways in self.leads.values() for event, _ in ways if event is not None)
        return {event for event in events if event[0] in (DECLARED, TIMEOUT)}

    def taking(self, event: Happening) -> list[tuple[State, State]]:
        """The steps that an event makes."""
        return [(s, after) for s, ways in self.leads.items() for what, after in ways if what == event]

    def possible(self, event: Happening, state: State) -> bool:
        """Whether an event may happen in a state."""
        return any(what == event for what, _ in self.leads[state])

    # --- kinds ---

    def can_end(self, *ends: str) -> bool:
        """Whether the mission may end so."""
        return self.runs.begin in self.reaching(ends)

    def always(self, *ends: str) -> bool:
        """Whether it may end so from whatever state."""
        return self.reaching(ends) >= self.leads.keys()

    def goes_on(self) -> bool:
        """Whether some event may happen until it ends."""
        return all(s.outcome or any(e is not None for e, _ in ways) for s, ways in self.leads.items())

    def without(self, name: str) -> bool:
        """Whether it may succeed without the success of an objective."""
        return self.runs.begin in self.reaching([SUCCESS], ((SUCCESS, copy) for copy in self.of(name)))

    def loss(self, ends: Collection[str], hardware: str, aided: bool) -> bool:
        """Whether a loss for good may take the last way to an end, with nothing else lost."""
        away = set() if aided else self.helping()
        before, later = self.reaching(ends, away), self.reaching(ends, {*away, (REPAIRED, hardware)})
        lost = self.taking((OUT_OF_SERVICE, hardware))
        return any(s in self._sound and s in before and after not in later for s, after in lost)

    def failure(self, ends: Collection[str], hardware: str, name: str) -> bool:
        """Whether a failure during an objective may take all ways to an end, repairs among them."""
        before = self.reaching(ends)
        lost = self.taking((OUT_OF_SERVICE, hardware))
        return any(
            s in self._sound and self.runs_in(name, s) and s in before and after not in before
            for s, after in lost
        )

    def handled(self, event: str) -> bool:
        """Whether it may happen whatever runs."""
        return all(self.possible((DECLARED, event), s) for s in self.leads if s.running)

    def idle(self, event: str, name: str, *, led: bool) -> bool:
        """Whether it changes nothing in a state in which an objective runs; where it led there, or not."""
        inside = set() if led else self.led[event]
        return any(
            self.runs_in(name, s) and not self.possible((DECLARED, event), s) and s.running.isdisjoint(inside)
            for s in self.leads
        )

    def interrupts(self, event: str, name: str) -> bool:
        """Whether it ends all copies of an objective that run."""
        steps = self.taking((DECLARED, event))
        return any(self.runs_in(name, s) and not self.runs_in(name, after) for s, after in steps)

    def ends(self, event: str, end: str) -> bool:
        """Whether it ends the mission so."""
        return any(after.outcome == end != s.outcome for s, after in self.taking((DECLARED, event)))

    def goes_round(self) -> bool:
        """Whether a loop has nothing but declared events that interrupt."""
        own = {(DECLARED, event) for event in self.events}
        left = {s: {after for event, after in ways if event in own} for s, ways in self.leads.items()}
        while ended := {s for s, after in left.items() if not after & left.keys()}:
            for state in ended:
                del left[state]
        return bool(left)

    def decides(self, *events: Happening) -> bool:
        """Whether one of some events may lead from a way to success to none."""
        hopeful = self.reaching([SUCCESS])
        return any(s in hopeful and after not in hopeful for e in events for s, after in self.taking(e))

    def defeats(self, fact: str, value: str) -> bool:
        """Whether a value of a fact, which it may have, takes all ways to success, where there are some."""
        there = {s for s in self.leads if (fact, value) in s.facts and s.outcome != SUCCESS}
        hopeful = self.reaching([SUCCESS])
        return bool(there) and self.runs.begin in hopeful and there.isdisjoint(hopeful)

    def selected(self, activity: str, way: str) -> bool:
        """Whether an activity ever runs in an alternative."""
        ways = self.interpreter.robot.activities[activity].alternatives
        return any(
            name == activity and doing is Acting.RUNS and ways[rank].name == way
            for state in self.leads
            for name, (doing, rank) in state.activities
        )

    def used(self, hardware: str) -> bool:
        """Whether an alternative that consumes it ever runs."""
        activities = self.interpreter.robot.activities
        return any(
            doing is Acting.RUNS and hardware in activities[name].alternatives[rank].consumes
            for state in self.leads
            for name, (doing, rank) in state.activities
        )

    def waits(self) -> bool:
        """Whether nothing but hardware may go on before it ends."""
        return any(
            not s.outcome and all(e is None or e[0] in HARDWARE for e, _ in ways)
            for s, ways in self.leads.items()
        )

    def says(self, kind: str, subject: tuple[str, ...], aided: bool) -> bool | None:
        """Whether a claim holds; ``None`` of a kind that is judged elsewhere."""
        safe, every = (SUCCESS, ABORTED), (SUCCESS, FAILURE, ABORTED)
        kinds: dict[str, Callable[[], bool]] = {
            "can_succeed": lambda: self.can_end(SUCCESS),
            "can_fail": lambda: self.can_end(FAILURE),
            "can_be_aborted": lambda: self.can_end(ABORTED),
            "can_always_end": lambda: self.always(*every),
            "can_always_end_safely": lambda: self.always(*safe),
            "can_always_go_on": self.goes_on,
            "succeeds_without": lambda: self.without(*subject),
            "loss_defeats": lambda: self.loss([SUCCESS], subject[0], aided),
            "loss_endangers": lambda: self.loss(safe, subject[0], aided),
            "failure_loses_mission": lambda: self.failure([SUCCESS], *subject),
            "failure_loses_robot": lambda: self.failure(safe, *subject),
            "handled_always": lambda: self.handled(*subject),
            "ignored": lambda: self.idle(subject[0], subject[1], led=False),
            "answered_already": lambda: self.idle(subject[0], subject[1], led=True),
            "interrupts_answer": lambda: self.interrupts(*subject[:2]),
            "ends_at_once": lambda: self.ends(subject[0], subject[1]),
            "alternate_for_ever": self.goes_round,
            "event_decides": lambda: self.decides((DECLARED, subject[0])),
            "end_decides": lambda: self.decides(*((subject[1], copy) for copy in self.of(subject[0]))),
            "outcome_comes": lambda: self.runs.happens([(subject[1], copy) for copy in self.of(subject[0])]),
            "fact_defeats": lambda: self.defeats(*subject),
            "used": lambda: self.used(*subject),
            "selected": lambda: self.selected(*subject),
            "waits_for_hardware": self.waits,
        }
        return kinds[kind]() if kind in kinds else None
