"""Questions about a net or a mission in temporal logic, answered by any engine on any of its graphs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from mcpn.check.logic.contest import Property
from mcpn.check.logic.evaluate import Evaluation
from mcpn.check.logic.formulas import Core, Formula, Justice
from mcpn.check.logic.language import parse
from mcpn.check.logic.resolve import progress, resolve
from mcpn.check.logic.witness import Witness, explain
from mcpn.check.nets.behaviour import examine
from mcpn.check.spaces import Engine, On, space_of
from mcpn.errors import InputError, UnsafeError
from mcpn.net.compose import MissionNet
from mcpn.net.petri import PetriNet
from mcpn.space.algebra import Space
from mcpn.space.diagrams import DiagramMarkings

PROGRESS = "progress"


@dataclass(frozen=True)
class Answer:
    """The answer to a formula.

    Args:
        formula: As it was written.
        holds: Whether the initial state satisfies it.
        witness: A run that shows why.
    """

    formula: str
    holds: bool
    witness: Witness


class Questions:
    """Answers questions about one net; the space is made once, when it is first needed.

    Args:
        net: The net.
        mission_net: The mission that it is of, if any.
        on: The graph that formulas speak of.
        fair: ``progress`` or formulas that hold again and again on the infinite paths that count.
        engine: Who makes the space: arrays, diagrams or composition.
        max_states: Limit on states that are listed one by one.

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
        self.max_states = max_states
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

    @cached_property
    def space(self) -> Space[Any]:
        """The space that formulas speak of; it raises what :func:`mcpn.check.spaces.space_of` does."""
        return space_of(
            self.net, self.mission_net, engine=self.engine, on=self.on, max_states=self.max_states
        )

    @cached_property
    def evaluation(self) -> Evaluation[Any]:
        """Evaluates formulas on the space, under the constraints."""
        return Evaluation(self.space, self.fair)

    def answer(self, text: str, core: Core) -> Answer:
        """Answers a formula, and shows by a run why.

        Args:
            text: The formula as it was written.
            core: The same, names looked up.
        """
        holds = self.evaluation.holds(core)
        return Answer(text, holds, explain(self.evaluation, core))

    def look_up(self, asked: Property) -> Core | dict[int, int]:
        """What a property of the contest asks, names looked up: a formula, or places with their weights.

        Raises:
            InputError: A name is unknown.
        """
        if asked.formula is not None:
            try:
                return self.core(asked.formula)
            except InputError as error:
                raise InputError.at(asked.source, f"{asked.name}: {error}") from error
        weights: dict[int, int] = {}
        for name in asked.bound:
            if name not in self.net.place_index:
                raise InputError.at(asked.source, f"no place is named {name}")
            place = self.net.place_index[name]
            weights[place] = weights.get(place, 0) + 1
        return weights

    def property(self, asked: Property) -> str:
        """Answers a property of the contest: TRUE, FALSE, or the bound asked for."""
        meant = self.look_up(asked)
        if isinstance(meant, dict):
            return str(largest(self.space, meant))
        return str(self.evaluation.holds(meant)).upper()

    def examination(self, name: str) -> str:
        """Answers an examination of the contest (see :func:`mcpn.check.nets.behaviour.examine`)."""
        try:
            return str(examine(name, self.space)).upper()
        except UnsafeError:
            if name == "OneSafe":
                return "FALSE"
            raise


def largest(space: Space[Any], weights: dict[int, int]) -> int:
    """The largest weighted sum of tokens in a state of a space; weights are not negative."""
    if isinstance(space, DiagramMarkings):  # in one pass over the diagram
        levels, always = space.encoding.weigh(weights)
        return space.everything.largest(levels) + always
    low, high = 0, sum(weights.values())
    while low < high:
        middle = (low + high) // 2
        if space.everything - space.at_most(weights, middle):
            low = middle + 1
        else:
            high = middle
    return low
