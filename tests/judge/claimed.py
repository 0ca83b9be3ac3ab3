"""What each kind of claim means, told by the interpreter's states one by one: no net, no formula."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from functools import cached_property

from mcpn.mission.model import Mission
from mcpn.testing.judge.interpreter import (
    ABORTED,
    DECLARED,
    DETECTED,
    FAILURE,
    OUT_OF_SERVICE,
    REPAIRED,
    START,
    SUCCESS,
    TIMEOUT,
    Happening,
    Interpreter,
    State,
)
from mcpn.testing.judge.robot import Acting
from tests.judge.asked import Runs
from tests.judge.losses import Played
from tests.judge.nominal import played
from tests.judge.test_ignored import around, led_to
from tests.judge.test_unsafe_abort import by_word_alone, failing

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
        self.blocks = {node.name: node for leaf in interpreter.objectives.values() for node in around(leaf)}
        self._from: dict[object, set[State]] = {}
        self._sound = {state for state in self.leads if state.out.isdisjoint(hardware)}

    def of(self, name: str) -> frozenset[str]:
        """The copies of an objective that a name means."""
        return frozenset(self.meant(name))

    def runs_in(self, name: str, state: State) -> bool:
        """Whether an objective runs in a state, in some copy."""
        return not state.running.isdisjoint(self.of(name))

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

    def happenings(self, name: str, word: str) -> list[Happening]:
        """The events that a claim calls by what they are to a thing: of hardware, or of all copies."""
        of_hardware = {"loss": OUT_OF_SERVICE, "detected loss": DETECTED}
        if word in of_hardware:
            return [(of_hardware[word], name)]
        end, _, reason = word.partition(" for ")
        what = f"{end} {reason}" if reason else end
        named = self.of(name) or {copy for copy in self.interpreter.timed if self.as_written(copy) == name}
        return [(START, "") if end == "start" else (what, copy) for copy in named or {name}]

    def as_written(self, copy: str) -> str:
        """What a block is called of which another is a copy, or lies in one."""
        parts = copy.split(".")
        whole = [".".join(parts[: n + 1]) for n in range(len(parts))]
        known = (self.blocks.get(name) for name in whole)
        return ".".join(node.written if node else part for node, part in zip(known, parts, strict=True))

    def taking(self, event: Happening) -> list[tuple[State, State]]:
        """The steps that an event makes."""
        return [(s, after) for s, ways in self.leads.items() for what, after in ways if what == event]

    def possible(self, event: Happening, state: State) -> bool:
        """Whether an event may happen in a state."""
        return any(what == event for what, _ in self.leads[state])

    def reaching_safely(self, without: Iterable[Happening] = ()) -> set[State]:
        """The same of safe ends: success, and an abort but by the failure of what should make safe."""
        left_out = frozenset(without)
        found = {state for state in self.leads if state.outcome == SUCCESS}
        last = {
            s
            for s, ways in self.leads.items()
            for event, after in ways
            if after.outcome == ABORTED != s.outcome
            and event is not None
            and event not in left_out
            and not self.fails_badly(s, event)
        }
        return found | self.onto(last, left_out)

    def onto(self, goal: set[State], left_out: frozenset[Happening]) -> set[State]:
        """States of a goal, of success, and those from which runs lead there."""
        found, more = {s for s in self.leads if s.outcome == SUCCESS} | goal, True
        while more:
            new = {
                s
                for s, ways in self.leads.items()
                if s not in found and not s.outcome
                if any(e is not None and e not in left_out and after in found for e, after in ways)
            }
            found, more = found | new, bool(new)
        return found

    @cached_property
    def unsafe(self) -> set[str]:
        """The objectives that should make safe, and by whose failure it aborts."""
        return by_word_alone(self.mission) or set()

    def fails_badly(self, state: State, event: Happening) -> bool:
        """Whether what should make safe fails by an event."""
        fails = event[0].startswith(FAILURE) or event[0] == TIMEOUT
        return fails and not self.unsafe.isdisjoint(failing(self.interpreter, state, event[1]))

    def safely(self, ends: Collection[str], without: Iterable[Happening] = ()) -> set[State]:
        """States from which it may end so; of safe ends, but by the failure of what should make safe."""
        return self.reaching_safely(without) if ABORTED in ends else self.reaching(ends, without)

    def well(self, states: set[State], among: set[State]) -> set[State]:
        """Where runs lead on which nothing fails, from some states through some."""
        seen, stack = {*states}, [*states]
        while stack:
            ways = self.leads[stack.pop()]
            new = {after for event, after in ways if event is not None and event[0] in (START, SUCCESS)}
            new = (new & among) - seen
            seen |= new
            stack += new
        return seen

    def needs_help(self, ends: Collection[str]) -> bool:
        """Whether some state leads to an end only with help."""
        return bool(self.safely(ends) - self.safely(ends, self.helping()))

    def starts_with_help(self) -> bool:
        """Whether it succeeds, and never without help."""
        begin = self.runs.begin
        return begin in self.reaching([SUCCESS]) - self.reaching([SUCCESS], self.helping())

    def shelters(self) -> set[str]:
        """The objectives by whose success it aborts, or that lead there and never to success."""
        every, found = {*self.leads}, set[str]()
        for name in self.interpreter.objectives:
            after = [(s, then) for s, then in self.taking((SUCCESS, name))]
            ends = {then.outcome for then in self.well({then for _, then in after}, every)}
            if any(then.outcome == ABORTED for _, then in after) or (ABORTED in ends and SUCCESS not in ends):
                found.add(name)
        return found

    def past(self, event: str) -> bool:
        """Whether it leads to abort with nothing that makes safe, while nothing fails."""
        shelters = self.shelters()
        outside = {s for s in self.leads if s.running.isdisjoint(shelters)}
        led = {after for s, after in self.taking((DECLARED, event)) if s in outside and not s.outcome}
        return any(s.outcome == ABORTED for s in self.well(led & outside, outside))

    def always_decides(self, *events: Happening) -> bool:
        """Whether each of some events, where success is possible, takes all ways to it."""
        hopeful = self.reaching([SUCCESS])
        after = [then for event in events for s, then in self.taking(event) if s in hopeful]
        return bool(after) and hopeful.isdisjoint(after)

    def leaves_repair(self, *events: Happening) -> bool:
        """Whether one of some events may leave only ways on which something is repaired."""
        repairs = {e for ways in self.leads.values() for e, _ in ways if e is not None and e[0] == REPAIRED}
        hopeful, before = self.reaching([SUCCESS]), self.reaching([SUCCESS], repairs)
        steps = (step for event in events for step in self.taking(event))
        return any(s in before and after in hopeful - before for s, after in steps)

    def unrepaired(self, ends: Collection[str]) -> bool:
        """Whether it ends so only if something is repaired, if at all."""
        repairs = {e for ways in self.leads.values() for e, _ in ways if e is not None and e[0] == REPAIRED}
        return self.runs.begin not in self.safely(ends, repairs)

    def always_lost(self, ends: Collection[str], hardware: str) -> bool:
        """Whether a loss for good takes all ways to an end, whenever it comes."""
        out = {hardware, *(f.name for f in self.mission.faults if hardware in f.affects)}
        lost = {s for s in self.leads if s.begun and not s.out.isdisjoint(out) and s.outcome not in ends}
        return bool(lost) and lost.isdisjoint(self.safely(ends, [(REPAIRED, hardware)]))

    def leaves(self, hardware: str, end: str) -> bool:
        """Whether a loss for good that takes the last way to success always leaves one to an end."""
        repair = [(REPAIRED, hardware)]
        hopeful, later = self.reaching([SUCCESS]), self.reaching([SUCCESS], repair)
        possible = self.reaching([{"abort": ABORTED, "failure": FAILURE}[end]], repair)
        lost = self.taking((OUT_OF_SERVICE, hardware))
        return all(
            after in possible for s, after in lost if s in self._sound and s in hopeful and after not in later
        )

    def runs_with(self, name: str, ways: str) -> bool:
        """Whether an objective runs while its activities run in some alternatives."""
        wanted = {tuple(each.split(" by ")) for each in ways.split(" and ")}
        activities = self.interpreter.robot.activities

        def doing(state: State) -> set[tuple[str, ...]]:
            each = state.activities
            return {(a, activities[a].alternatives[n].name) for a, (how, n) in each if how is Acting.RUNS}

        return any(self.runs_in(name, s) and wanted <= doing(s) for s in self.leads)

    def unnoticed(self, hardware: str, name: str, *, alone: bool) -> bool:
        """Whether a loss takes the success of what runs, while nothing can find it out."""
        (copy,) = self.of(name)
        running = {s for s in self.leads if copy in s.running}
        hopeful = {s for s in running if self.possible((SUCCESS, copy), s)}
        while new := {
            s
            for s in running - hopeful
            if any(e is not None and e[0] != REPAIRED and after in hopeful for e, after in self.leads[s])
        }:
            hopeful |= new
        own, among = (OUT_OF_SERVICE, hardware), running & hopeful
        if alone:
            seen, stack = {self.runs.begin}, [self.runs.begin]
            while stack:
                ways = self.leads[stack.pop()]
                fit = (after for e, after in ways if e is None or e == own or e[0] != OUT_OF_SERVICE)
                new = {*fit} - seen
                seen |= new
                stack += new
            among = among & seen & self._sound
        steps = ((s, after) for s, after in self.taking(own) if s in among)
        found = (DETECTED, hardware)
        return any(
            after in running and after not in hopeful and not self.possible(found, after)
            for _, after in steps
        )

    def all_handled(self) -> bool:
        """Whether no event that must be handled is ignored."""
        required = [event.name for event in self.mission.events if event.required]
        names = self.interpreter.objectives
        return not any(self.idle(event, name, led=False) for event in required for name in names)

    def can_end(self, *ends: str) -> bool:
        """Whether the mission may end so."""
        return self.runs.begin in self.reaching(ends)

    def always(self, *ends: str) -> bool:
        """Whether it may end so from whatever state."""
        ended = (
            {s for s in self.leads if s.outcome == ABORTED} if ABORTED in ends and FAILURE not in ends else {}
        )
        reached = self.reaching(ends) if FAILURE in ends else self.safely(ends)
        return reached | {*ended} >= self.leads.keys()

    def goes_on(self) -> bool:
        """Whether some event may happen until it ends."""
        return all(s.outcome or any(e is not None for e, _ in ways) for s, ways in self.leads.items())

    def without(self, name: str) -> bool:
        """Whether it may succeed without the success of an objective."""
        return self.runs.begin in self.reaching([SUCCESS], ((SUCCESS, copy) for copy in self.of(name)))

    def loss(self, ends: Collection[str], hardware: str, aided: bool) -> bool:
        """Whether a loss for good may take the last way to an end, with nothing else lost."""
        away = set() if aided else self.helping()
        before, later = self.safely(ends, away), self.safely(ends, {*away, (REPAIRED, hardware)})
        lost = self.taking((OUT_OF_SERVICE, hardware))
        return any(s in self._sound and s in before and after not in later for s, after in lost)

    def failure(self, ends: Collection[str], hardware: str, name: str) -> bool:
        """Whether a failure during an objective may take all ways to an end, repairs among them."""
        before = self.safely(ends)
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

    @cached_property
    def success_left(self) -> dict[frozenset[str], bool]:
        """Whether success is left after each set of losses before the start.

        As in cut sets a loss is taken as given there, also of what can only crash while it runs.
        """
        return Played(self.mission, self.hardware).left()

    @cached_property
    def safety_left(self) -> dict[frozenset[str], bool]:
        """Whether a safe end is left after each set of losses that is played before the start."""
        left = dict[frozenset[str], bool]()
        for state in (s for s in self.leads if not s.begun):  # facts may differ before the start
            lost = frozenset(state.out.intersection(self.hardware))
            safe = self.safely([SUCCESS, ABORTED], [(REPAIRED, name) for name in lost])
            left[lost] = left.get(lost, False) or state in safe
        return left

    def numbers(self, kind: str, number: int) -> bool | None:
        """Whether a claim on any so many losses by the start holds, or on the most that leave a way.

        Args:
            kind: Of the claim.
            number: How many losses it speaks of.

        Returns:
            ``None`` of safe ends where something only crashes while it runs.

        Raises:
            OverflowError: As of :class:`Played`.
        """
        ends_well = kind.endswith(("defeat", "success"))
        if not ends_well and not {*self.hardware} <= {*self.interpreter.faulty}:
            return None
        left = (self.success_left if ends_well else self.safety_left).items()
        if kind.startswith("any_lost"):
            return any(len(lost) == number and not spared for lost, spared in left)
        return number == max(len(lost) for lost, spared in left if spared)

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
            "end_decides": lambda: self.decides(*self.happenings(*subject)),
            "outcome_comes": lambda: self.runs.happens([(subject[1], copy) for copy in self.of(subject[0])]),
            "fact_defeats": lambda: self.defeats(*subject),
            "used": lambda: self.used(*subject),
            "selected": lambda: self.selected(*subject),
            "waits_for_hardware": self.waits,
            "needs_help_to_succeed": self.starts_with_help,
            "needs_help_to_end": lambda: bool(self.reaching(every) - self.reaching(every, self.helping())),
            "needs_help_to_end_safely": lambda: self.needs_help(safe),
            "leads_past": lambda: self.past(*subject),
            "event_always_decides": lambda: self.always_decides((DECLARED, subject[0])),
            "event_leaves_repair": lambda: self.leaves_repair((DECLARED, subject[0])),
            "end_always_decides": lambda: self.always_decides(*self.happenings(*subject)),
            "end_leaves_repair": lambda: self.leaves_repair(*self.happenings(*subject)),
            "loss_always_defeats": lambda: self.always_lost([SUCCESS], *subject),
            "loss_always_endangers": lambda: self.always_lost(safe, *subject),
            "still_possible": lambda: self.leaves(*subject),
            "runs_with": lambda: self.runs_with(*subject),
            "loss_unnoticed": lambda: self.unnoticed(*subject, alone=True),
            "loss_unnoticed_later": lambda: (
                not self.unnoticed(*subject, alone=True) and self.unnoticed(*subject, alone=False)
            ),
            "without_repair_defeated": lambda: self.unrepaired([SUCCESS]),
            "without_repair_endangered": lambda: self.unrepaired(safe),
            "abort_after": lambda: not self.unsafe.isdisjoint(self.of(subject[0])),
            "aborted_by_failure": lambda: bool(self.unsafe),
            "required_events_handled": self.all_handled,
            "nominal_success": lambda: (found := played(self.mission)) is not None and found.holds,
        }
        return kinds[kind]() if kind in kinds else None
