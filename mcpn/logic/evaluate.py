"""CTL* over any space of states: the set of states that satisfy a formula.

``EX``, ``EU`` and ``EG`` are one step back, backward reachability along a set, and the states from which a
maximal run stays in a set; each space has its own algorithms for these (:mod:`mcpn.spaces.algebra`). What is
said of whole paths is asked of the product with an automaton (:mod:`mcpn.logic.ltl.product`). Fair
states are found as Emerson and Lei do (*Efficient model checking in fragments of the propositional
mu-calculus*, LICS 1986), in one region of the space after the other, since a cycle never leaves its region.

Paths are maximal: infinite, or ending in a state without successors, as in the Model Checking Contest.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, reduce
from itertools import count
from operator import and_, or_
from typing import TYPE_CHECKING, Any, Generic

from mcpn.logic.formulas import EG, EU, EX, Justice
from mcpn.logic.ltl.formulas import SomePath
from mcpn.spaces.algebra import S, Space, by_region
from mcpn.spaces.search.goal import TRUE, And, AtMost, Deadlock, Fires, Formula, Not, Or, Stable

if TYPE_CHECKING:
    from mcpn.logic.ltl.product import Product


class Evaluation(Generic[S]):
    """Evaluates formulas on one space; each sub-formula is evaluated once.

    Args:
        space: The space.
        fair: Justice constraints: infinite paths that meet one of them only finitely often do not count.
    """

    first_steps = 8
    """How often states without a successor are left out of a fair hull one step at a time, not altogether."""

    def __init__(self, space: Space[S], fair: Sequence[Justice] = ()) -> None:
        self.space = space
        self.fair = tuple(fair)
        self._known: dict[Formula, S] = {}
        self._begins: dict[SomePath, bool] = {}  # whether such a path begins in the initial state
        self._products: dict[SomePath, Product[S]] = {}
        self.plain: Evaluation[S] = Evaluation(space) if fair else self
        """Evaluates the constraints themselves, whose operators speak of all paths."""

    def holds(self, formula: Formula) -> bool:
        """Whether the initial state satisfies a formula; evaluates no more than this takes."""
        match formula:
            case Not((operand,)):
                return not self.holds(operand)
            case And(operands) | Or(operands):
                values = map(self.holds, sorted(operands, key=_effort))
                return all(values) if isinstance(formula, And) else any(values)
            case EU((And(()), right)):  # every state is reachable
                return bool(self.states(right) & self.fair_states)
            case EG((operand,)) if not self.fair and formula not in self._known:
                initial = self.space.initial
                return bool(initial & self.space.staying(self.states(operand), initial))
            case SomePath() if formula not in self._known:
                if formula not in self._begins:
                    product, initial = self.product(formula), self.space.initial
                    accepted = product.accepted(product.reached(initial)) if product.edges else {}
                    self._begins[formula] = bool(initial & accepted.get(0, self.space.nothing))
                return self._begins[formula]
        return bool(self.space.initial & self.states(formula))

    def states(self, formula: Formula) -> S:
        """The states that satisfy a formula."""
        if formula not in self._known:
            self._known[formula] = self._evaluate(formula)
        return self._known[formula]

    def _evaluate(self, formula: Formula) -> S:
        space = self.space
        match formula:
            case Not((operand,)):
                return space.everything - self.states(operand)
            case And(operands):
                return reduce(and_, map(self.states, operands), space.everything)
            case Or(operands):
                return reduce(or_, map(self.states, operands), space.nothing)
            case AtMost(weights, -1) if all(weight == -1 for _, weight in weights):
                return space.marked([place for place, _ in weights])
            case AtMost(weights, bound):
                return space.at_most(dict(weights), bound)
            case Fires(transitions):
                return space.enabling(transitions)
            case Deadlock():
                return space.dead
            case Stable():
                return space.stable
            case EX((operand,)):
                return space.before(self.states(operand) & self.fair_states)
            case EU((left, right)):
                return space.reaching(self.states(right) & self.fair_states, self.along(left))
            case EG((operand,)):
                return self._always(self.states(operand))
            case SomePath():
                return self.product(formula).accepted().get(0, space.nothing)
        raise TypeError(f"no formula: {formula!r}")

    def product(self, formula: SomePath) -> Product[S]:
        """The space beside the automaton of what some path is to satisfy."""
        from mcpn.logic.ltl.automaton import translated
        from mcpn.logic.ltl.product import Constraint, Product

        if formula not in self._products:
            fair = [Constraint(self.plain.states(c.states), c.transitions) for c in self.fair]
            automaton = translated(formula.operands[0])
            self._products[formula] = Product(self.space, automaton, self.states, fair)
        return self._products[formula]

    def along(self, formula: Formula) -> S | None:
        """The states that a run may pass; ``None``, which every space answers quicker, for all of them."""
        return None if formula == TRUE else self.states(formula)

    @cached_property
    def fair_states(self) -> S:
        """States from which some fair path begins; all of them where there are no constraints."""
        return self._always(self.space.everything) if self.fair else self.space.everything

    def _always(self, along: S) -> S:
        """States from which some fair path stays in a set."""
        if not self.fair:
            return self.space.staying(along)
        return self.space.reaching((along & self.space.dead) | self.hull(along), along)

    def hull(self, along: S) -> S:
        """The fair hull of a set: each of its states begins an endless fair path that stays in the hull.

        It holds every cycle of the set that meets all constraints, and what leads from one such cycle to
        another in the same region.
        """
        fair = self.space.nothing
        unmet = [(c, self.plain.states(~c.states)) for c in self.fair]
        for region, constraints in by_region(self.space, unmet):
            inside = along & region
            if inside:
                fair = fair | self._hull_of(inside, constraints)
        return fair

    def _hull_of(self, inside: S, constraints: Sequence[Justice]) -> S:
        """The states from which a fair run stays inside: a greatest fixpoint (Emerson, Lei 1986).

        In each round, states without a successor in the set are dropped, then, for each constraint, those
        from which no state that meets it is reached within the set. The second step starts from the states
        that do not meet the constraint: in a composite these lie in few sections.
        """
        space, fair = self.space, inside
        for step in count():
            if step < self.first_steps:
                narrower = space.before(fair, among=fair)
            else:
                narrower = space.staying(fair - space.dead)
            for constraint in constraints:
                waiting = narrower & self.plain.states(~constraint.states)
                if not waiting:
                    continue
                onward = space.after(waiting) & narrower
                meeting = space.before(onward - waiting, among=waiting)
                if constraint.transitions:
                    meeting = meeting | space.before(onward, constraint.transitions, among=waiting)
                stuck = waiting - space.reaching(meeting, waiting)
                if stuck:
                    narrower = narrower - stuck
            if not fair - narrower:
                break
            fair = narrower
        return fair

    def met(self, constraint: Justice, inside: S) -> S:
        """States of a set at which a constraint is met, there or by the next step inside the set."""
        here = self.plain.states(constraint.states) & inside
        if constraint.transitions:
            here = here | self.space.before(inside, constraint.transitions, among=inside)
        return here


def _effort(formula: Formula) -> int:
    """How much a formula takes: operators that need a fixpoint count most."""
    costs: dict[type, int] = {SomePath: 1000, EG: 100, EU: 10, EX: 10}
    return sum(costs.get(type(inside), 1) for inside in formula.walk())


def largest(space: Space[Any], weights: dict[int, int]) -> int:
    """The largest weighted sum of tokens in a state of a space; weights are not negative."""
    from mcpn.spaces.diagrams.spaces import DiagramMarkings

    if isinstance(space, DiagramMarkings):  # in one pass over the diagram
        levels, constant = space.encoding.weigh(weights)
        return space.everything.largest(levels) + constant
    from mcpn.spaces.arrays import ArraySpace  # which loads NumPy: that takes longer than a small net

    if isinstance(space, ArraySpace):
        return int(space.graph.tokens(weights).max())
    low, high = 0, sum(weights.values())  # any other space is of a 1-safe net
    while low < high:
        middle = (low + high) // 2
        if space.everything - space.at_most(weights, middle):
            low = middle + 1
        else:
            high = middle
    return low
