"""Automata in the Hanoi Omega-Automata format, for other tools; and the classes of a formula.

Source: Babiak and others, *The Hanoi Omega-Automata format*, CAV 2015 (adl.github.io/hoaf).
"""

from __future__ import annotations

import json
from collections.abc import Callable

from mcpn.logic.ltl.automaton import Automaton
from mcpn.logic.ltl.formulas import Happens, Next, Release, Until, atom_of
from mcpn.spaces.search.goal import And, Formula, Or


def write_hoa(automaton: Automaton, name: str, formula: Formula, said: Callable[[Formula], str]) -> str:
    """An automaton as text.

    Args:
        automaton: The automaton.
        name: Of what it accepts.
        formula: What it was translated from, in normal form.
        said: A formula on states, or a step, as text: these are the atomic propositions.
    """
    literals = [f for edges in automaton.edges for e in edges for f in sorted(e.literals, key=said)]
    atoms = {atom: i for i, atom in enumerate(dict.fromkeys(map(atom_of, literals)))}
    inf = "&".join(f"Inf({mark})" for mark in range(automaton.marks))
    properties = "trans-labels explicit-labels trans-acc"
    hierarchy = classes(formula)
    lines = [
        "HOA: v1",
        f"name: {json.dumps(name, ensure_ascii=False)}",
        'tool: "mcpn"',
        f"States: {len(automaton.edges)}",
        "Start: 0",
        " ".join([f"AP: {len(atoms)}", *(json.dumps(said(atom), ensure_ascii=False) for atom in atoms)]),
        f"acc-name: generalized-Buchi {automaton.marks}" if automaton.marks else "acc-name: all",
        f"Acceptance: {automaton.marks} {inf or 't'}",
        f"properties: {properties}{' stutter-invariant' if 'stutter-insensitive' in hierarchy else ''}",
        f"mcpn-classes: {' '.join(map(json.dumps, hierarchy))}",
        "--BODY--",
    ]
    for number, edges in enumerate(automaton.edges):
        lines.append(f"State: {number}")
        for edge in edges:
            signs = sorted((atoms[atom_of(f)], atom_of(f) != f) for f in edge.literals)
            label = "&".join(f"{'!' if negated else ''}{atom}" for atom, negated in signs) or "t"
            marks = f" {{{' '.join(map(str, sorted(edge.marks)))}}}" if edge.marks else ""
            lines.append(f"  [{label}] {edge.target}{marks}")
    return "\n".join([*lines, "--END--", ""])


def classes(formula: Formula) -> list[str]:
    """The classes of the hierarchy of Manna and Pnueli that a formula is of by how it is written.

    One that is written otherwise may be of further classes.

    Args:
        formula: On paths, in normal form.

    Returns:
        Of ``safety``, ``guarantee``, ``obligation``, ``recurrence``, ``persistence``, ``reactivity``, and
        ``stutter-insensitive``: the last says that steps which change nothing do not count.

    Examples:
        >>> from mcpn.logic.ltl.formulas import always, eventually
        >>> from mcpn.spaces.search.goal import marked
        >>> classes(always(marked(0)))
        ['safety', 'obligation', 'recurrence', 'persistence', 'stutter-insensitive']
        >>> classes(always(eventually(marked(0))))
        ['recurrence', 'stutter-insensitive']
    """
    names = [name for name, belongs in _CLASSES.items() if belongs(formula)]
    if not names:
        names = ["reactivity"]
    if is_stutter_insensitive(formula):
        names.append("stutter-insensitive")
    return names


def is_stutter_insensitive(formula: Formula) -> bool:
    """Whether a formula is stutter-insensitive by its syntax: it holds neither ``X`` nor a step.

    Examples:
        >>> from mcpn.logic.ltl.formulas import Next, eventually
        >>> from mcpn.spaces.search.goal import marked
        >>> is_stutter_insensitive(eventually(marked(0))), is_stutter_insensitive(Next(marked(0)))
        (True, False)
    """
    return not any(isinstance(part, Next | Happens) for part in formula.walk())


def _safety(formula: Formula) -> bool:
    return not any(isinstance(part, Until) for part in formula.walk())


def _guarantee(formula: Formula) -> bool:
    return not any(isinstance(part, Release) for part in formula.walk())


def _obligation(formula: Formula) -> bool:
    if _safety(formula) or _guarantee(formula):
        return True
    return isinstance(formula, And | Or | Next) and all(map(_obligation, formula.operands))


def _recurrence(formula: Formula) -> bool:
    match formula:
        case And(operands) | Or(operands) | Next(operands) | Release(operands):
            return _obligation(formula) or all(map(_recurrence, operands))
    return _obligation(formula)


def _persistence(formula: Formula) -> bool:
    match formula:
        case And(operands) | Or(operands) | Next(operands) | Until(operands):
            return _obligation(formula) or all(map(_persistence, operands))
    return _obligation(formula)


_CLASSES: dict[str, Callable[[Formula], bool]] = {
    "safety": _safety,
    "guarantee": _guarantee,
    "obligation": _obligation,
    "recurrence": _recurrence,
    "persistence": _persistence,
}
