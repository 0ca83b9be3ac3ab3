"""What LTL3 says of finite words, by its definition: over all endless words that go on from them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from itertools import product

import numpy as np
from hypothesis import strategies as st

from mcpn.answers.requirements import AskedRequirement
from mcpn.controller.monitors.watched import Watcher, on_one_path
from mcpn.events import Event
from mcpn.logic.syntax import parse
from mcpn.mission.requirement import Requirement
from mcpn.nets.petri import NetBuilder, PetriNet
from mcpn.spaces.arrays import ArraySpace
from mcpn.spaces.formula_names import Names
from mcpn.spaces.markings.explicit import explore
from tests.answers.patterns.words import Words

LETTERS = ("", "p", "q", "pq")
"""In the order of :class:`Words`."""
LONGEST, AHEAD = 4, 4
"""Letters of a finite word; of what follows it, the repeated ones once."""


def formulas() -> st.SearchStrategy[str]:
    """Small formulas on paths over p and q, with few X: short endless words tell what follows from them."""
    atoms = st.sampled_from(["p", "q", "!p", "!q"])

    def wider(inside: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
        return st.one_of(
            st.builds("({} {})".format, st.sampled_from(["!", "X", "F", "G"]), inside),
            st.builds(
                "({1} {0} {2})".format, st.sampled_from(["&", "|", "->", "U", "R", "W"]), inside, inside
            ),
        )

    drawn = st.recursive(atoms, wider, max_leaves=4)
    return drawn.filter(lambda text: text.count("X") < 3 and set("XFGURW") & set(text))


@cache
def endless() -> list[Words]:
    length = LONGEST + AHEAD
    return [Words("pq", length, cycle) for cycle in range(length)]


def by_definition(text: str) -> dict[tuple[int, ...], str]:
    """The verdict on each finite word that begins with the empty letter, by the numbers of its letters."""
    may: dict[bool, list[np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]] = {True: [], False: []}
    for words in endless():
        found = words.satisfying(text)
        may[True].append(found)
        may[False].append(~found)
    some = {truth: np.logical_or.reduce(arrays) for truth, arrays in may.items()}
    verdicts = {}
    for length in range(1, LONGEST + 1):
        # The number of an endless word in the base of the letters begins, from the right, with its first.
        hold, fail = (some[t].reshape(-1, len(LETTERS) ** length).any(axis=0) for t in (True, False))
        for rest in product(range(len(LETTERS)), repeat=length - 1):
            word = (0, *rest)
            number = sum(letter * len(LETTERS) ** i for i, letter in enumerate(word))
            verdicts[word] = "violated" if not hold[number] else "open" if fail[number] else "satisfied"
    return verdicts


@cache
def every_letter() -> PetriNet:
    """A net whose markings are the letters; each leads to each, by an event of the letter's name."""
    builder = NetBuilder("letters")
    for name in "pq":
        builder.place(name)
        builder.place(f"not_{name}", initial=1)
    for before, after in product(LETTERS, repeat=2):
        consume, produce = ([n if n in letter else f"not_{n}" for n in "pq"] for letter in (before, after))
        name = f"from_{before}_to_{after}"
        builder.transition(name, consume=consume, produce=produce, event=Event.parse(f"to_{after}"))
    return builder.build()


def by_monitor(text: str) -> Iterator[tuple[tuple[int, ...], str]]:
    """The verdict of the monitor on the same words."""
    names = Names(every_letter())
    asked = AskedRequirement("r", Requirement(name="r", formula=text), text, parse(text, names), names)
    formula = on_one_path(asked)
    assert formula is not None
    monitor = Watcher(ArraySpace(explore(every_letter()))).monitor(asked, formula)
    for rest in product(range(len(LETTERS)), repeat=LONGEST - 1):
        values = monitor.run(f"to_{LETTERS[letter]}" for letter in rest)
        yield from (((0, *rest[:length]), value) for length, value in enumerate(values))
