"""Bounds on the ends of a mission whose rates are known as intervals.

Each rate may lie anywhere in its interval. Here it may even change from moment to moment and depend on all
that has happened: what holds then holds of every constant choice, so that the bounds are true, though they
need not be the least. The largest probability of an end is the least solution of ``x = max T x``, where in
each state an edge has its highest rate if it leads to where the end is more probable, else its lowest.
Policies are improved until none is better (Howard).

Floats do not prove that. So the solution is enlarged a little, until one sees state by state, with what
floats may lose, that no choice leads above it; then by induction none ever does. The same is done for the
lowest. There the mission must leave its states in the end whatever the rates are; it does, for an interval
begins above 0, so that the edges are always the same.

Sources: Howard, *Dynamic programming and Markov processes*, 1960; Givan, Leach, Dean, *Bounded-parameter
Markov decision processes*, Artificial Intelligence 122, 2000; Hartmanns, Kaminski, *Optimistic value
iteration*, CAV 2020, for the proof by enlargement.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

import networkx as nx
import numpy as np

from mcpn.answers.causes.linear_systems import Floats, csc_array, csr_array, splu
from mcpn.answers.causes.prospects import Prospects
from mcpn.answers.causes.whole_chain import WholeChain, leading, whole_chain
from mcpn.errors import LimitError
from mcpn.spaces.markings.graph import Mask

MOST_ROUNDS = 100
"""Improvements of a policy; a few are usual."""

ENLARGED = 10.0 ** np.arange(-13, -4)
"""How much, relative to itself, a solution is enlarged to prove it: the first that is enough."""


def bounds(prospects: Prospects[Any], max_states: int | None = None) -> Mapping[str, tuple[float, float]]:
    """Bounds on the probability of each end that hold for every choice of rates in their intervals.

    Args:
        prospects: The mission on its alternatives graph.
        max_states: Limit on its stable states, which are listed.

    Raises:
        InputError: An objective that may run has no duration.
        LimitError: There are too many states, or no bounds could be proved.
    """
    low = whole_chain(prospects, max_states, lambda rate: getattr(rate, "low", rate))
    high = whole_chain(prospects, max_states, lambda rate: getattr(rate, "high", rate))
    found = dict[str, tuple[float, float]]()
    for end, goal in low.ends.items():
        least, most = (_proved(low, high, goal, up=up) for up in (False, True))
        found[end] = max(0.0, least), min(1.0, most)
    return found


def _proved(low: WholeChain, high: WholeChain, goal: Mask, *, up: bool) -> float:
    """A bound on the probability of some states, from the first state."""
    states, sources, targets = low.states, low.sources, low.targets
    # From elsewhere the probability is 0 whatever the rates are.
    inner = np.flatnonzero(leading(low, goal) & ~low.ended)
    if not len(inner) or inner[0] != 0:
        return float(goal[0])
    number = np.full(states, -1, np.int64)
    number[inner] = np.arange(len(inner))

    def best(values: Floats) -> Floats:
        """The rates that make the values larger, or smaller, in one step."""
        better = values[targets] > values[sources]
        return np.where(better == up, high.rates, low.rates).astype(np.float64)

    def after(rates: Floats, values: Floats) -> Floats:
        """The values after one step at some rates."""
        leaving = np.bincount(sources, rates, states)
        gained = np.bincount(sources, rates * values[targets], states)
        return np.asarray(gained[inner] / leaving[inner])

    def solved(rates: Floats) -> tuple[Floats, Floats]:
        """The probabilities at some rates; and their sum over all further steps."""
        share = rates / np.bincount(sources, rates, states)[sources]
        among = (number[sources] >= 0) & (number[targets] >= 0)
        ways = number[sources[among]], number[targets[among]]
        step = csr_array((share[among], ways), shape=(len(inner),) * 2)
        identity = csr_array((np.ones(len(inner)), (range(len(inner)),) * 2), shape=step.shape)
        solve = splu(csc_array(identity - step)).solve
        values, total = goal.astype(np.float64), np.zeros(states)
        values[inner] = solve(after(rates, goal.astype(np.float64)))
        total[inner] = solve(values[inner])
        return values, total

    rates = np.sqrt(low.rates * high.rates)
    for _ in range(MOST_ROUNDS):
        values, total = solved(rates)
        now, rates = rates, best(values)
        change = after(rates, values) - after(now, values)
        if np.all(np.abs(change) <= 1e-14 * values[inner]):
            break
    most = int(np.bincount(sources).max())
    for enlarged in ENLARGED:
        tried = values + enlarged * total if up else values - enlarged * total
        # What is compared is off by sums over as many edges as a state has, and by rates that are rounded.
        lost = (2 * most + 16) * 2.0**-53 * np.abs(tried[inner])
        beyond = after(best(tried), tried) - tried[inner]
        if np.all((beyond if up else -beyond) <= -lost) and np.all(tried >= 0):
            return float(tried[0])
    raise LimitError(f"no bounds could be proved: rates of {states} states differ too much for floats")


# How much success changes with the failure rate of each resource: the derivative of its probability.
#
# Birnbaum importance compares a resource that never fails with one that is lost from the start. The
# derivative asks what a little more or less reliability changes, where repairs and the time of use count.
# From one state to the next the probability of what remains changes by the difference of the two; the
# derivative is the sum of these differences over the failures of the resource, each times the hours that the
# mission is expected to spend in the state before it. Both come from one system of linear equations and its
# transpose.
#
# Source: Birnbaum, *On the importance of different components in a multicomponent system*, 1969; Cao, Chen,
# *Perturbation realization, potentials, and sensitivity analysis of Markov processes*, 1997.

MOST_STATES_OF_SLOPES = 100_000
"""Stable states of a mission whose derivatives are computed beside its numbers of risk."""


def slopes_of(prospects: Prospects[Any], max_states: int | None = None) -> Mapping[str, float] | None:
    """The derivatives of a mission (:func:`slopes`); ``None`` of one with too many states for them.

    Args:
        prospects: The mission on its alternatives graph.
        max_states: Stable states that it may have; never more than :data:`MOST_STATES_OF_SLOPES`.
    """
    limit = MOST_STATES_OF_SLOPES if max_states is None else min(max_states, MOST_STATES_OF_SLOPES)
    if prospects.space.everything.count() > limit:
        return None
    return slopes(whole_chain(prospects, limit))


def slopes(chain: WholeChain) -> Mapping[str, float]:
    """The derivative of the probability of success by the failure rate of each resource that has one.

    Args:
        chain: The mission's chain, its rates floats.

    Returns:
        By hardware, for one more failure per hour.
    """
    ends = chain.ended
    inner = np.flatnonzero(leading(chain, ends) & ~ends)
    leaving = np.bincount(chain.sources, chain.rates, chain.states)
    step = chain.rates / leaving[chain.sources]
    jumps = csr_array((step, (chain.sources, chain.targets)), shape=(chain.states, chain.states))[inner]
    among = jumps[:, inner]
    identity = csr_array((np.ones(len(inner)), (range(len(inner)),) * 2), shape=among.shape)
    factors = splu(csc_array(identity - among)) if len(inner) else None

    def reaching(goal: Mask) -> Floats:
        """How probable some ends are, by state."""
        found = goal.astype(np.float64)
        if factors is not None:
            found[inner] = factors.solve(np.asarray(jumps @ found))
        return found

    hours = np.zeros(chain.states)
    if factors is not None and inner[0] == 0:
        visits = splu(csc_array((identity - among).T)).solve(np.eye(1, len(inner))[0])
        hours[inner] = np.where(chain.hasty[inner], 0.0, visits / leaving[inner])
    # Where the mission is sure to end, success is lost by the other ends, which keep the digits when rare.
    sure = len(inner) + np.count_nonzero(ends) == chain.states
    gained = -reaching(ends & ~chain.ends["success"]) if sure else reaching(chain.ends["success"])
    found = dict[str, float]()
    rates = {h.name: h.failure_rate for h in chain.mission_net.mission.hardware}
    for number, name in enumerate(chain.hardware):
        if rate := rates[name]:
            own = chain.failing == number
            sources, targets = chain.sources[own], chain.targets[own]
            share = hours[sources] * chain.rates[own] / rate
            found[name] = float(share @ (gained[targets] - gained[sources]))
    return found


# How probable the ends of a mission are by a time, by uniformisation of the chain of the whole mission.
#
# A chain that leaves its states at most ``q`` times an hour jumps like one that jumps ``q`` times an hour
# everywhere, back to the same state where it would not have left. The jumps by a time are a Poisson number;
# the state after a number of them is that of a chain of steps. Vanishing states take no time: what comes to
# one is in the same step where it leads. No sum has a negative member, so that small probabilities keep their
# digits.
#
# Sources: Jensen, *Markoff chains as an aid in the study of Markoff processes*, 1953; Fox, Glynn, *Computing
# Poisson probabilities*, CACM 31, 1988, for weights from the mode on; Boucheron, Lugosi, Massart,
# *Concentration Inequalities*, 2013, section 2.2, for the tails.

MOST_STEPS = 300_000
"""Steps of the uniformised chain that are done; a mission that has ended by then needs no more."""

TAIL = 1e-12
"""How probable numbers of jumps may be, together, that are left out."""

SETTLED = 1e-12
"""How probable it may be that the mission has not ended, where no further step is done."""

ROUNDING = 2.0**-53


@dataclass(frozen=True)
class Within:
    """The ends of a mission by a time.

    Args:
        hours: The time.
        success: Probability that the mission has ended in success.
        failure: The same of failure.
        abort: The same of abort; ``None`` of a mission that cannot abort.
        error: A bound on the error of each, absolute.
        steps: Steps of the uniformised chain that were done.
    """

    hours: float
    success: float
    failure: float
    abort: float | None
    error: float
    steps: int


class Jumps(NamedTuple):
    """Poisson probabilities of numbers of jumps; those of other numbers are together at most ``TAIL``."""

    first: int
    weights: Floats


def within(chain: WholeChain, hours: float) -> Within:
    """The probability of each end of a mission by a time.

    Args:
        chain: The mission's chain, its rates floats.
        hours: The time since the start of the mission.

    Raises:
        LimitError: The chain is so stiff, and the time so long, that there are too many steps.
    """
    uniform = Uniform(chain)
    jumps = poisson(uniform.fastest * hours)
    last = jumps.first + len(jumps.weights) - 1
    found, now, left, done, unsettled = dict.fromkeys(chain.ends, 0.0), uniform.begin, 1.0, 0, 0.0
    for done in range(last + 1):
        unsettled = float(now[uniform.undecided].sum())
        settled = unsettled <= SETTLED
        weight = left if settled else float(jumps.weights[done - jumps.first]) if done >= jumps.first else 0.0
        left -= weight
        for name, states in chain.ends.items():
            found[name] += weight * float(now[states].sum())
        if settled:
            break
        if done == MOST_STEPS:
            raise LimitError(
                f"{hours:g} hours are {last} steps of uniformisation, for some state is left "
                f"{uniform.fastest:g} times an hour: the limit is {MOST_STEPS} steps"
            )
        now = uniform.onward(now)
    error = (
        2 * TAIL
        + uniform.rounding * (done + 1)
        + ROUNDING * len(chain.sources)
        + (unsettled if unsettled <= SETTLED else 0.0)
    )
    return Within(hours, found["success"], found["failure"], found.get("abort"), error, done)


def poisson(mean: float) -> Jumps:
    """Probabilities of numbers of jumps, made to sum up to 1.

    Args:
        mean: The expected number.
    """
    log = math.log(2 / TAIL)
    first = max(0, math.floor(mean - math.sqrt(2 * mean * log)))
    last = math.ceil(mean + log / 3 + math.sqrt(log * log / 9 + 2 * mean * log))
    mode = max(first, math.floor(mean))
    below = np.cumprod(np.arange(mode, first, -1) / mean) if mode > first else np.ones(0)
    above = np.cumprod(mean / np.arange(mode + 1, last + 1))
    weights = np.concatenate([below[::-1], [1.0], above])
    return Jumps(first, weights / math.fsum(weights))


class Uniform:
    """The uniformised chain.

    Args:
        chain: The mission's chain.

    Attributes:
        fastest: Its jumps per hour.
        begin: The probabilities of states at the start.
        undecided: States that some run leads to an end, and that are none.
        rounding: A bound on what floats lose in each step, of all probability.
    """

    def __init__(self, chain: WholeChain) -> None:
        size, hasty = chain.states, chain.hasty
        slow = ~hasty[chain.sources]
        leaving = np.bincount(chain.sources[slow], chain.rates[slow], size)
        self.fastest = float(leaving.max())
        share = np.where(slow, chain.rates / (self.fastest or 1.0), chain.rates).astype(np.float64)
        self._stay: Floats = np.where(hasty, 0.0, 1.0 - leaving / (self.fastest or 1.0))
        self._step = self._onto(chain, share, slow)
        ends = chain.ended
        self.undecided: Mask = leading(chain, ends) & ~ends
        # What never leaves the vanishing states again never ends, and is left out.
        self._quick = np.flatnonzero(hasty & leading(chain, ~hasty))
        self._out = self._onto(chain, share, ~slow)
        among = self._out[self._quick][:, self._quick]
        identity = csr_array((np.ones(len(self._quick)), (range(len(self._quick)),) * 2), shape=among.shape)
        self._within = splu(csc_array(identity - among)).solve if len(self._quick) else None
        graph: nx.DiGraph[int] = nx.DiGraph(zip(*(at.tolist() for at in among.nonzero()), strict=True))
        groups = [len(group) for group in nx.strongly_connected_components(graph)]
        depth = 1 + sum(groups) if max(groups, default=1) > 1 else 1 + nx.dag_longest_path_length(graph)
        # An edge to an end is taken once in a run, so that rounding there is no matter of each step.
        most = int(np.bincount(chain.targets[~ends[chain.targets]], minlength=size).max())
        self.rounding = ROUNDING * (most + 4) * (depth + 1)
        first = np.zeros(size)
        first[0] = 1.0
        self.begin = self._settled(first)

    @staticmethod
    def _onto(chain: WholeChain, share: Floats, edges: Mask) -> csr_array:
        """By state and state before it, the probability of the edges between them."""
        ways = chain.targets[edges], chain.sources[edges]
        return csr_array((share[edges], ways), shape=(chain.states, chain.states))

    def onward(self, now: Floats) -> Floats:
        """The probabilities of states after one more step."""
        return self._settled(np.asarray(self._step @ now + self._stay * now))

    def _settled(self, now: Floats) -> Floats:
        """What has come to vanishing states, where it leads at once."""
        if self._within is None or not now[self._quick].any():
            return now
        through = np.zeros(len(now))
        through[self._quick] = self._within(now[self._quick])
        after = np.asarray(now + self._out @ through)
        after[self._quick] = 0.0
        return after
