"""Block elimination, components and factors of layers, against one dense system."""

from __future__ import annotations

from collections.abc import Hashable
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcpn.answers.causes import factors, linear_systems
from mcpn.answers.causes.block_elimination import Elimination
from mcpn.answers.causes.linear_systems import LayeredSystem, Layers, StepSystem, solver_of
from mcpn.answers.causes.resolvents import TOO_SMALL, Eliminated, resolvent
from mcpn.answers.causes.sparse import Floats, SparseMatrix
from mcpn.errors import LimitError
from tests.shares import returns_early


def sparse(matrix: Floats) -> SparseMatrix:
    """The entries of a dense matrix that are not 0."""
    rows, columns = np.nonzero(matrix)
    return SparseMatrix(matrix[rows, columns], rows, columns, matrix.shape)


@given(st.data())
def test_blocks_give_what_one_dense_system_gives(data: st.DataObject) -> None:
    """Few different matrices at drawn places, rows that sum to less than 1, as of a chain that ends."""
    count, size = data.draw(st.integers(1, 9)), data.draw(st.integers(1, 3))
    pair = st.tuples(st.integers(0, count - 1), st.integers(0, count - 1))
    names = data.draw(st.dictionaries(pair, st.integers(0, 3), max_size=3 * count))
    random = np.random.default_rng(data.draw(st.integers(0, 99)))
    matrices = random.random((4, size, size)) * 0.99 / (size * count)
    right = random.random((count, size, 2))
    dense = np.eye(count * size)
    for (i, j), name in names.items():
        dense[i * size : (i + 1) * size, j * size : (j + 1) * size] -= matrices[name]
    asked: list[Hashable] = []

    def matrix(name: Hashable) -> Floats:
        asked.append(name)
        if isinstance(name, tuple):
            return np.asarray(dense[name[1] * size : (name[1] + 1) * size].sum(axis=1)[:, None])
        assert isinstance(name, int)
        return np.asarray(matrices[name])

    leaving = [("leaving", i) for i in range(count)]
    found = Elimination(names, leaving).factored_with(matrix)(right)
    expected = np.linalg.solve(dense, right.reshape(-1, 2)).reshape(right.shape)
    assert found == pytest.approx(expected, abs=1e-12)
    assert sorted(asked, key=repr) == sorted({*names.values(), *leaving}, key=repr)


@pytest.mark.parametrize("back", ["first", "before", "last leads to first"])
def test_a_row_of_equal_blocks_takes_as_many_products_as_its_length_has_digits(back: str) -> None:
    def products(length: int) -> int:
        names: dict[tuple[int, int], Hashable] = {(i, i + 1): "on" for i in range(length - 1)}
        for i in range(length):
            to = {"first": 0, "before": max(0, i - 1), "last leads to first": 0}[back]
            if i == length - 1 or back != "last leads to first":
                names[i, to] = "back"
        return Elimination(names, ["out"] * length).products

    assert products(2000) - products(1000) <= products(1000) - products(500) + 8 <= 50


@given(st.integers(1, 12), st.integers(0, 99), st.sampled_from([1.0, 1e-9, 1e-15]))
def test_a_resolvent_is_exact_however_rarely_it_is_left(size: int, seed: int, rare: float) -> None:
    """Against fractions: each entry relative to itself, where rows sum to nearly 1."""
    random = np.random.default_rng(seed)
    steps, leaving = random.random((size, size)), random.random(size) * rare
    np.fill_diagonal(steps, 0.0)
    rows = [[Fraction(x) for x in row] for row in steps]
    matrix = [[-x for x in row] + [Fraction(int(i == j)) for j in range(size)] for i, row in enumerate(rows)]
    for i, row in enumerate(rows):
        matrix[i][i] += sum(row) + Fraction(leaving[i])
    for i in range(size):  # Gauss and Jordan
        matrix[i] = [x / matrix[i][i] for x in matrix[i]]
        for j in set(range(size)) - {i}:
            matrix[j] = [x - matrix[j][i] * y for x, y in zip(matrix[j], matrix[i], strict=True)]
    inverse = [[float(x) for x in row[size:]] for row in matrix]
    assert resolvent(steps, leaving) == pytest.approx(np.array(inverse), rel=1e-12)


