"""Bouc and Wen's law against itself, solved by SciPy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from layflat.physics.hysteresis.bouc_wen import BoucWenPart, parameters, relaxed, stored_energy, torques, turned

REACH, LIMIT, TURN = 0.12, 10.0, 0.035


@pytest.mark.parametrize(("beta", "exponent"), [(0.5, 1.0), (0.9, 1.0), (0.5, 2.0), (1.3, 2.0)])
def test_curves_are_those_of_the_law(beta: float, exponent: float) -> None:
    part = BoucWenPart(
        kind="bouc-wen", reference_pressure_gauge="3 bar", pressure_free=0.2, deflection=f"{TURN} rad", beta=beta,
        exponent=exponent, hardening=0.01,
    )  # fmt: skip
    loss, s = parameters(part, LIMIT), np.linspace(0.0, 14.0, 2801)
    angle, way = REACH * np.sin(s) * (1.0 - s / 20.0), np.cos(s) * (1.0 - s / 20.0) - np.sin(s) / 20.0

    def rate(t: float, z: np.ndarray) -> np.ndarray:
        v = REACH * (np.cos(t) * (1.0 - t / 20.0) - np.sin(t) / 20.0) / TURN
        return np.asarray(v * (1.0 - np.abs(z) ** exponent * (beta * np.sign(v * z) + 1.0 - beta)))

    exact = solve_ivp(rate, (0.0, 14.0), [0.0], t_eval=s, max_step=0.01, rtol=1e-8, atol=1e-10).y[0]
    state, found = relaxed(loss), [0.0]
    for turn in np.diff(angle):
        state = turned(loss, state, float(turn), 3e5, 1.0)
        found.append(state.torque)
    assert way[0] > 0.0
    assert np.abs(np.array(found) - LIMIT * exact).max() < 2e-4 * LIMIT
    # The spring beside it has what stiffness and angle say.
    stiffness = LIMIT / TURN
    assert sum(torques(loss, state)) - found[-1] == pytest.approx(0.01 * stiffness * angle[-1])
    elastic = found[-1] ** 2 / stiffness + 0.01 * stiffness * angle[-1] ** 2
    assert stored_energy(loss, state) == pytest.approx(0.5 * elastic)


def test_a_small_cycle_does_not_close_as_masings_would() -> None:
    part = BoucWenPart(kind="bouc-wen", reference_pressure_gauge="3 bar", pressure_free=0.2, deflection=f"{TURN} rad")
    loss = parameters(part, LIMIT)
    state, found = relaxed(loss), []
    for turn in np.repeat([0.0005, -0.0005, 0.0005], [40, 20, 20]):
        state = turned(loss, state, float(turn), 3e5, 1.0)
        found.append(state.torque)
    assert found[-1] < found[39] - 0.02 * LIMIT
