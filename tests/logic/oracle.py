"""What a mission can still reach, by plain search over its net, which shares nothing with what it judges."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache, cached_property
from itertools import combinations

from hypothesis import strategies as st

from mcpn.drawing.compose import MissionNet
from mcpn.events import Event, What
from mcpn.mission.model import Block, Holder, Mission, Objective
from mcpn.nets.petri import Marking
from mcpn.testing import missions

Edge = tuple[str, Marking]


def fails(text: str) -> bool:
    """Whether an event is the failure of an objective, for whatever reason."""
    return Event.parse(text).what in (What.FAILURE, What.TIMEOUT)


class Play:
    """Stable markings of a mission's net and the events between them, found as they are asked for."""

    def __init__(self, found: MissionNet) -> None:
        self.net = found.net
        self.place = found.net.place_index
        self.hardware = [h.name for h in found.core.hardware if h.faulty]
        blocks = found.graph.timed_blocks()
        self.timed = {f"OBJ_{block.name}_EV_TIMEOUT": [f"OBJ_{n}" for n in block.held] for block in blocks}
        """By event of a block whose time is over, the objectives in it."""
        self._edges: dict[Marking, list[Edge]] = {}
        self._left: dict[tuple[Marking, Marking, str], frozenset[int]] = {}
        self.initial = self.settle(self.net.initial)

    def settle(self, marking: Marking, left: set[int] | None = None) -> Marking:
        """The stable marking after internal transitions; adds the places that they consume from."""
        while True:
            enabled = self.net.enabled(marking)
            if not enabled or self.net.transitions[enabled[0]].event is not None:
                return marking
            if left is not None:
                left |= {p for p, _ in self.net.transitions[enabled[0]].consume}
            marking = self.net.fire(marking, enabled[0])

    def edges(self, marking: Marking) -> list[Edge]:
        if marking not in self._edges:
            self._edges[marking] = []
            for t in self.net.enabled(marking):
                event, left = str(self.net.transitions[t].event), set[int]()
                after = self.settle(self.net.fire(marking, t), left)
                left |= {p for p, _ in self.net.transitions[t].consume}
                self._left[marking, after, event] = frozenset(left)
                self._edges[marking].append((event, after))
        return self._edges[marking]

    def leaves(self, before: Marking, event: str, after: Marking, place: str) -> bool:
        """Whether an event takes the token of a place, be it that another comes before all is stable."""
        return self.place[place] in self._left[before, after, event]

    def after(self, marking: Marking, events: Iterable[str]) -> Marking:
        for event in events:
            (marking,) = [m for e, m in self.edges(marking) if e == event]
        return marking

    def walked(self, events: Iterable[str]) -> Iterator[tuple[Marking, str, Marking]]:
        """Each event of a run from the start, with the markings before and after it."""
        marking = self.initial
        for event in events:
            before, marking = marking, self.after(marking, [event])
            yield before, event, marking

    def without(self, dead: Iterable[str]) -> Marking:
        """The start after the failure of some hardware, of what is not out of service already."""
        failing = sorted(set(dead) - self.out(self.initial))
        return self.after(self.initial, [f"{h}_EV_OOS" for h in failing])

    def reach(
        self,
        starts: Iterable[Marking],
        without: Collection[str] = (),
        keeping: str | None = None,
    ) -> set[Marking]:
        """Every marking that runs without some events lead to; a place, if given, keeps its token."""
        seen = {m for m in starts if keeping is None or m[self.place[keeping]]}
        stack = list(seen)
        while stack:
            before = stack.pop()
            for event, m in self.edges(before):
                left = keeping is not None and self.leaves(before, event, m, keeping)
                if event not in without and m not in seen and not left:
                    seen.add(m)
                    stack.append(m)
        return seen

    def marks(self, place: str) -> Callable[[Marking], bool]:
        number = self.place[place]
        return lambda marking: bool(marking[number])

    def out(self, marking: Marking) -> frozenset[str]:
        return frozenset(h for h in self.hardware if marking[self.lost_place(h)])

    def lost_place(self, hardware: str) -> int:
        """The place of lost hardware. What crashes may be called as its activity: then names say the kind."""
        prefixes = (f"{hardware}_", f"hardware:{hardware}:")
        names = (prefix + part for part in ("gone", "OOS") for prefix in prefixes)
        return next(self.place[name] for name in names if name in self.place)

    def subsets(self) -> list[frozenset[str]]:
        sizes = range(len(self.hardware) + 1)
        return [frozenset(c) for size in sizes for c in combinations(self.hardware, size)]

    def mission_survives(
        self, marking: Marking, dead: frozenset[str], ends: Sequence[str] = ("MISSION_success",)
    ) -> bool:
        """Whether the mission may still come to one of some ends."""
        ended = [self.marks(end) for end in ends]
        reached = self.reach([marking], [f"{h}_EV_RD" for h in dead])
        return any(end(m) for m in reached for end in ended)

    def fail(self, marking: Marking, text: str) -> list[str]:
        """The places of the objectives that fail with an event; all in a block as its time is over."""
        if text in self.timed:
            return [place for place in self.timed[text] if self.marks(place)(marking)]
        return [text.rpartition("_EV_")[0]] if text.startswith("OBJ_") and fails(text) else []

    @cached_property
    def unsafe(self) -> set[tuple[Marking, str]]:
        """Where the failure of a safing objective leads to abort.

        Such an objective ends the mission in abort by its success, too; or after its success objectives that
        succeed lead to abort, and never to success.
        """
        aborted, succeeded = self.marks("MISSION_abort"), self.marks("MISSION_success")
        edges = [(m, *edge) for m in self.reach([self.initial]) for edge in self.edges(m)]
        others = {text for _, text, _ in edges if not text.endswith("_EV_OK")}
        into = [(m, text) for m, text, target in edges if aborted(target) and not aborted(m)]
        ending = {text for _, text in into}

        @cache
        def shelter(name: str) -> bool:
            onward = self.reach([target for _, text, target in edges if text == f"{name}_EV_OK"], others)
            only = any(map(aborted, onward)) and not any(map(succeeded, onward))
            return f"{name}_EV_OK" in ending or only

        return {(m, text) for m, text in into if any(map(shelter, self.fail(m, text)))}

    def ends_safely(self, marking: Marking, dead: frozenset[str]) -> bool:
        """Whether the mission may still succeed, or abort by what is no failure of what should make safe."""
        aborted, succeeded = self.marks("MISSION_abort"), self.marks("MISSION_success")
        reached = self.reach([marking], [f"{h}_EV_RD" for h in dead])
        return any(map(succeeded, reached)) or any(
            aborted(target) and not aborted(m) and (m, text) not in self.unsafe
            for m in reached
            for text, target in self.edges(m)
        )

    def objective_survives(self, marking: Marking, name: str, dead: frozenset[str]) -> bool:
        """Whether the present run may end in success: its end, or an interruption, is no part of it."""
        run = self.reach([marking], [f"{h}_EV_RD" for h in dead], f"OBJ_{name}")
        return any(event == f"OBJ_{name}_EV_OK" for m in run for event, _ in self.edges(m))

    def forced(self, stop: Callable[[Marking], bool] | None = None) -> set[Marking]:
        """Markings after runs without repairs in which objectives fail only where they are lost."""
        seen, stack = {self.initial}, [self.initial]
        while stack:
            m = stack.pop()
            if stop is not None and stop(m):
                continue
            for event, after in self.edges(m):
                failing = [place.removeprefix("OBJ_") for place in self.fail(m, event)]
                dead = frozenset(self.hardware)
                if failing and all(self.objective_survives(m, name, dead) for name in failing):
                    continue
                if not event.endswith("_EV_RD") and after not in seen:
                    seen.add(after)
                    stack.append(after)
        return seen

    def ever_succeeds(self, marking: Marking, name: str, dead: frozenset[str]) -> bool:
        run = self.reach([marking], [f"{h}_EV_RD" for h in dead])
        return any(event == f"OBJ_{name}_EV_OK" for m in run for event, _ in self.edges(m))


