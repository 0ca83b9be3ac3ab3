"""Automata in the Hanoi Omega-Automata format, for other tools.

Source: Babiak and others, *The Hanoi Omega-Automata format*, CAV 2015 (adl.github.io/hoaf).
"""

from __future__ import annotations

import json
from collections.abc import Callable

from mcpn.logic.ltl.automaton import Automaton
from mcpn.logic.ltl.formula_classes import classes
from mcpn.logic.ltl.formulas import atom_of
from mcpn.spaces.search.goal import Formula


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
