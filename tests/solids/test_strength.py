"""Stresses by hand formulas, beside integrals of the same beams and rings."""

from math import inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.design.strength import SHAFT_YIELD, min_shaft_diameter
from layflat.solids.standard.materials import material
from layflat.solids.strength import (
    Strength,
    bearing_load,
    bearing_reactions,
    calliper_arm,
    check_strength,
    clamp_bar,
    clamp_force,
    clamp_screws,
    end_plate,
    hinge_webbing,
    hose_pull,
    section_modulus,
    shaft,
    tightening_torque,
)

SIZES = st.floats(0.5e-3, 0.2)
FORCES = st.floats(-1e4, 1e4)


@given(SIZES, SIZES, st.floats(0.0, 0.9))
def test_a_section_modulus_is_the_integral_of_the_square_of_the_height(
    width: float, height: float, share: float
) -> None:
    hole = share * height
    y = np.linspace(hole / 2, height / 2, 4001)
    inertia = 2 * width * np.trapezoid(y**2, y)  # both halves beside the hole
    assert section_modulus(width, height, hole) == pytest.approx(inertia / (height / 2), rel=1e-5)


def test_a_clamp_bar_is_bent_as_the_integral_of_its_pressure_says() -> None:
    p, seal, pitch, width, height = 4e5, 0.012, 0.03, 0.015, 0.006
    x = np.linspace(0.0, pitch / 2, 2001)
    moment = p * seal * pitch / 2 * pitch / 2 - np.trapezoid(p * seal * (pitch / 2 - x), x)
    strength = clamp_bar(p, seal, pitch, width, height, 240e6)
    assert strength.stress == pytest.approx(moment / (width * height**2 / 6), rel=1e-6)
    assert clamp_bar(p, seal, 2 * pitch, width, height, 240e6).stress == pytest.approx(4 * strength.stress)


def test_an_inflated_hose_pulls_by_the_pressure_on_its_round_section() -> None:
    radius = 2 * 0.16 / (2 * pi)  # its circumference is twice the flat width
    assert hose_pull(4e5, 0.16) == pytest.approx(4e5 * pi * radius**2)


def test_clamp_screws_bear_the_pressure_and_hold_the_hose() -> None:
    force = clamp_force(1000.0, 3000.0, friction=0.3)
    assert 2 * 0.3 * (force - 1000.0) == pytest.approx(3000.0)
    assert clamp_screws(force, 4, 14.2e-6, 450e6).stress == pytest.approx(6000.0 / (4 * 14.2e-6))
    assert tightening_torque(6.4e3, 5e-3) == pytest.approx(6.4)  # about that of makers' tables for an M5 of class 8.8


def test_an_end_plate_without_a_lever_is_pulled_across_its_bearing() -> None:
    pulled = end_plate(2000.0, 0.0, 0.06, 0.037, 0.006, 240e6).stress
    assert pulled == pytest.approx(2000.0 / (0.023 * 0.006))
    bent = end_plate(2000.0, 0.05, 0.06, 0.037, 0.006, 240e6).stress - pulled
    y = np.linspace(0.0185, 0.03, 4001)  # the moment of the stresses is that of the force
    assert 2 * 0.006 * np.trapezoid(bent * y / 0.03 * y, y) == pytest.approx(100.0, rel=1e-5)


def test_a_bearing_is_used_up_at_its_static_rating() -> None:
    assert bearing_load(-2600.0, 2600.0).safety == 1.0
    assert bearing_load(0.0, 2600.0).safety == inf


@given(st.lists(st.tuples(FORCES, st.floats(-0.1, 0.3)), min_size=1, max_size=4), st.floats(0.02, 0.2))
def test_bearings_hold_the_forces_and_their_moments(loads: list[tuple[float, float]], span: float) -> None:
    first, second = bearing_reactions(loads, span)
    assert first + second == pytest.approx(sum(force for force, _ in loads), abs=1e-6)
    place = 0.07
    moments = sum(force * (at - place) for force, at in loads)
    assert first * -place + second * (span - place) == pytest.approx(moments, abs=1e-5)


