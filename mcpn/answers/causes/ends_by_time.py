"""How probable the ends of a mission are by a time, by uniformisation of the chain of the whole mission.

A chain that leaves its states at most ``q`` times an hour jumps like one that jumps ``q`` times an hour
everywhere, back to the same state where it would not have left. The jumps by a time are a Poisson number;
the state after a number of them is that of a chain of steps. Vanishing states take no time: what comes to
one is in the same step where it leads. No sum has a negative member, so that small probabilities keep their
digits.

Sources: Jensen, *Markoff chains as an aid in the study of Markoff processes*, 1953; Fox, Glynn, *Computing
Poisson probabilities*, CACM 31, 1988, for weights from the mode on; Boucheron, Lugosi, Massart,
*Concentration Inequalities*, 2013, section 2.2, for the tails.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from mcpn.answers.causes.factors import csc_array, csr_array, splu
from mcpn.answers.causes.linear_systems import Layers
from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.answers.causes.whole_chain import WholeChain, leading
from mcpn.errors import LimitError
from mcpn.spaces.markings.graph import Mask

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
        entries = among.tocoo()
        ways = entries.row.astype(np.intp), entries.col.astype(np.intp)
        layers = Layers(SparseMatrix(entries.data, *ways, entries.shape))
        around = np.union1d(*among.nonzero()).size
        depth = 1 + (around if layers.largest > 1 else max(len(layers.blocks) - 1, 0))
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
