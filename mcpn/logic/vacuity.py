"""Vacuity of a formula that holds: the parts that can be replaced by anything while it still holds.

Reference: O. Kupferman, M. Y. Vardi, *Vacuity detection in temporal model checking*, STTT 4, 2003: a formula
holds vacuously if a part of it can be replaced by anything. For a part that stands under an even number of
negations everywhere, or under an odd number everywhere, it is enough to try the worst, ``false`` or ``true``.
If any part may be replaced, then so may one without operators: these are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator

from mcpn.logic.formulas import some_path
from mcpn.logic.ltl.formulas import SomePath
from mcpn.spaces.search.goal import DEADLOCK, FALSE, TRUE, Formula, Not


def idle_parts(
    formula: Formula, words: Collection[Formula], holds: Callable[[Formula], bool]
) -> Iterator[Formula]:
    """The atoms and words in which a formula that holds is vacuous.

    Args:
        formula: A formula that holds.
        words: Formulas that people say by one word: they are not taken apart.
        holds: Whether another formula holds.

    Yields:
        Parts that can be replaced by anything, each alone, in their order. Of parts that stand under an even
        number of negations here and an odd number there nothing is said.
    """
    for part, signs in signs_of(formula, words).items():
        if len(signs) == 1 and part not in (formula, DEADLOCK):  # the translation of X adds deadlock
            worst = FALSE if signs == {True} else TRUE
            if holds(_replaced(formula, part, worst)):
                yield part


def signs_of(formula: Formula, words: Collection[Formula]) -> dict[Formula, set[bool]]:
    """By part whether it stands under an even number of negations, an odd number, or both.

    A word that is negated is the word, under one negation more.
    """
    signs: dict[Formula, set[bool]] = {}
    stack = [(formula, True)]
    while stack:
        part, sign = stack.pop()
        if part in words or (not part.operands and ~part not in words):
            if part not in (TRUE, FALSE):
                signs.setdefault(part, set()).add(sign)
        elif ~part in words:
            signs.setdefault(~part, set()).add(not sign)
        else:
            below = not sign if isinstance(part, Not) else sign
            stack.extend((operand, below) for operand in reversed(part.operands))
    return signs


def _replaced(formula: Formula, part: Formula, by: Formula) -> Formula:
    """The formula with every occurrence of a part replaced by another formula."""
    if formula == part:
        return by
    if formula == ~part:
        return ~by
    if isinstance(formula, SomePath):
        return some_path(_replaced(formula.operands[0], part, by))
    return formula.mapped(lambda inside: _replaced(inside, part, by))
