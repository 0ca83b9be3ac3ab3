"""CTL from the initial state forward, beside backward from goals, on the formulas of contest nets.

Usage: ``python experiments/forward.py FOLDER NET... [--seconds S]``; it takes some three minutes for 50 nets.

*Backward* finds the states of each sub-formula, as mcpn does (``mcpn.logic.evaluate``). *Forward* asks
whether some of a set of states satisfies a formula, and follows it: ``EX f`` is ``f`` of some successor,
``E[f U g]`` is ``g`` of what runs through ``f`` come to, a conjunction first narrows the set by what speaks
of no path, and ``EG f`` is asked of the set alone (H. Iwashita, T. Nakata, F. Hirose, *CTL model checking
based on forward state traversal*, ICCAD 1996). Of several parts of a conjunction that speak of paths all but
one, and what is negated inside, need their states, backward.

Asked is what is left for the space when the files' formulas are answered. Each way has a process of its own
for each formula and begins with the same diagrams and caches; both must agree. Rows are formulas for which
one way takes a moment.

On 372 formulas of 50 nets, some three minutes, backward takes 36.8 s, forward 39.4 s, the quicker of both
33.1 s; of the 82 that take a moment backward wins 6, forward 9, and no shape tells which: most time goes into
negated parts, whose states both need. So mcpn goes backward.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from limits import Result, measured

from mcpn import __version__
from mcpn.errors import McpnError
from mcpn.logic import verdicts
from mcpn.logic.answering import answer_all
from mcpn.logic.asking import Questions
from mcpn.logic.contest import read_properties
from mcpn.logic.evaluate import Evaluation
from mcpn.logic.formulas import EG, EU, EX, is_temporal
from mcpn.nets.formats import read_net
from mcpn.spaces.algebra import S
from mcpn.spaces.search.goal import TRUE, And, Formula, Not, Or

QUICKLY = 0.1
"""Seconds below which a formula tells nothing about ways."""


class Forward(Evaluation[S]):
    """Evaluates formulas from the initial state on; without fairness."""

    def holds(self, formula: Formula) -> bool:
        """Whether the initial state satisfies a formula."""
        if isinstance(formula, Not):
            return not self.holds(formula.operands[0])
        if isinstance(formula, And | Or):  # of one state all parts may be asked alone
            values = map(self.holds, sorted(formula.operands, key=_operators))
            return all(values) if isinstance(formula, And) else any(values)
        return self.some(self.space.initial, formula)

    def some(self, among: S, formula: Formula) -> bool:
        """Whether some of these states satisfies a formula."""
        space = self.space
        if not among:
            return False
        match formula:
            case _ if formula in self._known:
                pass
            case Or(operands):
                return any(self.some(among, part) for part in sorted(operands, key=_operators))
            case And(operands) if is_temporal(formula):
                *first, last = sorted(operands, key=_difficulty)
                for part in first:
                    among = among & self.states(part)
                return self.some(among, last)
            case EX((operand,)):
                return self.some(space.after(among), operand)
            case EG((operand,)):
                return bool(among & space.staying(self.states(operand), among))
            case EU((left, right)) if self.some(among, right):
                return True
            case EU((left, right)) if left == TRUE and (among - space.initial).count() != among.count():
                return self.some(space.everything, right)
            case EU((left, right)):
                through = space.reached(among, self.along(left))
                return self.some(through if left == TRUE else space.after(through), right)
        return bool(among & self.states(formula))


def _operators(formula: Formula) -> int:
    return sum(1 for inside in formula.walk() if isinstance(inside, EX | EG | EU))


def _difficulty(formula: Formula) -> tuple[bool, int]:
    """What goes on forward comes last: of parts that can, the one with most operators."""
    return isinstance(formula, EX | EG | EU), _operators(formula)


def run(way: str, questions: Questions, formula: Formula) -> Result:
    """The answer one way gives, and its CPU seconds."""
    known = questions.evaluation
    evaluation: Evaluation[Any] = known if way == "backward" else Forward(known.space)
    evaluation._known = known._known
    started = time.process_time()
    return {"holds": evaluation.holds(formula), "cpu": time.process_time() - started}


WAYS = "backward", "forward"
VALUE = verdicts._value


class Comparison:
    """Prints a row for each formula that takes a moment; ends the script where ways disagree."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.took: list[tuple[float, float]] = []

    def value(self, questions: Questions, meaning: verdicts.Meaning) -> int:
        """The answer to what is left for the space; a formula is measured first."""
        if isinstance(meaning, Formula) and is_temporal(meaning):
            questions.evaluation  # noqa: B018  # the space is there before time is taken
            found = [measured(run, way, questions, meaning, seconds=self.seconds) for way in WAYS]
            if len({result["holds"] for result in found if "holds" in result}) > 1:
                sys.exit(f"the ways disagree: {meaning}")
            backward, forward = (result.get("cpu", self.seconds) for result in found)
            self.took.append((backward, forward))
            if max(backward, forward) > QUICKLY:
                kind = type(questions.space).__name__
                print(
                    f"{questions.net.name:28}{kind:18}{_shape(meaning)[:44]:46}{backward:9.2f}{forward:9.2f}",
                    flush=True,
                )
        return VALUE(questions, meaning)

    def tell(self) -> None:
        """Sums, and how often each way was the quicker one by a half."""
        backward, forward = (sum(column) for column in zip(*self.took, strict=True))
        print(f"{len(self.took)} formulas; backward {backward:.1f} s, forward {forward:.1f} s")
        best = sum(map(min, self.took))
        slow = [pair for pair in self.took if max(pair) > QUICKLY]
        won = [sum(pair[i] * 1.5 < pair[1 - i] for pair in slow) for i in (0, 1)]
        print(
            f"the quicker of both {best:.1f} s; of {len(slow)} slow backward wins {won[0]}, forward {won[1]}"
        )
        if slow:
            print(f"median of forward / backward {statistics.median(f / max(b, 0.001) for b, f in slow):.2f}")


def _shape(formula: Formula) -> str:
    """A formula without its atoms."""
    names = {And: "&", Or: "|", Not: "!"}
    inside = [_shape(part) for part in formula.operands if is_temporal(part)]
    return f"{names.get(type(formula), type(formula).__name__)}({' '.join(inside)})"


def main(arguments: Sequence[str] | None = None) -> None:
    """Prints a row for each formula that takes one of the ways a moment, and the totals."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path)
    parser.add_argument("nets", nargs="+")
    parser.add_argument("--seconds", type=float, default=20, help="limit of each way on each formula")
    given = parser.parse_args(arguments)
    comparison = Comparison(given.seconds)
    verdicts._value = comparison.value
    print(f"{'net':28}{'space':18}{'formula':46}{'backward':>9}{'forward':>9}  CPU seconds")
    for net in given.nets:
        for kind in ("CTLCardinality", "CTLFireability"):
            path = given.folder / net / f"{kind}.xml"
            if not path.exists():
                continue
            questions = Questions(read_net(given.folder / net / "model.pnml"))
            try:
                for _ in answer_all(questions, read_properties(path, questions.names)):
                    pass
            except McpnError as error:
                print(f"{net} {kind}: {error}")
    comparison.tell()
    print(f"mcpn {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}")


if __name__ == "__main__":
    main()
