import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.bridge.brake import hold, rub
from layflat.physics.friction.box import slide_two
from layflat.physics.friction.coulomb import Coulomb


@given(st.integers(0, 10**6), st.integers(1, 7))
def test_every_joint_is_held_or_slides_against_its_brake(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    A = root @ root.T + 0.1 * np.eye(n)
    v, B = rng.normal(size=n), rng.exponential(0.3, n)
    J, after = rng.normal(size=n) * B, np.zeros(n)
    hold(A, v, B, J, after)
    left = v + A @ J
    held = after == 0.0
    assert np.all(np.abs(J) <= B)
    assert np.abs(left[held]).max(initial=0.0) < 1e-9
    assert np.allclose(left, after, atol=1e-9)
    assert np.array_equal(J[~held], -np.sign(left[~held]) * B[~held])


def test_without_brakes_nothing_acts() -> None:
    J, after, v = np.zeros(3), np.zeros(3), np.array([1.0, -2.0, 3.0])
    hold(np.eye(3), v, np.zeros(3), J, after)
    assert np.array_equal(after, v)
    assert not J.any()


@given(st.integers(0, 10**6), st.integers(1, 5))
def test_what_comes_to_rest_is_held_by_more_than_what_slides(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n))
    A = root @ root.T + 0.1 * np.eye(n)
    u, v, B = rng.normal(size=n) * rng.integers(0, 2, n), rng.normal(size=n), rng.exponential(0.3, n)
    S = 1.5 * B
    J, after = np.zeros(n), np.zeros(n)
    rub(A, u, v, B, S, J, after)
    assert np.allclose(v + A @ J, after, atol=1e-9)
    assert np.all(J * after <= 0.0)
    assert np.all(np.abs(J) <= S)
    still = u == 0.0
    assert np.allclose(np.abs(J[still & (after != 0.0)]), S[still & (after != 0.0)])
    if n == 2:
        M = np.linalg.inv(A)
        mass, p = (M[0, 0], M[0, 1], M[1, 1]), M @ v
        assert np.allclose(slide_two(Coulomb(), mass, *p, *u, *B, *S), [*after, *J], atol=1e-8)
