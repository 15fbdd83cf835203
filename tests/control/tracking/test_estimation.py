import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.tracking.estimation import (
    CREDIBLE_DEVIATIONS,
    PAYLOAD_DEVIATIONS,
    MatrixZeros,
    ParameterEstimate,
    Prior,
    initial_estimate,
    update_parameters,
    upper_payload,
)  # fmt: skip

N, M = 2, 5
SHAPE = MatrixZeros((0.0,) * (N * N), (0.0,) * (M * M), (0.0,) * (N * M))
UNKNOWNS = Prior(
    (0.0, 0.0, 0.0, 0.0, 1.0), (2.0, 1.0, 1.5, 0.5, 0.6), (0.0,) * M, (-9.0,) * M, (9.0,) * M, angle_variance=1e-6
)


def with_sensitivities(seed: int) -> ParameterEstimate:
    Q, V = np.random.default_rng(seed).normal(size=(2, N * M)) * [[1e-3], [0.1]]
    parameters: ParameterEstimate = initial_estimate(UNKNOWNS, SHAPE)
    return parameters._replace(angles=tuple(Q), velocities=tuple(V))


@given(st.integers(0, 10_000))
def test_it_learns_as_a_kalman_filter_does(seed: int) -> None:
    parameters = with_sensitivities(seed)
    e = 1e-3 * np.random.default_rng(seed + 1).uniform(-1.0, 1.0, N)
    after, turns, speeds, doubt = update_parameters(UNKNOWNS, parameters, tuple(e), 1.0)
    C, Q, V = (np.reshape(x, (-1, M)) for x in (parameters.covariance, parameters.angles, parameters.velocities))
    gain = C @ Q.T @ np.linalg.inv(Q @ C @ Q.T + UNKNOWNS.angle_variance * np.eye(N))
    change = gain @ e
    assert np.subtract(after.values, parameters.values) == pytest.approx(change, rel=1e-6, abs=1e-12)
    assert np.reshape(after.covariance, (M, M)) == pytest.approx((np.eye(M) - gain @ Q) @ C, rel=1e-6, abs=1e-9)
    assert turns == pytest.approx(tuple(Q @ change))
    assert speeds == pytest.approx(tuple(V @ change))
    first = e[0] ** 2 / (Q[0] @ C @ Q[0] + UNKNOWNS.angle_variance)
    assert doubt >= first * (1.0 - 1e-9)


def test_what_is_not_credible_teaches_the_less_the_further_off_it_is() -> None:
    parameters = with_sensitivities(3)
    Q = np.reshape(parameters.angles, (N, M))[0]
    edge = CREDIBLE_DEVIATIONS * np.sqrt(Q @ np.reshape(parameters.covariance, (M, M)) @ Q + UNKNOWNS.angle_variance)
    sizes = (0.5 * edge, edge, 2.0 * edge, 4.0 * edge)
    first = np.array([update_parameters(UNKNOWNS, parameters, (size, 0.0), 1.0)[0].values[0] for size in sizes])
    assert first / first[1] == pytest.approx([0.5, 1.0, 0.5, 0.25], rel=0.05)


def test_what_is_known_stays_as_it_is_and_what_is_learnt_within_its_range() -> None:
    sure = UNKNOWNS._replace(deviations=(2.0, 1.0, 1.5, 0.5, 0.0), high=(0.01,) * 4 + (9.0,), low=(-0.01,) * 4 + (0.0,))
    parameters = initial_estimate(sure, SHAPE)._replace(angles=with_sensitivities(5).angles)
    after, _, _, _ = update_parameters(sure, parameters, (2e-3, -2e-3), 1.0)
    assert after.values[4] == 1.0
    assert np.abs(after.values[:4]).max() <= 0.01
    assert np.abs(after.values[:4]).max() > 0.0


def test_an_arm_that_is_left_to_what_pushes_it_learns_nothing() -> None:
    parameters = with_sensitivities(3)
    after, turns, speeds, doubt = update_parameters(UNKNOWNS, parameters, (0.5, -0.5), 0.0)
    assert after == parameters
    assert turns == speeds == (0.0, 0.0)
    assert doubt == pytest.approx(0.25 / UNKNOWNS.angle_variance)


def test_the_heaviest_payload_is_beyond_the_estimate_as_far_as_that_is_unsure_and_possible() -> None:
    first = initial_estimate(UNKNOWNS, SHAPE)
    assert upper_payload(UNKNOWNS, first) == pytest.approx(1.0 + PAYLOAD_DEVIATIONS * 0.6)
    assert upper_payload(UNKNOWNS._replace(high=(9.0,) * 4 + (1.5,)), first) == 1.5
    sure = UNKNOWNS._replace(deviations=(2.0, 1.0, 1.5, 0.5, 0.0))
    assert upper_payload(sure, initial_estimate(sure, SHAPE)) == 1.0
