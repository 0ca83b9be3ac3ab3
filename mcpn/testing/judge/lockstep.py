"""A mission in lockstep: the interpreter beside what plays it, over every pair of states.

What plays is a :class:`Player`, here the alternatives graph of a net.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import fields
from typing import Protocol, TypeAlias, TypeVar

from mcpn.answers.verdicts.modes import Situation, situation
from mcpn.drawing.compose import MissionNet
from mcpn.events import Event
from mcpn.mission.model import Mission
from mcpn.robot.runtime.controller_tables import Inside
from mcpn.spaces.markings.graph import StateGraph
from mcpn.testing.judge.interpreter import Happening, Interpreter, Seen, State, Undetermined, words

Order = tuple[str | None, str, str, Mapping[str, str]]
"""An alternative that is selected: its objective, its activity, its name, the parameters that it is given."""


Key = TypeVar("Key", bound=Hashable)
"""Where a player is; it can be gone back to."""


class Player(Protocol[Key]):
    """A mission played by mcpn."""

    start: Key

    def seen(self, at: Key) -> Seen:
        """What can be seen there."""

    def possible(self, at: Key) -> set[Happening]:
        """The events that may happen there."""

    def after(self, at: Key, happened: Happening) -> tuple[Key, Iterable[Order]]:
        """Where an event leads, and the alternatives that are selected on the way, where orders are given."""


def happening(event: Event | None) -> Happening:
    """An event of a net in the interpreter's words."""
    assert event is not None
    return " ".join(filter(None, (event.what.value, event.reason))), event.element


def seen_of(
    said: Situation | Inside,
    out: Iterable[str],
    unnoticed: Iterable[str],
    facts: Mapping[str, str],
    outcome: str | None,
) -> Seen:
    """What a situation or a controller's state says."""
    return Seen(
        running=frozenset(said.objectives),
        pending=frozenset(said.pending),
        ended=frozenset(said.done),
        mode=frozenset(said.mode.items()),
        waiting=frozenset(said.waiting.items()),
        refused=frozenset(said.refused),
        out=frozenset(out),
        unnoticed=frozenset(unnoticed),
        facts=frozenset(facts.items()),
        outcome=outcome,
    )


class OfGraph:
    """An alternatives graph.

    Args:
        mission_net: The net of the mission.
        graph: Its stable states.
    """

    start = 0

    def __init__(self, mission_net: MissionNet, graph: StateGraph) -> None:
        self.mission_net, self.graph = mission_net, graph
        self.edges: dict[int, dict[Happening, int]] = {}

    def seen(self, at: int) -> Seen:
        """What can be seen in a state."""
        said = situation(self.mission_net, self.graph.marking(at))
        return seen_of(said, said.out_of_service, said.unnoticed, said.facts, said.outcome)

    def possible(self, at: int) -> set[Happening]:
        """The events that may happen there."""
        return set(self.onward(at))

    def after(self, at: int, happened: Happening) -> tuple[int, Iterable[Order]]:
        """Where an event leads; a graph gives no orders."""
        return self.onward(at)[happened], ()

    def onward(self, at: int) -> dict[Happening, int]:
        """Each event that may happen in a state, and where it leads."""
        if at not in self.edges:
            transitions = self.graph.net.transitions
            found = [(happening(transitions[t].event), to) for t, to in self.graph.successors(at)]
            self.edges[at] = dict(found)
            assert len(self.edges[at]) == len(found), "one event leads to one state"
        return self.edges[at]


Came: TypeAlias = dict[tuple[State, Key], tuple[tuple[State, Key], Happening] | None]
"""How each pair was first come to: from which pair, and by which event."""

MOST_STATES = 3_000
"""Stable states of the missions that are judged."""


