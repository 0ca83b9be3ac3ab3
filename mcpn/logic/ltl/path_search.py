"""Some path that an automaton accepts, found marking by marking: no space is built.

The native kernel searches the product of the net and the automaton: depth first, in an order that a seed
draws, or greedily by the additive heuristic of planning, to where the automaton may accept, round by what it
asks for again and again, and back. It ends with a lasso; or it has seen that no path is accepted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple, TypeAlias, cast

from mcpn._kernel import PathFinder
from mcpn.logic.ltl.automaton import Automaton, AutomatonEdge
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import Formula, Goal, as_goal, encode
from mcpn.spaces.search.searches import MAX_BYTES, Searches
from mcpn.turns import Pausing, finished

MOST_MARKS = 64
PAUSE, GUIDED_PAUSE = 16_000, 100
"""Steps from pause to pause: each follows an edge of the product, or looks at all of the net."""
Outcome: TypeAlias = Literal["found", "none", "steps", "bytes", "tokens"]


class FoundPath(NamedTuple):
    """How a search for an accepted path ended.

    Args:
        outcome: A path was found, or there is none, or a limit was hit: on steps, on memory, or on tokens in
            one place.
        run: Transitions of the path, up to where it repeats, or ends, or where all that goes on is accepted.
        cycle: Index of the transition with which the part begins that repeats, if one does.
    """

    outcome: Outcome
    run: tuple[int, ...] = ()
    cycle: int | None = None


class PathSearch:
    """Looks for a path of a net from its initial marking that an automaton accepts.

    Args:
        net: The net.
        automaton: Its literals are conditions on markings, or steps.
        searches: Walks on the net, where there are some already.

    Attributes:
        fits: Whether the kernel can follow both.
    """

    def __init__(self, net: PetriNet, automaton: Automaton, searches: Searches | None = None) -> None:
        self._net, self._searches = net, searches or Searches(net)
        self._goals: dict[Formula, Goal] = {}
        self.fits = self._searches.fits and automaton.marks <= MOST_MARKS
        for literal in dict.fromkeys(f for edges in automaton.edges for edge in edges for f in edge.reads):
            goal = as_goal(literal, net)
            if goal is None:
                self.fits = False
                return
            self._goals[literal] = goal
        encoded, roots = encode(list(self._goals.values()), len(net.places))
        self._numbers = {literal: number for number, literal in enumerate(self._goals)}
        components = automaton.components()
        component_of = {q: number for number, inside in enumerate(components) for q in inside}
        self._finder = PathFinder(
            self._searches.kernel,
            net.initial,
            encoded,
            roots,
            [list(map(self._edge, edges)) for edges in automaton.edges],
            (1 << automaton.marks) - 1,
            [q in automaton.accepting_all for q in range(len(automaton.edges))],
            [component_of[q] for q in range(len(automaton.edges))],
        )

    def search(
        self, max_steps: int, seed: int, max_bytes: int = MAX_BYTES, *, guided: bool = False
    ) -> FoundPath:
        """What :meth:`searching` finds."""
        return finished(self.searching(max_steps, seed, max_bytes, guided=guided))

    def searching(
        self, max_steps: int, seed: int, max_bytes: int = MAX_BYTES, *, guided: bool = False
    ) -> Pausing[FoundPath]:
        """Searches, with pauses.

        Args:
            max_steps: Edges of the product that are followed; if guided, its members that are looked at.
            seed: Draws the order.
            max_bytes: Limit on memory.
            guided: Whether to search greedily. Such a search finds a path, or none, or nothing.

        Returns:
            How it has ended.
        """
        pause = GUIDED_PAUSE if guided else PAUSE
        while True:
            outcome, run, cycle = self._finder.search(max_steps, max_bytes, seed, guided, pause)
            if outcome != "pause":
                return FoundPath(cast(Outcome, outcome), tuple(run), cycle)
            yield

    def _edge(self, edge: AutomatonEdge) -> tuple[Sequence[int], int, int, Sequence[int] | None, bool]:
        fired, rests = edge.fires(len(self._net.transitions))
        return (
            [self._numbers[literal] for literal in edge.reads],
            sum(1 << mark for mark in edge.marks),
            edge.target,
            None if fired is None else sorted(fired),
            rests,
        )
