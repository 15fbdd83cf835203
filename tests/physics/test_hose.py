from math import degrees

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from layflat.physics.hose import (
    PolynomialStroke,
    peeled_volume,
    roller_torque,
    roller_travel,
    swept_volume,
    torque_per_pressure,
)

# The paper's Table 1 was computed with pi = 3.14.
R, r, R_H, GAMMA = 0.0762, 0.026, 0.16 / 3.14, 2.094
coefficients = st.builds(PolynomialStroke, *[st.floats(-1e-3, 1e-3)] * 5)


def table_torque(alpha: float) -> float:
    """Eq. (1) with the table's pi, which enters as pi R_h, the hose's width, and in cos((pi - gamma)/2)."""
    lever = np.cos((np.pi - GAMMA) / 2) / np.cos((3.14 - GAMMA) / 2)
    return float(lever * roller_torque(4e5, R, r, 0.16 / np.pi, GAMMA, alpha))


@pytest.mark.parametrize(
    ("alpha", "torque"),
    [
        (2.094, 109.7463),
        (1.9684, 98.48103),
        (1.78, 81.77094),
        (1.6544, 70.99169),
        (1.5288, 60.67268),
        (1.466, 55.72693),
    ],
)
def test_equation_1_gives_table_1(alpha: float, torque: float) -> None:
    assert table_torque(alpha) == pytest.approx(torque, abs=1e-4)


def test_torque_is_proportional_to_pressure_and_zero_at_the_clamp() -> None:
    assert roller_torque(2e5, R, r, R_H, GAMMA, 1.7) == pytest.approx(2 * roller_torque(1e5, R, r, R_H, GAMMA, 1.7))
    assert roller_torque(4e5, R, r, R_H, GAMMA, 0.0) == 0.0


@given(st.floats(0.2, 2.0), st.floats(1.0, 1.5))
def test_peeled_volume_is_the_integral_of_equation_1(alpha: float, c: float) -> None:
    # One pascal: the torque is the volume per radian of output, which turns by c R/r per contact angle.
    swept, _ = quad(lambda a: roller_torque(1.0, R, r, R_H, GAMMA, a) * c * R / r, alpha, GAMMA, epsabs=1e-15)
    assert peeled_volume(R, R_H, GAMMA, alpha, c) == pytest.approx(swept, rel=1e-9)


def test_travel_of_a_roller_starts_at_the_collapsed_hose() -> None:
    assert roller_travel(R, r, GAMMA, GAMMA, 1.26) == 0.0
    # Table 1: 13.32 degrees per 0.0628 rad.
    assert degrees(roller_travel(R, r, GAMMA, GAMMA - 0.0628, 1.2631)) == pytest.approx(13.32, abs=0.01)


@given(coefficients, st.floats(0.0, 2.5))
def test_swept_volume_grows_by_torque_per_pressure(stroke: PolynomialStroke, s: float) -> None:
    step = 1e-4
    # Richardson extrapolation of central differences is exact for polynomials of this degree.
    coarse = (swept_volume(stroke, s + 2 * step) - swept_volume(stroke, s - 2 * step)) / (4 * step)
    fine = (swept_volume(stroke, s + step) - swept_volume(stroke, s - step)) / (2 * step)
    assert (4 * fine - coarse) / 3 == pytest.approx(torque_per_pressure(stroke, s), abs=1e-12)


@given(coefficients)
def test_nothing_is_swept_without_travel(stroke: PolynomialStroke) -> None:
    assert swept_volume(stroke, 0.0) == 0.0
