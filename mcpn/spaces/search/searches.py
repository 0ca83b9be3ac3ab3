"""Walks and searches of the native kernel on a net, with runs that replay.

A walk follows one run at a time and finds what is easy to come to; a search stores what it has seen, nearest
to the goal first, and says also that nothing more is reachable.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias, cast

from mcpn._kernel import GoalSearch, TokenNet
from mcpn.errors import UnsafeError
from mcpn.nets.petri import PetriNet
from mcpn.nets.structure import changes, needs
from mcpn.spaces.markings.masked import unsafe_at_start
from mcpn.spaces.search.goal import Goal, encode, holds
from mcpn.turns import Pausing, finished

Run: TypeAlias = tuple[int, ...]
"""Transitions by index, from the initial marking on."""

Outcome: TypeAlias = Literal["reached", "unreachable", "states", "bytes", "tokens"]
MOST_TOKENS = 2**31
MAX_BYTES = 1 << 30
FIRST_WALK, LONGEST_WALK, MOST_WALKS = 4_000, 640_000, 64
"""Firings of one walk from pause to pause, at first and at most, and walks of one seed."""
WALK_LENGTH = 500
"""Firings before a walk begins anew, at first; in large nets twice as many as there are transitions."""


class Search(NamedTuple):
    """How a search ended.

    Args:
        outcome: The goal was reached, or no marking of it is reachable, or a limit was hit: on states, on
            memory, or on tokens in one place.
        states: Markings seen.
        run: To the goal.
    """

    outcome: Outcome
    states: int
    run: Run = ()


class Seeking:
    """A search for a marking of a goal that rests now and then, and goes on where a limit has ended it.

    Args:
        net: The net.
        start: Where it begins.
        work: The search in the kernel.
    """

    def __init__(self, net: PetriNet, start: Sequence[int], work: GoalSearch) -> None:
        self._net, self._start, self._work = net, start, work

    def searching(self, max_states: int, max_bytes: int = MAX_BYTES) -> Pausing[Search]:
        """Goes on to a limit on markings and on memory, both counted from the beginning."""
        while (ended := self._work.search(max_states, max_bytes))[0] == "pause":
            yield
        outcome, states, run = ended
        return Search(cast(Outcome, outcome), states, shortened(self._net, run, self._start))


class Searches:
    """Looks for markings of one net without building its space.

    Args:
        net: Any net; priorities are respected.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net

    @property
    def fits(self) -> bool:
        """Whether the net's numbers are within what the kernel follows."""
        return self.net.largest < MOST_TOKENS

    @cached_property
    def kernel(self) -> TokenNet:
        """The net as the kernel walks it."""
        transitions = []
        for t in range(len(self.net.transitions)):
            changed = list(changes(self.net, t).items())
            transitions.append((list(needs(self.net, t).items()), changed, self.net.ranks[t]))
        return TokenNet(len(self.net.places), transitions, self.net.priorities)

    @cached_property
    def _orders(self) -> tuple[list[int], list[int]]:
        """Two orders of the transitions, in which those of components that are alike stand together.

        Their names differ in a number at the end alone. What is enabled at first comes first, in one order as
        its names are met, in the other the reverse. A walk to a deadlock begins by such an order, for
        components that all do the same first often lock each other: each philosopher takes the left fork.
        """
        net, stems = self.net, dict[str, int]()
        stem_of = [stems.setdefault(t.name.rstrip("0123456789"), len(stems)) for t in net.transitions]
        late = [not net.covers(net.initial, t) for t in range(len(stem_of))]
        orders = []
        for sign in (1, -1):
            ranked = sorted(
                range(len(stem_of)), key=lambda t: (late[t], stem_of[t] if late[t] else sign * stem_of[t])
            )
            orders.append([0] * len(stem_of))
            for place, t in enumerate(ranked):
                orders[-1][t] = place
        return orders[0], orders[1]

    @property
    def _length(self) -> int:
        return max(WALK_LENGTH, 2 * len(self.net.transitions))

    def walk(
        self,
        goals: Sequence[Goal],
        *,
        steps: int,
        seed: int = 0,
        counts: Sequence[int] = (),
    ) -> dict[int, Run]:
        """Walks from the initial marking: at random, towards one goal, or by a drawn order of transitions.

        Args:
            goals: What is looked for.
            steps: Firings in all, those tried included.
            seed: The same seed walks the same way.
            counts: How often each transition should fire, where the state equation has proposed it.

        Returns:
            Runs to the goals that were met, by their index.
        """
        return {goal: shortened(self.net, run) for goal, run in self._walked(goals, steps, seed, counts)}

    def met(
        self, goals: Sequence[Goal], *, steps: int, seed: int = 0, counts: Sequence[int] = ()
    ) -> set[int]:
        """The goals that :meth:`walk` meets, by index, where their runs are not asked for."""
        return {goal for goal, _ in self._walked(goals, steps, seed, counts)}

    def walking(
        self, goals: Sequence[Goal], steps: int, *, seed: int = 0
    ) -> Iterator[tuple[int, list[int]] | None]:
        """Walks as :meth:`walk` does, with pauses: some walks, each twice as long as the one before.

        Args:
            goals: What is looked for.
            steps: Firings in all, those tried included.
            seed: The same seed walks the same way.

        Yields:
            The index of a goal that was met, and the run to it; ``None`` for a pause.
        """
        if not goals or not steps:
            return
        encoded, roots = encode(goals, len(self.net.places))
        left, length, number = list(range(len(goals))), FIRST_WALK, MOST_WALKS * seed
        while left and steps > 0:
            walked = self.kernel.walk(
                self.net.initial,
                encoded,
                [roots[goal] for goal in left],
                steps=min(length, steps),
                length=self._length,
                seed=number,
                order=self._orders[number % 2],
            )
            met = {left[index]: run for index, run in walked}
            yield from met.items()
            yield None
            left = [goal for goal in left if goal not in met]
            steps, length, number = steps - length, min(2 * length, LONGEST_WALK), number + 1

    def _walked(
        self, goals: Sequence[Goal], steps: int, seed: int, counts: Sequence[int]
    ) -> list[tuple[int, list[int]]]:
        encoded, roots = encode(goals, len(self.net.places))
        length = max(self._length, 2 * sum(counts))
        return self.kernel.walk(
            self.net.initial,
            encoded,
            roots,
            steps=steps,
            length=length,
            seed=seed,
            counts=list(counts),
            order=self._orders[seed % 2],
        )

    def ends(self, *, steps: int, walks: int) -> Iterator[list[int]]:
        """Markings that random walks come to, of a net without priorities; a dead one ends its walk.

        Args:
            steps: Firings of all together.
            walks: How many, each twice as long as the one before.
        """
        net, draw = self.net, random.Random(0)
        takers: list[list[int]] = [[] for _ in net.places]
        for t in range(len(net.transitions)):
            for place in needs(net, t):
                takers[place].append(t)
        near = [
            sorted({u for place in changes(net, t) for u in takers[place]})
            for t in range(len(net.transitions))
        ]
        for walk in range(walks):
            marking, enabled = list(net.initial), set(net.enabled(net.initial))
            for _ in range(steps >> (walks - walk)):
                if not enabled:
                    break
                fired = draw.choice(tuple(enabled))
                net.fire_in_place(marking, fired)
                for t in near[fired]:
                    (enabled.add if net.covers(marking, t) else enabled.discard)(t)
            yield marking

    def walk_unsafe(self, *, steps: int, seed: int = 0) -> UnsafeError | None:
        """Walks until a firing puts a second token in a place, if one does within so many steps.

        Returns:
            The error of that firing, or of an initial marking that holds several tokens in a place.
        """
        if error := unsafe_at_start(self.net):
            return error
        encoded, roots = encode((), len(self.net.places))
        walked = self.kernel.walk(self.net.initial, encoded, roots, steps, self._length, seed, True, [])
        if not walked:
            return None
        *run, last = shortened(self.net, walked[0][1])
        before = replay(self.net, run)
        after = self.net.fire(before, last)
        place = next(p for p, tokens in enumerate(after) if tokens > 1)
        names = [self.net.transitions[t].name for t in run]
        return UnsafeError(
            self.net.places[place].name, self.net.transitions[last].name, self.net.marked(before), names
        )

    def planning(self, goal: Goal, *, seed: int = 0, start: Sequence[int] | None = None) -> Seeking:
        """Searches greedily for a marking of a goal, by the additive heuristic of planning.

        Args:
            goal: What is looked for.
            seed: Draws the order of what is equally near.
            start: Where to begin; by default in the initial marking.

        Returns:
            The search, which is still to begin. Its runs are longer than those of :meth:`seeking`, and it
            finds some that the other does not.
        """
        encoded, (root,) = encode((goal,), len(self.net.places))
        begin = self.net.initial if start is None else tuple(start)
        return Seeking(self.net, begin, self.kernel.plan(begin, encoded, root, seed))

    def plan(self, goal: Goal, *, max_states: int, seed: int = 0) -> Search:
        """What :meth:`planning` finds from the initial marking, at once."""
        return finished(self.planning(goal, seed=seed).searching(max_states))

    def seeking(self, goal: Goal, *, stubborn: bool = True, start: Sequence[int] | None = None) -> Seeking:
        """Searches for a marking of a goal, nearest first.

        Args:
            goal: What is looked for.
            stubborn: Whether to leave out interleavings that do not matter to the goal.
            start: Where to begin, reachable or not; by default in the initial marking.

        Returns:
            The search, which is still to begin: it finds a run to the goal, or that it is not reachable.
        """
        encoded, (root,) = encode((goal,), len(self.net.places))
        begin = self.net.initial if start is None else tuple(start)
        return Seeking(self.net, begin, self.kernel.seek(begin, encoded, root, stubborn))

    def seek(
        self, goal: Goal, *, max_states: int, max_bytes: int = MAX_BYTES, stubborn: bool = True
    ) -> Search:
        """What :meth:`seeking` finds from the initial marking, at once."""
        return finished(self.seeking(goal, stubborn=stubborn).searching(max_states, max_bytes))


