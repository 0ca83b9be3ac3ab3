"""How a parallel block is left: when all branches have ended, or when some of them decide its end.

Each branch marks how it has ended. When all have, internal transitions leave the block. A block that does not
await all of them halts the others when its end is decided: an internal transition takes the place that says
that the block runs, as an event does that interrupts it (:mod:`mcpn.drawing.templates.control`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import combinations, compress, product
from math import comb
from typing import NamedTuple, TypeAlias

from mcpn.drawing.templates.canvas import Canvas, Pen
from mcpn.drawing.templates.facts import FactArcs
from mcpn.errors import LimitError
from mcpn.mission.core.objectives_graph import Branch, ParallelSection

Continuation: TypeAlias = tuple[str, FactArcs, list[str]]
"""A way that an outcome may lead: its number, empty if there is one alone, facts, places to mark."""

Continuations: TypeAlias = Callable[[str], Iterable[Continuation]]
"""Says where an outcome leads."""

MAX_COMBINED = 6
"""Children of a parallel block up to which each combination of outcomes has a transition of its own."""

MAX_DECIDING = 10_000
"""Combinations of branches whose ends decide that of their block, each with a transition."""

_DECIDED = {
    "success": ("succeeding", "succeed", "succeeded"),
    "failure": ("failing", "fail", "failed"),
    "abort": ("aborting", "abort", "aborted"),
}
"""What is drawn for an outcome that is decided while branches run: a place, what marks it, what follows."""


class Leaving(NamedTuple):
    """Draws what leaves a block.

    Args:
        canvas: Where to draw.
        section: The block.
    """

    canvas: Canvas
    section: ParallelSection

    @property
    def combined(self) -> bool:
        """Whether each combination of outcomes has a transition of its own."""
        most = self.canvas.most_combined
        return len(self.section.branches) <= (MAX_COMBINED if most is None else most)

    def of_branch(self, branch: Branch, part: str) -> str:
        """A place of a branch."""
        return self.canvas.place_of("objective", branch.name, part)

    def done(self, branch: Branch, ok: bool) -> str:
        """The place that says that a branch has ended so."""
        return self.of_branch(branch, "ok" if ok else "fail")

    def ends(self, branch: Branch) -> list[tuple[str, ...]]:
        """By outcome, the places marked when a branch has ended; the last says that it has."""
        more = () if self.combined else (self.of_branch(branch, "ended"),)
        return [(self.done(branch, ok), *more) for ok in (True, False)]

    def all_ended(self, pen: Pen, running: list[str], continuations: Continuations, halted: bool) -> None:
        """Draws what follows when all branches have ended.

        Args:
            pen: The block's.
            running: The place that says that the block runs, where there is one.
            continuations: Says where an outcome leads.
            halted: Whether the block may be halted.
        """
        section = self.section
        if self.combined:
            self._combined(pen, running, continuations)
            return
        # A block that may be halted, or has few children, counts no outcome before all have ended: until
        # then each child's outcome stays marked in a place of its own.
        late = halted or len(section.branches) <= MAX_COMBINED
        begin = 0 if late else len(section.branches) - 1
        ended = [*(self.of_branch(b, "ended") for b in section.branches), *running]
        if section.needed is not None:
            self._counted(pen, continuations, begin, ended, section.needed)
        else:
            self._one_by_one(pen, continuations, begin, ended)

    def _combined(self, pen: Pen, running: list[str], continuations: Continuations) -> None:
        """One transition per combination of outcomes; success if every mandatory child succeeded (4.2)."""
        section = self.section
        for outcome in product((True, False), repeat=len(section.branches)):
            done = [self.done(branch, ok) for branch, ok in zip(section.branches, outcome, strict=True)]
            succeeded = section.succeeds(compress(section.branches, outcome))
            digits = "".join("0" if ok else "1" for ok in outcome)
            self._leave(
                pen, f"exit_{digits}", [*done, *running], continuations("success" if succeeded else "failure")
            )

    def _leave(self, pen: Pen, part: str, taken: list[str], continuations: Iterable[Continuation]) -> None:
        """Takes some places and goes on, as facts decide."""
        for number, way, entered in continuations:
            name = f"{part}_{number}" if number else part
            pen.transition(name, taken, entered, read=way.read, rank=self._rank)

    def _one_by_one(self, pen: Pen, continuations: Continuations, begin: int, all_ended: list[str]) -> None:
        """The outcome of a wide block by a net of linear size, which counts children in document order."""
        well, lost = [], []
        for number in range(1, len(self.section.branches)):
            well.append([pen.place(f"ok{number}")])
            lost.append([pen.place(f"fail{number}")])
        well, lost = [[], *well, []], [[], *lost, []]
        for i, branch in enumerate(self.section.branches):
            name = f"note{i + 1}"
            after_failure = lost[i + 1] if branch.mandatory else well[i + 1]
            ended = all_ended if i == begin else []
            ways = [(well[i], True, well[i + 1]), (well[i], False, after_failure)]
            if i:
                ways += [(lost[i], True, lost[i + 1]), (lost[i], False, lost[i + 1])]
            for number, (before, ok, after) in enumerate(ways):
                taken = [*before, self.done(branch, ok), *ended]
                if i + 1 < len(self.section.branches):
                    pen.transition(f"{name}_{number}", taken, after, rank=self._rank)
                else:
                    outcome = "success" if after is well[-1] else "failure"
                    self._leave(pen, f"{name}_{number}", taken, continuations(outcome))

    def _counted(
        self, pen: Pen, continuations: Continuations, begin: int, all_ended: list[str], needed: int
    ) -> None:
        """The outcome of a block that so many successes decide: they are counted up to that."""
        last = len(self.section.branches)
        after: dict[tuple[int, int], list[str]] = {(0, 0): []}
        counts = [0]
        for i, branch in enumerate(self.section.branches, 1):
            reached = sorted({min(n + more, needed) for n in counts for more in (0, 1)})
            for count in reached:
                after[i, count] = [] if i == last else [pen.place(f"ok{count}of{i}")]
            ended = all_ended if i == begin + 1 else []
            for count, ok in product(counts, (True, False)):
                taken = [*after[i - 1, count], self.done(branch, ok), *ended]
                part = f"note{i}_{count}_{int(not ok)}"
                counted = min(count + ok, needed)
                if i < last:
                    pen.transition(part, taken, after[i, counted], rank=self._rank)
                else:
                    outcome = "success" if counted == needed else "failure"
                    self._leave(pen, part, taken, continuations(outcome))
            counts = reached

    @property
    def _rank(self) -> int:
        return self.canvas.ranks.control

    def decided(self, pen: Pen, running: str, continuations: Continuations, all_halted: list[str]) -> None:
        """Draws how branches that have ended decide the block's end, and what follows it.

        Args:
            pen: The block's.
            running: The place that says that the block runs.
            continuations: Says where an outcome leads.
            all_halted: The places that say of each branch that it is halted.
        """
        for outcome, _ in self.section.outcomes:
            last = [branch for how, branch in self.section.deciding if how == outcome]
            if last:
                deciding, decides, follows = _DECIDED[outcome]
                self._deciding(pen, running, outcome, last, (pen.place(deciding), decides))
                taken = [self.canvas.place_of(*pen.called, deciding), *all_halted]
                self._leave(pen, follows, taken, continuations(outcome))

    def _deciding(
        self, pen: Pen, running: str, outcome: str, last: Iterable[Branch], drawn: tuple[str, str]
    ) -> None:
        """Branches that decide the end halt the others; of several that end alike the first ones count."""
        section, (place, decides) = self.section, drawn
        counted = {"success": section.needed, "failure": section.failing}.get(outcome)
        if counted and (count := comb(len(section.branches), counted)) > MAX_DECIDING:
            verb = {"success": "succeed", "failure": "fail"}[outcome]
            message = f"parallel block {section.name}: {count} ways in which {counted} branches {verb}"
            raise LimitError(f"{message}, the limit is {MAX_DECIDING}")
        for branch in last:
            rank = self.canvas.ranks.deciding(section.name, outcome, branch.name)
            for ended in self._before(branch, outcome, counted):
                those = (*ended, branch)
                put = [place, *(self.of_branch(b, "halted") for b in those)]
                put += [self.of_branch(b, "halt") for b in section.branches if b not in those]
                taken = [place for b in those for place in self._ended(b, outcome)]
                name = (decides, *(b.name for b in those))
                pen.transition(name, [*taken, running], put, rank=rank)

    def _before(self, branch: Branch, outcome: str, counted: int | None) -> Iterable[tuple[Branch, ...]]:
        """The branches before one that decide the end with it: each combination that may."""
        hasty = outcome == "failure" and self.section.hasty
        if counted is None or (hasty and branch.mandatory):
            return [()]
        before = self.section.branches[: self.section.branches.index(branch)]
        return combinations((b for b in before if not (hasty and b.mandatory)), counted - 1)

    def _ended(self, branch: Branch, outcome: str) -> tuple[str, ...]:
        """The places that are marked when a branch has ended so."""
        if outcome == "abort":
            return (self.of_branch(branch, "abort"),)
        return self.ends(branch)[outcome == "failure"]
