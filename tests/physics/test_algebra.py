import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.lanes import Lanes
from layflat.physics.algebra import (
    diagonal,
    dot,
    invert_symmetric,
    max_item,
    max_magnitude,
    min_item,
    multiply_symmetric,
)

SIZES, SEEDS = st.integers(1, 4), st.integers(0, 10_000)


def inertia(n: int, seed: int) -> tuple[np.ndarray, tuple[float, ...]]:
    """A positive definite matrix, and its upper triangle row by row."""
    root = np.random.default_rng(seed).normal(size=(n, n))
    whole = root @ root.T + 0.5 * np.eye(n)
    return whole, tuple(whole[np.triu_indices(n)].tolist())


@given(SIZES, SEEDS)
def test_products_and_diagonal_are_those_of_the_whole_matrix(n: int, seed: int) -> None:
    whole, upper = inertia(n, seed)
    x, y = np.random.default_rng(seed + 1).normal(size=(2, n))
    assert multiply_symmetric(upper, tuple(x)) == pytest.approx(tuple(whole @ x))
    assert diagonal(upper, (0.0,) * n) == pytest.approx(tuple(np.diag(whole)))
    assert dot(tuple(x), tuple(y)) == pytest.approx(float(x @ y))


@given(SIZES, SEEDS)
def test_inverse(n: int, seed: int) -> None:
    whole, upper = inertia(n, seed)
    found = invert_symmetric(upper, (0.0,) * n, (0.0,) * (n * n))
    assert np.reshape(found, (n, n)) == pytest.approx(np.linalg.inv(whole), rel=1e-6, abs=1e-9)


@given(st.integers(2, 4), SEEDS)
def test_the_inverse_with_a_fixed_row_is_that_of_the_rest(n: int, seed: int) -> None:
    whole, upper = inertia(n, seed)
    fixed = tuple(1.0 if i == 1 else 0.0 for i in range(n))
    found = np.reshape(invert_symmetric(upper, fixed, (0.0,) * (n * n)), (n, n))
    free = [i for i in range(n) if i != 1]
    assert found[np.ix_(free, free)] == pytest.approx(np.linalg.inv(whole[np.ix_(free, free)]), rel=1e-6, abs=1e-9)
    assert np.abs(found[1]).max() < 1e-10


def test_extremes() -> None:
    assert (max_magnitude((1.0, -3.0, 2.0)), max_item((1.0, -3.0, 2.0)), min_item((1.0, -3.0, 2.0))) == (3.0, 2.0, -3.0)


def test_lanes_have_each_their_own_extremes() -> None:
    values = (Lanes((1.0, -5.0)), Lanes((2.0, -7.0)), Lanes((-3.0, 6.0)))
    assert max_item(values) == (2.0, 6.0)
    assert min_item(values) == (-3.0, -7.0)
    assert max_magnitude(values) == (3.0, 7.0)