def replay(net: PetriNet, run: Sequence[int]) -> tuple[int, ...]:
    """The marking after a run of enabled transitions, priorities aside.

    Raises:
        ValueError: A transition of the run is not enabled.
    """
    marking = list(net.initial)
    for number, t in enumerate(run):
        if not net.covers(marking, t):
            raise ValueError(f"step {number}: {net.transitions[t].name} is not enabled")
        net.fire_in_place(marking, t)
    return tuple(marking)


def leads_to(net: PetriNet, run: Sequence[int], goal: Goal) -> bool:
    """Whether a run replays and its end satisfies a goal."""
    try:
        return holds(goal, net, replay(net, run))
    except ValueError:
        return False


def shortened(net: PetriNet, run: Sequence[int], start: Sequence[int] | None = None) -> Run:
    """A run, by default from the initial marking, without the parts that come back to a marking.

    Takes time linear in the arcs of what fires, however many places a marking has: markings are told apart by
    keys, and where two have the same, by whether what fired between them changes nothing.
    """
    marking = list(net.initial if start is None else start)
    effects: dict[int, dict[int, int]] = {}
    key = 0
    seen = {key: 0}
    kept: list[int] = []
    keys: list[int | None] = [key]  # none where an earlier marking, which is another, has the same
    for t in run:
        if t not in effects:
            effects[t] = changes(net, t)
        for place, change in effects[t].items():
            before = marking[place]
            marking[place] = after = before + change
            key ^= _mark(place, before) ^ _mark(place, after)
        kept.append(t)
        back = seen.get(key)
        if back is None:
            seen[key] = len(kept)
            keys.append(key)
        elif _changes_nothing(effects[fired] for fired in kept[back:]):
            for dropped in keys[back + 1 :]:
                if dropped is not None:
                    del seen[dropped]
            del keys[back + 1 :], kept[back:]
        else:
            keys.append(None)
    return tuple(kept)


def _mark(place: int, tokens: int) -> int:
    """What a place adds to the key of a marking."""
    return hash((place, tokens))


def _changes_nothing(effects: Iterable[Mapping[int, int]]) -> bool:
    total: Counter[int] = Counter()
    for effect in effects:
        total.update(effect)
    return not any(total.values())
