from fractions import Fraction
from math import inf, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.air import CP, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.flow import LAMINAR_RATIO, effective_area, effective_pressure, laminar_slope, orifice

C, B = 1.2e-8, 0.3
SLOPE = laminar_slope(B)
pressures = st.floats(1e4, 1e6)
temperatures = st.floats(200.0, 400.0)


def flow(p_a: float, p_b: float, T_a: float = 293.15, T_b: float = 293.15) -> float:
    return float(orifice(C, B, SLOPE, p_a, T_a, p_b, T_b)[0])


def test_a_conductance_is_that_of_an_area_that_chokes() -> None:
    # S = 5.02 C, of C in dm3/(s bar) and S in mm2 (ISO 6358).
    assert effective_area(1e-8) == pytest.approx(5.02e-6, rel=4e-3)


@given(pressures, st.floats(0.0, B), temperatures)
def test_choked_flow_depends_on_upstream_alone(p: float, ratio: float, T: float) -> None:
    choked = C * REFERENCE_DENSITY * p * sqrt(REFERENCE_TEMPERATURE / T)
    assert flow(p, ratio * p, T) == pytest.approx(choked, rel=1e-12)


@given(pressures, st.floats(B, LAMINAR_RATIO))
def test_subsonic_flow_is_the_ellipse_of_iso_6358(p: float, ratio: float) -> None:
    ellipse = sqrt(max(1 - ((ratio - B) / (1 - B)) ** 2, 0.0))
    assert effective_pressure(p, ratio * p, B, SLOPE) == pytest.approx(p * ellipse, rel=1e-9)


@given(pressures, st.floats(1.0, 3.0))
def test_nothing_is_driven_against_a_higher_pressure(p: float, ratio: float) -> None:
    assert effective_pressure(p, ratio * p, B, SLOPE) == 0.0


@given(pressures, st.floats(1e-9, 1e-4))
def test_the_ellipse_loses_no_digits_next_to_equal_pressures(p: float, share: float) -> None:
    p_2 = p * (1.0 - share)
    D = (Fraction(p) - Fraction(p_2)) / (1 - Fraction(B))
    exact = sqrt(Fraction(p) ** 2 - (Fraction(p) - D) ** 2)
    assert effective_pressure(p, p_2, B, inf) == pytest.approx(exact, rel=1e-14)


@given(pressures, st.floats(LAMINAR_RATIO, 1.0))
def test_flow_is_linear_next_to_equal_pressures(p: float, ratio: float) -> None:
    assert effective_pressure(p, ratio * p, B, SLOPE) == pytest.approx(SLOPE * (p - ratio * p), rel=1e-9, abs=1e-9 * p)


@given(st.floats(0.05, 0.6))
def test_flow_is_continuous_at_the_laminar_edge(b: float) -> None:
    ellipse = sqrt(1 - ((LAMINAR_RATIO - b) / (1 - b)) ** 2)
    assert laminar_slope(b) * (1 - LAMINAR_RATIO) == pytest.approx(ellipse, rel=1e-12)
    inside, outside = (effective_pressure(1e5, 1e5 * (LAMINAR_RATIO + d), b, laminar_slope(b)) for d in (1e-9, -1e-9))
    assert inside == pytest.approx(outside, rel=1e-5)


@given(pressures, pressures, temperatures)
def test_flow_is_the_same_in_both_directions(p_1: float, p_2: float, T: float) -> None:
    assert flow(p_1, p_2, T, T) == -flow(p_2, p_1, T, T)


@given(pressures, temperatures, temperatures)
def test_no_flow_between_equal_pressures(p: float, T_a: float, T_b: float) -> None:
    assert orifice(C, B, SLOPE, p, T_a, p, T_b) == (0.0, 0.0)


def test_flow_falls_as_the_pressure_downstream_rises() -> None:
    flows = [flow(5e5, p) for p in np.linspace(0.0, 1e6, 2001)]
    assert np.all(np.diff(flows) <= 0.0)
    assert flows[0] > 0.0 > flows[-1]


@given(pressures, pressures, temperatures, temperatures)
def test_air_carries_the_enthalpy_of_where_it_comes_from(p_a: float, p_b: float, T_a: float, T_b: float) -> None:
    mass, heat = orifice(C, B, SLOPE, p_a, T_a, p_b, T_b)
    assert heat == pytest.approx(mass * CP * (T_a if p_a >= p_b else T_b), rel=1e-12)
