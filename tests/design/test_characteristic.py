"""Force over travel: Eq. (1), energy, and what is refused; curves through points, by spline and by stencils."""

from __future__ import annotations

from math import cos, pi, radians
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from layflat.design import Characteristic, cylinder_characteristic, design_joint, wrapped_hose
from layflat.design.characteristic import CURVE_POINTS, Through, spline, stencils
from layflat.errors import DesignError
from layflat.machine import changed, load
from layflat.machine.parameters import full_travel, torque_constant

ARM = load("paper-arm")
UNEVEN = np.linspace(0.0, 1.0, 101) ** 1.5  # points spaced as the angles of a cam are


def eq1_force(width: float, R: float, gamma: float, alpha: float) -> float:
    """F/P written out from the paper, apart from the package."""
    return R / (2 * cos((pi - gamma) / 2)) * (width - R * (gamma - alpha) / 2) * (1 - cos(alpha))


@given(
    width=st.floats(0.05, 0.3),
    share=st.floats(0.7, 1.2),
    gamma=st.floats(radians(70), radians(150)),
    c=st.floats(1, 1.4),
)
def test_force_is_eq1_and_volume_its_integral(width: float, share: float, gamma: float, c: float) -> None:
    R, end = share * width / 2, 0.7 * gamma
    curve = wrapped_hose(width, R, gamma, end, c)
    for alpha, s, force in zip(np.linspace(gamma, end, CURVE_POINTS), curve.travel, curve.force, strict=True):
        assert s == pytest.approx(c * R * (gamma - alpha), rel=1e-9, abs=1e-12)
        assert force == pytest.approx(eq1_force(width, R, gamma, alpha), rel=1e-9)
    swept, _ = quad(lambda a: eq1_force(width, R, gamma, a) * c * R, end, gamma)
    assert curve.swept_volume == pytest.approx(swept, rel=1e-9)


@pytest.mark.parametrize("name", ["large", "small"])
def test_agrees_with_the_parameters_of_the_dynamics(name: str) -> None:
    joint = ARM.joint[name]
    curve = cylinder_characteristic(joint)
    assert curve.swept_volume == pytest.approx(joint.geometry.volume, rel=1e-12)
    assert curve.full_travel / joint.output.radius == pytest.approx(full_travel(joint), rel=1e-12)


def test_exact_mean_torque_is_within_half_a_percent_of_table_1() -> None:
    assert design_joint(ARM, "large").mean_torque == pytest.approx(82.10202, rel=0.005)


@pytest.mark.parametrize("width", ["160 mm", None, [0.16]])
def test_a_size_that_is_no_number_is_refused(width: Any) -> None:
    with pytest.raises(DesignError, match=r"hose on a cylinder: width: .*; give a positive number"):
        wrapped_hose(width, 0.0762, radians(120), radians(84), 1.26)


def test_a_measured_torque_factor_counts_in_design_as_in_simulation() -> None:
    weaker = changed(ARM, "joint.large.hose.torque_factor", 0.9)
    design, whole = design_joint(weaker, "large"), design_joint(ARM, "large")
    assert design.mean_torque == pytest.approx(torque_constant(weaker.joint["large"]) * 4e5, rel=1e-12)
    np.testing.assert_allclose(design.tension, 0.9 * whole.tension, rtol=1e-9)
    assert design.air.swept_volume == pytest.approx(weaker.joint["large"].geometry.volume, rel=1e-12)


def test_on_a_round_roller_torque_falls_to_about_half() -> None:
    angle, torque = design_joint(ARM, "large").roller_torque
    assert torque[-1] / torque[0] == pytest.approx(0.51, abs=0.01)
    assert np.degrees(angle[-1]) == pytest.approx(133.3, abs=0.1)


@pytest.mark.parametrize("bad", [0.0, -0.1, float("nan"), float("inf")])
@pytest.mark.parametrize("which", range(5))
def test_sizes_must_be_positive(bad: float, which: int) -> None:
    sizes = [0.16, 0.0762, radians(120), radians(84), 1.26]
    sizes[which] = bad
    with pytest.raises(DesignError, match="positive"):
        wrapped_hose(*sizes)


def test_wrap_over_half_a_turn_is_refused() -> None:
    with pytest.raises(DesignError, match=r"wrap of 190 deg.*at most 180 deg"):
        wrapped_hose(0.16, 0.0762, radians(190), radians(84), 1.26)


def test_contact_end_beyond_wrap_is_refused() -> None:
    with pytest.raises(DesignError, match="contact_end must be smaller"):
        wrapped_hose(0.16, 0.0762, radians(84), radians(120), 1.26)


def test_a_hose_too_narrow_for_its_wrap_is_refused() -> None:
    with pytest.raises(DesignError, match="no force at"):
        wrapped_hose(0.03, 0.0762, radians(120), radians(30), 1.26)


@pytest.mark.parametrize(
    ("travel", "force", "says"),
    [
        ([0, 1, 2], [1, 1, 1], "3 travels and 3 forces"),
        ([0, 1, 2, 3, 4, 5], [1, 1, 1, 1, 1], "6 travels and 5 forces"),
        ([0, 1, 2, 2, 4, 5, 6], [1] * 7, "does not rise"),
        ([1, 2, 3, 4, 5, 6, 7], [1] * 7, "does not rise from 0"),
        ([0, 1, 2, 3, 4, 5, 6], [1, 1, 1, np.nan, 1, 1, 1], "not finite"),
        ([0, 1, 2, 3, 4, 5, 6], [1, 1, 1, 0, 1, 1, 1], "no force at 3000 mm"),
    ],
)
def test_a_broken_curve_is_refused(travel: list[float], force: list[float], says: str) -> None:
    with pytest.raises(DesignError, match=says):
        Characteristic(np.array(travel, dtype=float), np.array(force, dtype=float), "test")


@pytest.mark.parametrize("through", [spline, stencils])
def test_integral_and_derivatives_of_a_sine(through: Through) -> None:
    integral, slope, bend = through(UNEVEN, np.sin(3.0 * UNEVEN))
    np.testing.assert_allclose(integral, (1.0 - np.cos(3.0 * UNEVEN)) / 3.0, atol=1e-9)
    np.testing.assert_allclose(slope, 3.0 * np.cos(3.0 * UNEVEN), atol=1e-6)
    np.testing.assert_allclose(bend, -9.0 * np.sin(3.0 * UNEVEN), atol=1e-4)


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
