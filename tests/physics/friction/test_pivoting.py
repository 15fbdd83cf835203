"""Friction of many coupled joints: what is true of the solution, whatever leads to it."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from layflat.jit import kernel
from layflat.lanes import join
from layflat.physics.friction.pivoting import brake_many
from layflat.physics.friction.turning import brake_two

SIZES = st.integers(1, 7)


def problem(n: int, seed: int, coupling: float) -> tuple[np.ndarray, ...]:
    """Mass matrix, momenta, velocities before the step, and greatest impulses; some joints lack brakes or motion."""
    draw = np.random.default_rng(seed)
    root = draw.normal(size=(n, n)) + coupling * draw.normal(size=(n, 1))
    M = root @ root.T + 0.02 * np.eye(n)
    u = draw.normal(size=n) * draw.integers(0, 2, n)
    B = draw.uniform(0.0, 2.0, n) * draw.integers(0, 4, n) / 3
    return M, M @ u + draw.normal(size=n), u, B


def given_to(M: np.ndarray, p: np.ndarray, u: np.ndarray, B: np.ndarray) -> tuple[Any, ...]:
    return tuple(M[np.triu_indices(len(M))].tolist()), *(tuple(x.tolist()) for x in (p, u, -B, B))


def solved(*of: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    w, J = brake_many(*given_to(*of))
    return np.array(w), np.array(J)


@settings(max_examples=300, deadline=None)
@given(SIZES, st.integers(0, 100_000), st.sampled_from([0.0, 1.0, 5.0]))
def test_joints_are_held_exactly_or_slide_against_all_of_their_friction(n: int, seed: int, coupling: float) -> None:
    M, p, u, B = problem(n, seed, coupling)
    w, J = solved(M, p, u, B)
    scale = np.abs(M).max() * (1.0 + np.abs(w).max())
    assert np.abs(M @ w - p - J).max() < 1e-9 * scale
    assert np.all(np.abs(J) <= B)
    slides = w != 0.0
    assert np.abs(J[slides] + np.sign(w[slides]) * B[slides]).max(initial=0.0) < 1e-9 * scale


@given(st.integers(0, 100_000), st.sampled_from([0.0, 1.0, 5.0]))
def test_two_joints_are_those_of_the_closed_form(seed: int, coupling: float) -> None:
    M, p, u, B = problem(2, seed, coupling)
    w, _ = solved(M, p, u, B)
    closed = brake_two(M[0, 0], M[0, 1], M[1, 1], *p.tolist(), *(-B).tolist(), *B.tolist())[:2]
    assert w == pytest.approx(closed, rel=1e-8, abs=1e-9)


def test_joints_at_rest_stay_there_exactly() -> None:
    M, _, u, B = problem(6, 3, 1.0)
    p = 0.9 * B * np.array([1, -1, 1, 1, -1, -1])
    w, J = solved(M, p, 0.0 * u, B)
    assert np.array_equal(w, np.zeros(6))
    assert J == pytest.approx(-p)


def test_arms_side_by_side_are_as_each_alone() -> None:
    given_ = [given_to(*problem(4, seed, 1.0)) for seed in range(4)]
    side_by_side = brake_many(*join(join(given_[0], given_[1]), join(given_[2], given_[3])))
    alone = [brake_many(*one) for one in given_]
    assert side_by_side == join(join(alone[0], alone[1]), join(alone[2], alone[3]))


@settings(max_examples=300, deadline=None)
@given(SIZES, st.integers(0, 100_000), st.sampled_from([0.0, 1.0, 5.0]))
def test_what_moves_on_has_known_friction_and_the_others_are_held_or_slip(n: int, seed: int, coupling: float) -> None:
    M, p, u, B = problem(n, seed, coupling)
    upper, momenta, before, *_ = given_to(M, p, u, B)
    known = -np.sign(u) * B
    low, high = (tuple(np.where(u == 0.0, most, known).tolist()) for most in (-B, B))
    w, J = (np.array(found) for found in brake_many(upper, momenta, before, low, high))
    rests = u == 0.0
    assert J[~rests] == pytest.approx(known[~rests], abs=0.0)
    # What moves on put in: the others alone are the same problem, seen from what is left of the matrix.
    left = np.linalg.inv(np.linalg.inv(M)[np.ix_(rests, rests)])
    pushed = left @ np.linalg.solve(M, p + np.where(rests, 0.0, known))[rests]
    if rests.any():
        alone, _ = solved(left, pushed, u[rests], B[rests])
        assert w[rests] == pytest.approx(alone, abs=1e-7 * (1.0 + np.abs(w).max()))


@kernel
def compiled(M: Any, p: Any, u: Any, low: Any, high: Any) -> Any:
    return brake_many(M, p, u, low, high)


@pytest.mark.compiled
@pytest.mark.parametrize("n", [1, 3, 4, 7])
def test_compiled_it_has_the_same_bits(n: int) -> None:
    for seed in range(20):
        given_ = given_to(*problem(n, seed, 1.0))
        assert compiled(*given_) == brake_many(*given_)