def minimal(sets: Iterable[frozenset[str]]) -> list[tuple[str, ...]]:
    """The minimal ones, by size, then by names."""
    known = set(sets)
    least = [tuple(sorted(s)) for s in known if not any(t < s for t in known)]
    return sorted(least, key=lambda names: (len(names), names))


def fragile_missions(**bounds: int) -> st.SearchStrategy[Mission]:
    """Missions most of which need much to succeed: few routes around what fails, no contention."""

    @st.composite
    def drawn(draw: st.DrawFn) -> Mission:
        mission = draw(missions(None, disjoint_branches=True, protocols=False, timeouts=2, early=1, **bounds))
        return replace(mission, blocks=_unrouted(draw, mission.blocks))

    return drawn()


@st.composite
def coming_home(draw: st.DrawFn) -> Mission:
    """Missions that need much to succeed, and come home, which aborts them, by most failures.

    Args:
        draw: Given by hypothesis.
    """
    mission = draw(fragile_missions(max_hardware=3, max_objectives=2, max_sections=4))
    started = [a.name for a in mission.activities if not a.produces]
    home = Objective(
        name="home",
        activities=(draw(st.sampled_from(started)),),
        success="abort",
        failure=draw(st.sampled_from(["fail", "abort"])),
        retries=draw(st.sampled_from([0, 0, 1])),
    )
    leads = st.sampled_from(["home", "home", "abort", "fail"])
    blocks = [replace(block, failure=draw(leads)) for block in mission.blocks]
    blocks[-1] = replace(blocks[-1], success="succeed")
    return replace(mission, blocks=(*blocks, home))


def _unrouted(draw: st.DrawFn, blocks: tuple[Block, ...]) -> tuple[Block, ...]:
    found = []
    for block in blocks:
        if isinstance(block, Holder):
            block = replace(block, blocks=_unrouted(draw, block.blocks))
        kept = block.failure if draw(st.integers(0, 3)) == 0 else None
        found.append(replace(block, success=None, failure=kept))
    return tuple(found)
