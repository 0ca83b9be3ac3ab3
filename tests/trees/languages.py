"""What can be seen of a tree and of its mission, and whether it is the same.

Seen is which leaf that may run ends, and how; in between, which of them run. Conditions, events that ask
them again, objectives that only decide, and moments in which nothing runs are not seen: each side may take
as many such steps as it likes. Both sides are explored as sets of states behind one word, until no new pair
of sets appears.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from mcpn.testing.judge import interpreter
from mcpn.testing.judge.interpreter import Interpreter
from mcpn.trees.importing import Imported
from tests.trees.ticking import IDLE, RUNNING, State, Tree, Visible, ticks

Rest = tuple[str, ...]
"""What runs, sorted; or how it has ended."""


@dataclass
class Sides:
    """Both sides of a comparison, with what has been computed of them."""

    tree: Tree
    mission: Interpreter
    does: dict[str, str]
    """By activity of the mission, the leaf that it does."""
    hidden: frozenset[str]
    """Leaves that are not seen."""

    def tree_moves(self, state: tuple[State, str]) -> list[tuple[tuple[Visible, ...], tuple[State, str]]]:
        if state[1] not in (IDLE, RUNNING):
            return []
        return [(seen, (after, status)) for after, status, seen, _ in ticks(self.tree, state[0])]

    def tree_rest(self, state: tuple[State, str]) -> Rest | None:
        if state[1] not in (IDLE, RUNNING):
            return (state[1],)
        if state[1] == IDLE:
            return None
        at = [k.removesuffix(":status") for k, v in state[0] if k.endswith(":status") and v == RUNNING]
        names = [self.tree.leaves[place].id for place in at if place in self.tree.leaves]
        return None if self.hidden.intersection(names) or not names else tuple(sorted(names))

    def tree_stays(self, state: tuple[State, str]) -> Rest | None:
        """As :meth:`tree_rest`, where a tick may leave all as it is: moments between ticks are not seen."""
        stays = state[1] != RUNNING or ((), state) in self.tree_moves(state)
        return self.tree_rest(state) if stays else None

    def mission_moves(self, state: interpreter.State) -> list[tuple[tuple[Visible, ...], interpreter.State]]:
        found = []
        for happening in self.mission.possible(state):
            what, element = happening
            seen: tuple[Visible, ...] = ()
            if what in (interpreter.SUCCESS, interpreter.FAILURE):
                (activity,) = self.mission.objectives[element].activities
                leaf = self.does.get(activity)
                if leaf is not None and leaf not in self.hidden:
                    seen = ((leaf, what),)
            found.append((seen, self.mission.after(state, happening)))
        return found

    def mission_rest(self, state: interpreter.State) -> Rest | None:
        return self._mission(state, hidden=False)

    def mission_shows(self, state: interpreter.State) -> Rest | None:
        """As :meth:`mission_rest`, whatever runs beside that is not seen: in a tree it has answered."""
        return self._mission(state, hidden=True)

    def _mission(self, state: interpreter.State, *, hidden: bool) -> Rest | None:
        if state.outcome is not None:
            return (state.outcome,)
        if not state.begun:
            return None
        names = []
        for objective in state.running | state.pending:
            (activity,) = self.mission.objectives[objective].activities
            leaf = self.does.get(activity)
            if leaf is None and activity.startswith(("bt_wait", "bt_idle")):
                continue
            if leaf is None or leaf in self.hidden:
                if hidden:
                    continue
                return None
            names.append(leaf)
        return tuple(sorted(names)) or None


def sides(imported: Imported, tree: Tree) -> Sides:
    """The tree and the mission, ready to be compared."""
    does = {}
    for activity in imported.mission.activities:
        name = activity.name.rstrip("0123456789")
        if not name.startswith("bt_"):
            does[activity.name] = name
    return Sides(tree, Interpreter(imported.mission), does, tree.quick)


class TooMuch(Exception):
    """There are too many states for this way to compare."""


class Difference(AssertionError):
    """One side does what the other does not."""


Element = tuple[tuple[Visible, ...], Any]
"""A state, after some answers of the step to it that are yet to be seen."""


def compare(both: Sides, *, exact: bool, most: int = 400) -> int:
    """Compares what can be seen of both sides.

    Args:
        both: The sides.
        exact: Whether the mission may do nothing but what the tree does.
        most: How many words are followed at most.

    Returns:
        How many pairs of sets were compared.

    Raises:
        Difference: With the word, and what one side can be in after it and the other cannot.
    """
    trees, missions = Side(both.tree_moves, both.tree_rest), Side(both.mission_moves, both.mission_rest)
    nothing: State = ()
    start = (trees.closed([((), (nothing, IDLE))]), missions.closed([((), both.mission.initial)]))
    seen = {start}
    todo: deque[tuple[tuple[frozenset[Element], frozenset[Element]], tuple[Visible, ...]]] = deque(
        [(start, ())]
    )
    while todo and len(seen) < most:
        (one, other), word = todo.popleft()
        shown = missions.rests(other, both.mission_shows)
        _within(word, trees.rests(one, both.tree_stays), shown, "the tree")
        there, here = trees.behind(one), missions.behind(other)
        _within(word, set(there), set(here), "the tree")
        if exact:
            _within(word, missions.rests(other), trees.rests(one), "the mission")
            _within(word, set(here), set(there), "the mission")
        for visible, states in there.items():
            if visible in here and (pair := (states, here[visible])) not in seen:
                seen.add(pair)
                todo.append((pair, (*word, visible)))
    return len(seen)


def _within(word: tuple[Visible, ...], one: set[Any], other: set[Any], who: str) -> None:
    if more := one - other:
        raise Difference(f"after {word} {who}: {sorted(more)}, the other only: {sorted(other)}")


class Side:
    """Sets of states that are closed under steps that are not seen; a step that shows much is taken apart."""

    def __init__(self, moves: Callable[[Any], list[Element]], rest: Callable[[Any], Rest | None]) -> None:
        self.moves, self.rest = moves, rest
        self.known: dict[Any, list[Element]] = {}

    def of(self, state: Any) -> list[Element]:
        if state not in self.known:
            if len(self.known) > 300:
                raise TooMuch
            self.known[state] = self.moves(state)
        return self.known[state]

    def closed(self, elements: Iterable[Element]) -> frozenset[Element]:
        stack = list(elements)
        found = set(stack)
        while stack:
            pending, state = stack.pop()
            for element in [] if pending else self.of(state):
                if not element[0] and element not in found:
                    found.add(element)
                    stack.append(element)
        return frozenset(found)

    def rests(
        self, elements: frozenset[Element], rest: Callable[[Any], Rest | None] | None = None
    ) -> set[Rest]:
        found = ((rest or self.rest)(state) for pending, state in elements if not pending)
        return {rest for rest in found if rest is not None}

    def behind(self, elements: frozenset[Element]) -> dict[Visible, frozenset[Element]]:
        by: dict[Visible, list[Element]] = {}
        for pending, state in elements:
            for shown, after in [(pending, state)] if pending else self.of(state):
                if shown:
                    by.setdefault(shown[0], []).append((shown[1:], after))
        return {visible: self.closed(states) for visible, states in by.items()}
