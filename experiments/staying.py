"""Which states begin a maximal run that stays in a set (``EG``), on diagrams, three ways side by side.

Usage: ``python experiments/staying.py [--contest FOLDER NET...] [--seconds S]``

*Layers* drop the states without a successor in the set until none is left. *Components* take a state, find
its strongly connected component by one closure forward and one back, and go on in what is left, with a state
of the farthest layer (R. Gentilini, C. Piazza, A. Policriti, *Computing strongly connected components in a
linear number of symbolic steps*, SODA 2003). *Turns* are what mcpn does: layers, and in turns with them one
closure back from dead states and layers of what may fire on cycles
(``mcpn.spaces.diagrams.greatest_fixpoint``).

Asked are runs on which some of the transitions are never enabled, on nets of several families. With
``--contest`` the sets are those that come up while the CTL formulas of such nets are answered. Every way has
a process of its own for each set and begins with the same diagrams and caches; all ways that end must find as
many states. It takes some three minutes; with ``--contest`` up to half a minute for each set.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import sys
import time
from collections.abc import Callable, Iterator
from decimal import Decimal
from pathlib import Path

from limits import Result, measured

from mcpn import __version__
from mcpn._kernel import Zdd
from mcpn.errors import McpnError
from mcpn.logic.answering import answer_all
from mcpn.logic.asking import Questions
from mcpn.logic.contest import read_properties
from mcpn.nets.formats import read_net
from mcpn.nets.petri import PetriNet
from mcpn.spaces.diagrams.base import Diagrams
from mcpn.testing.nets import component_ring, fms, kanban, philosophers, slotted_ring

Way = Callable[[Diagrams, Zdd, Zdd | None], Zdd]
TURNS = Diagrams.staying
QUICKLY = 0.1
"""Seconds below which a set tells nothing about ways."""


def by_layers(space: Diagrams, along: Zdd, asked: Zdd | None) -> Zdd:
    """Drops states without a successor in the set until none is left, or none that is asked for."""
    found = along
    while True:
        kept = (space.before(found) & found) | (found & space.dead)
        if kept == found or (asked is not None and not asked & kept):
            return kept
        found = kept


def by_components(space: Diagrams, along: Zdd, asked: Zdd | None) -> Zdd:
    """Dead states and components with an edge inside, one after the other, each with what leads there.

    Of a component without one, what leads there is not yet known to leave the set: only the component goes.
    """
    rest = along if asked is None else space.reached(asked & along, along)
    found = space.reaching(rest & space.dead, rest)
    rest -= found
    # Parts of what is left that no cycle crosses, each with the states that the next component is taken from.
    parts = [(rest, rest)]
    while parts and not (asked is not None and asked & found):
        part, hints = parts.pop()
        part -= found
        if not part:
            continue
        state = space.single((part & hints or part).pick() or ())
        forward, farthest = _ahead(space, state, part)
        component = space.reaching(state, forward)
        if space.before(component) & component:
            found |= space.reaching(component, rest)
            component = found
        beyond, behind = forward - component, part - forward
        parts += [(behind, space.before(component) & behind), (beyond, farthest)]
    return found


def _ahead(space: Diagrams, begin: Zdd, within: Zdd) -> tuple[Zdd, Zdd]:
    """What a state leads to inside a set, and its farthest layer."""
    found = layer = begin
    while new := space.after(layer) & within - found:
        found, layer = found | new, new
    return found, layer


WAYS: dict[str, Way] = {"layers": by_layers, "components": by_components, "turns": TURNS}


def run(way: str, space: Diagrams, along: Zdd, asked: Zdd | None) -> Result:
    """How many states one way finds, or, where some are asked for, whether these are among them."""
    started = time.process_time()
    found = WAYS[way](space, along, asked)
    cpu = time.process_time() - started
    return {"states": found.count() if asked is None else bool(found & asked), "cpu": cpu}


def _short(count: int | None) -> str:
    """A count, to three digits where it is long; whether those are found that are asked for."""
    return "?" if count is None else str(count) if count < 10**8 else f"{Decimal(count):.2e}"


class Comparison:
    """Prints a row for each set; ends the script where ways disagree."""

    def __init__(self, seconds: float) -> None:
        self.seconds = seconds
        self.ratios: dict[str, list[float]] = {way: [] for way in WAYS}
        self.won: dict[str, int] = dict.fromkeys(WAYS, 0)

    def compare(self, name: str, space: Diagrams, along: Zdd, asked: Zdd | None) -> None:
        """Runs every way on one set, each in its own process."""
        found = {way: measured(run, way, space, along, asked, seconds=self.seconds) for way in WAYS}
        answers = {result["states"] for result in found.values() if "states" in result}
        if len(answers) > 1:
            sys.exit(f"{name}: the ways disagree: {found}")
        took = {way: result["cpu"] for way, result in found.items() if "cpu" in result}
        if took and len(took) == len(WAYS) and max(took.values()) < QUICKLY:
            return
        cells = "".join(f"{took[way]:12.2f}" if way in took else f"{'-':>12}" for way in WAYS)
        print(
            f"{name:34}{_short(along.count()):>12}{_short(next(iter(answers), None)):>12}{cells}", flush=True
        )
        if took:
            best = min(took, key=lambda way: took[way])
            self.won[best] += 1
            for way in WAYS:
                self.ratios[way].append(took.get(way, self.seconds) / max(took[best], 0.001))

    def tell(self) -> None:
        """How often each way was the quickest, and how far from it in the middle and at worst."""
        for way, ratios in self.ratios.items():
            if ratios:
                middle, worst = statistics.median(ratios), max(ratios)
                print(f"{way}: quickest {self.won[way]} times; median {middle:.1f}, worst {worst:.0f} x that")


def nets() -> Iterator[PetriNet]:
    """Nets of our own that grow."""
    for count in (20, 50, 100):
        yield philosophers(count)
    for count in (8, 16, 24):
        yield component_ring(count)
    for count in (5, 8, 10):
        yield slotted_ring(count)
    for count in (5, 10, 20):
        yield kanban(count)
    for count in (5, 10):
        yield fms(count)


def of_families(comparison: Comparison) -> None:
    """Runs on which the first half of the transitions, or every other or third one, is never enabled."""
    for net in nets():
        space = Questions(net, engine="symbolic").space
        assert isinstance(space, Diagrams)
        everyone = range(len(net.transitions))
        halves = {
            "first half": everyone[: len(everyone) // 2],
            "every 2nd": everyone[::2],
            "every 3rd": everyone[::3],
        }
        for told, never in halves.items():
            along = space.everything - space.enabling(never)
            comparison.compare(f"{net.name} never {told}", space, along, None)


def of_contest(comparison: Comparison, folder: Path, model: str) -> None:
    """The sets that come up while the CTL formulas of a net are answered."""

    def staying(space: Diagrams, along: Zdd, asked: Zdd | None = None) -> Zdd:
        if (along, asked) not in space._left_off:
            comparison.compare(f"{model} {'from the start' if asked else ''}", space, along, asked)
        return TURNS(space, along, asked)

    Diagrams.staying = staying  # type: ignore[method-assign]
    questions = Questions(read_net(folder / model / "model.pnml"))
    for kind in ("CTLCardinality", "CTLFireability"):
        path = folder / model / f"{kind}.xml"
        try:
            for _ in answer_all(questions, read_properties(path, questions.names)):
                pass
        except McpnError as error:
            print(f"{model} {kind}: {error}")


def main() -> None:
    """Prints a row for each set that takes one of the ways a moment, and the totals."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--contest", nargs="+", metavar="FOLDER NET", help="sets of these nets' CTL formulas")
    parser.add_argument("--seconds", type=float, default=10, help="limit of each way on each set")
    arguments = parser.parse_args()
    comparison = Comparison(arguments.seconds)
    print(f"{'set':34}{'states':>12}{'found':>12}{''.join(f'{way:>12}' for way in WAYS)}  CPU seconds")
    if arguments.contest:
        folder, *models = arguments.contest
        for model in models:
            of_contest(comparison, Path(folder), model)
    else:
        of_families(comparison)
    comparison.tell()
    print(f"mcpn {__version__}, Python {platform.python_version()}, {platform.system()} {platform.machine()}")


if __name__ == "__main__":
    main()
