"""What is answered of drawn nets and questions in the manner of the Model Checking Contest.

Usage: ``python experiments/nets/contest_drawn.py [--seconds 15] [--small] [FAMILY...]``. Of each net of
:mod:`experiments.shared.contest_nets` 16 questions of each of the contest's seven kinds and five
examinations are asked in one process with so many seconds of CPU time. Answers of small nets are compared
with those that the explicit engine gives. ``--save FILE`` keeps the answers, ``--against FILE`` compares with
kept ones. It takes up to 15 seconds for each net.
"""

from __future__ import annotations

import argparse
import json
import random
import resource
import sys
from collections import Counter
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parents[2]))

from experiments.nets.mcc_properties import cpu_of_children, told_by
from experiments.shared.contest_nets import MADE
from mcpn.nets.petri import PetriNet

EXAMINATIONS = ("OneSafe", "QuasiLiveness", "StableMarking", "Liveness", "ReachabilityDeadlock")
KINDS = ("Reachability", "CTL", "LTL")
EACH, GIB = 16, 3


class Drawing:
    """Draws questions about one net; the same net has the same.

    Args:
        net: The net.
        kind: What is asked, which draws others.
    """

    def __init__(self, net: PetriNet, kind: str) -> None:
        self.net, self.draw = net, random.Random(f"{kind} of {net.name}")
        self.cardinality = kind.endswith("Cardinality")
        self.places = [f'"{place.name}"' for place in net.places]
        self.transitions = [f'"{transition.name}"' for transition in net.transitions]

    def some(self, of: list[str], most: int) -> str:
        """One or more names, with commas."""
        return ", ".join(self.draw.sample(of, min(self.draw.randint(1, most), len(of))))

    def atom(self) -> str:
        """A condition on tokens, or on what may fire."""
        if not self.cardinality:
            return f"enabled({self.some(self.transitions, 3)})"
        left = f"tokens({self.some(self.places, 3)})"
        if self.draw.random() < 0.5:
            return f"{left} <= tokens({self.some(self.places, 3)})"
        return f"{left} >= {self.draw.randint(1, 3)}"

    def condition(self, depth: int) -> str:
        """Atoms joined by connectives."""
        kind = self.draw.random()
        if depth == 0 or kind < 0.2:
            return self.atom()
        if kind < 0.35:
            return f"!({self.condition(depth - 1)})"
        joined = self.draw.choice((" & ", " | "))
        return f"({self.condition(depth - 1)}{joined}{self.condition(depth - 1)})"

    def reachability(self) -> str:
        """Whether a condition may hold, or always holds."""
        return f"{self.draw.choice(('EF', 'AG'))} ({self.condition(self.draw.choice((1, 2, 3)))})"

    def ctl(self, depth: int = 3) -> str:
        """A formula on all paths and some path, with operators in each other."""
        kind = self.draw.random()
        if depth == 0 or (depth < 3 and kind < 0.25):
            return self.condition(1)
        if kind < 0.4:
            return f"({self.ctl(depth - 1)}{self.draw.choice((' & ', ' | '))}{self.ctl(depth - 1)})"
        if kind < 0.45:
            return f"!({self.ctl(depth - 1)})"
        if kind < 0.6:
            return f"{self.draw.choice('EA')}[{self.ctl(depth - 1)} U {self.ctl(depth - 1)}]"
        operator = self.draw.choice(("EF", "AG", "AF", "EG", "AF", "EG", "AG", "EF", "EX", "AX"))
        return f"{operator} ({self.ctl(depth - 1)})"

    def ltl(self) -> str:
        """A formula on each path."""
        return f"A ({self.path(3)})"

    def path(self, depth: int) -> str:
        """A formula on one path, with operators in each other."""
        kind = self.draw.random()
        if depth == 0 or (depth < 3 and kind < 0.2):
            return self.condition(1)
        if kind < 0.4:
            return f"({self.path(depth - 1)}{self.draw.choice((' & ', ' | '))}{self.path(depth - 1)})"
        if kind < 0.55:
            return f"(({self.path(depth - 1)}) U ({self.path(depth - 1)}))"
        return f"{self.draw.choice('FGFGFGX')} ({self.path(depth - 1)})"


