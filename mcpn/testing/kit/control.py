"""Machines that drive the objectives graph alone, or a fact alone, and play all else."""

from __future__ import annotations

from hypothesis import strategies as st
from hypothesis.stateful import invariant, precondition, rule

from mcpn.events import START, Event, What
from mcpn.testing.kit.alone import CHOICE, TemplateMachine, told


class ControlMachine(TemplateMachine):
    """The objectives graph, between the activities that it starts and stops."""

    def __init__(self) -> None:
        super().__init__()
        self.begun = False
        self.started: set[str] = set()
        """Activities that have been started, and not stopped."""
        self.ways = {s.name: s.activities for s in self.alone.graph.walk()}
        self.timed = {s.name for s in self.alone.graph.walk() if s.timed_out is not None}
        self.reasons = {s.name: [why for why, _ in s.failures] for s in self.alone.graph.walk()}
        self.activities = sorted({a for used in self.ways.values() for a in used})

    def marked(self, part: str) -> list[str]:
        """Activities of which a place is marked."""
        return [a for a in self.activities if self.has(part, element=("activity", a))]

    def runs(self, activity: str) -> bool:
        """Whether an activity runs, and is not refused."""
        return self.has("active1", element=("activity", activity))

    def owed(self) -> bool:
        """Whether activities have to start or stop."""
        return bool(self.marked("Start") or self.marked("Stop"))

    @property
    def reacting(self) -> bool:
        """Whether activities act: what control decides first has fired."""
        return self.owed() and not any(t.rank < 0 for t in self.alone.internal)

    @precondition(lambda self: any(t.rank <= 0 or not self.owed() for t in self.alone.internal))
    @rule(choice=CHOICE)
    def fires(self, choice: int) -> None:
        """An internal transition fires; gates are of the last ranks, and wait for the activities."""
        enabled = self.alone.internal
        self.alone.fire(enabled[choice % len(enabled)])

    @precondition(lambda self: self.at_rest and self.alone.events)
    @rule(choice=CHOICE)
    def happens(self, choice: int) -> None:
        """An event happens."""
        events = list(self.alone.events.items())
        event, transition = events[choice % len(events)]
        self.begun |= event.what is What.START
        self.alone.fire(transition)

    @precondition(lambda self: self.reacting)
    @rule(choice=CHOICE, possible=st.booleans())
    def an_activity_reacts(self, choice: int, possible: bool) -> None:
        """An activity is stopped, or starts: it runs, or is refused."""
        asked = sorted({*self.marked("Start"), *self.marked("Stop")})
        name = asked[choice % len(asked)]
        element = ("activity", name)
        if self.has("Stop", element=element) and name in self.started:
            self.started.discard(name)
            ended = [self.at("active1", element=element)] if self.runs(name) else []
            idle = self.at("idle", element=element)
            puts = [idle] if idle in self.alone.tokens else []
            self.alone.move(f"{name} stops", (self.at("Stop", element=element), *ended), tuple(puts))
            return
        self.alone.require(self.has("Start", element=element), f"{name} is stopped and has not been started")
        self.alone.require(name not in self.started, f"{name} is started twice")
        self.started.add(name)
        begins = (self.at("active1", element=element),) if possible else ()
        said = "runs" if possible else "is refused"
        self.alone.move(f"{name} {said}", (self.at("Start", element=element),), begins)

    @precondition(lambda self: self.at_rest and self.started)
    @rule(choice=CHOICE)
    def an_activity_changes(self, choice: int) -> None:
        """What ran is refused now, or runs again."""
        names = sorted(self.started)
        name = names[choice % len(names)]
        place = (self.at("active1", element=("activity", name)),)
        if self.runs(name):
            self.alone.move(f"{name} is refused", place, ())
        else:
            self.alone.move(f"{name} runs", (), place)

    @precondition(lambda self: self.at_rest and not self.alone.events)
    @rule()
    def is_begun_anew(self) -> None:
        """Where nothing may happen any more the mission is played again."""
        self.alone.begin()
        self.begun = False

    @invariant()
    def it_starts_what_its_objectives_use(self) -> None:
        """At rest the activities of the objectives that run are started, and no others."""
        if not self.at_rest:
            return
        running = [name for name in self.ways if self.alone.says("objective", name)]
        used = {activity for name in running for activity in self.ways[name]}
        self.alone.require(
            used == self.started,
            f"{sorted(self.started)} are started, and {running} run, which use {sorted(used)}",
        )
        name = self.mission.name
        ended = [end for end in ("success", "failure", "abort") if self.alone.says(end, name)]
        self.alone.require(len(ended) < 2, f"the mission has ended in {' and '.join(ended)}")
        said = f"run: {told(running)}; the mission's end: {told(ended)}"
        self.alone.require((len(ended) + bool(running)) == self.begun, said)
        self._events_are_those_of(running)
        if ended:
            left = self.alone.changed(self.at("begin", element=("mission", name)))
            self.alone.require(not left, f"the mission has ended, and these are not as before: {told(left)}")

    def _events_are_those_of(self, running: list[str]) -> None:
        expected = {Event(What.FAILURE, name, why) for name in running for why in self.reasons[name]}
        expected |= {Event(What.TIMEOUT, name) for name in running if name in self.timed}
        expected |= {Event(What.SUCCESS, name) for name in running if all(map(self.runs, self.ways[name]))}
        expected |= set() if self.begun else {START}
        found = {e for e in self.alone.events if e.what is not What.DECLARED}
        wrong = sorted(" ".join(filter(None, (e.element, e.what, e.reason))) for e in expected ^ found)
        self.alone.require(not wrong, f"{', '.join(wrong)} may happen, or not, against what runs")
        heard = [e for e in self.alone.events if e.what is What.DECLARED]
        self.alone.require(not heard or bool(running), "an event is handled, and nothing runs")


