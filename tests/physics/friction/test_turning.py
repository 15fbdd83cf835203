"""Friction over a step in which joints come to rest or turn round, against steps so short that none does."""

from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import lsq_linear

from layflat.jit import kernel
from layflat.lanes import join
from layflat.physics.friction.pivoting import brake_many
from layflat.physics.friction.turning import brake_one, brake_two, solve_constant_friction, solve_varying_friction

MANY = 1000  # steps that take the place of one
SIZES, SEEDS, COUPLINGS = st.integers(1, 5), st.integers(0, 100_000), st.sampled_from([0.0, 0.5, 2.0])
speeds, pushes, limits = st.floats(-3.0, 3.0), st.floats(-3.0, 3.0), st.floats(0.0, 2.0)

Tuples = tuple[tuple[float, ...], ...]


def problem(n: int, seed: int, coupling: float) -> tuple[np.ndarray, ...]:
    """Mass matrix, velocities, impulse of all but friction, greatest impulses; some joints lack brakes or motion."""
    draw = np.random.default_rng(seed)
    root = draw.normal(size=(n, n)) + coupling * draw.normal(size=(n, 1))
    M = root @ root.T + 0.1 * np.eye(n)
    u = draw.normal(size=n) * draw.integers(0, 2, n)
    return M, u, 2.0 * draw.normal(size=n), draw.uniform(0.0, 2.0, n) * draw.integers(0, 4, n) / 3


def given_to(M: np.ndarray, *vectors: np.ndarray) -> Tuples:
    return tuple(M[np.triu_indices(len(M))].tolist()), *(tuple(x.tolist()) for x in vectors)


