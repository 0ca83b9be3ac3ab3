"""What a monitor says of a requirement after each event: violated, satisfied, or open.

The verdicts are those of LTL3 (Bauer, Leucker, Schallhart, *Runtime verification for LTL and TLTL*, ACM
TOSEM 2011): a formula is violated when no continuation of the run satisfies it, satisfied when every one
does, else open. Continuations are any sequences of states and events, or those alone that the mission's
stable states allow, which decides earlier: then an automaton counts in a state only where it accepts some
path of the mission from there (:mod:`mcpn.logic.ltl.product`). What holds in the states up to now, the one
after the last event included, is taken from the mission's stable states. States of a monitor that no run of
the mission tells apart are merged (:mod:`mcpn.controller.monitors.merging`).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product
from typing import Any, Literal, TypeAlias

from mcpn.answers.requirements import AskedRequirement
from mcpn.controller.monitors.merging import merged
from mcpn.errors import LimitError
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU
from mcpn.logic.ltl.automaton import Automaton, AutomatonEdge, kept, translated
from mcpn.logic.ltl.formulas import Happens, always, eventually, is_of_paths, normal
from mcpn.logic.ltl.product import Product
from mcpn.logic.syntax import parse_open
from mcpn.spaces.algebra import Space
from mcpn.spaces.search.goal import TRUE, And, Formula, Not, Or

Decided = Literal["violated", "satisfied", "open"]
_Machine: TypeAlias = tuple[list[Decided], list[dict[str, int]]]
_Alive: TypeAlias = Callable[[frozenset[int], Any], frozenset[int]]
MAX_STATES = 200_000
MAX_WITHIN = 20_000
"""Most states, before they are merged, of a monitor that is decided by the mission's own continuations."""
MOST_ATOMS = 10


@dataclass(frozen=True)
class Monitor:
    """A machine over the events of a mission; an event that has no move changes nothing.

    Args:
        name: Of the requirement.
        words: What it says, for people.
        formula: The same, as a formula.
        values: What is known in each state; it begins in state 0.
        moves: By state, the states that events lead to, by text of the event.
        within: Whether the mission's continuations alone decide; else any do.
    """

    name: str
    words: str
    formula: str
    values: tuple[Decided, ...]
    moves: tuple[dict[str, int], ...]
    within: bool = False

    def run(self, events: Iterable[str]) -> list[Decided]:
        """What is known at first, and after each of some events."""
        state, found = 0, [self.values[0]]
        for event in events:
            state = self.moves[state].get(event, state)
            found.append(self.values[state])
        return found


def on_one_path(asked: AskedRequirement) -> Formula | None:
    """What a requirement says of each run by itself; ``None`` where it speaks of what may happen.

    ``AG`` and ``AF`` of what holds in states are read as ``G`` and ``F``.
    """
    formula = parse_open(asked.text, asked.names)
    if is_of_paths(formula):
        return formula
    match formula:
        case Not((EU((along, operand)),)) if along == TRUE:
            return always(~operand)
        case Not((EG((operand,)),)):
            return eventually(~operand)
    return None


