"""Generalised Büchi automata on transitions, and the translation of formulas on paths into them.

The states of the automaton are sets of obligations: formulas that the rest of the path must satisfy. Its
edges are the covers of such a set: what the present state must satisfy, and the obligations left then
(Couvreur, *On-the-fly verification of linear temporal logic*, FM 1999; Gastin, Oddoux, *Fast LTL to Büchi
automata translation*, CAV 2001, whose simplifications are used). An edge bears the mark of each ``U`` that it
does not put off; a run is accepted where it takes every mark again and again.

>>> from mcpn.logic.ltl.formulas import Until
>>> from mcpn.spaces.search.goal import TRUE, marked
>>> p = marked(0)
>>> automaton = translated(Until(TRUE, p))
>>> len(automaton.edges), automaton.marks
(2, 1)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple, TypeAlias

from mcpn.errors import LimitError
from mcpn.logic.ltl.formulas import Happens, Next, Release, Until, atom_of, is_of_paths
from mcpn.spaces.components import strongly_connected
from mcpn.spaces.search.goal import FALSE, TRUE, And, Formula, Or

MAX_STATES = 2_000
MAX_EDGES = 50_000
MAX_STEPS = 15_000_000
"""Comparisons of covers and edges that one automaton may take, which are what its construction costs."""

_STEPS_OF_A_CHOICE = 20
"""What it costs to go on with a cover, in comparisons."""

Literals: TypeAlias = frozenset[Formula]
"""Formulas on states, steps and their negations, all of which hold."""


class AutomatonEdge(NamedTuple):
    """An edge of an automaton.

    Args:
        literals: What the path satisfies in the state that the edge reads.
        marks: Marks that it bears.
        target: The state that it leads to.
    """

    literals: Literals
    marks: frozenset[int]
    target: int

    @property
    def reads(self) -> tuple[Formula, ...]:
        """The literals about the state; the others are about the step."""
        return tuple(literal for literal in self.literals if not isinstance(atom_of(literal), Happens))

    def fires(self, transitions: int) -> tuple[frozenset[int] | None, bool]:
        """The steps along which the edge may be taken, by its literals.

        Args:
            transitions: How many the net has.

        Returns:
            What may fire along it, ``None`` for anything; and whether it may be taken where nothing fires: in
            a state without successors, which repeats.
        """
        fired: frozenset[int] | None = None
        rests = True
        for literal in self.literals:
            if isinstance(atom := atom_of(literal), Happens):
                may = frozenset(atom.transitions)
                if atom is literal:
                    rests = False
                else:
                    may = frozenset(range(transitions)) - may
                fired = may if fired is None else fired & may
        return fired, rests


class Automaton(NamedTuple):
    """A generalised Büchi automaton with marks on its edges; its initial state is number 0.

    Args:
        edges: By state. A state without edges accepts nothing.
        marks: How many marks an accepted run takes again and again.
    """

    edges: tuple[tuple[AutomatonEdge, ...], ...]
    marks: int

    def components(self) -> list[list[int]]:
        """The strongly connected components of its states, those that others lead to first."""
        return strongly_connected([[edge.target for edge in edges] for edges in self.edges])

    @property
    def is_empty(self) -> bool:
        """Whether it accepts no path at all: no cycle takes every mark."""
        for component in map(set, self.components()):
            inside = [edge for q in component for edge in self.edges[q] if edge.target in component]
            if inside and len(frozenset[int]().union(*(edge.marks for edge in inside))) == self.marks:
                return False
        return True

    @property
    def accepting_all(self) -> frozenset[int]:
        """States from which it accepts every path: by a loop that bears every mark and asks for nothing."""
        return frozenset(
            q
            for q, edges in enumerate(self.edges)
            if any(e.target == q and not e.literals and len(e.marks) == self.marks for e in edges)
        )


class _Cover(NamedTuple):
    """One way to satisfy some formulas: by this state, by the rest of the path, and what is put off."""

    literals: Literals
    left: frozenset[Formula]
    put_off: frozenset[Formula]

    def covers(self, other: _Cover) -> bool:
        """Whether this cover makes the other needless: it asks for no more and puts off no more."""
        return self.literals <= other.literals and self.left <= other.left and self.put_off <= other.put_off


class _Steps:
    """Counts what the construction of an automaton has cost."""

    def __init__(self) -> None:
        self._left = MAX_STEPS

    def spend(self, steps: int) -> None:
        self._left -= steps
        if self._left < 0:
            raise LimitError(
                f"the automaton of a formula on paths takes more than {MAX_STEPS:,} steps to build:"
                " the limit was hit"
            )


def translated(formula: Formula) -> Automaton:
    """The automaton of the paths that satisfy a formula.

    Args:
        formula: In normal form (:func:`mcpn.logic.ltl.formulas.normal`).

    Raises:
        LimitError: The automaton is too large, or takes too many steps.

    See Also:
        :func:`mcpn.logic.ltl.formulas.normal`: what is translated.
        :mod:`mcpn.logic.ltl.product`: where the automaton is run.
    """
    steps, start = _Steps(), _conjuncts(formula)
    numbers, queue = {start: 0}, [start]
    ways: list[list[_Cover]] = []
    for obligations in queue:
        ways.append(_ways(obligations, steps))
        for way in ways[-1]:
            if way.left not in numbers:
                numbers[way.left] = len(queue)
                queue.append(way.left)
        if len(queue) > MAX_STATES or sum(map(len, ways)) > MAX_EDGES:
            raise LimitError(
                f"the automaton of a formula on paths has more than {MAX_STATES} states or {MAX_EDGES} edges:"
                " the limit was hit"
            )
    untils = list(
        dict.fromkeys(
            f for ways_of_state in ways for way in ways_of_state for f in sorted(way.put_off, key=repr)
        )
    )
    edges = tuple(
        tuple(
            AutomatonEdge(
                way.literals,
                frozenset(i for i, until in enumerate(untils) if until not in way.put_off),
                numbers[way.left],
            )
            for way in ways_of_state
        )
        for ways_of_state in ways
    )
    return _reduced(Automaton(edges, len(untils)), steps)


def kept(automaton: Automaton, keep: Callable[[Literals], bool]) -> Automaton:
    """An automaton without the edges whose literals are not to be kept, and without states useless then."""
    edges = tuple(
        tuple(edge for edge in edges_of_state if keep(edge.literals)) for edges_of_state in automaton.edges
    )
    return _reduced(Automaton(edges, automaton.marks), _Steps())


def _conjuncts(formula: Formula) -> frozenset[Formula]:
    return frozenset(formula.operands if isinstance(formula, And) else (formula,))


def _ways(obligations: frozenset[Formula], steps: _Steps) -> list[_Cover]:
    """The covers of some formulas, without those that another cover makes needless.

    What leaves no choice comes first. A choice of which one alternative asks for nothing new takes that one:
    all covers of the others ask for more. A beginning that a cover makes needless is not gone on with.
    """
    covers: list[_Cover] = []
    nothing = frozenset[Formula]()
    begun = [(list(obligations), list[Formula](), nothing, _Cover(nothing, nothing, nothing))]
    while begun:
        todo, choices, done, way = begun.pop()
        steps.spend(_STEPS_OF_A_CHOICE)
        if todo:
            formula, *rest = todo
            if formula in done:
                begun.append((rest, choices, done, way))
                continue
            alternatives, done = _alternatives(formula, way), done | {formula}
            if len(alternatives) > 1:
                begun.append((rest, [*choices, formula], done, way))
            else:
                begun += [([*more, *rest], choices, done, then) for more, then in alternatives]
            continue
        steps.spend(len(covers))
        if any(known.covers(way) for known in covers):
            continue
        if choices:
            formula, *others = choices
            alternatives = _alternatives(formula, way)
            if any(
                then == way and all(_asks_nothing(f, way, done) for f in more) for more, then in alternatives
            ):
                begun.append(([], others, done, way))
            else:
                begun += [(more, others, done, then) for more, then in alternatives]
        else:
            covers = [known for known in covers if not way.covers(known)] + [way]
    return [way for way in covers if FALSE not in way.left]


def _asks_nothing(formula: Formula, way: _Cover, done: frozenset[Formula]) -> bool:
    """Whether what a cover asks for already satisfies a formula."""
    return formula in done or (isinstance(formula, Next) and _conjuncts(formula.operands[0]) <= way.left)


def _alternatives(formula: Formula, way: _Cover) -> list[tuple[list[Formula], _Cover]]:
    """The alternatives to satisfy a formula: what else the state must satisfy then, and the cover that grows.

    Those that ask for a literal come last: they are tried first, and make others needless.
    """
    match formula:
        case And(operands):
            return [([*operands], way)]
        case Or(operands):
            return [([operand], way) for operand in sorted(operands, key=is_of_paths, reverse=True)]
        case Next((operand,)):
            left = way.left | _conjuncts(operand)
            return [([], _Cover(way.literals, left - {TRUE}, way.put_off))]
        case Until((before, reach)):
            later = _Cover(way.literals, way.left | {formula}, way.put_off | {formula})
            return [([before], later), ([reach], way)]
        case Release((freed, held)):
            later = _Cover(way.literals, way.left | {formula}, way.put_off)
            return [([held], later), *([([freed, held], way)] if freed != FALSE else [])]
    if ~formula in way.literals:
        return []
    return [([], _Cover(way.literals | {formula}, way.left, way.put_off))]


def _reduced(automaton: Automaton, steps: _Steps) -> Automaton:
    """An automaton of the same language without useless states, bisimilar states merged."""
    while True:
        smaller = _merged(_useful(automaton), steps)
        if len(smaller.edges) == len(automaton.edges):
            return smaller
        automaton = smaller


def _useful(automaton: Automaton) -> Automaton:
    """Without states that accept nothing; marks stand where a cycle may take them, and no others."""
    accepting, component = set[int](), dict[int, int]()
    for number, states in enumerate(automaton.components()):
        component.update(dict.fromkeys(states, number))
        inside = [
            edge.marks for q in states for edge in automaton.edges[q] if component.get(edge.target) == number
        ]
        taken = frozenset[int]().union(*inside)
        onward = any(edge.target in accepting for q in states for edge in automaton.edges[q])
        if onward or (inside and len(taken) == automaton.marks):
            accepting.update(states)
    nothing = frozenset[int]()
    edges = tuple(
        tuple(
            AutomatonEdge(e.literals, e.marks if component[e.target] == component[q] else nothing, e.target)
            for e in edges_of_state
            if e.target in accepting
        )
        if q in accepting
        else ()
        for q, edges_of_state in enumerate(automaton.edges)
    )
    return Automaton(edges, automaton.marks)


def _merged(automaton: Automaton, steps: _Steps) -> Automaton:
    """States that cannot be told apart by their edges are one (bisimulation by refinement)."""
    blocks = [0] * len(automaton.edges)
    size = sum(map(len, automaton.edges))
    while True:
        steps.spend(size)
        looks = [
            (block, frozenset(AutomatonEdge(e.literals, e.marks, blocks[e.target]) for e in edges))
            for block, edges in zip(blocks, automaton.edges, strict=True)
        ]
        numbers: dict[object, int] = {}
        finer = [numbers.setdefault(look, len(numbers)) for look in looks]
        if len(numbers) == len(set(blocks)):
            break
        blocks = finer
    by_block = {block: q for q, block in reversed(list(enumerate(finer)))}
    reached = list(_reached(0, by_block, finer, automaton))
    number = {block: i for i, block in enumerate(reached)}
    edges = tuple(
        tuple(
            _needed(
                (
                    AutomatonEdge(e.literals, e.marks, number[finer[e.target]])
                    for e in automaton.edges[by_block[block]]
                ),
                steps,
            )
        )
        for block in reached
    )
    return Automaton(edges, automaton.marks)


def _reached(start: int, by_block: dict[int, int], blocks: list[int], automaton: Automaton) -> Iterator[int]:
    """The blocks that the block of a state leads to, itself first."""
    seen, queue = {blocks[start]: None}, [blocks[start]]
    for block in queue:
        yield block
        for edge in automaton.edges[by_block[block]]:
            if (after := blocks[edge.target]) not in seen:
                seen[after] = None
                queue.append(after)


def _needed(edges: Iterable[AutomatonEdge], steps: _Steps) -> Iterator[AutomatonEdge]:
    """Some edges of one state, each once, without those that another of them makes needless."""
    distinct = list(dict.fromkeys(edges))
    steps.spend(len(distinct) ** 2)

    def needless(e: AutomatonEdge) -> bool:
        return any(
            o != e and o.target == e.target and o.literals <= e.literals and o.marks >= e.marks
            for o in distinct
        )

    return (edge for edge in distinct if not needless(edge))
