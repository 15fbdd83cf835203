import numpy as np
import pytest

from layflat.bridge.brake import like_tuples, solve_brakes

SIZES = (1, 2, 4)


@pytest.mark.parametrize("n", SIZES)
def test_every_joint_is_held_or_slides_against_its_brake(n: int) -> None:
    rng = np.random.default_rng(n)
    for _ in range(300):
        root = rng.normal(size=(n, n))
        A = root @ root.T + 0.1 * np.eye(n)
        u, v, B = rng.normal(size=n), rng.normal(size=n), rng.exponential(0.3, n)
        J, after = np.zeros(n), np.zeros(n)
        solve_brakes(like_tuples(n), A, u, v, B, B, J, after)
        assert np.all(np.abs(J) <= B)
        assert np.allclose(v + A @ J, after, atol=1e-9)
        slides = after != 0.0
        if np.all(u[slides] * after[slides] > 0.0):  # friction turns with the joint
            assert np.allclose(J[slides], -np.sign(after[slides]) * B[slides])


@pytest.mark.parametrize("n", SIZES)
def test_without_brakes_nothing_acts(n: int) -> None:
    J, after, v = np.zeros(n), np.zeros(n), np.array([1.0, -2.0, 3.0, -4.0])[:n]
    solve_brakes(like_tuples(n), np.eye(n), v, v, np.zeros(n), np.zeros(n), J, after)
    assert np.array_equal(after, v)
    assert not J.any()


@pytest.mark.parametrize("n", SIZES)
def test_what_comes_to_rest_is_held_by_more_than_what_slides(n: int) -> None:
    rng = np.random.default_rng(10 + n)
    for _ in range(300):
        root = rng.normal(size=(n, n))
        A = root @ root.T + 0.1 * np.eye(n)
        u, v, B = rng.normal(size=n) * rng.integers(0, 2, n), rng.normal(size=n), rng.exponential(0.3, n)
        S = 1.5 * B
        J, after = np.zeros(n), np.zeros(n)
        solve_brakes(like_tuples(n), A, u, v, B, S, J, after)
        assert np.allclose(v + A @ J, after, atol=1e-9)
        assert np.all(np.abs(J) <= S)
        if np.all((u == 0.0) | (u * after > 0.0)):
            assert np.all(J * after <= 0.0)
            slipping = (u == 0.0) & (after != 0.0)
            assert np.allclose(np.abs(J[slipping]), S[slipping])
