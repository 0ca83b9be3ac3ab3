"""When something fails, as a minimal Boolean formula and as a person would say it.

A monotone function has one minimal sum of products, the sum of its minimal solutions; espresso finds a
minimal one for any function, so the two must be the same, and pyeda's solver proves that formula and function
are equivalent. pyeda is an optional dependency, loaded only here.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from mcpn.check.causes.cutsets import CutSet
from mcpn.errors import LimitError, SemanticsError

MAX_TERMS = 2000


@dataclass(frozen=True)
class Formula:
    """A minimal sum of products over hardware that is out of service.

    Args:
        terms: Its products, each a set of names.
        text: For example ``thruster_actuator | GPS_sensor & IMU_sensor``; ``0`` never, ``1`` always.
    """

    terms: tuple[CutSet, ...]
    text: str


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


def minimal_formula(losing: Sequence[CutSet]) -> Formula:
    """The minimal sum of products of a function, found by espresso and proved equivalent to it.

    Args:
        losing: Products whose sum is the function; they need not be minimal.

    Returns:
        Smaller products first, then in alphabetical order.

    Raises:
        LimitError: pyeda is not installed, or the function has more than :data:`MAX_TERMS` products.
        SemanticsError: The solver finds the formula and the function to differ.
    """
    if not losing:
        return Formula((), "0")
    if () in losing:
        return Formula(((),), "1")
    if len(losing) > MAX_TERMS:
        raise LimitError(f"{len(losing)} products: more than {MAX_TERMS}, the limit on products of a formula")
    try:
        from pyeda.boolalg.expr import And, Or, Xor, exprvar
        from pyeda.boolalg.minimization import espresso_exprs
    except ImportError as error:
        raise LimitError('minimal formulas need pyeda: pip install "mcpn[pyeda]"') from error
    names = sorted({name for product in losing for name in product})
    variables = {name: exprvar("hardware", number) for number, name in enumerate(names)}
    named = {variable.uniqid: name for name, variable in variables.items()}
    function = Or(*(And(*(variables[name] for name in product)) for product in losing))
    (minimised,) = espresso_exprs(function.to_dnf())
    if Xor(function, minimised).satisfy_one() is not None:
        raise SemanticsError("espresso's formula differs from the function that it minimises")
    products = [
        tuple(sorted(named[literal] for literal in product)) for product in _products(minimised.to_ast())
    ]
    terms = tuple(sorted(products, key=lambda product: (len(product), product)))
    return Formula(terms, " | ".join(" & ".join(product) for product in terms))


def _products(tree: Any) -> list[list[int]]:
    """Products of pyeda's tree of a sum, a product or a literal, as literals."""
    if tree[0] == "or":
        return [product for part in tree[1:] for product in _products(part)]
    literals = tree[1:] if tree[0] == "and" else (tree,)
    return [[literal[1] for literal in literals]]