class FactMachine(TemplateMachine):
    """A fact, between the objectives that change it."""

    @property
    def values(self) -> tuple[str, ...]:
        """The values of the fact."""
        return self.alone.usage.world.facts[self.element[1]].values

    def said(self) -> list[str]:
        """The values that its places say."""
        return [value for value in self.values if self.alone.says("fact", f"{self.element[1]}={value}")]

    @precondition(lambda self: self.at_rest)
    @rule(choice=CHOICE)
    def an_objective_changes_it(self, choice: int) -> None:
        """The end of an objective gives it a value."""
        (was,) = self.said()
        others = [value for value in self.values if value != was]
        now = others[choice % len(others)]
        watched = (self.element[1], now) in self.alone.usage.world.watched
        noted = (self.at(f"became:{now}"),) if watched else ()  # for blocks that are left then
        self.alone.move(f"it becomes {now}", (self.at(was),), (self.at(now), *noted))

    @precondition(lambda self: self.at_rest and self.alone.events)
    @rule(choice=CHOICE)
    def happens(self, choice: int) -> None:
        """A declared event happens, and gives it the value that it says."""
        events = list(self.alone.events.items())
        event, transition = events[choice % len(events)]
        (was,) = self.said()
        self.alone.fire(transition)
        to = self.alone.usage.world.changing[event.element][self.element[1]]
        wanted = to[was]
        self.alone.require(
            self.said() == [wanted], f"{event} makes it {told(self.said())}, expected {wanted}"
        )

    @invariant()
    def it_has_one_value(self) -> None:
        """One place says the value, and an event that would change it may happen."""
        said = self.said()
        self.alone.require(len(said) == 1, f"the values that are said: {told(said)}")
        if not self.at_rest:
            return
        changing = self.alone.usage.world.changing
        name, value = self.element[1], said[0]
        expected = sorted(e for e, to in changing.items() if name in to and to[name][value] != value)
        found = sorted(event.element for event in self.alone.events)
        self.alone.require(found == expected, f"{told(found)} may happen, expected {told(expected)}")
