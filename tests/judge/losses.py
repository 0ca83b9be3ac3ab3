"""What losses before the start of a mission leave: the interpreter plays each subset of them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import replace
from itertools import combinations

from mcpn.mission.model import Mission
from mcpn.testing.judge.interpreter import REPAIRED, SUCCESS, Happening, Interpreter, State
from tests.logic.oracle import minimal

MOST_STATES = 400
MOST_LOSSES = 5


class Played:
    """All that may happen in a mission, from its start and from its start after losses.

    Args:
        of: The mission.
        names: What is lost before the start; without names all that may fail then.

    Raises:
        OverflowError: There are more than :data:`MOST_STATES` stable states, or :data:`MOST_LOSSES`.
        Undetermined: Two activities ask for one thing at the same moment.
    """

    def __init__(self, of: Mission, names: Collection[str] = ()) -> None:
        self.judge = Interpreter(of)
        self.edges: dict[State, list[tuple[Happening, State]]] = {}
        begin = self.judge.initial
        names = names or self.judge.faulty
        if len(names) > MOST_LOSSES:
            raise OverflowError
        self.subsets = [frozenset(s) for n in range(len(names) + 1) for s in combinations(names, n)]
        late = self.judge.late
        self.starts = {
            lost: replace(
                begin, out=begin.out | lost, unnoticed=begin.unnoticed | ((lost - begin.out) & late)
            )
            for lost in self.subsets
        }
        self.all = self.reached([begin], frozenset())

    def onward(self, state: State) -> list[tuple[Happening, State]]:
        """What may happen in a state, and where it leads."""
        if state not in self.edges:
            if len(self.edges) >= MOST_STATES:
                raise OverflowError
            self.edges[state] = [(e, self.judge.after(state, e)) for e in self.judge.possible(state)]
        return self.edges[state]

    def reached(self, begin: Iterable[State], lost: frozenset[str]) -> set[State]:
        """Where runs lead in which nothing of what is lost is repaired."""
        seen, stack = {*begin}, [*begin]
        while stack:
            for _, after in self.kept(stack.pop(), lost):
                if after not in seen:
                    seen.add(after)
                    stack.append(after)
        return seen

    def kept(self, state: State, lost: frozenset[str]) -> Iterator[tuple[Happening, State]]:
        """What may happen but for the repair of what is lost."""
        return (edge for edge in self.onward(state) if edge[0][0] != REPAIRED or edge[0][1] not in lost)

    def ends(self, begin: State, lost: frozenset[str]) -> set[str | None]:
        """The ends that a mission may still come to."""
        return {state.outcome for state in self.reached([begin], lost)}

    def succeeds(self, begin: State, lost: frozenset[str], objective: str | None = None) -> bool:
        """Whether a mission, or an objective of it, may still succeed."""
        if objective is None:
            return SUCCESS in self.ends(begin, lost)
        reached = self.reached([begin], lost)
        return any(event == (SUCCESS, objective) for s in reached for event, _ in self.kept(s, lost))

    def lost_at_start(self, objective: str | None = None) -> list[tuple[str, ...]]:
        """The least losses before the start after which nothing succeeds."""
        starts = self.starts.items()
        return minimal(lost for lost, begin in starts if not self.succeeds(begin, lost, objective))

    def lost_whenever(self) -> list[tuple[str, ...]]:
        """The least losses after which the mission cannot succeed, whenever they come."""
        open_ = [state for state in self.all if state.begun and state.outcome != SUCCESS]
        return minimal(
            lost
            for lost in self.subsets
            if not any(lost <= state.out and self.succeeds(state, lost) for state in open_)
        )

    def left(self) -> dict[frozenset[str], bool]:
        """Whether success is left after each set of losses before the start."""
        return {lost: self.succeeds(begin, lost) for lost, begin in self.starts.items()}
