"""Automata of other translators, ``spin -f`` and ``lbt``, and of our own: over the letters of p and q."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import networkx as nx
from hypothesis import strategies as st

Written: TypeAlias = tuple[Any, ...]
Letter: TypeAlias = frozenset[str]
LETTERS: tuple[Letter, ...] = (frozenset(), frozenset("p"), frozenset("q"), frozenset("pq"))
Guard: TypeAlias = Callable[[Letter], bool]


@dataclass
class Büchi:
    """A generalised Büchi automaton.

    Args:
        start: Its initial states.
        edges: State, guard, marks, state.
        marks: How many marks a run takes again and again.
    """

    start: set[Any]
    edges: list[tuple[Any, Guard, frozenset[int], Any]]
    marks: int

    def accepts(self, word: list[Letter], cycle: int) -> bool:
        """Whether it accepts a word that goes on from one position for ever."""
        letters = range(len(word))
        graph: nx.MultiDiGraph[Any] = nx.MultiDiGraph()
        for source, guard, marks, target in self.edges:
            for i in letters:
                if guard(word[i]):
                    after = i + 1 if i + 1 < len(word) else cycle
                    graph.add_edge((source, i), (target, after), marks=marks)
        return _some_cycle(graph, {(s, 0) for s in self.start}, self.marks)

    def meets(self, other: Büchi) -> bool:
        """Whether some word is accepted by both."""
        graph: nx.MultiDiGraph[Any] = nx.MultiDiGraph()
        for a, guard, marks, b in self.edges:
            for c, other_guard, other_marks, d in other.edges:
                if any(guard(letter) and other_guard(letter) for letter in LETTERS):
                    both = marks | {self.marks + mark for mark in other_marks}
                    graph.add_edge((a, c), (b, d), marks=both)
        return _some_cycle(graph, {(a, b) for a in self.start for b in other.start}, self.marks + other.marks)


def _some_cycle(graph: nx.MultiDiGraph[Any], start: set[Any], marks: int) -> bool:
    reached = set[Any]()
    for node in start & set(graph):
        reached |= {node, *nx.descendants(graph, node)}
    inside = graph.subgraph(reached)
    for component in nx.strongly_connected_components(inside):
        part = inside.subgraph(component)
        taken: set[int] = set().union(*(data["marks"] for _, _, data in part.edges(data=True)))
        if part.number_of_edges() and len(taken) == marks:
            return True
    return False


def formulas(unary: str, leaves: int = 4) -> st.SearchStrategy[Written]:
    """Formulas with some operators of one operand."""

    def wider(inside: st.SearchStrategy[Written]) -> st.SearchStrategy[Written]:
        return st.one_of(
            st.tuples(st.sampled_from(unary), inside),
            st.tuples(st.sampled_from(["&", "|", "->", "U", "R"]), inside, inside),
        )

    return st.recursive(st.sampled_from([("p",), ("q",)]), wider, max_leaves=leaves)


OURS = {"!": "!", "X": "X ", "F": "F ", "G": "G ", "&": "&", "|": "|", "->": "->", "U": "U", "R": "R"}
SPIN = {**OURS, "F": "<>", "G": "[]", "&": "&&", "|": "||", "R": "V"}
LBT = {**OURS, "->": "i", "R": "V"}


def infix(formula: Written, signs: dict[str, str]) -> str:
    operator, *operands = formula
    inside = [infix(f, signs) for f in operands]
    if not inside:
        return str(operator)
    if len(inside) == 1:
        return f"({signs[operator]}{inside[0]})"
    return f"({inside[0]} {signs[operator]} {inside[1]})"


def prefix(formula: Written) -> str:
    operator, *operands = formula
    if not operands:
        return {"p": "p0", "q": "p1"}[operator]
    return " ".join([LBT[operator].strip(), *map(prefix, operands)])


def by_spin(formula: Written) -> Büchi:
    """The never claim of ``spin -f``: states with a label accept_... are to be met again and again."""
    command = ["spin", "-f", infix(formula, SPIN)]
    text = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    moves: list[tuple[int, Guard, str]] = []
    labels: dict[str, int] = {"ended": -1}  # a claim that ends accepts, whatever follows
    state, fresh = 0, False
    for line in text.splitlines():
        if label := re.match(r"\s*(\w+):\s*$", line):
            state += not fresh  # several labels may stand at one state
            labels[label[1]], fresh = state, True
            continue
        fresh = False
        if move := re.match(r"\s*:: \((.*)\) -> goto (\w+)", line):
            moves.append((state, _guard(move[1]), move[2]))
        elif move := re.match(r"\s*:: atomic \{ \((.*)\) -> assert\(", line):
            moves.append((state, _guard(move[1]), "ended"))
        elif line.strip() == "skip":
            moves.append((state, lambda letter: True, "ended"))
        else:
            assert line.strip() in ("do", "od;", "}", "", ":: false") or line.startswith("never"), line
    accepting = {of for label, of in labels.items() if label.startswith("accept")} | {-1}
    moves.append((-1, lambda letter: True, "ended"))
    edges = [
        (source, guard, frozenset({0} if source in accepting else ()), labels[target])
        for source, guard, target in moves
    ]
    return Büchi({1}, edges, 1)


def _guard(text: str) -> Guard:
    """A guard of p, q, constants and connectives, as C and SPIN write it."""
    assert re.fullmatch(r"(?:p|q|1|0|true|false|[()!&|\s])*", text), text
    python = text.replace("true", "1").replace("false", "0")
    python = python.replace("&&", " and ").replace("||", " or ").replace("!", " not ")
    code = compile(python.strip(), "<guard>", "eval")
    return lambda letter: bool(eval(code, {"p": "p" in letter, "q": "q" in letter}))


def by_lbt(formula: Written) -> Büchi:
    """The automaton of ``lbt``: acceptance sets are of states, and are to be met again and again."""
    text = subprocess.run(
        ["lbt"], input=prefix(formula), capture_output=True, text=True, check=True, timeout=60
    ).stdout
    lines = iter(text.splitlines())
    states, marks = map(int, next(lines).split())
    start, edges, sets = (
        set[Any](),
        list[tuple[Any, Guard, frozenset[int], Any]](),
        dict[int, frozenset[int]](),
    )
    for _ in range(states):
        name, initial, *accepting = map(int, next(lines).split())
        assert accepting[-1] == -1
        sets[name] = frozenset(accepting[:-1])
        if initial:
            start.add(name)
        while (line := next(lines)) != "-1":
            target, _, guard = line.partition(" ")
            edges.append((name, _prefixed(guard), sets[name], int(target)))
    return Büchi(start, edges, marks)


def _prefixed(text: str) -> Guard:
    tokens = text.split()

    def read(at: int) -> tuple[Guard, int]:
        token = tokens[at]
        if token == "!":
            inside, end = read(at + 1)
            return (lambda letter: not inside(letter)), end
        if token in "&|" and len(token) == 1:
            left, middle = read(at + 1)
            right, end = read(middle)
            both = token == "&"
            return (
                lambda letter: (left(letter) and right(letter)) if both else (left(letter) or right(letter))
            ), end
        if token in ("t", "f"):
            return (lambda letter: token == "t"), at + 1
        name = {"p0": "p", "p1": "q"}[token]
        return (lambda letter: name in letter), at + 1

    return read(0)[0]


def of_hoa(text: str) -> Büchi:
    """An automaton in the Hanoi format, as :mod:`mcpn.logic.ltl.automaton` writes it."""
    head, _, body = text.partition("--BODY--")
    (aps,) = re.findall(r"^AP: \d+(.*)$", head, re.MULTILINE)
    names = re.findall(r'"([^"]*)"', aps)
    (marks,) = map(int, re.findall(r"^Acceptance: (\d+)", head, re.MULTILINE))
    edges: list[tuple[Any, Guard, frozenset[int], Any]] = []
    source = -1
    for line in body.splitlines():
        if state := re.fullmatch(r"State: (\d+)", line):
            source = int(state[1])
        elif edge := re.fullmatch(r"  \[(.*)\] (\d+)(?: \{(.*)\})?", line):
            edges.append(
                (
                    source,
                    _labelled(edge[1], names),
                    frozenset(map(int, (edge[3] or "").split())),
                    int(edge[2]),
                )
            )
    return Büchi({0}, edges, marks)


def _labelled(label: str, names: list[str]) -> Guard:
    parts = [] if label == "t" else label.split("&")
    # Propositions are formulas on states: here Boolean ones.
    said = (names[int(part.lstrip("!"))].replace("&", "&&").replace("|", "||") for part in parts)
    wanted = [(_guard(name), not part.startswith("!")) for name, part in zip(said, parts, strict=True)]
    return lambda letter: all(guard(letter) == truth for guard, truth in wanted)
