"""Questions about a net or a mission, answered by either engine on either graph."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

from mcpn.check.arrays import ExplicitEvaluation
from mcpn.check.ctl import Evaluation, SymbolicAlternatives, SymbolicMarkings
from mcpn.check.logic.formulas import Core, Formula, Justice
from mcpn.check.logic.language import parse
from mcpn.check.logic.resolve import progress, resolve
from mcpn.check.logic.witness import Witness, explain
from mcpn.check.runs import Step, replay
from mcpn.errors import InputError
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.space.alternatives import by_reduction
from mcpn.space.confluence import prove_confluent
from mcpn.space.explicit import DEFAULT_MAX_STATES, explore
from mcpn.space.graph import StateGraph
from mcpn.space.symbolic import SymbolicSpace, reach

On: TypeAlias = Literal["markings", "alternatives"]
Engine: TypeAlias = Literal["auto", "symbolic", "explicit"]
PROGRESS = "progress"


@dataclass(frozen=True)
class Answer:
    """The answer to a formula.

    Args:
        formula: As it was written.
        holds: Whether the initial state satisfies it.
        witness: A run that shows it (symbolic engine only).
        told: The events of the run in mission words; empty for nets of no mission.
    """

    formula: str
    holds: bool
    witness: Witness | None = None
    told: tuple[Step, ...] = ()


class Questions:
    """Answers questions about one net; the state space is built once, when it is first needed.

    Args:
        net: The net.
        mission_net: The mission that it is of, if any.
        on: The graph that formulas speak of.
        fair: ``progress`` or formulas that hold again and again on the infinite paths that count.
        engine: Diagrams, arrays as the second opinion, or (``auto``) diagrams with a search before them.
        max_states: Limit for the explicit engine.

    Raises:
        InputError: A constraint is no formula, or the words do not fit the net.
    """

    def __init__(
        self,
        net: PetriNet,
        mission_net: MissionNet | None = None,
        *,
        on: On = "markings",
        fair: Sequence[str] = (),
        engine: Engine = "auto",
        max_states: int | None = None,
    ) -> None:
        if on == "alternatives" and not net.priorities:
            raise InputError.at(None, "the alternatives graph is of missions: this net has no priorities")
        self.net = net
        self.mission_net = mission_net
        self.on = on
        self.engine = engine
        self.max_states = max_states or DEFAULT_MAX_STATES
        self.fair = tuple(constraint for text in fair for constraint in self._constraints(text))

    def _constraints(self, text: str) -> tuple[Justice, ...]:
        if text != PROGRESS:
            return (Justice(self.core(parse(text))),)
        if self.mission_net is None:
            raise InputError.at(
                None, f"the constraint {PROGRESS} speaks of missions, and this net is of none"
            )
        return progress(self.mission_net)

    def core(self, formula: Formula) -> Core:
        """The formula with its names looked up.

        Raises:
            InputError: A name is unknown.
        """
        return resolve(formula, self.net, self.mission_net)

    @property
    def searchable(self) -> bool:
        """Whether reachability of a marking may be asked of a search: markings, no priorities, all paths."""
        return self.engine == "auto" and self.on == "markings" and not self.fair and not self.net.priorities

    @cached_property
    def space(self) -> SymbolicSpace:
        """The reachable markings as a diagram.

        Raises:
            UnsafeError: The net is not 1-safe.
            LimitError: A limit was hit.
        """
        return reach(self.net)

    @cached_property
    def symbolic(self) -> Evaluation:
        """Evaluates on diagrams.

        Raises:
            ConfluenceError: The alternatives graph is asked for, and internal evolution is not confluent.
            DivergenceError: The same, and internal evolution need not end.
        """
        if self.on == "markings":
            return Evaluation(SymbolicMarkings(self.space), self.fair)
        prove_confluent(self.net, max_states=self.max_states, space=self.space)
        return Evaluation(SymbolicAlternatives(self.space), self.fair)

    @cached_property
    def explicit(self) -> ExplicitEvaluation:
        """Evaluates on arrays.

        Raises:
            UnsafeError: The net is not 1-safe.
            ConfluenceError: As for :attr:`symbolic`.
            DivergenceError: As for :attr:`symbolic`.
            LimitError: A limit was hit.
        """
        graph: StateGraph = explore(self.net, max_states=self.max_states)
        return ExplicitEvaluation(by_reduction(graph) if self.on == "alternatives" else graph, self.fair)

    def answer(self, text: str, core: Core) -> Answer:
        """Answers a formula, and shows by a run why.

        Args:
            text: The formula as it was written.
            core: The same, names looked up.
        """
        if self.engine == "explicit":
            return Answer(text, self.explicit.holds(core))
        witness = explain(self.symbolic, core)
        names = [self.net.transitions[t].name for t in witness.firings]
        told = replay(self.mission_net, names) if self.mission_net else ()
        return Answer(text, self.symbolic.holds(core), witness, tuple(told))
