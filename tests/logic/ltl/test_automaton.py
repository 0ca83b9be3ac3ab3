"""Automata of formulas: their language against other translators; components of graphs."""

from __future__ import annotations

import re
import shutil
from itertools import product
from pathlib import Path

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.errors import LimitError
from mcpn.logic.ltl import automaton
from mcpn.logic.ltl.automaton import translated
from mcpn.logic.ltl.formula_classes import classes, is_stutter_insensitive
from mcpn.logic.ltl.formulas import Happens, Next, Until, always, eventually, normal
from mcpn.logic.ltl.hoa import write_hoa
from mcpn.logic.syntax import parse_open
from mcpn.logic.writing import show
from mcpn.nets.petri import NetBuilder
from mcpn.spaces.components import strongly_connected
from mcpn.spaces.formula_names import Names
from mcpn.spaces.search.goal import And, Formula, Not, Or, marked
from tests.commands import mcpn
from tests.logic.ltl.translators import (
    LETTERS,
    OURS,
    Letter,
    Written,
    by_lbt,
    by_spin,
    formulas,
    infix,
    of_hoa,
)

GRAPHS = st.integers(1, 9).flatmap(
    lambda n: st.lists(st.lists(st.integers(0, n - 1), max_size=4), min_size=n, max_size=n)
)


@given(GRAPHS)
def test_components_are_those_of_the_graph(targets: list[list[int]]) -> None:
    found = strongly_connected(targets)
    graph = nx.DiGraph((q, t) for q, of in enumerate(targets) for t in of)
    graph.add_nodes_from(range(len(targets)))
    assert {frozenset(c) for c in found} == set(map(frozenset, nx.strongly_connected_components(graph)))
    place = {q: i for i, component in enumerate(found) for q in component}
    assert all(place[t] <= place[q] for q, of in enumerate(targets) for t in of)


def ours(formula: Written, *, wanted: bool = True) -> str:
    """Our automaton of a formula or of its negation, in the Hanoi format."""
    builder = NetBuilder("letters")
    for name in "pq":
        builder.place(name)
    names = Names(builder.build())
    found = normal(parse_open(infix(formula, OURS), names), wanted)
    return write_hoa(translated(found), "a formula", found, lambda f: show(f, names))


WORDS = [
    ([LETTERS[i] for i in word], cycle)
    for length in range(1, 5)
    for word in product(range(4), repeat=length)
    for cycle in range(length)
]


@pytest.mark.parametrize("tool", ["spin", "lbt"])
def test_the_language_is_that_of_other_translators(tool: str) -> None:
    if shutil.which(tool) is None:
        pytest.skip(f"needs {tool}, a package of Debian")
    translate = {"spin": by_spin, "lbt": by_lbt}[tool]

    # SPIN of Debian is built without X.
    @given(
        formulas("!FG" if tool == "spin" else "!XFG"),
        st.lists(st.sampled_from(WORDS), min_size=20, max_size=20),
    )
    def same(formula: Written, words: list[tuple[list[Letter], int]]) -> None:
        other, negated = translate(formula), translate(("!", formula))
        mine, mine_negated = of_hoa(ours(formula)), of_hoa(ours(formula, wanted=False))
        assert not mine.meets(negated)
        assert not mine_negated.meets(other)
        for word, cycle in words:
            accepted = other.accepts(word, cycle)
            assert mine.accepts(word, cycle) == accepted
            assert mine_negated.accepts(word, cycle) != accepted

    same()


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G p", ["safety", "obligation", "recurrence", "persistence", "stutter-insensitive"]),
        ("F p", ["guarantee", "obligation", "recurrence", "persistence", "stutter-insensitive"]),
        ("G (p -> X q)", ["safety", "obligation", "recurrence", "persistence"]),
        ("F p | G q", ["obligation", "recurrence", "persistence", "stutter-insensitive"]),
        ("G F p", ["recurrence", "stutter-insensitive"]),
        ("F G p", ["persistence", "stutter-insensitive"]),
        ("G F p & F G q", ["reactivity", "stutter-insensitive"]),
    ],
)
def test_classes_of_formulas(text: str, expected: list[str]) -> None:
    builder = NetBuilder("letters")
    for name in "pq":
        builder.place(name)
    assert classes(normal(parse_open(text, Names(builder.build())))) == expected


def test_automata_are_printed(tmp_path: Path) -> None:
    net = tmp_path / "lamp.net"
    net.write_text("pl on (1)\ntr t on -> off\ntr u off -> on\n")
    found = mcpn("ask", net, "G (on -> F off)", "EF off", "--hoa")
    assert found.returncode == 2
    assert "EF off" in found.stderr
    printed = mcpn("ask", net, "G (on -> F off)", "--hoa")
    assert printed.returncode == 0
    assert printed.stdout.startswith('HOA: v1\nname: "G (on -> F off)"\n')
    assert 'AP: 2 "on" "off"' in printed.stdout
    assert 'mcpn-classes: "recurrence" "stutter-insensitive"' in printed.stdout
    assert printed.stdout.endswith("--END--\n")
    headers, _, _ = printed.stdout.partition("--BODY--")
    for line in headers.splitlines():  # HEADERNAME of the format's version 1, which has no dot
        assert re.match("[A-Za-z_][A-Za-z0-9_-]*: ", line), line


@pytest.mark.parametrize("levels", [1, 5, 40])
@pytest.mark.parametrize("distinct", [False, True])
@pytest.mark.parametrize("wanted", [False, True])
def test_nested_sequences_grow_by_one_state_a_level(levels: int, distinct: bool, wanted: bool) -> None:
    """``F (p & X F (...))`` and its negation: twice as many steps with each level, before."""
    formula: Formula = marked(0)
    for level in range(levels):
        formula = eventually(And(marked(1 + level * distinct), Next(formula)))
    automaton = translated(normal(formula, wanted))
    assert len(automaton.edges) == levels + 1 + wanted
    assert sum(map(len, automaton.edges)) == 2 * (levels + 1)


def test_an_automaton_that_takes_too_many_steps_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    conjuncts = [always(eventually(marked(place))) for place in range(12)]
    with pytest.raises(LimitError, match=r"the automaton of a formula on paths .*: the limit was hit"):
        translated(normal(And(*conjuncts)))
    monkeypatch.setattr(automaton, "MAX_STEPS", 1_500_000)
    other = Or(Not(And(*conjuncts)), always(eventually(marked(90))))
    with pytest.raises(LimitError, match="takes more than 1,500,000 steps to build: the limit was hit"):
        translated(normal(other, wanted=False))


def test_steps_are_what_stuttering_changes() -> None:
    p, q = marked(0), marked(1)
    for formula in (p, eventually(p), always(Until(p, q)), And(p, Not(q))):
        assert is_stutter_insensitive(formula)
        for step in (Next(formula), Happens((0,))):
            assert not is_stutter_insensitive(step)
            assert not is_stutter_insensitive(always(Or(formula, step)))
