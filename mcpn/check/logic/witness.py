"""Runs that show why a formula holds or fails.

An existential operator that holds is shown by a run: ``EX`` by a step, ``EU`` and ``EF`` by a shortest run,
``EG`` by a run into a cycle or to an end; and so is a universal one that fails. From where such a run leads,
what is inside the operator is shown next, as far as one run can go: a universal statement that holds, or a
second one of two that are needed, has no linear witness, and the note says so (Clarke, Veith,
*Counterexamples revisited*, 2003).
"""

from __future__ import annotations

from dataclasses import dataclass, field

from mcpn._kernel import Zdd
from mcpn.check.ctl import Evaluation
from mcpn.check.logic.formulas import (
    AF,
    AG,
    AX,
    EF,
    EG,
    EU,
    EX,
    And,
    Compare,
    Const,
    Core,
    Enabled,
    Fires,
    Formula,
    Justice,
    Not,
    Or,
    Sum,
    TokenBound,
    walk,
)
from mcpn.check.logic.language import show
from mcpn.net.formats.tina import quote
from mcpn.net.petri import Marking, PetriNet

MAX_WALK = 100_000

Step = tuple[tuple[int, ...], Marking]
"""The transitions of one edge, and the marking after them."""


@dataclass
class Witness:
    """A run from the initial state.

    Args:
        start: The marking that it starts from; on the alternatives graph the first stable one.
        steps: The edges of the run.
        cycle: Index of the step with which the part begins that is repeated for ever, if there is one.
        notes: What the run shows, and where showing stops.
    """

    start: Marking
    steps: list[Step] = field(default_factory=list)
    cycle: int | None = None
    notes: list[str] = field(default_factory=list)

    @property
    def end(self) -> Marking:
        """The last marking."""
        return self.steps[-1][1] if self.steps else self.start

    @property
    def cycle_firing(self) -> int | None:
        """Index of the firing with which the part begins that is repeated for ever, if there is one."""
        return None if self.cycle is None else sum(len(fired) for fired, _ in self.steps[: self.cycle])

    @property
    def firings(self) -> list[int]:
        """The transitions of the run, one after the other."""
        return [t for fired, _ in self.steps for t in fired]


def explain(evaluation: Evaluation, formula: Core) -> Witness:
    """Shows by a run why a formula holds, or fails, in the initial state.

    Args:
        evaluation: Of the formula on a graph.
        formula: Of the core.

    Returns:
        A witness or a counterexample. Runs to an ``EF`` are shortest; its cost is a breadth-first search in
        diagrams, back from what is reached.
    """
    graph = evaluation.graph
    (start,) = graph.initial
    witness = Witness(graph.space.encoding.marking(start))
    _Explanation(evaluation, witness).explain(formula, evaluation.holds(formula))
    return witness


