"""Calls every function of the kernel with drawn arguments: ``python -m tests.kernel.arguments SEED ROUNDS``.

Each round is made in a process of its own. What ended one is printed with the last call that it made, and at
the end how often each function was called. An argument that does not fit must raise an exception.
"""

from __future__ import annotations

import os
import resource
import sys
from collections import Counter, defaultdict
from collections.abc import Callable
from mmap import mmap
from random import Random
from typing import Any

import numpy as np

from mcpn import _kernel as kernel

ROOM = 2 << 30
"""Bytes that the process may have: what asks for more is a MemoryError."""

EXPECTED = (ValueError, TypeError, IndexError, OverflowError, MemoryError, RuntimeError)
"""What a call may raise."""

FAR = (
    -(1 << 63),
    -1,
    1 << 20,
    1 << 31,
    (1 << 32) - 1,
    (1 << 32) - 40,
    1 << 62,
    (1 << 63) - 1,
    (1 << 64) - 1,
    1 << 130,
)
GARBAGE: tuple[Any, ...] = (None, "word", 1.5, [], [[]], b"\0" * 12, object())

DEEP = 200_000
"""How deep goals and operators are nested now and then."""

CALLS = 150
"""In one round."""

Draw = Callable[..., Any]


class Caller:
    """Draws objects of the kernel and arguments for them; most fit, for those that do get further.

    Args:
        seed: What is drawn depends on it alone.
        last: Where the name of the last call is written.
    """

    def __init__(self, seed: int, last: mmap) -> None:
        self.random = Random(seed)
        self.last = last
        self.made = defaultdict[type, list[Any]](list)
        self.known = defaultdict[int, list[int]](list)  # events and conditions, by store
        self.called = Counter[str]()
        self.places = self.random.choice((0, 1, 3, 5, 70, 130))

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def number(self, below: int | None = None) -> Any:
        """A number, nearly always from 0 to one below a limit."""
        if self.chance(0.02):
            return self.random.choice(FAR)
        if self.chance(0.03):
            return self.random.randrange(-2, 140)
        return self.random.randrange(max(below if below is not None else self.places, 1))

    def few(self, draw: Draw, most: int = 4) -> list[Any]:
        return [draw() for _ in range(self.random.randrange(most + 1))]

    def numbers(self, below: int | None = None, most: int = 4) -> list[Any]:
        found = self.few(lambda: self.number(below), most)
        return found if self.chance(0.1) else list(dict.fromkeys(found))

    def weight(self) -> int:
        found: int = self.random.choice((-2, -1, 1, 1, 2, 0, *(FAR if self.chance(0.05) else ())))
        return found

    def arcs(self) -> list[Any]:
        return [(place, self.weight()) for place in self.numbers()]

    def flag(self) -> bool:
        return self.chance(0.5)

    def limit(self) -> int:
        return self.random.choice((0, 1, 10, 100, 2_000))

    def bytes_limit(self) -> int:
        return self.random.choice((0, 100, 1 << 12, 1 << 16, 1 << 22, 1 << 22))

    def rank(self) -> int:
        return self.random.choice((0, 1, 1, 0xFFFF, 0xFFFF))

    def order(self) -> list[int]:
        found = list(range(self.places))
        self.random.shuffle(found)
        return [*found, 0] if self.chance(0.05) else found

    def rows(self, columns: int | None = None) -> Any:
        """Markings as rows of words."""
        width = max(1, (self.places + 63) // 64) if columns is None or self.chance(0.9) else columns
        width += self.random.choice((-1, 1)) * self.chance(0.05)
        height = self.random.randrange(4)
        low = np.array([[self.random.getrandbits(64) for _ in range(max(width, 0))] for _ in range(height)])
        rows = low.astype(np.uint64).reshape(height, max(width, 0))
        if self.places % 64 and rows.shape[1] and self.chance(0.8):
            rows[:, -1] &= np.uint64((1 << self.places % 64) - 1)
        return rows

    def graph(self, kind: Any) -> tuple[Any, Any]:
        """Offsets and targets, which nearly always fit each other."""
        states = self.random.randrange(5)
        rows = [
            [self.number(states) for _ in range(self.random.randrange(3) if states else 0)]
            for _ in range(states)
        ]
        ends = np.cumsum([0, *map(len, rows)])
        if self.chance(0.1):
            ends = ends + self.random.choice((-1, 1, 1 << 40))
        limits = np.iinfo(kind)
        return ends.astype(np.int64), np.array(
            [min(max(target, limits.min), limits.max) for row in rows for target in row], dtype=kind
        )

    def mask(self, size: int) -> Any:
        return np.array([self.flag() for _ in range(size + self.chance(0.1))], dtype=bool)

    def some(self, kind: type) -> Any:
        """An object made before."""
        if not self.made[kind]:
            self.make(kind)
        return self.random.choice(self.made[kind]) if self.made[kind] else None

    def make(self, kind: type) -> None:
        """Makes an object of a class, if the arguments drawn for it fit."""
        match kind:
            case kernel.Zdd | kernel.Markings:
                self.call(kernel.Store, "singleton" if kind is kernel.Zdd else "empty")
                if kind is kernel.Markings:
                    self.call(kernel.Zdd, "__iter__")
            case kernel.Exploration:
                self.call(self.random.choice((kernel.SafeNet, kernel.CountedNet)), "explore")
            case kernel.Explorer:
                self.call(kernel.SafeNet, "explorer")
            case kernel.GoalSearch:
                self.call(kernel.TokenNet, self.random.choice(("seek", "plan")))
            case _:
                self.keep(self.attempt(kind.__name__, kind, CLASSES[kind](self)))

    def transitions(self) -> list[Any]:
        found = [
            (
                need := self.numbers(),
                need if self.chance(0.9) else self.numbers(),
                self.numbers(),
                self.rank(),
                self.chance(0.1),
            )
            for _ in range(self.random.randrange(7))
        ]
        return found if self.chance(0.05) else sorted(found, key=lambda transition: transition[3])

    def rules(self) -> list[Any]:
        """Transitions that take what they need."""
        found = []
        for _ in range(self.random.randrange(7)):
            need = [(place, self.random.randrange(1, 3)) for place in self.numbers()]
            change = [(place, -tokens) for place, tokens in need] + [(place, 1) for place in self.numbers()]
            found.append((need, self.arcs() if self.chance(0.1) else change, self.rank()))
        return found

    def fields(self) -> list[Any]:
        return [
            (p // 8 + self.number(1), p % 8 * 8, 8 if self.chance(0.98) else self.number(70))
            for p in range(self.places)
        ]

    def nodes(self, kinds: tuple[str, ...], more: Callable[[], tuple[Any, ...]]) -> list[Any]:
        deep = DEEP if self.chance(0.02) else 0
        found = [
            (self.random.choice(kinds), self.numbers(number, 2), *more())
            for number in range(self.random.randrange(1, 6))
        ]
        return found + [("all", [len(found) - 1 + at], *more()) for at in range(deep)]

    def operators(self) -> list[Any]:
        kinds = ("not", "all", "any", "next", "until", "always")
        found = [("goal", [self.number(2)]), ("goal", [self.number(2)])]
        for number in range(2, 2 + self.random.randrange(6)):
            kind = self.random.choice(kinds)
            size = {"until": 2, "not": 1, "next": 1, "always": 1}.get(kind, self.random.randrange(3))
            found.append((kind, [self.number(number) for _ in range(size)]))
        deep = DEEP if self.chance(0.02) else 0
        return found + [("until", [len(found) - 1 + at] * 2) for at in range(deep)]

    def root(self) -> Any:
        """A goal or an operator, the deepest of which there are many now and then."""
        return 1 + DEEP if self.chance(0.2) else self.number(6)

    def marking(self) -> list[Any]:
        return [
            self.random.choice((0, 1, 1, 2, *(FAR if self.chance(0.01) else ()))) for _ in range(self.places)
        ]

    def edges(self) -> list[Any]:
        return [
            [
                (
                    self.numbers(2, 2),
                    self.random.getrandbits(3),
                    self.number(2),
                    self.random.choice((None, self.numbers(5))),
                    self.flag(),
                )
                for _ in range(self.random.randrange(3))
            ]
            for _ in range(2)
        ]

    def table(self) -> bytes:
        """Big steps as bytes: a way, a function, or anything."""
        if self.chance(0.2):
            return self.random.randbytes(self.random.randrange(40))
        rows: list[int] = []
        for _ in range(self.random.randrange(3)):
            levels = sorted({self.number(max(self.places, 1)) % (1 << 20) for _ in range(3)})
            if self.chance(0.5):
                rows += [len(levels), *(level << 2 | self.random.randrange(4) for level in levels)]
            else:
                part: list[int] = []
                for at, level in enumerate(reversed(levels)):
                    part += [level, self.random.randrange(4), at, self.number(at + 1) % 8]
                rows += [(1 << 32) - 1, len(part), *part]
        return np.array(rows, dtype=np.uint32).tobytes()

    def set_in_bytes(self) -> Any:
        """A set as a table of its nodes, or rows of anything."""
        known = self.made[kernel.Zdd]
        if known and self.flag():
            return self.attempt("Zdd.to_bytes", self.random.choice(known).to_bytes, ())
        return self.random.randbytes(12 * self.random.randrange(4))

    def ids(self, store: Any) -> list[Any]:
        """Events and conditions of a store."""
        known = self.known[id(store)]
        found = [self.random.choice(known) for _ in range(self.random.randrange(4))] if known else []
        return [*found, self.number(1 << 40)] if self.chance(0.05) else found

    def call(self, kind: type | None, name: str) -> None:
        """Calls a function of the kernel, or a method or property of an object of a class."""
        label = name if kind is None else f"{kind.__name__}.{name}"
        subject = kernel if kind is None else self.some(kind)
        if subject is None:
            return
        if label not in METHODS:
            self.attempt(label, lambda: getattr(subject, name), ())
            return
        found = self.attempt(label, getattr(subject, name), METHODS[label](self, subject))
        if label.startswith("Store.") and isinstance(found, int):
            self.known[id(subject)].append(found)
        self.keep(found)

    def attempt(self, label: str, function: Draw, arguments: tuple[Any, ...]) -> Any:
        self.called[label] += 1
        self.last[: len(label) + 1] = f"{label}\n".encode()
        given = list(arguments)
        if given and self.chance(0.02):
            given[self.random.randrange(len(given))] = self.random.choice(GARBAGE)
        try:
            return function(*given)
        except (StopIteration, *EXPECTED):
            return None

    def keep(self, found: Any) -> None:
        if type(found) is tuple:
            for one in found:
                self.keep(one)
        if type(found) in ANSWERS:
            self.made[type(found)].append(found)


def _grouped(me: Caller) -> tuple[Any, ...]:
    return me.few(lambda: me.numbers(most=6), 5), me.order()


def _of_graph(*masks: str) -> Callable[[Caller, Any], tuple[Any, ...]]:
    """Arguments of a function on rows of targets: masks over states or edges."""

    def drawn(me: Caller, _: Any) -> tuple[Any, ...]:
        offsets, targets = me.graph(np.uint32)
        sizes = {"states": len(offsets) - 1, "edges": len(targets)}
        return offsets, targets, *(me.mask(sizes[mask]) for mask in masks)

    return drawn


def _passages(me: Caller, _: Any) -> tuple[Any, ...]:
    offsets, targets = me.graph(np.int64)
    rows = np.zeros((len(offsets) - 1, max(1, (me.places + 63) // 64)), dtype=np.uint64)
    if me.chance(0.5) and rows.size:
        rows[0, -1] = me.random.getrandbits(64)
    events = np.array([me.random.randrange(7) for _ in targets], dtype=np.uint32)
    leaving = [me.numbers(2, 2) for _ in range(me.random.randrange(7))]
    return rows, offsets, targets, events, leaving, [(me.numbers(), me.numbers()) for _ in range(2)]


def _staying(me: Caller, _: Any) -> tuple[Any, ...]:
    offsets, targets, along = _of_graph("states")(me, None)
    try:
        back = kernel.incoming(offsets, targets)
    except ValueError:
        back = (offsets, targets)
    return offsets, targets, *(me.graph(np.uint32) if me.chance(0.2) else back), along


def _terms(me: Caller) -> list[Any]:
    return me.few(lambda: (me.number(2), me.number(60), me.random.randrange(5), me.weight()), 3)


CLASSES: dict[type, Callable[[Caller], tuple[Any, ...]]] = {
    kernel.Store: lambda me: (
        me.number() if me.chance(0.1) else me.places,
        me.random.choice((1 << 16, 1 << 24)),
    ),
    kernel.SafeNet: lambda me: (
        me.places if me.chance(0.97) else me.number(),
        me.transitions(),
        me.chance(0.8),
    ),
    kernel.CountedNet: lambda me: (me.fields(), me.rules(), me.flag()),
    kernel.TokenNet: lambda me: (me.places if me.chance(0.97) else me.number(), me.rules(), me.flag()),
    kernel.Goals: lambda me: (
        me.places if me.chance(0.9) else me.number(200),
        me.nodes(("all", "any", "at_most", "at_most", "dead", "not_dead"), lambda: (me.arcs(), me.weight())),
    ),
    kernel.Checker: lambda me: (
        me.some(kernel.TokenNet),
        me.marking(),
        me.some(kernel.Goals),
        me.operators(),
        me.bytes_limit(),
    ),
    kernel.PathFinder: lambda me: (
        me.some(kernel.TokenNet),
        me.marking(),
        me.some(kernel.Goals),
        me.numbers(2),
        me.edges(),
        me.random.getrandbits(3),
        [me.flag(), me.flag()],
        [me.number(2), me.number(2)],
    ),
    kernel.BigSteps: lambda me: (
        me.some(kernel.SafeNet),
        me.numbers(),
        [p if me.chance(0.98) else me.number() for p in range(me.places)],
        me.few(lambda: (me.number(), me.number()), 1),
        me.bytes_limit(),
        me.limit(),
        me.random.choice((0, 1, 300)),
    ),
}
ANSWERS = {
    *CLASSES,
    kernel.Zdd,
    kernel.Firings,
    kernel.Markings,
    kernel.Exploration,
    kernel.Explorer,
    kernel.GoalSearch,
}
BOTH = lambda me, _: (me.some(kernel.Zdd),)  # noqa: E731
NOTHING = lambda me, _: ()  # noqa: E731
METHODS: dict[str, Callable[[Caller, Any], tuple[Any, ...]]] = {
    "force": lambda me, _: (*_grouped(me), me.random.randrange(5)),
    "closing": lambda me, _: _grouped(me),
    "sloan": lambda me, _: _grouped(me),
    "clustered": lambda me, _: _grouped(me),
    "stable_ends": lambda me, _: (*(graph := me.graph(np.int64)), me.mask(len(graph[0]) - 1)),
    "incoming": _of_graph("edges"),
    "spread": _of_graph("states", "states", "edges"),
    "staying": _staying,
    "sweep_reaching": _of_graph("states", "states", "edges"),
    "sweep_staying": _of_graph("states"),
    "stays": _of_graph("states", "states"),
    "before": _of_graph("states", "edges"),
    "weigh": lambda me, _: (me.rows(2), _terms(me)),
    "satisfying": lambda me, _: (me.rows(2), me.few(lambda: me.few(lambda: (_terms(me), me.weight()), 2), 2)),
    "choices": lambda me, _: (
        me.some(kernel.Store),
        me.table(),
        me.random.choice(("ahead", "back", "where", "")),
        me.numbers(most=2),
    ),
    "Store.empty": NOTHING,
    "Store.from_bytes": lambda me, _: (me.set_in_bytes(),),
    "Store.from_markings": lambda me, _: (
        me.rows(),
        [bit if me.chance(0.98) else me.number() for bit in range(me.places)],
    ),
    "Store.singleton": lambda me, _: (me.numbers(),),
    "Store.event": lambda me, _: (*(me.numbers(most=1) for _ in range(4)),),
    "Store.condition": lambda me, _: (me.numbers(most=2), me.numbers(most=1)),
    "Store.branch": lambda me, store: (me.number(), *(next(iter(me.ids(store)), None) for _ in range(4))),
    "Store.collect": NOTHING,
    "Zdd.__or__": BOTH,
    "Zdd.__and__": BOTH,
    "Zdd.__sub__": BOTH,
    "Zdd.__eq__": BOTH,
    "Zdd.__hash__": NOTHING,
    "Zdd.__bool__": NOTHING,
    "Zdd.__iter__": NOTHING,
    "Zdd.count": NOTHING,
    "Zdd.nodes": NOTHING,
    "Zdd.to_bytes": NOTHING,
    "Zdd.pick": NOTHING,
    "Zdd.subset": lambda me, _: (me.numbers(most=2), me.numbers(most=1)),
    "Zdd.onto": lambda me, _: (me.numbers(),),
    "Zdd.largest": lambda me, _: ([me.weight() for _ in range(me.places)],),
    "Zdd.without": lambda me, _: (me.ids(me.some(kernel.Store)),),
    "Zdd.counts": lambda me, _: (me.ids(me.some(kernel.Store)),),
    "Zdd.first": lambda me, _: (me.ids(me.some(kernel.Store)),),
    "Zdd.images": lambda me, _: (
        me.ids(me.some(kernel.Store)),
        me.random.choice((None, me.some(kernel.Zdd))),
    ),
    "Zdd.beyond": lambda me, _: (me.some(kernel.Zdd), me.ids(me.some(kernel.Store))),
    "Zdd.saturate": lambda me, _: (
        me.ids(me.some(kernel.Store)),
        me.limit(),
        me.random.choice((None, me.some(kernel.Zdd))),
        me.limit(),
    ),
    "Zdd.weighing": lambda me, _: ([me.weight() for _ in range(me.places)], me.weight(), me.weight()),
    "Markings.__iter__": NOTHING,
    "Markings.__next__": NOTHING,
    "Exploration.run": lambda me, _: (me.number(10),),
    "Exploration.take_markings": NOTHING,
    "Exploration.take_offsets": NOTHING,
    "Exploration.take_targets": NOTHING,
    "Exploration.take_labels": NOTHING,
    "Explorer.run": lambda me, _: (me.random.choice((0, 1, 5)),),
    "Explorer.take": NOTHING,
    "Explorer.cancel": NOTHING,
    "BigSteps.start": lambda me, _: (me.some(kernel.Store),),
    "BigSteps.cover": lambda me, _: (me.some(kernel.Zdd), me.number(7), me.random.randrange(4)),
    "BigSteps.after": lambda me, _: (me.some(kernel.Zdd), me.number(7)),
    "BigSteps.after_together": lambda me, _: (
        me.few(lambda: (me.some(kernel.Zdd), me.number(7)), 3),
        me.limit(),
    ),
    "BigSteps.function": lambda me, _: (
        me.some(kernel.Zdd),
        me.random.choice(me.made[kernel.Firings] or [None]),
        me.flag(),
    ),
    "SafeNet.explore": lambda me, _: (me.numbers(), me.flag(), me.limit(), me.bytes_limit()),
    "SafeNet.explorer": lambda me, _: (me.numbers(), me.bytes_limit(), me.flag()),
    "SafeNet.labels": lambda me, _: (me.rows(),),
    "SafeNet.passages": _passages,
    "SafeNet.units": lambda me, _: (me.numbers(),),
    "SafeNet.settle": lambda me, _: (
        me.numbers(),
        me.random.choice(("one", "enough", "every", "?")),
        me.limit(),
        me.limit(),
        me.bytes_limit(),
        None,
        me.limit(),
    ),
    "CountedNet.explore": lambda me, _: (me.marking(), me.flag(), me.limit(), me.bytes_limit()),
    "TokenNet.walk": lambda me, _: (
        me.marking(),
        me.some(kernel.Goals),
        me.numbers(2),
        me.limit(),
        me.limit(),
        me.number(1 << 60),
        me.flag(),
        [] if me.flag() else [me.weight() for _ in range(me.random.randrange(7))],
    ),
    "TokenNet.seek": lambda me, _: (
        me.marking(),
        me.some(kernel.Goals),
        me.root(),
        me.flag(),
    ),
    "TokenNet.plan": lambda me, _: (
        me.marking(),
        me.some(kernel.Goals),
        me.root(),
        me.number(1 << 60),
    ),
    "GoalSearch.search": lambda me, _: (me.limit(), me.bytes_limit()),
    "PathFinder.search": lambda me, _: (
        me.limit(),
        me.bytes_limit(),
        me.number(1 << 60),
        me.flag(),
        me.limit(),
    ),
    "Checker.decide": lambda me, _: (me.root(), me.limit(), me.number(9)),
}
LEFT_OUT = {"Store.cancel", "Store.progress"}
"""What ends a store for good; and what is no call."""


def everything() -> list[tuple[type | None, str]]:
    """All that the module declares: functions, methods and properties."""
    found: list[tuple[type | None, str]] = []
    for name, value in vars(kernel).items():
        if isinstance(value, type):
            if issubclass(value, Exception):
                continue
            special = {label.partition(".")[2] for label in METHODS if label.startswith(f"{name}.")}
            inside = [inner for inner in vars(value) if not inner.startswith("_") or inner in special]
            found += [(value, inner) for inner in inside if f"{name}.{inner}" not in LEFT_OUT]
        elif callable(value):
            found.append((None, name))
    return found


def say(line: str) -> None:
    os.write(sys.stdout.fileno(), f"{line}\n".encode())


def main(seed: int, rounds: int) -> None:
    """Makes some rounds of calls, each with objects of its own."""
    resource.setrlimit(resource.RLIMIT_AS, (ROOM, ROOM))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    calls, last, counts = everything(), mmap(-1, 4096), mmap(-1, 1 << 16)
    labels = sorted(
        {name if kind is None else f"{kind.__name__}.{name}" for kind, name in calls}
        | {k.__name__ for k in CLASSES}
    )
    called = np.frombuffer(counts, dtype=np.int64)
    for number in range(seed, seed + rounds):
        child = os.fork()
        if child == 0:
            status = 1
            try:
                caller = Caller(number, last)
                for made in caller.random.sample(list(CLASSES), len(CLASSES)):
                    caller.make(made)
                for kind, name in caller.random.choices(calls, k=CALLS):
                    caller.call(kind, name)
                for label, times in caller.called.items():
                    called[labels.index(label)] += times
                status = 0
            except BaseException as error:
                say(f"round {number}: {type(error).__name__}: {str(error)[:200]}")
            finally:
                os._exit(status)
        ended = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if ended:
            call = last[:].split(b"\n")[0].decode()
            say(f"round {number} ended with {ended} in {call}")
    for at, label in enumerate(labels):
        say(f"called {called[at]} {label}")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