class Watcher:
    """Makes monitors of one mission.

    Args:
        space: Its stable states.
        ends: The places of its ends. Once one is marked nothing need happen any more, though hardware may
            still fail: a robot that has come home stands there.
    """

    def __init__(self, space: Space[Any], ends: Collection[int] = ()) -> None:
        self._space, self._ends = space, ends
        self._evaluation = Evaluation(space)
        self._known: dict[tuple[Formula, Any], bool] = {}
        self._edges: dict[Any, list[tuple[int, str, Any]]] = {}

    def monitor(self, asked: AskedRequirement, formula: Formula, within: bool = False) -> Monitor:
        """The monitor of a requirement, with few states.

        Args:
            asked: The requirement; where it is expected to fail, its negation is watched.
            formula: What it says, on paths.
            within: Whether the mission's own continuations decide, all of them, fair or not; a monitor that
                would have more than :data:`MAX_WITHIN` states is decided by any continuations all the same.

        Raises:
            LimitError: It has too many states before they are merged.
        """
        holds = asked.requirement.expected == "holds"
        watched = formula if holds else ~formula
        product = self._product(watched, MAX_WITHIN) if within else None
        within = product is not None
        values, moves = merged(*(product or self._plain(watched)))
        words = asked.words if holds else f"not: {asked.words}"
        text = asked.text if holds else f"!({asked.text})"
        return Monitor(asked.name, words, text, tuple(values), tuple(moves), within)

    def _plain(self, formula: Formula) -> _Machine:
        """The product that any continuations decide."""
        product = self._product(formula)
        if product is None:
            raise LimitError(f"the monitor has more than {MAX_STATES} states: the limit was hit")
        return product

    def _product(self, formula: Formula, within: int = 0) -> _Machine | None:
        """The product of the stable states with the automata of a formula and of its negation.

        Args:
            formula: The formula.
            within: How many states it may have, if the mission's continuations alone decide; else 0.

        Returns:
            By state of the product, the verdict, and where each event leads; ``None`` where there are too
            many.
        """
        both = [kept(translated(normal(formula, wanted)), satisfiable) for wanted in (True, False)]
        edges = [edge for automaton in both for leaving in automaton.edges for edge in leaving]
        of_events = {f for edge in edges for f in edge.literals if _of_event(f)}
        alive = [self._alive(automaton) if within else _everywhere for automaton in both]
        initial, first = self._space.initial.pick(), frozenset({0})
        start = initial, alive[0](first, initial), alive[1](first, initial)
        numbers, queue = {start: 0}, [start]
        values: list[Decided] = []
        moves: list[dict[str, int]] = []
        for state, *sets in queue:
            may_hold, may_fail = (self._enabled(a, held, state) for a, held in zip(both, sets, strict=True))
            values.append("violated" if not may_hold else "open" if may_fail else "satisfied")
            moves.append({})
            known: dict[frozenset[Formula], tuple[frozenset[int], frozenset[int]]] = {}
            for transition, event, target in self._leaving(state) if values[-1] == "open" else ():
                true = frozenset(f for f in of_events if _happens(f, transition))
                if true not in known:
                    known[true] = _targets(may_hold, true), _targets(may_fail, true)
                hold, fail = known[true]
                into = target, alive[0](hold, target), alive[1](fail, target)
                if into not in numbers:
                    numbers[into] = len(queue)
                    queue.append(into)
                    if len(queue) > (within or MAX_STATES):
                        return None
                moves[-1][event] = numbers[into]
        return values, moves

    def _alive(self, automaton: Automaton) -> _Alive:
        """Of states of an automaton those that accept some path of the mission from a stable state on."""
        ended = self._space.marked(self._ends)
        accepted = Product(self._space, automaton, self._evaluation.states, resting=ended).accepted()
        known: dict[tuple[int, Any], bool] = {}

        def alive(q: int, state: Any) -> bool:
            if (q, state) not in known:
                known[q, state] = q in accepted and bool(self._space.single(state) & accepted[q])
            return known[q, state]

        return lambda held, state: frozenset(q for q in held if alive(q, state))

    def _leaving(self, state: Any) -> list[tuple[int, str, Any]]:
        """What may happen in a stable state: transition, text of the event, and the state after it."""
        if state not in self._edges:
            transitions = self._space.net.transitions
            self._edges[state] = [
                (edge.transition, str(transitions[edge.transition].event), edge.target)
                for edge in self._space.edges(state)
            ]
        return self._edges[state]

    def _satisfied(self, formula: Formula, state: Any) -> bool:
        key = formula, state
        if key not in self._known:
            self._known[key] = bool(self._space.single(state) & self._evaluation.states(formula))
        return self._known[key]

    def _enabled(self, automaton: Automaton, held: frozenset[int], state: Any) -> list[AutomatonEdge]:
        """The edges from states ``held`` of an automaton whose literals on states hold in a stable state."""
        return [
            e
            for q in held
            for e in automaton.edges[q]
            if all(self._satisfied(f, state) for f in e.literals if not _of_event(f))
        ]


def satisfiable(formulas: Iterable[Formula]) -> bool:
    """Whether some truth values of their atoms satisfy all of some formulas on states and of events.

    With more than :data:`MOST_ATOMS` atoms the answer is yes without a search: verdicts may then come later.
    """
    whole = And(*formulas)
    atoms = list(dict.fromkeys(_atoms(whole)))
    if len(atoms) > MOST_ATOMS:
        return True
    truths = (dict(zip(atoms, each, strict=True)) for each in product((False, True), repeat=len(atoms)))
    return any(_true(whole, each) for each in truths)


def _atoms(formula: Formula) -> Iterator[Formula]:
    if isinstance(formula, And | Or | Not):
        for operand in formula.operands:
            yield from _atoms(operand)
    else:
        yield formula


def _true(formula: Formula, truths: Mapping[Formula, bool]) -> bool:
    match formula:
        case And(operands):
            return all(_true(f, truths) for f in operands)
        case Or(operands):
            return any(_true(f, truths) for f in operands)
        case Not((operand,)):
            return not _true(operand, truths)
    return truths[formula]


def _everywhere(held: frozenset[int], state: Any) -> frozenset[int]:
    """All states of an automaton, where any continuation counts: those that accept nothing are left out."""
    return held


def _of_event(literal: Formula) -> bool:
    return isinstance(literal.operands[0] if isinstance(literal, Not) else literal, Happens)


def _happens(literal: Formula, transition: int) -> bool:
    match literal:
        case Happens(transitions):
            return transition in transitions
        case Not((Happens(transitions),)):
            return transition not in transitions
    raise TypeError(literal)


def _targets(ways: Iterable[AutomatonEdge], true: frozenset[Formula]) -> frozenset[int]:
    """The targets of those of some edges whose literals on events are all true."""
    return frozenset(e.target for e in ways if all(f in true for f in e.literals if _of_event(f)))