class _Explanation:
    def __init__(self, evaluation: Evaluation, witness: Witness) -> None:
        self.evaluation = evaluation
        self.graph = evaluation.graph
        self.net: PetriNet = evaluation.graph.space.encoding.net
        self.witness = witness

    def explain(self, formula: Core, holds: bool) -> None:
        """Goes on with the run so that it shows the value of a formula where the run has come to."""
        match formula:
            case Not(operand):
                self.explain(operand, not holds)
            case And(operands) | Or(operands):
                self.explain_some(operands, holds, all_needed=isinstance(formula, And) == holds)
            case EX(operand) if holds:
                self.note("one step on", operand)
                self.go(self.evaluation.states(operand) & self.evaluation.fair_states)
                self.explain(operand, True)
            case EU(left, right) if holds:
                goal = self.evaluation.states(right) & self.evaluation.fair_states
                self.follow(self.evaluation.states(left), goal)
                if left != Const(True):
                    self.note("up to there", left)
                self.explain(right, True)
            case EG(operand) if holds:
                self.note("all along", operand)
                self.stay(operand)
            case EX() | EU() | EG():
                self.note("every run from here", Not(formula), "no single run shows it")
            case _:
                self.note("here", formula if holds else Not(formula))

    def explain_some(self, operands: tuple[Core, ...], holds: bool, *, all_needed: bool) -> None:
        """Shows an operand of the value wanted: the simplest, or the first of all where all are needed."""
        at = self.at(self.witness.end)
        shown = [o for o in operands if bool(at & self.evaluation.states(o)) == holds]
        if not shown:
            return
        if all_needed:
            temporal = [o for o in shown if _is_temporal(o)]
            for operand in shown:
                if operand not in temporal[:1]:
                    reason = "shown by a run of its own, not by this one" if operand in temporal else ""
                    self.note("here", operand if holds else Not(operand), reason)
            shown = temporal[:1]
        if shown:
            self.explain(min(shown, key=_is_temporal), holds)

    # --- runs ---

    def at(self, marking: Marking) -> Zdd:
        return self.graph.space.encoding.set_of(marking)

    def next_in(self, marking: Marking, allowed: Zdd) -> Step | None:
        """The first edge into a set."""
        for step in self.graph.successors(marking):
            if self.at(step[1]) & allowed:
                return step
        return None

    def go(self, allowed: Zdd) -> None:
        step = self.next_in(self.witness.end, allowed)
        assert step is not None, "evaluation said that there is such an edge"
        self.witness.steps.append(step)

    def follow(self, along: Zdd, goal: Zdd) -> None:
        """Takes a shortest run through a set into another."""
        here = self.at(self.witness.end)
        layers = [goal]
        seen = goal
        while not layers[-1] & here:
            nearer = (self.graph.before(layers[-1]) & along) - seen
            assert nearer, "evaluation said that there is such a run"
            seen |= nearer
            layers.append(nearer)
        for layer in reversed(layers[:-1]):
            self.go(layer)

    def stay(self, operand: Core) -> None:
        """Goes on inside a set for ever, or to an end."""
        evaluation, along = self.evaluation, self.evaluation.states(operand)
        if evaluation.fair:
            hull = evaluation.hull(along)
            self.follow(along, (along & evaluation.dead) | hull)
            if not self.at(self.witness.end) & evaluation.dead:
                self.go_round(hull)
            return
        inside = evaluation.states(EG(operand))
        seen: dict[Marking, int] = {}
        while self.witness.end not in seen:
            if len(seen) > MAX_WALK:
                self.witness.notes.append(
                    f"no state has come back within {MAX_WALK} steps: the run is cut here"
                )
                return
            seen[self.witness.end] = len(self.witness.steps)
            step = self.next_in(self.witness.end, inside)
            if step is None:
                self.witness.notes.append("here the run ends: nothing may fire")
                return
            self.witness.steps.append(step)
        self.witness.cycle = seen[self.witness.end]

    def go_round(self, hull: Zdd) -> None:
        """Takes a cycle that meets every constraint, further on where none leads back to where it began."""
        while True:
            begin, first = self.witness.end, len(self.witness.steps)
            for constraint in self.evaluation.fair:
                self.meet(constraint, hull)
            if len(self.witness.steps) == first:
                self.go(hull)
            home = self.at(begin)
            if self.at(self.witness.end) & self.graph.until(hull, home):
                self.follow(hull, home)
                self.witness.cycle = first
                return

    def meet(self, constraint: Justice, hull: Zdd) -> None:
        there = self.evaluation.plain.states(constraint.states) & hull
        if constraint.transitions and not there & self.at(self.witness.end):
            self.follow(hull, self.evaluation.met(constraint, hull))
            if self.at(self.witness.end) & there:
                return
            for step in self.graph.successors(self.witness.end):
                if step[0][0] in constraint.transitions and self.at(step[1]) & hull:
                    self.witness.steps.append(step)
                    return
        self.follow(hull, there)

    # --- words ---

    def note(self, where: str, formula: Core, reason: str = "") -> None:
        text = f"after step {len(self.witness.steps)}, {where}: {show(written(formula, self.net))}"
        self.witness.notes.append(f"{text} ({reason})" if reason else text)


def _is_temporal(formula: Core) -> bool:
    return any(isinstance(inside, EX | EU | EG) for inside, _ in walk(formula))


def written(formula: Core, net: PetriNet) -> Formula:
    """A formula of the core with names instead of indices, for a reader."""
    match formula:
        case TokenBound(((place, -1),), -1):
            return Compare(Sum(0, (net.places[place].name,)), ">=", Sum(1))
        case TokenBound(weights, bound):
            positive = tuple(net.places[p].name for p, w in weights for _ in range(w))
            negative = tuple(net.places[p].name for p, w in weights for _ in range(-w))
            return Compare(Sum(max(-bound, 0), positive), "<=", Sum(max(bound, 0), negative))
        case Fires(transitions):
            return Enabled(tuple(net.transitions[t].name for t in transitions))
        case Not(Not(a)):
            return written(a, net)
        case Not(EX(a)):
            return AX(written(Not(a), net))
        case Not(EG(a)):
            return AF(written(Not(a), net))
        case Not(EU(Const(True), a)):
            return AG(written(Not(a), net))
        case EU(Const(True), a):
            return EF(written(a, net))
        case Not(Const(value)):
            return Const(not value)
        case Not(a):
            return Not(written(a, net))
        case And(inside):
            return And(tuple(written(a, net) for a in inside))
        case Or(inside):
            return Or(tuple(written(a, net) for a in inside))
        case EX(a):
            return EX(written(a, net))
        case EG(a):
            return EG(written(a, net))
        case EU(a, b):
            return EU(written(a, net), written(b, net))
    return formula


def scenario(witness: Witness, net: PetriNet) -> str:
    """A witness as a firing sequence: names of transitions, as TINA's stepper writes them in ``.scn`` files.

    Args:
        witness: The run.
        net: Its net.

    Returns:
        A name a line, in braces where it holds anything but letters, digits, ``_`` and ``'``; comments after
        ``#`` say where a cycle begins.
    """
    lines, fired = [], 0
    for index, (transitions, _) in enumerate(witness.steps):
        if index == witness.cycle:
            lines.append("# from here on for ever")
        for t in transitions:
            lines.append(quote(net.transitions[t].name))
            fired += 1
    return "\n".join([*lines, ""])
