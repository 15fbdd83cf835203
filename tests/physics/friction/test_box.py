import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from layflat.physics.friction.box import brake_one, brake_two

momenta = st.floats(-5.0, 5.0)
limits = st.floats(0.0, 2.0)


@st.composite
def mass_matrices(draw: st.DrawFn) -> np.ndarray:
    """Positive definite, as strongly coupled as an arm can be and more."""
    m_11, m_22, coupling = draw(st.floats(0.05, 2.0)), draw(st.floats(0.05, 2.0)), draw(st.floats(-0.95, 0.95))
    m_12 = coupling * np.sqrt(m_11 * m_22)
    return np.array([[m_11, m_12], [m_12, m_22]])


def both(M: np.ndarray, p: tuple[float, float], B: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    v_1, v_2, J_1, J_2 = brake_two(M[0, 0], M[0, 1], M[1, 1], *p, -B[0], -B[1], *B)
    return np.array([v_1, v_2]), np.array([J_1, J_2])


@given(mass_matrices(), st.tuples(momenta, momenta), st.tuples(limits, limits))
def test_two_brakes_hold_exactly_or_slip_at_full_force(
    M: np.ndarray, p: tuple[float, float], B: tuple[float, float]
) -> None:
    v, J = both(M, p, B)
    assert M @ v == pytest.approx(np.array(p) + J, abs=1e-9)
    for i in (0, 1):
        assert abs(J[i]) <= B[i]
        assert v[i] == 0.0 or J[i] == pytest.approx(-np.sign(v[i]) * B[i], abs=1e-12) or abs(v[i]) < 1e-9


@given(mass_matrices(), st.tuples(momenta, momenta), st.tuples(st.floats(0.01, 2.0), st.floats(0.01, 2.0)))
def test_two_brakes_minimise_the_kinetic_energy(M: np.ndarray, p: tuple[float, float], B: tuple[float, float]) -> None:
    # Over all impulses within the limits: a least-squares problem with bounds, in the square root of M^-1.
    root = np.linalg.inv(np.linalg.cholesky(M))
    best = lsq_linear(root, -root @ np.array(p), bounds=(-np.array(B), np.array(B)), tol=1e-14).x
    _, J = both(M, p, B)

    def energy(impulse: np.ndarray) -> float:
        return float(np.sum((root @ (np.array(p) + impulse)) ** 2))

    assert energy(J) <= energy(best) + 1e-9
    assert pytest.approx(best, abs=1e-4) == J


@given(mass_matrices(), st.tuples(momenta, momenta))
def test_without_brakes_momentum_is_kept(M: np.ndarray, p: tuple[float, float]) -> None:
    v, J = both(M, p, (0.0, 0.0))
    assert np.all(J == 0.0)
    assert M @ v == pytest.approx(np.array(p), abs=1e-12)


@given(mass_matrices(), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_held_joints_stand_exactly_still(M: np.ndarray, p_1: float, p_2: float) -> None:
    v, J = both(M, (p_1, p_2), (10.0, 10.0))
    assert np.all(v == 0.0)
    assert pytest.approx(np.array([-p_1, -p_2]), abs=1e-12) == J


@pytest.mark.parametrize("p", [0.5 + 1e-12, 0.6, 5.0])
def test_the_smallest_motion_meets_the_full_force(p: float) -> None:
    v, J = brake_one(0.3, p, -0.5, 0.5)
    assert v > 0.0
    assert J == -0.5


@given(st.floats(0.05, 2.0), momenta, limits)
def test_one_brake(M: float, p: float, B: float) -> None:
    v, J = brake_one(M, p, -B, B)
    if abs(p) <= B:
        assert (v, J) == (0.0, -p)
    else:
        assert -B * np.sign(p) == J
        assert v == pytest.approx((p + J) / M)


@given(st.floats(0.05, 2.0), momenta, limits)
def test_two_uncoupled_brakes_are_two_single_ones(M: float, p: float, B: float) -> None:
    v, J = both(np.diag([M, 1.0]), (p, 0.0), (B, 0.1))
    assert (v[0], J[0]) == pytest.approx(brake_one(M, p, -B, B), abs=1e-12)
    assert (v[1], J[1]) == (0.0, 0.0)
