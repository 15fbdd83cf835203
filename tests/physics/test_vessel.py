from math import pi
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from layflat.physics.chamber import Chamber, air_mass, energy, pressure, temperature, wall_heat
from layflat.physics.flow import laminar_slope, orifice, sonic_conductance

VOLUME = pi / 4 * 0.2**2 * 0.515
START, OUTSIDE, WARMTH = 7.9e5, 1e5, 298.0
HOLE = pi / 4 * 0.00271**2
CRITICAL_RATIO = 0.528
"""Of an ideal nozzle."""


def blow_down(discharge: float, wall: float, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Pressure at these times, Pa, by our laws of chamber and flow."""
    vessel = Chamber(VOLUME, 0.0, wall)
    C, slope = sonic_conductance(HOLE, discharge), laminar_slope(CRITICAL_RATIO)

    def rates(_t: float, state: NDArray[np.float64]) -> list[float]:
        E, m = float(state[0]), float(state[1])
        p = pressure(vessel, E, VOLUME, OUTSIDE)
        T = temperature(vessel, p, m, VOLUME, OUTSIDE)
        flow, heat = orifice(C, CRITICAL_RATIO, slope, p, T, OUTSIDE, WARMTH)
        return [wall_heat(vessel, T, WARMTH) - heat, -flow]

    state = [energy(vessel, START, VOLUME, OUTSIDE), air_mass(vessel, START, WARMTH, VOLUME, OUTSIDE)]
    energies = solve_ivp(rates, (0.0, times[-1]), state, t_eval=times, rtol=1e-6, atol=1e-9, max_step=1.0).y[0]
    return np.array([pressure(vessel, E, VOLUME, OUTSIDE) for E in energies])


@pytest.mark.compiled
def test_a_measured_blow_down_with_two_fitted_numbers(measured_data: Path) -> None:
    lines = (measured_data / "vessel" / "Air_790kPa_21mm.csv").read_text().splitlines()
    rows = [line.split(",") for line in lines if line.startswith("gas_pressure")]
    times, measured = np.array([float(row[1]) for row in rows]), np.array([float(row[2]) for row in rows]) * 1e5

    def misses(guess: NDArray[np.float64]) -> NDArray[np.float64]:
        return (blow_down(guess[0], 10.0 * guess[1], times) - measured) / 1e3

    fit = least_squares(misses, [0.8, 0.2], bounds=([0.3, 0.0], [1.0, 2.0]))
    rms = float(np.sqrt(np.mean(fit.fun**2)))
    assert rms < 3.0
    assert 0.6 < fit.x[0] < 1.0