@given(st.lists(st.tuples(FORCES, st.floats(-0.1, 0.3)), min_size=1, max_size=4), st.floats(0.02, 0.2))
def test_a_shaft_is_bent_by_the_largest_moment_along_it(loads: list[tuple[float, float]], span: float) -> None:
    first, second = bearing_reactions(loads, span)
    forces = [*loads, (-first, 0.0), (-second, span)]
    places = np.unique([at for _, at in forces])
    moments = [sum(force * (x - at) for force, at in forces if at < x) for x in places]
    d = 1e-3  # thin, so that bending prevails over shear
    bent = 32 * max(abs(m) for m in moments) / (pi * d**3)
    stress = shaft(loads, span, d, 0.0, 490e6).stress
    shear = 4 / 3 * sqrt(3) * 3e4 * 4 / (pi / 4 * d**2)
    assert stress >= bent * (1 - 1e-9) - 1.0
    assert stress <= max(bent * (1 + 1e-9) + 1.0, shear)


def test_a_shaft_with_two_equal_straps_has_the_moment_of_four_point_bending() -> None:
    stress = shaft([(1500.0, 0.02), (1500.0, 0.06)], 0.08, 0.02, 0.0, 490e6).stress
    assert stress == pytest.approx(32 * 1500.0 * 0.02 / (pi * 0.02**3))


def test_a_shaft_that_is_only_twisted_has_the_safety_of_the_joints_design() -> None:
    d = min_shaft_diameter(25.0)
    assert shaft([], 0.08, d, 25.0, SHAFT_YIELD).safety == pytest.approx(1.5)
    assert material("shaft-steel").yield_stress == SHAFT_YIELD


def test_a_short_thick_shaft_is_sheared_as_a_round_bar() -> None:
    # the parabolic shear stress of a round section has its peak 4/3 V/A in the middle (integrated: V Q/(I b))
    d, force = 0.02, 1000.0
    y = np.linspace(0.0, d / 2, 20001)
    first_moment = np.trapezoid(2 * np.sqrt((d / 2) ** 2 - y**2) * y, y)
    peak = force * first_moment / (pi * d**4 / 64 * d)
    assert shaft([(2 * force, 1e-6)], 2e-6, d, 0.0, 490e6).stress == pytest.approx(sqrt(3) * peak, rel=1e-4)


def test_webbing_and_arms_are_pulled_and_bent() -> None:
    assert hinge_webbing(1000.0, 0.04, 0.0015, 300e6).stress == pytest.approx(1000.0 / 60e-6)
    arm = calliper_arm(400.0, 0.04, 0.015, 0.012, 240e6)
    y = np.linspace(-0.006, 0.006, 4001)
    assert 0.015 * np.trapezoid(arm.stress * y / 0.006 * y, y) == pytest.approx(400.0 * 0.04, rel=1e-5)


def test_a_weak_part_is_reported_with_the_safety_that_it_needs() -> None:
    def strength(stress: float) -> Strength:
        return Strength("shaft", "M/W", stress, 300e6, 1.5, "a textbook")

    assert check_strength(strength(0.0)) is None
    assert check_strength(strength(200e6)) is None
    warning, error = check_strength(strength(250e6)), check_strength(strength(400e6))
    assert warning is not None
    assert error is not None
    assert (warning.severity, error.severity) == ("warning", "error")
    assert str(warning).startswith("shaft: safety 1.2 (M/W); give it a safety of 1.5: ")
    assert str(strength(250e6)) == "shaft: 250 MPa of 300 MPa, safety 1.2 (M/W; a textbook)"
    assert strength(250e6).allowed == 200e6
    assert str(bearing_load(1300.0, 2600.0)) == "bearing: 1300 N of 2600 N, safety 2 (s0 = C0/F; ISO 76)"
