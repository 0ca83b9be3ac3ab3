"""What a branch of a block does with a token that halts, pauses, resumes or drops it, by where it is."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Generic, Literal, NamedTuple, Self, TypeAlias, TypeVar

from mcpn.drawing.templates.canvas import Pen
from mcpn.drawing.templates.leaving import Leaving
from mcpn.drawing.templates.level import Level
from mcpn.mission.core.objectives_graph import ElementarySection, ParallelSection

L = TypeVar("L")

Word: TypeAlias = Literal["halt", "pause", "resume", "drop"]
"""What a token of a branch has it do."""


class Arcs(NamedTuple):
    """Arcs of a transition that halts, pauses, resumes or drops a branch, besides the token that says so."""

    taken: list[str]
    put: list[str]
    read: Sequence[str] = ()


class Region(NamedTuple, Generic[L]):
    """A region of a block, as in a state machine: a branch, or what runs while the block pauses.

    Args:
        level: Its graph.
        ends: By outcome, the places that are marked when a branch has ended; the last says that it has.
        place: Names its places.
    """

    level: L
    ends: list[tuple[str, ...]]
    place: Callable[[str], str]

    @property
    def ended(self) -> list[str]:
        """The places that say that it has ended."""
        return list(dict.fromkeys(end[-1] for end in self.ends))


class Halting(Level):
    """Draws how what stands in blocks of one level is halted, and goes on."""

    def regions(self, section: ParallelSection, phase: int) -> list[Region[Self]]:
        """The branches of a block; of a later phase that alone which runs while the block pauses."""
        if phase:
            return [Region(self.meanwhile(section, phase), [], partial(self.of_phase, section, phase))]
        leaving = Leaving(self.canvas, section)
        return [
            Region(self.inside(section, branch), leaving.ends(branch), partial(self.of_branch, branch))
            for branch in section.branches
        ]

    def of_phase(self, section: ParallelSection, phase: int, word: str) -> str:
        """A place of a phase of a block."""
        return self.of(section, f"{word}_meanwhile{phase}" if phase else word)

    def tokens(self, section: ParallelSection, phase: int, word: str) -> list[str]:
        """The place of this name of each branch, or of what runs while the block pauses."""
        return [region.place(word) for region in self.regions(section, phase)]

    def each(self, pen: Pen, section: ParallelSection, phase: int, word: Word) -> None:
        """Draws how the branches, or what runs while the block pauses, are halted, resumed and so on."""
        number = 0
        for region in self.regions(section, phase):
            token = pen.own(region.place(word))
            if word == "halt":
                pen.own(region.place("halted"))
            for taken, put, read in region.level.arcs(word, region):
                number += 1
                part = f"{word}{number}" + (f"of{phase}" if phase else "")
                pen.transition(part, [token, *taken], put, read=[*read], rank=self.first)

    def arcs(self, word: Word, region: Region[Self]) -> Iterator[Arcs]:
        """What a branch does with its token ``word``, by where it is in this graph.

        To *pause* notes where the branch is; to *resume* and to *drop* ask what was noted::

                     at its entry   in an objective      in a phase of a block   ended
            halt     halted         stops, halted        its branches halt       halted
            pause    noted, halted  stops, noted, halted its branches pause      stays, halted
            resume                  enters it again      its branches resume     stays
            drop                    halted               its branches drop       halted
        """
        halted = region.place("halted")
        for inner in self.graph.sections:
            if isinstance(inner, ElementarySection):
                yield from self._in_objective(word, inner, halted)
                continue
            if word == "halt" and self.gated(inner):
                yield Arcs([self.of(inner, "enter")], [halted])
            for phase in range(len(inner.pause_graphs) + 1):
                yield self._in_phase(word, inner, phase)
        if word in ("halt", "drop"):
            yield from (Arcs(list(end), [halted]) for end in region.ends)
        else:
            put = [halted] if word == "pause" else []
            yield from (Arcs([], put, [end]) for end in region.ended)
        if word == "halt" and self.graph.aborts and region.ends:
            yield Arcs([region.place("abort")], [halted])

    def _in_objective(self, word: Word, section: ElementarySection, halted: str) -> Iterator[Arcs]:
        paused = self.of(section, "paused")
        if word == "resume":
            yield Arcs([paused], self.enter(section.name))
        elif word == "drop":
            yield Arcs([paused], [halted])
        else:
            left = [halted] if word == "halt" else [paused, halted]
            if self.gated(section):
                yield Arcs([self.of(section, "enter")], left)
            if word == "halt" and section.setting("start"):
                yield Arcs([self.of(section, "starts")], left)
            yield Arcs([self.of(section)], [*self.stops(section), *left])

    def _in_phase(self, word: Word, section: ParallelSection, phase: int) -> Arcs:
        running, paused = self.active(section, phase), self.of_phase(section, phase, "paused")
        match word:
            case "halt":
                halting = self.of_phase(section, phase, "halting")
                return Arcs([running], [halting, *self.tokens(section, phase, word)])
            case "pause":
                pausing = self.of_phase(section, phase, "pausing")
                return Arcs([running], [pausing, *self.tokens(section, phase, word)])
            case "resume":
                return Arcs([paused], self.going_on(section, phase))
            case "drop":
                then = self.of(section, "then_halted")
                return Arcs([paused], [*self.given_up(section, phase), then])

    def going_on(self, section: ParallelSection, phase: int) -> list[str]:
        """Places to mark so that a phase of a block that paused goes on."""
        return [self.active(section, phase), *self.tokens(section, phase, "resume")]

    def given_up(self, section: ParallelSection, phase: int) -> list[str]:
        """Places to mark so that a phase of a block that paused is given up."""
        return [self.of_phase(section, phase, "dropping"), *self.tokens(section, phase, "drop")]
