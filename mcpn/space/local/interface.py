"""Interface states: which hardware is out of service, as sets on decision diagrams.

All that one section of a mission hands to the next is which of its hardware is out of service. There are two
to the power of the hardware of such states, so that sets of them are diagrams, never lists: a level for each
resource of the mission, marked where it is out of service.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TypeVar

import numpy as np

from mcpn._kernel import Store, Zdd
from mcpn.space.graph import Mask

Part = TypeVar("Part", bound=Hashable)


class HardwareSpace:
    """The hardware of a mission that can fail, as levels of one store.

    Args:
        names: In document order.
    """

    def __init__(self, names: Sequence[str]) -> None:
        self.names = tuple(names)
        self.level = {name: level for level, name in enumerate(self.names)}
        self.store = Store(len(self.names))
        self.fails = [self.store.event([], [level]) for level in range(len(self.names))]
        self.recovers = [self.store.event([level], []) for level in range(len(self.names))]

    def frame(self, names: Sequence[str]) -> Frame:
        """Some of the hardware in an order of its own, as a section has it."""
        return Frame(self, tuple(names))


@dataclass(frozen=True)
class Frame:
    """Some hardware of a mission, by its bit in masks: what the sets of a section's interface are about.

    Args:
        space: All hardware of the mission.
        names: The hardware of the section.
    """

    space: HardwareSpace
    names: tuple[str, ...]
    _known: dict[bytes, Zdd] = field(default_factory=dict, compare=False, repr=False)

    @property
    def nothing(self) -> HardwareStates:
        """No state."""
        return HardwareStates(self, self.space.store.empty())

    @property
    def in_service(self) -> HardwareStates:
        """The one state in which nothing is out of service."""
        return HardwareStates(self, self.space.store.singleton([]))

    @property
    def everything(self) -> HardwareStates:
        """All states."""
        return self.in_service.freeing(self.names)

    def of_mask(self, mask: int) -> HardwareStates:
        """The one state in which just these are out of service, by their bits."""
        out = sorted(self.space.level[name] for bit, name in enumerate(self.names) if mask >> bit & 1)
        return HardwareStates(self, self.space.store.singleton(out))

    def from_masks(self, masks: Mask) -> HardwareStates:
        """The states listed in an array.

        Args:
            masks: Shape (2 ** hardware,), by the bits of what is out of service.
        """
        key = masks.tobytes()
        if key not in self._known:
            # Axes from the mission's first resource on, so that equal parts are equal rows.
            count = len(self.names)
            axes = [count - 1 - bit for _, bit in self.from_top]
            table = masks.reshape((2,) * count).transpose(axes).tobytes()
            self._known[key] = self._built(table, _halves, any)
        return HardwareStates(self, self._known[key])

    def from_diagram(self, states: Zdd, split: Callable[[Zdd, int], tuple[Zdd, Zdd]]) -> HardwareStates:
        """The states in a diagram of another store.

        Args:
            states: What is out of service, and nothing more.
            split: Those of some states in which a resource, given by its bit, is in service, and those in
                which it is out, with nothing more told of it.
        """
        return HardwareStates(self, self._built(states, split, bool))

    def _built(
        self, whole: Part, split: Callable[[Part, int], tuple[Part, Part]], there: Callable[[Part], bool]
    ) -> Zdd:
        """A diagram from parts: those without and with each resource out; equal parts are looked at once."""
        memo: dict[tuple[Part, int], Zdd] = {}
        store, fails = self.space.store, self.space.fails

        def built(part: Part, at: int) -> Zdd:
            if at == len(self.from_top) or not there(part):
                return store.singleton([]) if there(part) else store.empty()
            if (part, at) not in memo:
                level, bit = self.from_top[at]
                up, down = split(part, bit)
                memo[part, at] = built(up, at + 1) | built(down, at + 1).images([fails[level]])
            return memo[part, at]

        return built(whole, 0)

    @cached_property
    def from_top(self) -> list[tuple[int, int]]:
        """Levels of the mission's store, ascending, each with its bit."""
        return sorted((self.space.level[name], bit) for bit, name in enumerate(self.names))

    def mask(self, levels: Iterable[int]) -> int:
        """The mask of one state, given as the levels that it marks."""
        return sum(self._bits[level] for level in levels)

    @cached_property
    def _bits(self) -> dict[int, int]:
        return {level: 1 << bit for level, bit in self.from_top}


def _halves(table: bytes, _: int) -> tuple[bytes, bytes]:
    return table[: len(table) // 2], table[len(table) // 2 :]


@dataclass(frozen=True)
class HardwareStates:
    """A set of states of some hardware.

    Args:
        frame: The hardware.
        out: What is out of service in each, on the levels of the mission's store.
    """

    frame: Frame
    out: Zdd

    def __or__(self, other: HardwareStates) -> HardwareStates:
        return HardwareStates(self.frame, self.out | other.out)

    def __and__(self, other: HardwareStates) -> HardwareStates:
        return HardwareStates(self.frame, self.out & other.out)

    def __sub__(self, other: HardwareStates) -> HardwareStates:
        return HardwareStates(self.frame, self.out - other.out)

    def __bool__(self) -> bool:
        return bool(self.out)

    def count(self) -> int:
        """How many states there are."""
        return self.out.count()

    def freeing(self, names: Sequence[str]) -> HardwareStates:
        """The same with some hardware, in service so far, in either state."""
        space = self.frame.space
        return HardwareStates(self.frame, self.out.saturate([space.fails[space.level[h]] for h in names]))

    def in_service(self, names: Sequence[str]) -> HardwareStates:
        """Those of the states in which some hardware is in service."""
        return HardwareStates(
            self.frame, self.out.subset(unmarked=[self.frame.space.level[h] for h in names])
        )

    def seen_by(self, other: Frame, *, free: bool = True) -> HardwareStates:
        """What other hardware can be like: what both have keeps its state, what only the other has is free.

        Args:
            other: The other hardware.
            free: Whether what only the other has comes in both states, or in service.
        """
        level = self.frame.space.level
        kept = [level[h] for h in other.names if h in self.frame.names]
        found = HardwareStates(other, self.out.onto(kept))
        return found.freeing([h for h in other.names if h not in self.frame.names]) if free else found

    def masks(self) -> Mask:
        """The states as an array, shape (2 ** hardware,), by the bits of what is out of service."""
        found = np.zeros(1 << len(self.frame.names), np.bool_)
        found[[self.frame.mask(state) for state in self.out]] = True
        return found

    def pick(self) -> int:
        """The mask of one of the states, one with little out of service first; there must be one."""
        state = self.out.pick()
        assert state is not None, "asked of sets that are not empty"
        return self.frame.mask(state)

    def built(self, one: Zdd, none: Zdd, join: Callable[[Zdd, Zdd, int], Zdd]) -> Zdd:
        """The set as a diagram of another store.

        Args:
            one: What is there for the state in which nothing is out of service.
            none: What is there for no state.
            join: Puts together what is there where a resource, given by its bit, is in service, and what is
                there where it is out.
        """
        order, memo = self.frame.from_top, dict[tuple[Zdd, int], Zdd]()
        recovers = self.frame.space.recovers

        def follow(out: Zdd, at: int) -> Zdd:
            if not out or at == len(order):
                return one if out else none
            if (out, at) not in memo:
                level, bit = order[at]
                up, down = out.subset(unmarked=[level]), out.images([recovers[level]])
                memo[out, at] = join(follow(up, at + 1), follow(down, at + 1), bit)
            return memo[out, at]

        return follow(self.out, 0)
