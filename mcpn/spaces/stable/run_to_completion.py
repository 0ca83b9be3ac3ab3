"""Run to completion: from a stable marking through an event to the next one, in the kernel.

Internal transitions fire in one order, which is sound where internal evolution is confluent, or in enough
orders to prove that it is. In a marking where one transition commutes with everything that may fire before
it, only that one is fired (*stubborn sets*, Valmari 1989; ``papers/mcpn.md``, Proposition 3). Elsewhere
every enabled one is, depth first, and the kernel keeps the one stable end of each marking
(``kernel/src/markings/settling.hpp``).

Exploration stops at an unsafe firing, at a firing that closes a cycle, and at a marking two of whose
transitions lead to different ends. All markings after these two were explored before, and each has one end:
so the two transitions decide the outcome, and the error names them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

from mcpn._kernel import Exploration, MemoryLimit, StateLimit
from mcpn.errors import ConfluenceError, DivergenceError, LimitError, SemanticsError
from mcpn.nets.petri import PetriNet
from mcpn.spaces.markings.explicit import DEFAULT_MAX_MEMORY, KernelNet
from mcpn.spaces.markings.masked import MaskedNet, mask_of, unsafe_after
from mcpn.spaces.run import Completion
from mcpn.spaces.stable.decisive_conflict import parting_runs
from mcpn.steps import telling

PROOF_BY_MARKINGS = (
    "behind each event enough orders of internal transitions explored; all have one stable end"
)

Orders: TypeAlias = Literal["one", "enough", "every"]

MAX_STABLE_STATES = 5_000_000
"""Stable states that an alternatives graph may have."""

LEAST_TRANSIENT = 100_000
TRANSIENT_OF_A_STATE = 100
"""How many transient markings the proof may explore: that many, or so many for each stable state allowed."""

MOST_ENDS = 200_000
"""Stable markings that may be found behind one event while its error is looked for."""

MOST_LISTED = 20_000
"""Transient markings behind one event that are listed to find the nearest at which runs part."""


def settled(
    prepared: KernelNet,
    marking: Sequence[int] | None = None,
    *,
    orders: Orders,
    max_states: int,
    max_transient: int | None = None,
    max_firings: int | None = None,
) -> Exploration:
    """Runs events to completion, from stable marking to stable marking, in the kernel.

    Args:
        prepared: A net with priorities.
        marking: Where it begins; by default the initial marking.
        orders: In which orders internal transitions fire behind an event: in one; in enough of them to prove
            that all have one end; or in every one, which tests judge the former by.
        max_states: How many stable markings there may be.
        max_transient: How many markings between them may be kept; by default a hundred times as many, and
            100,000 at least.
        max_firings: How many firings there may be, internal ones included; by default any number.

    Returns:
        Stable markings and events, or why the proof has failed.

    Raises:
        LimitError: A limit was hit.
    """
    begin = prepared.initial if marking is None else [p for p, tokens in enumerate(marking) if tokens]
    most = max(TRANSIENT_OF_A_STATE * max_states, LEAST_TRANSIENT) if max_transient is None else max_transient
    try:
        limits = (max_states, most, DEFAULT_MAX_MEMORY)
        if max_firings is None:
            return prepared.kernel.settle(begin, orders, *limits, telling())
        return prepared.kernel.settle(begin, orders, *limits, telling(), max_firings)
    except (StateLimit, MemoryLimit) as error:
        raise LimitError(str(error)) from error


def judged(prepared: KernelNet, max_states: int, max_firings: int | None = None) -> Exploration:
    """Runs events to completion in enough orders of internal transitions to judge all.

    Args:
        prepared: A net with priorities.
        max_states: How many stable markings there may be.
        max_firings: As of :func:`settled`.

    Returns:
        Stable markings and events: each event has one outcome.

    Raises:
        ConfluenceError: Two interleavings end in different stable markings.
        DivergenceError: An internal run need not end.
        UnsafeError: A firing would put a second token in a place.
        LimitError: A limit was hit.
    """
    exploration = settled(prepared, orders="enough", max_states=max_states, max_firings=max_firings)
    if exploration.trouble is not None:
        raise _fault_found(prepared, exploration)
    return exploration


def _fault_found(prepared: KernelNet, exploration: Exploration) -> SemanticsError:
    """The error for a proof that has failed, with whole runs from the initial marking."""
    assert exploration.trouble is not None, "asked of what has come to trouble"
    state, firings, _ = exploration.trouble
    walk = Walk(prepared.net)
    if not prepared.net.transitions[prepared.transitions[firings[0]]].internal:  # else before any event
        walk.settle()
        for t in exploration.run(state):
            walk.fire(prepared.transitions[t])
            walk.settle()
    return walk.fault(prepared, exploration)


def fault_after(net: PetriNet, events: Iterable[int]) -> SemanticsError | None:
    """The error of a run of events whose last has not one stable end, every interleaving after each explored.

    Args:
        net: A net with priorities.
        events: The transitions of the events from the initial marking on.

    Returns:
        The error with whole runs from the initial marking, ``None`` where each event has one stable end.

    Raises:
        LimitError: Too many markings behind an event.
    """
    internal, walk = KernelNet(net, events=False), Walk(net)
    for t in (None, *events):
        if t is not None:
            walk.fire(t)
        exploration = settled(internal, walk.marking, orders="enough", max_states=MOST_ENDS)
        if exploration.trouble is not None:
            return walk.fault(internal, exploration)
        walk.settle()
    return None


class Walk:
    """A run from the initial marking, and where it is.

    Args:
        net: A net with priorities.
    """

    def __init__(self, net: PetriNet) -> None:
        self.net = net
        self.completion = Completion(net)
        self.marking = list(net.initial)
        self.run: list[int] = []

    def fire(self, t: int) -> None:
        """Goes on by one firing."""
        self.net.fire_in_place(self.marking, t)
        self.run.append(t)

    def settle(self) -> None:
        """Goes on to a stable marking, along one interleaving."""
        self.run += self.completion.settle(self.marking)

    def fault(self, prepared: KernelNet, exploration: Exploration) -> SemanticsError:
        """The error for trouble that begins where the run is."""
        assert exploration.trouble is not None, "asked of what has come to trouble"
        _, firings, kind = exploration.trouble
        last = [prepared.transitions[t] for t in firings]
        names = [transition.name for transition in self.net.transitions]
        if kind == "unsafe":
            return unsafe_after(self.net, [*self.run, *last])
        if kind == "endless":
            return divergence_error([names[t] for t in (*self.run, *last)])
        if not self.net.transitions[last[0]].internal:
            self.fire(last.pop(0))
        runs = self.parted(last)
        return confluence_error(self.net, [[names[t] for t in (*self.run, *run)] for run in runs])

    def parted(self, last: list[int]) -> Sequence[list[int]]:
        """Two runs that part where the outcome is decided: in the nearest such marking, if soon found."""
        after: dict[int, dict[int, int]] = {}
        masked, start = MaskedNet(self.net), mask_of(self.marking)
        queue = [start]
        for marking in queue:
            if marking not in after:
                enabled = masked.allowed(masked.covered(marking) & masked.internal)
                after[marking] = {t: masked.fire(marking, t)[0] for t in enabled}
                queue.extend(after[marking].values())
            if len(after) > MOST_LISTED:
                break
        else:
            return parting_runs(after, start)
        *way, first, second = last
        runs = []
        for t in (first, second):
            run, at = [*way, t], list(self.marking)
            for u in run:
                self.net.fire_in_place(at, u)
            runs.append([*run, *self.completion.settle(at)])
        return runs


def confluence_error(net: PetriNet, runs: list[list[str]]) -> ConfluenceError:
    """The error for two runs that differ in their stable end; it names the transitions at which they part."""
    first, second = runs
    parted = next(i for i, (a, b) in enumerate(zip(first, second, strict=False)) if a != b)
    by_name = {transition.name: transition for transition in net.transitions}
    origins = [by_name[run[parted]].provenance for run in runs]
    where = " and ".join(dict.fromkeys(str(o) for o in origins if o))
    events = [str(e) for name in first[:parted] if (e := by_name[name].event)]
    after = f"after {events[-1]}" if events else "at the start"
    return ConfluenceError(
        f"not confluent: {after} the outcome depends on the interleaving of "
        f"{where or f'{first[parted]} and {second[parted]}'}",
        runs,
        events,
    )


def divergence_error(run: list[str]) -> DivergenceError:
    """The error for an internal run that comes back to a marking it has passed."""
    return DivergenceError(
        f"divergent: an internal run comes back to a marking it has passed, after {len(run)} firings", [run]
    )
