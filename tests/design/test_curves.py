"""Curves through points: both ways find integral and derivatives, and the same of every joint."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from layflat.design import design_joint
from layflat.design.curves import Through, spline, stencils
from layflat.errors import DesignError
from layflat.machine import changed, load

POINTS = np.linspace(0.0, 1.0, 101) ** 1.5
"""Unevenly spaced, as the angles of a cam are."""


@pytest.mark.parametrize("through", [spline, stencils])
def test_integral_and_derivatives_of_a_sine(through: Through) -> None:
    integral, slope, bend = through(POINTS, np.sin(3.0 * POINTS))
    np.testing.assert_allclose(integral, (1.0 - np.cos(3.0 * POINTS)) / 3.0, atol=1e-9)
    np.testing.assert_allclose(slope, 3.0 * np.cos(3.0 * POINTS), atol=1e-6)
    np.testing.assert_allclose(bend, -9.0 * np.sin(3.0 * POINTS), atol=1e-4)


@pytest.mark.parametrize("through", [spline, stencils])
def test_six_points_are_enough_for_a_polynomial_of_degree_five(through: Through) -> None:
    x = np.array([0.0, 0.1, 0.3, 0.45, 0.8, 1.0])
    integral, slope, bend = through(x, x**5)
    np.testing.assert_allclose(integral, x**6 / 6, atol=1e-12)
    np.testing.assert_allclose(slope, 5 * x**4, atol=1e-10)
    np.testing.assert_allclose(bend, 20 * x**3, atol=1e-9)


@pytest.mark.parametrize(
    ("path", "values"),
    [
        ("output.shaft_offset", (0.0, 0.002, 0.01, 0.025, 0.035, 0.05, 0.07)),
        ("output.radius", (0.005, 0.012, 0.018, 0.03, 0.04, 0.05)),
        ("hose.wrap", (1.6, 2.0, 2.3, 2.8)),
        ("hose.contact_end", (0.4, 1.0, 1.8)),
        ("strap.thickness", (5e-5, 2e-4, 4e-4)),
    ],
)
def test_findings_are_the_same_either_way(path: str, values: tuple[float, ...]) -> None:
    def found(value: float, name: str, **how: Any) -> object:
        try:
            machine = changed(load("paper-arm"), f"joint.{name}.{path}", value)
            return design_joint(machine, name, strict=False, **how).findings
        except DesignError as error:
            return str(error)

    for name in ("large", "small"):
        for value in values:
            assert found(value, name, through=stencils) == found(value, name)
