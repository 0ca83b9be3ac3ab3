"""A mission in lockstep: the interpreter beside what plays it, over every pair of states."""

from __future__ import annotations

from collections import deque
from collections.abc import Collection
from dataclasses import fields
from typing import TypeAlias

from mcpn.mission.model import Mission
from mcpn.testing.judge.interpreter import Happening, Interpreter, Seen, State, Undetermined, words
from mcpn.testing.judge.players import Key, Player

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
