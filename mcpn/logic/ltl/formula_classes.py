"""The classes of a formula on paths, as safety and guarantee, by how it is written."""

from __future__ import annotations

from collections.abc import Callable

from mcpn.logic.ltl.formulas import Happens, Next, Release, Until
from mcpn.spaces.search.goal import And, Formula, Or


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