def step(M: np.ndarray, u: np.ndarray, push: np.ndarray, B: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    triangle, *others = given_to(M, M @ u + push, u, B)
    w, J = solve_constant_friction(None, triangle, *others, others[-1])
    return np.array(w), np.array(J)


def energy(M: np.ndarray, v: np.ndarray) -> float:
    return float(0.5 * v @ M @ v)


def exact(M: float, u: float, push: float, B: float) -> float:
    """Velocity of one joint: it slows down evenly, and goes on from rest if it is pushed by more than friction."""
    way = np.sign(u) if u != 0.0 else np.sign(push)
    if u == 0.0:
        return float(way * max(abs(push) - B, 0.0) / M)
    onwards = u + (push - way * B) / M
    if onwards * way > 0.0:
        return float(onwards)
    left = 1.0 - u / (u - onwards)
    return float(np.sign(push) * max(abs(push) - B, 0.0) * left / M)


@given(st.floats(0.05, 2.0), speeds, pushes, limits)
def test_one_joint_goes_as_pushed_and_rubbed_evenly(M: float, u: float, push: float, B: float) -> None:
    w, J = step(np.array([[M]]), np.array([u]), np.array([push]), np.array([B]))
    assert w[0] == pytest.approx(exact(M, u, push, B), abs=1e-9)
    assert M * w[0] == pytest.approx(M * u + push + J[0], abs=1e-9)


@settings(max_examples=30, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(SIZES, SEEDS, COUPLINGS)
def test_a_step_is_as_many_short_ones_where_one_joint_turns(n: int, seed: int, coupling: float) -> None:
    M, u, push, B = problem(n, seed, coupling)
    w, J = step(M, u, push, B)
    assert M @ w == pytest.approx(M @ u + push + J, abs=1e-8)
    assert np.all(np.abs(J) <= B)
    # Where one joint passes zero and no other comes to rest, or sets out, all are as they would be.
    assume(np.sum(u * w < 0.0) == 1 and np.all((u == 0.0) == (w == 0.0)))
    v, turns = u, 0
    for _ in range(MANY):
        before, (v, _) = v, step(M, v, push / MANY, B / MANY)
        turns += np.sum(np.sign(v) != np.sign(before))
    assume(turns <= 2)  # it may stand still for a short step
    per = np.linalg.norm(np.linalg.inv(M), 2)
    assert np.abs(w - v).max() <= 10.0 * per * (np.abs(push).max() + B.max()) / MANY


@given(SIZES, SEEDS, COUPLINGS, st.floats(1.0, 2.0))
def test_friction_of_any_levels_only_takes_energy(n: int, seed: int, coupling: float, ratio: float) -> None:
    M, u, push, B = problem(n, seed, coupling)
    triangle, p, of, B_, S = given_to(M, M @ u, u, B, ratio * B)
    w, J = (np.array(found) for found in solve_varying_friction(None, triangle, p, of, B_, S))
    assert energy(M, w) <= energy(M, u) * (1.0 + 1e-9)
    triangle, p, of, B_, S = given_to(M, M @ u + push, u, B, ratio * B)
    w, J = (np.array(found) for found in solve_varying_friction(None, triangle, p, of, B_, S))
    assert M @ w == pytest.approx(M @ u + push + J, abs=1e-8)
    assert np.all(np.abs(J) <= ratio * B)


@given(SIZES, SEEDS, COUPLINGS)
def test_where_none_comes_to_rest_it_is_solved_at_once(n: int, seed: int, coupling: float) -> None:
    M, u, push, B = problem(n, seed, coupling)
    triangle, p, of, B_ = given_to(M, M @ u + 0.1 * push, u, B)
    low = tuple(-most for most in B_)
    w, J = brake_many(triangle, p, of, low, B_)
    if n == 1:
        (w,), (J,) = zip(brake_one(triangle[0], p[0], *low, *B_), strict=True)
        w, J = (w,), (J,)
    if n == 2:
        w_1, w_2, J_1, J_2 = brake_two(*triangle, *p, *low, *B_)
        w, J = (w_1, w_2), (J_1, J_2)
    assume(all(before * after > 0.0 or before == 0.0 for before, after in zip(of, w, strict=True)))
    velocities, impulses = solve_constant_friction(None, triangle, p, of, B_, B_)
    assert velocities == w
    # What moves has all of its friction, to the last bit; what is solved for is that but for rounding.
    assert impulses == tuple(j if v == 0.0 else -np.sign(v) * most for v, j, most in zip(of, J, B_, strict=True))
    assert impulses == pytest.approx(J, abs=1e-9)


@given(SIZES, SEEDS, COUPLINGS)
def test_where_static_friction_is_kinetic_friction_it_is_coulombs(n: int, seed: int, coupling: float) -> None:
    M, u, push, B = problem(n, seed, coupling)
    triangle, p, of, B_ = given_to(M, M @ u + push, u, B)
    one, other = (
        solve_varying_friction(None, triangle, p, of, B_, B_),
        solve_constant_friction(None, triangle, p, of, B_, B_),
    )
    assert np.array(one) == pytest.approx(np.array(other), abs=1e-9)


@pytest.mark.parametrize(
    ("u", "p", "J"),
    [
        (0.0, 0.7, -0.7),  # at rest, held by more than it slides at
        (0.0, -1.1, 1.0),  # torn loose
        (2.0, 0.7, -0.5),  # sliding on
        (2.0, -0.3, 0.3),  # it would turn back, but is held where it stops
        (2.0, -1.2, -0.5 * 6 / 23 + 17 / 23),  # it turns back: 6/23 of the step onwards, 17/23 from rest
        (2.0, 0.3, -0.3),  # it comes to rest
    ],
)
def test_a_joint_holds_more_than_it_slides_at(u: float, p: float, J: float) -> None:
    (v,), (found,) = solve_varying_friction(None, (0.3,), (p,), (u,), (0.5,), (1.0,))
    assert found == pytest.approx(J)
    assert v == pytest.approx((p + J) / 0.3, abs=1e-12)
    assert (v == 0.0) == (abs(p + J) < 1e-12)


def some(n: int) -> list[Tuples]:
    found = []
    for seed in range(4):
        M, u, push, B = problem(n, seed, 0.5)
        found.append(given_to(M, M @ u + push, u, B, B))
    return found


@pytest.mark.parametrize("n", [1, 2, 4])
def test_arms_side_by_side_are_as_each_alone(n: int) -> None:
    given_ = some(n)
    joined: Any = join(join(given_[0], given_[1]), join(given_[2], given_[3]))
    alone = [solve_constant_friction(None, *one) for one in given_]
    assert solve_constant_friction(None, *joined) == join(join(alone[0], alone[1]), join(alone[2], alone[3]))


@given(st.integers(2, 4), SEEDS, COUPLINGS)
def test_it_does_not_matter_which_arm_comes_to_rest_beside_it(n: int, seed: int, coupling: float) -> None:
    """Also for one with a joint at rest that begins to slip, which may look as if another came to rest."""
    resting = given_to(np.eye(n), np.full(n, 0.5), np.ones(n), np.ones(n), np.ones(n))
    M, u, push, B = problem(n, seed, coupling)
    one = given_to(M, M @ u + push, u, B, B)
    assert solve_constant_friction(None, *join(one, resting)) == join(
        solve_constant_friction(None, *one), solve_constant_friction(None, *resting)
    )


@kernel
def compiled(M: Any, p: Any, u: Any, B: Any, S: Any) -> Any:
    return solve_varying_friction(0.0, M, p, u, B, S)


@pytest.mark.compiled
@pytest.mark.parametrize("n", [1, 2, 4])
def test_compiled_it_has_the_same_bits(n: int) -> None:
    for one in some(n):
        assert compiled(*one) == solve_varying_friction(0.0, *one)


momenta = st.floats(-5.0, 5.0)


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
