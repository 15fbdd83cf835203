"""Plates by virtual work: against numerical integration of the gap, finite differences, and Eq. (1)."""

from __future__ import annotations

from math import cos, inf, pi, radians, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from layflat.design import Plate, ShellLine, plate_characteristic, straplines, synthesise, wrapped_hose
from layflat.errors import DesignError

plates = st.builds(
    Plate, width=st.floats(0.05, 0.3), length=st.floats(0.05, 0.2), radius=st.one_of(st.just(inf), st.floats(0.08, 2.0))
)


def stadium(width: float, gap: float) -> float:
    """Area of a hose pressed flat to a gap: the flats are as long as the circumference leaves."""
    flat = (2 * width - pi * gap) / 2
    return flat * gap + pi * gap**2 / 4


@given(plate=plates, share=st.floats(0.05, 0.95))
def test_volume_is_the_stadium_summed_along_the_gap(plate: Plate, share: float) -> None:
    psi = share * plate.full_opening
    if plate.wrap == 0:
        swept, _ = quad(
            lambda x: stadium(plate.width, 2 * x * sin(psi / 2)) * cos(psi / 2), 0, plate.length, epsabs=1e-12
        )
    else:
        R = plate.radius
        swept, _ = quad(
            lambda a: stadium(plate.width, 2 * R * sin(a) * sin(psi / 2)) * R * cos(psi / 2),
            0,
            plate.wrap,
            epsabs=1e-12,
        )
    assert float(plate.volume(psi)) == pytest.approx(swept, rel=1e-7)


@given(plate=plates, share=st.floats(0.05, 0.95))
def test_moment_is_the_slope_of_the_volume(plate: Plate, share: float) -> None:
    psi, step = share * plate.full_opening, 1e-5
    slope = float(plate.volume(psi + step) - plate.volume(psi - step)) / (2 * step)
    assert float(plate.moment(psi)) == pytest.approx(slope, rel=1e-5, abs=1e-9)


@given(radius=st.floats(0.06, 0.5), wrap=st.floats(radians(30), radians(120)), width=st.floats(0.1, 0.3))
def test_a_curved_plate_starts_with_the_force_of_eq1(radius: float, wrap: float, width: float) -> None:
    plate = Plate(width, radius * wrap, radius)
    eq1 = wrapped_hose(width, radius, wrap, 0.99 * wrap, 1.26)
    assert float(plate.moment(0.0)) / plate.chord == pytest.approx(eq1.force[0], rel=1e-12)


def test_a_flat_plate_is_the_limit_of_a_curved_one() -> None:
    flat, curved = Plate(0.16, 0.16), Plate(0.16, 0.16, 300.0)
    psi = np.linspace(0.0, flat.full_opening * 0.999, 50)
    np.testing.assert_allclose(curved.volume(psi), flat.volume(psi), rtol=1e-6)


@pytest.mark.parametrize("radius", [inf, 0.3])
def test_plates_beside_the_shaft_carry_a_cam(radius: float) -> None:
    plate = Plate(0.16, 0.16, radius)
    curve = plate_characteristic(plate)
    assert curve.force[-1] / curve.force[0] == pytest.approx(0.5, abs=1e-6)
    line = straplines.plate_strap_line(plate, distance=0.06, height=0.15)
    assert isinstance(line, ShellLine)
    cam = synthesise(curve, line, radians(133))
    assert cam.convex
    assert cam.torque_constant * radians(133) == pytest.approx(curve.swept_volume, rel=1e-12)


@pytest.mark.parametrize(
    ("width", "length", "radius", "says"),
    [
        (0.0, 0.1, inf, "width"),
        (0.1, -0.1, inf, "length"),
        (0.1, float("nan"), inf, "length"),
        (inf, 0.1, inf, "width"),
        (0.1, 0.1, 0.0, "radius"),
        (0.1, 0.4, 0.1, "wraps 229.2 deg.*at most 180 deg"),
    ],
)
def test_bad_plates_are_refused(width: float, length: float, radius: float, says: str) -> None:
    with pytest.raises(DesignError, match=says):
        Plate(width, length, radius)


@pytest.mark.parametrize("opening", [0.0, -0.1, 3.0, float("nan")])
def test_bad_openings_are_refused(opening: float) -> None:
    with pytest.raises(DesignError, match="opening"):
        plate_characteristic(Plate(0.16, 0.16), opening)
