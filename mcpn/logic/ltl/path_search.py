"""Some path that an automaton accepts, found marking by marking: no space is built.

The native kernel searches the product of the net and the automaton depth first, in an order that a seed
draws. It ends with a lasso; or it has seen the whole product without one, and no path is accepted.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple, TypeAlias, cast

from mcpn.logic.ltl.automaton import Automaton, AutomatonEdge
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import Formula, Goal, as_goal, encode
from mcpn.spaces.search.searches import MAX_BYTES, Searches

MOST_MARKS = 64
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
        self._encoded, self._roots = encode(list(self._goals.values()), len(net.places))
        self._numbers = {literal: number for number, literal in enumerate(self._goals)}
        self._edges = [list(map(self._edge, edges)) for edges in automaton.edges]
        self._marks = (1 << automaton.marks) - 1
        self._all = [q in automaton.accepting_all for q in range(len(automaton.edges))]

    def search(self, max_steps: int, seed: int, max_bytes: int = MAX_BYTES) -> FoundPath:
        """Searches, with a limit on steps of the product and on memory."""
        outcome, _, run, cycle = self._searches.kernel.lasso(
            self._net.initial,
            self._encoded,
            self._roots,
            self._edges,
            self._marks,
            self._all,
            max_steps,
            max_bytes,
            seed,
        )
        return FoundPath(cast(Outcome, outcome), tuple(run), cycle)

    def _edge(self, edge: AutomatonEdge) -> tuple[Sequence[int], int, int, Sequence[int] | None, bool]:
        fired, rests = edge.fires(len(self._net.transitions))
        return (
            [self._numbers[literal] for literal in edge.reads],
            sum(1 << mark for mark in edge.marks),
            edge.target,
            None if fired is None else sorted(fired),
            rests,
        )