def questions(net: PetriNet) -> dict[str, str | tuple[int, ...]]:
    """The drawn questions of a net by name: formulas as text, and places whose bound is asked."""
    found: dict[str, str | tuple[int, ...]] = {}
    for kind in (kind + of for kind in KINDS for of in ("Cardinality", "Fireability")):
        drawing = Drawing(net, kind)
        of = {"R": drawing.reachability, "C": drawing.ctl, "L": drawing.ltl}[kind[0]]
        found |= {f"{kind}-{number:02}": of() for number in range(EACH)}
    drawing = Drawing(net, "UpperBounds")
    every = range(len(net.places))
    for number in range(EACH):
        count = min(drawing.draw.choice((1, 1, 1, 2, 3, 5)), len(every))
        found[f"UpperBounds-{number:02}"] = tuple(drawing.draw.sample(every, count))
    return found


def answer(net: PetriNet, engine: str, seconds: int, asked: set[str], answers: Connection) -> None:
    """Answers questions of a net, all or those asked; sends them as they come."""
    from mcpn.errors import McpnError, Source
    from mcpn.logic.answering import answer_all
    from mcpn.logic.contest import Property
    from mcpn.logic.questions import Questions
    from mcpn.logic.syntax import parse
    from mcpn.spaces.formula_names import Names

    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    resource.setrlimit(resource.RLIMIT_AS, (GIB << 30, GIB << 30))
    names, properties = Names(net), []
    for name, what in questions(net).items():
        if not asked or name in asked:
            meaning = what if isinstance(what, tuple) else parse(what, names)
            properties.append(Property(name, meaning, Source(net.name)))
    examinations = [name for name in EXAMINATIONS if not asked or name in asked]
    with suppress(McpnError, MemoryError):
        for verdict in answer_all(Questions(net, engine=engine), properties, examinations):
            answers.send((verdict.name.removeprefix(f"{net.name}-"), verdict.value, verdict.techniques))


def main() -> None:
    """Prints a row for each net, and what is open by kind of question."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("families", nargs="*")
    parser.add_argument("--seconds", type=int, default=15)
    parser.add_argument("--small", action="store_true", help="the small nets alone")
    parser.add_argument("--large", action="store_true", help="the large nets alone")
    parser.add_argument("--size", type=int, help="this size alone")
    parser.add_argument("--only", action="append", default=[], metavar="QUESTION")
    parser.add_argument("--save", type=Path)
    parser.add_argument("--against", type=Path)
    arguments = parser.parse_args()
    kept: dict[str, dict[str, str]] = {}
    known = json.loads(arguments.against.read_text()) if arguments.against else {}
    opened, asked, wrong = Counter[str](), 0, 0
    only = set(arguments.only)
    for family in arguments.families or MADE:
        make, small, large = MADE[family]
        sizes = (*(() if arguments.large else small), *(() if arguments.small else large))
        for size in [size for size in sizes if arguments.size in (None, size)]:
            net = make(size)
            names = only or {*questions(net), *EXAMINATIONS}
            before = cpu_of_children()
            told = list(told_by(answer, net, "auto", arguments.seconds, only))
            cpu, found = cpu_of_children() - before, {name: value for name, value, _ in told}
            right = dict(known.get(net.name, {}))
            if size in small:
                right |= {n: v for n, v, _ in told_by(answer, net, "explicit", 4 * arguments.seconds, only)}
            differ = [name for name in found if name in right and found[name] != right[name]]
            left = sorted(names - found.keys())
            kept[net.name] = found
            asked, wrong = asked + len(names), wrong + len(differ)
            opened.update(name.split("-")[0] for name in left)
            counts = Counter(name.split("-")[0] for name in left)
            row = ", ".join(f"{kind} {count}" for kind, count in counts.items())
            row += f"; compared {len(right)}" if right else ""
            row += f"  WRONG: {' '.join(differ)}" if differ else ""
            print(f"{net.name:22} {cpu:6.2f} s CPU, {len(left):3} open: {row}", flush=True)
    for kind, count in opened.most_common():
        print(f"{kind:26} {count:4} open")
    print(f"{opened.total()} of {asked} open, {wrong} wrong")
    if arguments.save:
        arguments.save.write_text(json.dumps(kept, indent=1))


if __name__ == "__main__":
    main()
