import numpy as np
import pytest
from scipy.optimize import minimize

from layflat.arrays import Array
from layflat.experiments.beyond.search import minimize_excess

POINTS, UNKNOWNS, RADIUS = 6, 20, 1.0


def drawn(seed: int) -> tuple[Array, Array]:
    draw = np.random.default_rng(seed).normal
    return 30.0 * draw(size=(POINTS, 2)), draw(size=(POINTS, 2, UNKNOWNS))


def objective(x: Array, v_0: Array, A: Array, lam: float) -> float:
    w = np.maximum(np.linalg.norm(v_0 + A @ x, axis=1) - RADIUS, 0.0)
    return float(w @ w + lam * (x @ x))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("lam", [0.1, 10.0])
def test_it_is_the_least_within_the_bounds(seed: int, lam: float) -> None:
    v_0, A = drawn(seed)
    low, high = np.full(UNKNOWNS, -1.0), np.full(UNKNOWNS, 0.5)
    x = minimize_excess(v_0, A, RADIUS, lam, low, high)
    assert (x >= low).all()
    assert (x <= high).all()
    bounds = list(zip(low, high, strict=True))
    reference = minimize(objective, 0.0 * x, (v_0, A, lam), bounds=bounds, options={"maxfun": 100_000})
    assert objective(x, v_0, A, lam) == pytest.approx(reference.fun, rel=1e-3)


def test_points_inside_the_disc_ask_for_nothing() -> None:
    _, A = drawn(0)
    bound = np.ones(UNKNOWNS)
    assert not minimize_excess(np.full((POINTS, 2), 0.5), A, RADIUS, 1.0, -bound, bound).any()