@given(st.integers(2, 12), st.integers(0, 10_000))
def test_iteration_is_as_exact_as_elimination(size: int, seed: int) -> None:
    """From nowhere are more than some four steps expected: the two differ by the roundings of so many."""
    random = np.random.default_rng(seed)
    steps = random.random((size, size)) * (random.random((size, size)) < 0.5)
    leaving = random.uniform(0.3, 1.0, size) * (steps.sum(axis=1) + 1)
    whole = steps.sum(axis=1) + leaving
    steps, leaving = steps / whole[:, None], leaving / whole
    right = (random.random(size) * leaving)[:, None]
    inverse = solver_of(lambda columns: np.asarray(steps @ columns), lambda: leaving, size)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear_systems, "MOST_DENSE", 0)
        iterated = solver_of(lambda columns: np.asarray(steps @ columns), lambda: leaving, size)
    assert iterated(right) == pytest.approx(inverse(right), rel=2e-14)


@given(st.lists(st.sampled_from([0.5, 0.1, 0.02, 0.004]), min_size=2, max_size=4), st.integers(0, 10_000))
def test_iteration_settles_where_parts_are_left_at_unlike_rates(rates: list[float], seed: int) -> None:
    """Parts of unknowns, each left with a probability of its own, some of which lead to earlier ones."""
    random, size = np.random.default_rng(seed), 3
    whole = size * len(rates)
    steps, leaving = np.zeros((whole, whole)), np.repeat(rates, size)
    for i in range(len(rates)):
        for j in range(i + 1):
            if i == j or random.random() < 0.4:
                share = random.random((size, size)) * (1.0 if i == j else 0.01)
                steps[i * size : (i + 1) * size, j * size : (j + 1) * size] = share
    steps *= ((1 - leaving) / steps.sum(axis=1))[:, None]
    shuffled = random.permutation(whole)
    steps, leaving = steps[shuffled][:, shuffled], leaving[shuffled]
    right = (random.random(whole) * leaving)[:, None]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear_systems, "MOST_DENSE", 0)
        iterated = solver_of(lambda columns: np.asarray(steps @ columns), lambda: leaving, whole)
    try:
        found = iterated(right)
    except LimitError:
        if len(set(rates)) == len(rates):
            raise
        returns_early("one part leads to another that is left as slowly")
        return
    assert found == pytest.approx(resolvent(steps, leaving) @ right, rel=1e-11)


@given(st.integers(1, 12), st.integers(0, 99), st.floats(0.0, 0.5), st.sampled_from([0, 1 << 31]))
def test_layers_give_what_one_dense_system_gives(size: int, seed: int, filled: float, little: int) -> None:
    """Drawn steps, of unknowns of which some lead to each other and others never back; by factors, too."""
    random = np.random.default_rng(seed)
    steps = random.random((size, size)) * (random.random((size, size)) < filled) * 0.99 / size
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear_systems, "LITTLE_WORK", little)
        system = LayeredSystem(sparse(steps), 1 - steps.sum(axis=1))
    right = random.random(size)
    np.testing.assert_allclose(system.solved(right), np.linalg.solve(np.eye(size) - steps, right))
    forward = system.solved(right, forward=True)
    np.testing.assert_allclose(forward, np.linalg.solve(np.eye(size) - steps.T, right))


def test_of_what_is_never_come_back_to_nothing_is_filled_in(monkeypatch: pytest.MonkeyPatch) -> None:
    """Rows of sections, each a cycle, that lead on to the next one: none has factors with another."""
    sections, size, sizes = 8, 5, list[int]()
    steps = np.zeros((sections * size,) * 2)
    for unknown in range(len(steps)):
        around = unknown + 1 if (unknown + 1) % size else unknown + 1 - size
        steps[unknown, around] = 0.5
        if unknown + size < len(steps):
            steps[unknown, unknown + size] = 0.25
    made = factors.factors

    def counted(matrix: SparseMatrix) -> object:
        sizes.append(matrix.shape[0])
        return made(matrix)

    monkeypatch.setattr(factors, "factors", counted)
    monkeypatch.setattr(linear_systems, "LITTLE_WORK", 0)
    LayeredSystem(sparse(steps), 1 - steps.sum(axis=1))
    assert sizes == [size] * sections


