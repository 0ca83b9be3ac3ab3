"""When something fails, as a minimal Boolean formula and as a person would say it.

A monotone function has one minimal sum of products, the sum of its minimal solutions; espresso finds a
minimal one for any function, so the two must be the same, and pyeda's solver proves that formula and function
are equivalent. pyeda is an optional dependency, loaded only here.
"""

from __future__ import annotations

from collections.abc import Sequence

from mcpn.check.causes.cutsets import CutSet
from mcpn.errors import LimitError, SemanticsError

MAX_TERMS = 2000


def sentence(name: str, cut_sets: Sequence[CutSet]) -> str:
    """When something fails, as a person would say it.

    Args:
        name: What fails.
        cut_sets: Its minimal cut sets.

    >>> sentence("going_up", [("thruster_actuator",), ("GPS_sensor", "IMU_sensor")])
    'going_up fails if thruster_actuator, or if GPS_sensor and IMU_sensor'
    >>> sentence("filming", [])
    'filming can succeed whatever hardware fails'
    """
    if not cut_sets:
        return f"{name} can succeed whatever hardware fails"
    if () in cut_sets:
        return f"{name} can never succeed"
    return f"{name} fails if " + ", or if ".join(enumeration(names) for names in cut_sets)


def enumeration(names: Sequence[str]) -> str:
    """Names as a list in a sentence: ``A``, ``A and B``, ``A, B and C``."""
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"


def minimal_formula(losing: Sequence[CutSet]) -> str:
    """The minimal sum of products of a function, found by espresso and proved equivalent to it.

    Args:
        losing: Products whose sum is the function, each of names of hardware; they need not be minimal.

    Returns:
        For example ``thruster_actuator | GPS_sensor & IMU_sensor``, smaller products first, then in
        alphabetical order; ``0`` never, ``1`` always.

    Raises:
        LimitError: pyeda is not installed, or the function has more than :data:`MAX_TERMS` products.
        SemanticsError: The solver finds the formula and the function to differ.
    """
    if not losing or () in losing:
        return "1" if losing else "0"
    if len(losing) > MAX_TERMS:
        raise LimitError(f"{len(losing)} products: more than {MAX_TERMS}, the limit on products of a formula")
    try:
        from pyeda.boolalg.expr import And, Or, Xor, exprvar
        from pyeda.boolalg.minimization import espresso_exprs
    except ImportError as error:
        raise LimitError('minimal formulas need pyeda: pip install "mcpn[pyeda]"') from error
    names = sorted({name for product in losing for name in product})
    variables = {name: exprvar("hardware", number) for number, name in enumerate(names)}
    function = Or(*(And(*(variables[name] for name in product)) for product in losing))
    (minimised,) = espresso_exprs(function.to_dnf())
    if Xor(function, minimised).satisfy_one() is not None:
        raise SemanticsError("espresso's formula differs from the function that it minimises")
    products = [sorted(names[variable.indices[0]] for variable in cube) for cube in minimised.cover]
    return " | ".join(" & ".join(product) for product in sorted(products, key=lambda p: (len(p), p)))