class Mismatch(AssertionError):
    """The interpreter and one of mcpn's ways to play a mission do not say the same.

    Args:
        who: Who differs from the interpreter.
        kind: In what: a field of :class:`Seen`, ``possible``, ``parameters``, or ``confluence``.
        run: The events that lead there.
        expected: What the interpreter says.
        found: What is found.
    """

    def __init__(self, who: str, kind: str, run: list[Happening], expected: object, found: object) -> None:
        super().__init__(f"{who}: {kind} after {words(run) or 'nothing'}: expected {expected}, found {found}")
        self.who, self.kind, self.run = who, kind, run
        self.expected, self.found = expected, found


class TooLargeError(Exception):
    """There are more states than are judged."""


class Judge:
    """Holds the interpreter against the ways to play a mission; each state is computed once.

    Args:
        mission: A valid mission.
        unseen: Fields of :class:`Seen` that are not compared.
    """

    def __init__(self, mission: Mission, unseen: Collection[str] = ()) -> None:
        self.mission = mission
        self.interpreter = Interpreter(mission)
        self.compared = [f.name for f in fields(Seen) if f.name not in unseen]
        self.unseen = frozenset(unseen)
        self._after: dict[State, dict[Happening, State | None]] = {}
        self._seen: dict[State, Seen] = {}

    @property
    def states(self) -> Collection[State]:
        """Those that have been looked at."""
        return self._after.keys()

    def after(self, state: State) -> dict[Happening, State | None]:
        """Where each event leads; ``None`` where that is not determined."""
        if state not in self._after:
            self._after[state] = {e: self._one(state, e) for e in sorted(self.interpreter.possible(state))}
        return self._after[state]

    def _one(self, state: State, happened: Happening) -> State | None:
        try:
            return self.interpreter.after(state, happened)
        except Undetermined:
            return None

    def explore(self, most: int | None = None) -> bool:
        """Looks at every state; says whether each event has a determined outcome.

        Args:
            most: How many states are looked at; :data:`MOST_STATES` by default.

        Raises:
            TooLargeError: There are more.
        """
        determined, stack, known = True, [self.interpreter.initial], {self.interpreter.initial}
        while stack:
            for after in self.after(stack.pop()).values():
                determined &= after is not None
                if after is not None and after not in known:
                    known.add(after)
                    stack.append(after)
            if len(known) > (MOST_STATES if most is None else most):
                raise TooLargeError
        return determined

    def lockstep(self, who: str, player: Player[Key]) -> int:
        """Holds one player against the interpreter; says in how many pairs of states they agree."""
        first: tuple[State, Key] = self.interpreter.initial, player.start
        came: Came[Key] = {first: None}
        queue = deque([first])
        while queue:
            state, at = queue.popleft()
            if (found := self.differs(state, player, at)) is not None:
                kind, expected, others = found
                raise Mismatch(who, kind, _run_to(came, (state, at)), expected, others)
            for happened, after in self.after(state).items():
                if after is None:
                    continue
                to, orders = player.after(at, happened)
                for objective, activity, alternative, given in orders:
                    wanted = self.interpreter.parameters(objective, activity, alternative)
                    if "parameters" not in self.unseen and given != wanted:
                        run = [*_run_to(came, (state, at)), happened]
                        raise Mismatch(who, "parameters", run, wanted, given)
                if (after, to) not in came:
                    came[after, to] = (state, at), happened
                    queue.append((after, to))
        return len(came)

    def differs(self, state: State, player: Player[Key], at: Key) -> tuple[str, object, object] | None:
        """In what a state differs, what is expected and what is found; ``None`` where all is the same."""
        if state not in self._seen:
            self._seen[state] = self.interpreter.seen(state)
        expected, found = self._seen[state], player.seen(at)
        for name in self.compared:
            if getattr(expected, name) != getattr(found, name):
                return name, getattr(expected, name), getattr(found, name)
        possible = set(self.after(state))
        if possible != (others := player.possible(at)):
            return "possible", words(possible - others), words(others - possible)
        return None


def _run_to(came: Came[Key], pair: tuple[State, Key]) -> list[Happening]:
    """The events that led to a pair."""
    run = list[Happening]()
    while (step := came[pair]) is not None:
        pair = step[0]
        run.append(step[1])
    return run[::-1]
