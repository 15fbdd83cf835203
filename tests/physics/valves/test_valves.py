import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import load
from layflat.physics.flow import orifice, root_temperature
from layflat.physics.valves import chamber_flow, commanded_opening
from layflat.physics.valves.spool import SpoolValvePart, Stiction, held_at, parameters
from layflat.physics.valves.spool_laws import SpoolState, mean_conductances, path_conductance
from tests.physics.plants import VALVE

SUPPLY, AMBIENT, T = 5.01e5, 1.013e5, 293.15


def flows(x: float, p: float) -> tuple[float, float, float]:
    warm = root_temperature(T)
    mass, heat, taken = chamber_flow(
        VALVE, path_conductance(VALVE, x), path_conductance(VALVE, -x), p, warm, SUPPLY, warm, AMBIENT
    )
    return mass, heat, taken


def test_a_spool_valve_is_what_its_description_says() -> None:
    described = load("paper-arm").valve
    assert isinstance(described, SpoolValvePart)
    valve = parameters(described)
    assert valve.spool.natural_frequency == pytest.approx(described.natural_frequency * 2.0 * np.pi)
    assert (valve.spool.damping_ratio, valve.spool.friction) == (described.damping_ratio, described.friction)
    assert (valve.conductance, valve.overlap) == (described.conductance, described.overlap)
    stuck = parameters(described.model_copy(update={"stiction": Stiction(static_ratio=1.5, velocity="2 Hz")})).spool
    assert tuple(stuck)[:3] == pytest.approx(tuple(valve.spool)[:3])
    assert tuple(stuck)[3:] == pytest.approx((0.5, 0.25))


def test_a_spool_that_is_held_is_at_rest() -> None:
    assert held_at(VALVE, -0.4) == SpoolState(-0.4, 0.0)


def test_volts_to_opening() -> None:
    assert [commanded_opening(VALVE, u) for u in (-3.0, 0.0, 5.0, 7.5, 10.0, 12.0)] == [-1.0, -1.0, 0.0, 0.5, 1.0, 1.0]


def test_a_land_covers_its_port_by_the_overlap() -> None:
    assert path_conductance(VALVE, 1.0) == pytest.approx(VALVE.conductance)
    for x in (-1.0, 0.0, VALVE.overlap):
        assert path_conductance(VALVE, x) == VALVE.leakage
    middle = 0.5 * (VALVE.overlap + 1.0)
    assert path_conductance(VALVE, middle) == pytest.approx(0.5 * (VALVE.leakage + VALVE.conductance))


@given(st.floats(0.1, 1.0), st.floats(1.5e5, 4.5e5))
def test_opening_fills_or_vents(x: float, p: float) -> None:
    assert flows(x, p)[0] > 0.0 > flows(-x, p)[0]
    assert flows(x, p)[2] > flows(-x, p)[2] > 0.0


@given(st.floats(-1.0, 1.0), st.floats(1.1e5, 4.9e5))
def test_flows_are_those_of_both_paths(x: float, p: float) -> None:
    b, s = VALVE.critical_ratio, VALVE.laminar_slope
    inflow = orifice(path_conductance(VALVE, x), b, s, SUPPLY, T, p, T)
    outflow = orifice(path_conductance(VALVE, -x), b, s, p, T, AMBIENT, T)
    expected = (inflow[0] - outflow[0], inflow[1] - outflow[1], inflow[0])
    assert flows(x, p) == pytest.approx(expected, rel=1e-12)


def test_pressure_never_passes_supply_or_ambient() -> None:
    assert flows(1.0, SUPPLY)[0] <= 0.0
    assert flows(-1.0, AMBIENT)[0] >= 0.0


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_mean_conductances_are_the_means_over_an_even_motion(x_0: float, x_1: float) -> None:
    way = np.linspace(x_0, x_1, 4001)
    shares = np.maximum(np.stack((way, -way)) - VALVE.overlap, 0.0) / (1.0 - VALVE.overlap)
    expected = VALVE.leakage + (VALVE.conductance - VALVE.leakage) * np.trapezoid(shares, dx=1 / 4000)
    assert mean_conductances(VALVE, x_0, x_1) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("x", [-0.5, 0.0, 0.3])
def test_mean_conductances_at_rest_are_the_conductances(x: float) -> None:
    expected = path_conductance(VALVE, x), path_conductance(VALVE, -x)
    assert mean_conductances(VALVE, x, x) == pytest.approx(expected, rel=1e-12)


def test_mean_conductances_where_the_land_meets_the_port() -> None:
    assert mean_conductances(VALVE, VALVE.overlap, VALVE.overlap) == (VALVE.leakage, VALVE.leakage)