@given(st.integers(1, 9), st.integers(1, 9), st.integers(0, 9999))
def test_sparse_products_are_those_of_dense_matrices(size: int, width: int, seed: int) -> None:
    """Entries in any order, some at one place; parts of the matrix, and the transposed one."""
    random = np.random.default_rng(seed)
    count = int(random.integers(0, 30))
    rows, columns, values = (
        random.integers(size, size=count),
        random.integers(width, size=count),
        np.zeros((size, width)),
    )
    entries = random.random(count)
    np.add.at(values, (rows, columns), entries)
    matrix = SparseMatrix(entries, rows, columns, (size, width))
    right = random.random((width, 3))
    np.testing.assert_allclose(matrix.dense, values)
    np.testing.assert_allclose(matrix.sums, values.sum(axis=1))
    np.testing.assert_allclose(matrix @ right, values @ right)
    np.testing.assert_allclose(matrix @ right[:, 0], values @ right[:, 0])
    np.testing.assert_allclose(matrix.transposed.dense, values.T)
    some, others = np.flatnonzero(random.random(size) < 0.5), np.flatnonzero(random.random(width) < 0.5)
    np.testing.assert_allclose(matrix.within(some, others).dense, values[some][:, others])


@pytest.mark.parametrize("forward", [False, True])
@given(st.integers(1, 3 * TOO_SMALL), st.integers(0, 9999), st.sampled_from([1.0, 1e-12]))
def test_halves_give_what_the_inverse_gives(forward: bool, size: int, seed: int, rare: float) -> None:
    """Each number relative to itself, however rarely the unknowns are left."""
    random = np.random.default_rng(seed)
    steps = random.random((2, size, size)) * (random.random((2, size, size)) < 0.4)
    leaving = random.random((2, size)) * rare
    right = random.random((2, size, 2))
    inverse = resolvent(steps, leaving)
    expected = (inverse.swapaxes(-1, -2) if forward else inverse) @ right
    system = Eliminated(steps, leaving)
    assert system.solved(right, forward=forward) == pytest.approx(expected, rel=1e-11)
    second = system[np.array([1])].solved(right[1:], forward=forward)
    assert second == pytest.approx(expected[1:], rel=1e-11)


def steps_solved(
    random: np.random.Generator, size: int, rare: float, *, together: int, forward: bool
) -> tuple[Floats, Floats]:
    """Two systems of a chain drawn anew, and what dense elimination makes of them."""
    rates = random.random((size, size)) * (random.random((size, size)) < 0.3)
    np.fill_diagonal(rates, 0.0)
    out, decays = random.random(size) * rare, random.random((2, size)) * rare
    right = random.random((2, size, 3))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear_systems, "MOST_TOGETHER", together)
        found = StepSystem(Layers(sparse(rates)), out, decays).solved(right, forward=forward)
    expected = []
    for decay, given_right in zip(decays, right, strict=True):
        leaving = rates.sum(axis=1) + out + decay
        inverse = resolvent(rates / leaving[:, None], (out + decay) / leaving) / leaving
        expected.append((inverse.T if forward else inverse) @ given_right)
    return found, np.stack(expected)


@pytest.mark.parametrize("forward", [False, True])
@given(st.integers(1, 14), st.integers(0, 9999), st.sampled_from([1.0, 1e-9]), st.sampled_from([0, 1024]))
def test_components_of_steps_give_what_one_dense_system_gives(
    forward: bool, size: int, seed: int, rare: float, together: int
) -> None:
    """Each number relative to itself, however rarely what leads in a circle is left; by factors, too."""
    found, expected = steps_solved(
        np.random.default_rng(seed), size, rare, together=together, forward=forward
    )
    assert found == pytest.approx(expected, rel=1e-10)


def test_small_components_have_no_factors(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(factors, "factors", None)
    found, expected = steps_solved(np.random.default_rng(1), 60, 1.0, together=1024, forward=True)
    assert found == pytest.approx(expected, rel=1e-12)
