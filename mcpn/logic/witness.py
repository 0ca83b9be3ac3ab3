"""Runs that show why a formula holds or fails, over any space of states.

A run shows an existential operator that holds: ``EX`` by a step, ``EU`` and ``EF`` by a short run, ``EG`` by
a run into a cycle or to an end; and in the same way a universal operator that fails. At the last state of
such a run, what is inside the operator is shown next, as far as one run can go: a universal statement that
holds, or the second of two statements that are needed, has no linear witness, and a note says so (Clarke,
Veith, *Counterexamples revisited*, 2003).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import field
from typing import Any, Generic, NamedTuple, Protocol

from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX, Justice, is_temporal
from mcpn.logic.ltl.formulas import SomePath
from mcpn.logic.writing import show
from mcpn.nets.petri import Marking, PetriNet
from mcpn.records import record
from mcpn.spaces.algebra import Edge, S
from mcpn.spaces.formula_names import Names
from mcpn.spaces.run import Run, transitions_of
from mcpn.spaces.search.goal import TRUE, And, Formula, Not, Or

MAX_WALK = 100_000


NEXT = "happens(e) holds in the state before e, of which e is the next event: X speaks of the state after it"
"""Says what a formula with events means, where a run shows it."""


class Note(NamedTuple):
    """What a run shows at one of its states.

    Args:
        step: After how many steps.
        where: Which part of the run shows it.
        formula: What is shown.
        reason: Why the run does not show all of it; empty where it does.
    """

    step: int
    where: str
    formula: Formula
    reason: str = ""


class Passed(Protocol):
    """What a run passes through: a space, or a net whose markings are fired one after the other."""

    @property
    def net(self) -> PetriNet:
        """The net."""

    def marking(self, state: Any) -> Marking:
        """The marking of a state that the run passes."""


class NoRun(Exception):
    """What is known does not tell the run that shows an answer."""


@record()
class Witness:
    """A run from the initial state, as it was found; names and words are made when they are asked for.

    Args:
        space: What it runs through.
        start: The state that it starts from.
        names: Names for a reader.
        settles: Whether its states are stable, so that internal evolution goes on to its end after each step.
        steps: Its edges.
        cycle: Index of the step with which the part begins that is repeated for ever, if there is one.
        decided: Whether the run alone shows what a path satisfies, however the path goes on.
        shown: What the run shows, and where showing stops.
    """

    space: Passed
    start: Any
    names: Names
    settles: bool = False
    steps: list[Edge] = field(default_factory=list)
    cycle: int | None = None
    decided: bool = False
    shown: list[Note | str] = field(default_factory=list)

    @property
    def end(self) -> Any:
        """The last state."""
        return self.steps[-1].target if self.steps else self.start

    @property
    def notes(self) -> list[str]:
        """What the run shows, for a reader."""
        notes = [note if isinstance(note, str) else self._words(note) for note in self.shown]
        return [*notes, NEXT] if any("happens(" in note for note in notes) else notes

    def _words(self, note: Note) -> str:
        text = f"{self.moment(note.step)}, {note.where}: {show(note.formula, self.names)}"
        return f"{text} ({note.reason})" if note.reason else text

    def moment(self, step: int) -> str:
        """The moment after some steps: by events, as runs are shown, where the net has events."""
        if not self.space.net.priorities:
            return f"after step {step}"
        events = [self.space.net.transitions[edge.transition].event is not None for edge in self.steps[:step]]
        later = next((back for back, event in enumerate(reversed(events)) if event), step)
        moment = f"after event {sum(events)}" if any(events) else "at the start"
        return f"{moment} and {later} internal firing{'s' * (later != 1)}" if later else moment

    @property
    def run(self) -> Run:
        """The run as firings of the net."""
        return self._run(self.steps)

    @property
    def repeated(self) -> list[int]:
        """The transitions of the part that is repeated for ever; none where the run ends."""
        return [] if self.cycle is None else [edge.transition for edge in self.steps[self.cycle :]]

    @property
    def cycle_firing(self) -> int | None:
        """Index of the firing with which the part begins that is repeated for ever, if there is one."""
        return None if self.cycle is None else len(self._run(self.steps[: self.cycle]).firings)

    @property
    def firings(self) -> Sequence[int]:
        """The transitions of the run, internal ones completed."""
        return self.run.firings

    def _run(self, steps: list[Edge]) -> Run:
        return Run(self.space.net, transitions_of(steps), settles=self.settles)


def explain(evaluation: Evaluation[S], formula: Formula, names: Names | None = None) -> Witness:
    """Shows by a run why a formula holds, or fails, in the initial state.

    Args:
        evaluation: Of the formula on a space. Runs to an ``EF`` are as short as the space's are.
        formula: The formula.
        names: Those that it was read with; the net's alone by default.
    """
    space = evaluation.space
    settles = space.net.priorities and not space.everything - space.stable
    witness = Witness(space, space.initial.pick(), names or Names(space.net), settles)
    _InSpace(evaluation, witness).explain(formula, evaluation.holds(formula))
    return witness


class Explanation(ABC):
    """Extends a run to demonstrate the value of a formula; subclasses say how paths are found.

    Args:
        witness: The run, extended in place.
    """

    def __init__(self, witness: Witness) -> None:
        self.witness = witness

    @abstractmethod
    def value(self, formula: Formula) -> bool | None:
        """Whether the last state of the run satisfies a formula; ``None`` where that is not known."""

    @abstractmethod
    def step(self, operand: Formula) -> None:
        """Appends an edge to a state that satisfies a formula."""

    @abstractmethod
    def reach(self, left: Formula, right: Formula) -> None:
        """Appends a path along the left formula to the right one."""

    @abstractmethod
    def stay(self, operand: Formula) -> None:
        """Appends a path along a formula that is endless or ends in a dead state."""

    @abstractmethod
    def show_path(self, formula: SomePath) -> None:
        """Appends a path that satisfies the operand, endless or ending in a dead state."""

    def explain(self, formula: Formula, holds: bool) -> None:
        """Extends the run to demonstrate the value of a formula at its last state."""
        match formula:
            case Not((operand,)):
                self.explain(operand, not holds)
            case And(operands) | Or(operands):
                self.explain_some(operands, holds, all_needed=isinstance(formula, And) == holds)
            case EX((operand,)) if holds:
                self.note("one step on", operand)
                self.step(operand)
                self.explain(operand, True)
            case EU((left, right)) if holds:
                self.reach(left, right)
                if left != TRUE:
                    self.note("up to there", left)
                self.explain(right, True)
            case EG((operand,)) if holds:
                self.note("all along", operand)
                self.stay(operand)
            case SomePath((path,)) if holds:
                self.note("along this run", path)
                self.show_path(formula)
            case EX() | EU() | EG() | SomePath():
                self.note("every run from here", ~formula, "no single run shows it")
            case _:
                self.note("here", formula if holds else ~formula)

    def explain_some(self, operands: tuple[Formula, ...], holds: bool, *, all_needed: bool) -> None:
        """Explains one operand of the wanted value; where all are needed, notes say so of the others."""
        shown = [o for o in operands if self.value(o) == holds]
        if len(shown) < (len(operands) if all_needed else 1):
            raise NoRun
        temporal = [o for o in shown if is_temporal(o)]
        onward = temporal[:1] if all_needed else sorted(shown, key=is_temporal)[:1]
        for operand in shown if all_needed else ():
            if operand not in onward:
                reason = "shown by a run of its own, not by this one" if operand in temporal else ""
                self.note("here", operand if holds else ~operand, reason)
        for operand in onward:
            self.explain(operand, holds)

    def note(self, where: str, formula: Formula, reason: str = "") -> None:
        """Says what the run shows at its last state."""
        self.witness.shown.append(Note(len(self.witness.steps), where, formula, reason))

    def show_rest(self, cycle: int | None, *, decided: bool) -> None:
        """Records how the path goes on behind the run: by a cycle, in any way (decided), or not at all."""
        self.witness.cycle, self.witness.decided = cycle, decided and cycle is None
        if cycle is None:
            end = (
                "that decides it, whatever comes later" if decided else "here the run ends: nothing may fire"
            )
            self.witness.shown.append(end)


class _InSpace(Explanation, Generic[S]):
    def __init__(self, evaluation: Evaluation[S], witness: Witness) -> None:
        super().__init__(witness)
        self.evaluation = evaluation
        self.space = evaluation.space

    def value(self, formula: Formula) -> bool:
        return self.at_end(self.evaluation.states(formula))

    def step(self, operand: Formula) -> None:
        self.go(self.evaluation.states(operand) & self.evaluation.fair_states)

    def reach(self, left: Formula, right: Formula) -> None:
        goal = self.evaluation.states(right) & self.evaluation.fair_states
        self.follow(self.evaluation.along(left), goal)

    def at_end(self, states: S) -> bool:
        """Whether the run has reached one of some states."""
        return bool(self.space.single(self.witness.end) & states)

    def go(self, allowed: S, transitions: Collection[int] | None = None) -> bool:
        """Appends the first edge into a set, of some transitions where they are given, if there is one."""
        for edge in self.space.edges(self.witness.end):
            wanted = transitions is None or edge.transition in transitions
            if wanted and self.space.single(edge.target) & allowed:
                self.witness.steps.append(edge)
                return True
        return False

    def follow(self, along: S | None, goal: S) -> None:
        """Appends a short path inside ``along`` to ``goal``."""
        run = self.space.run(self.witness.end, goal, along)
        assert run is not None, "evaluation said that there is such a run"
        self.witness.steps += run

    def stay(self, operand: Formula) -> None:
        """Appends an endless path inside a set, or one to a dead state."""
        evaluation, along = self.evaluation, self.evaluation.states(operand)
        if evaluation.fair:
            hull = evaluation.hull(along)
            self.follow(along, (along & self.space.dead) | hull)
            if not self.at_end(self.space.dead):
                self.go_round(next(r & hull for r in self.space.regions if self.at_end(r)))
            return
        inside = evaluation.states(EG(operand))
        seen: dict[Marking, int] = {}
        while (here := self.space.marking(self.witness.end)) not in seen:
            if len(seen) > MAX_WALK:
                cut = f"no state has come back within {MAX_WALK} steps: the run is cut here"
                self.witness.shown.append(cut)
                return
            seen[here] = len(self.witness.steps)
            if not self.go(inside):
                self.show_rest(None, decided=False)
                return
        self.witness.cycle = seen[here]

    def show_path(self, formula: SomePath) -> None:
        """Appends an accepted path of the product with the formula's automaton."""
        from mcpn.logic.ltl.lasso import Lasso

        begin = len(self.witness.steps)
        lasso = Lasso(self.evaluation.product(formula), self.witness.end)
        self.witness.steps += lasso.steps
        self.show_rest(None if lasso.cycle is None else begin + lasso.cycle, decided=lasso.decided)

    def go_round(self, hull: S) -> None:
        """Appends a cycle that meets every constraint; where none leads back, begins again further on."""
        while True:
            begin, first = self.witness.end, len(self.witness.steps)
            for constraint in self.evaluation.fair:
                self.meet(constraint, hull)
            if len(self.witness.steps) == first:
                self.go(hull)
            back = self.space.run(self.witness.end, self.space.single(begin), hull)
            if back is not None:
                self.witness.steps += back
                self.witness.cycle = first
                return

    def meet(self, constraint: Justice, hull: S) -> None:
        """Appends a path inside the hull to where a constraint is met."""
        self.follow(hull, self.evaluation.met(constraint, hull))
        if not self.at_end(self.evaluation.plain.states(constraint.states)):
            self.go(hull, constraint.transitions)


def scenario(witness: Witness) -> str:
    """A witness as a firing sequence, as TINA's stepper writes them in ``.scn`` files.

    Returns:
        The name of a transition a line, in braces where it holds anything but letters, digits, ``_`` and
        ``'``; a comment after ``#`` says where a cycle begins.
    """
    from mcpn.nets.formats.tina import quote

    lines = [quote(witness.space.net.transitions[t].name) for t in witness.firings]
    if witness.cycle_firing is not None:
        lines.insert(witness.cycle_firing, "# from here on for ever")
    return "\n".join([*lines, ""])
