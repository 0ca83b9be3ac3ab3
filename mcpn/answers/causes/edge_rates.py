"""The rate of each edge of a chain: what solves the chain takes floats, what writes it exact fractions.

The model is that of :mod:`mcpn.answers.causes.risk`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from mcpn.nets.events import What
from mcpn.spaces.markings.graph import Mask

if TYPE_CHECKING:
    from mcpn.answers.causes.chain import ListedChain

Number: TypeAlias = float | Fraction


def decimal(value: float) -> Fraction:
    """The number that a file says: the decimal text of a float, not the binary fraction next to it.

    Examples:
        >>> decimal(0.1)
        Fraction(1, 10)
    """
    return Fraction(repr(float(value)))


class EdgeRates:
    """The rates of a chain's edges.

    Args:
        listed: The states and edges.
        rates: Failures per hour in service and repairs per hour out of service, of each of its resources.
        ending: By objective, its ends per hour while its success is possible, and the probability that such
            an end is a failure.
        demands: By resource, how probable it is that it fails on demand.
        number: Makes a number of the kind that the arguments are: :func:`decimal`, else it makes floats.

    Attributes:
        rates: By edge, 0 where it is never taken; of a state that is left in no time its weight.
        hasty: Vanishing states, left in no time: an objective that runs cannot succeed any more, or
            hardware may fail on demand at the entry.
        moving: Edges that are taken with some probability.
    """

    def __init__(
        self,
        listed: ListedChain,
        rates: Sequence[tuple[Number, Number]],
        ending: Sequence[tuple[Number, Number]],
        demands: Sequence[Number] = (),
        number: Callable[[float], Number] = float,
    ) -> None:
        self._listed, self._graph = listed, listed.graph
        kind = np.object_ if number is decimal else np.float64
        split = listed.split
        one: npt.NDArray[Any] = np.ones(1, kind)
        self._weights = one if split is None else split.weights(demands, kind)
        fails, back = np.array([*rates, (number(0.0), number(0.0))], kind).T
        events: npt.NDArray[Any] = np.array([number(rate) for rate in listed.occurring], kind)
        self.rates: npt.NDArray[Any] = (
            fails[listed.failing] + back[listed.repaired] + events[listed.interrupting]
        )
        failed = self._run_objectives(ending)
        sources = self._graph.sources
        self.hasty: Mask = np.zeros(self._graph.states, np.bool_)
        self.hasty[sources[failed]] = True
        self.rates[self.hasty[sources]] = number(0.0)
        self.rates[failed | listed.starting] = number(1.0)
        self.hasty[sources[listed.starting]] = True
        self.rates = self.rates * self._weights
        # An event after which all is as it was takes no part in the jumps.
        changing = listed.inside & (sources != self._graph.targets)
        self.moving: Mask = np.asarray(self.rates > 0, np.bool_) & changing
        self.rates[~self.moving] = number(0.0)

    def _run_objectives(self, ending: Sequence[tuple[Number, Number]]) -> Mask:
        """Gives rates to edges that end objectives; those of objectives that fail at once are returned."""
        listed, sources, targets = self._listed, self._graph.sources, self._graph.targets
        may_happen = ((self.rates > 0) | listed.ending) & (self._weights > 0)
        failed = np.zeros(self._graph.edges, np.bool_)
        objectives = listed.prospects.objectives.items()
        for (name, goal), (rate, failure) in zip(objectives, ending, strict=True):
            if goal.running:
                well, badly = listed.carrying(What.SUCCESS, name), listed.carrying(What.FAILURE, name)
                running, won, misused = goal.running.mask, goal.won.mask, listed.misused[name]
                self.rates[well] = rate * (1 - failure)
                self.rates[badly & won[sources]] = rate * failure
                self.rates[badly & misused[sources]] = rate
                # What ends the present run may lead back into the objective: that is another run.
                going_on = running[sources] & running[targets] & may_happen & ~listed.ending_run(goal)
                hopeful = self._graph.reaching(won | misused, np.asarray(going_on, np.bool_))
                failed |= badly & (running & ~hopeful)[sources]
        return failed
