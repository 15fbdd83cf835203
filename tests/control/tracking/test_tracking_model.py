import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from layflat.control.tracking.model import ObserverTuning, PressureInnovations, correct_pressure, observer_gains

T = 0.005


@given(st.floats(0.05, 5.0), st.floats(0.02, 2.0))
def test_the_observers_gains_are_those_of_a_kalman_filter(torque: float, inertia: float) -> None:
    observer = ObserverTuning(torque, 2e-4, 0.5, 0.0)
    found = observer_gains(observer, inertia, T)
    F, H, g = np.array([[1.0, T], [0.0, 1.0]]), np.array([[1.0, 0.0]]), np.array([[0.5 * T * T], [T]])
    noise = g @ g.T * (torque / inertia) ** 2 + 1e-18 * np.eye(2)
    C = solve_discrete_are(F.T, H.T, noise, np.array([[observer.angle**2]]))
    gain = C @ H.T / (H @ C @ H.T + observer.angle**2)
    assert found.angle == pytest.approx(gain[0, 0], rel=1e-3)
    assert found.velocity == pytest.approx(gain[1, 0], rel=1e-3)


@pytest.mark.parametrize("periods", [0.25, 0.2, 0.15])
def test_dither_does_not_reach_the_models_pressure(periods: float) -> None:
    observer = ObserverTuning(1.0, 1e-4, 0.5, float(-2.0 * np.cos(2.0 * np.pi * periods)))
    model, kept, seen = 0.0, PressureInnovations(0.0, 0.0), []
    for k in range(200):
        change, kept = correct_pressure(observer, kept, 1e4 + 3e3 * np.cos(2.0 * np.pi * periods * k + 0.7) - model)
        model += change
        seen.append(model)
    assert np.abs(np.array(seen[60:]) - 1e4).max() < 30.0
