"""Sums and products of tokens, compared: a product of places is taken apart by the values of one of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import TypeAlias

from mcpn.errors import InputError
from mcpn.logic.formulas import compare
from mcpn.nets.bounds import proved_bounds
from mcpn.nets.petri import PetriNet
from mcpn.spaces.search.goal import And, Formula, Or

Polynomial: TypeAlias = Mapping[tuple[int, ...], int]
"""By product of places, in their order, how often it counts; the empty product is the constant."""

MAX_CASES = 1_000
"""Values of places that a comparison is taken apart by."""


def added(parts: Iterable[Polynomial]) -> Polynomial:
    """The sum.

    >>> added([{(): 1, (2,): 1}, {(2,): -1}])
    {(): 1}
    """
    total = Counter[tuple[int, ...]]()
    for part in parts:
        total.update(dict(part))
    return {product: weight for product, weight in total.items() if weight}


def multiplied(parts: Iterable[Polynomial]) -> Polynomial:
    """The product.

    >>> multiplied([{(): 2, (3,): 1}, {(1,): 5}])
    {(1,): 10, (1, 3): 5}
    """
    total: Polynomial = {(): 1}
    for part in parts:
        total = added({tuple(sorted((*a, *b))): v * w} for a, v in total.items() for b, w in part.items())
    return total


def related(left: Polynomial, relation: str, right: Polynomial, net: PetriNet) -> Formula:
    """A comparison, by ``<``, ``<=``, ``=``, ``!=``, ``>=`` or ``>``.

    Raises:
        InputError: In a product of places none has a proved bound.
    """
    difference = added([left, {product: -weight for product, weight in right.items()}])
    factors = any(len(product) > 1 for product in difference)
    return _related(difference, relation, net, proved_bounds(net) if factors else [], MAX_CASES)


def _related(difference: Polynomial, relation: str, net: PetriNet, bounds: list[float], most: int) -> Formula:
    """A comparison with 0, taken apart by at most so many values."""
    factors = {place for product in difference if len(product) > 1 for place in product}
    if not factors:
        weights = {product[0]: weight for product, weight in difference.items() if product}
        return compare((difference.get((), 0), weights), relation, (0, {}))
    place = min(factors, key=lambda place: (bounds[place], place))
    if bounds[place] >= most:
        said = f"found a product with {net.places[place].name}, expected one of places with a proved bound"
        raise InputError.at(None, f"{said}, of at most {MAX_CASES} values together")
    cases = []
    for value in range(int(bounds[place]) + 1):
        rest = added(_with(product, weight, place, value) for product, weight in difference.items())
        inside = _related(rest, relation, net, bounds, most // (int(bounds[place]) + 1))
        cases.append(And(compare((0, {place: 1}), "=", (value, {})), inside))
    return Or(*cases)


def _with(product: tuple[int, ...], weight: int, place: int, value: int) -> Polynomial:
    """A product with a value for one of its places."""
    return {tuple(p for p in product if p != place): weight * value ** product.count(place)}
