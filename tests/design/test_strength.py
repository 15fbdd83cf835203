"""Torsion of a shaft in the cam's bore."""

from math import pi, sqrt

import pytest

from layflat.design.strength import min_shaft_diameter, shaft_advice, shear_stress


def test_the_stress_of_a_bar_in_torsion_is_its_torque_over_its_section_modulus() -> None:
    assert shear_stress(12.0, 0.005) == pytest.approx(12.0 / (pi * 0.005**3 / 16.0))
    assert shear_stress(12.0, 0.005) == pytest.approx(490e6, rel=0.01)


@pytest.mark.parametrize("torque", [0.1, 12.0, 82.0])
def test_the_thinnest_shaft_bears_two_thirds_of_its_yield(torque: float) -> None:
    assert shear_stress(torque, min_shaft_diameter(torque)) == pytest.approx(490e6 / sqrt(3.0) / 1.5)


def test_a_bore_that_is_too_thin_is_told_with_its_stress() -> None:
    assert "in the bore of 5 mm it would bear 489 MPa: bolt the cam to the link" in shaft_advice(12.0, 0.005)
    assert "bore" not in shaft_advice(12.0, 0.008)
