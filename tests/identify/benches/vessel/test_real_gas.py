from math import sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.identify.benches.vessel.gas import (
    GASES_BY_NAME,
    IDEAL_AIR,
    RealGas,
    choked_flow_factor,
    gas_contents,
    gas_density,
    gas_energy,
    gas_outflow,
    gas_pressure,
    gas_state,
    gas_stiffness,
    gas_temperature,
    is_gas,
    isentropic_exponent,
)
from layflat.identify.benches.vessel.laws import (
    Filling,
    Outside,
    Vessel,
    VesselPath,
    Wall,
    compute_exchange,
    state_rates,
)
from layflat.physics.air import GAMMA, GAS_CONSTANT
from layflat.physics.chamber import Chamber
from layflat.physics.flow import CONDUCTANCE_PER_AREA, effective_area, laminar_slope, orifice, sonic_conductance

gases = st.sampled_from([GASES_BY_NAME[name] for name in ("air", "nitrogen", "hydrogen", "helium", "argon")])
pressures = st.floats(1e3, 200e5)
temperatures = st.floats(200.0, 400.0)
VESSEL = Chamber(0.02, 0.0, 0.0)
THIN = 1e-12

# Density (kg/m3) and isentropic exponent by the reference equations of state (CoolProp 6), pressure in bar.
MEASURED = [
    ("nitrogen", 288.0, 150.0, 172.68, 1.786),
    ("nitrogen", 220.0, 80.0, 134.26, 1.654),
    ("air", 293.0, 40.0, 48.07, 1.464),
    ("hydrogen", 288.0, 150.0, 11.55, 1.564),
    ("argon", 288.0, 150.0, 268.16, 2.145),
    ("helium", 288.0, 150.0, 23.36, 1.768),
    ("carbon dioxide", 293.0, 40.0, 97.63, 1.269),
]


@pytest.mark.parametrize(("name", "T", "bar", "density", "exponent"), MEASURED)
def test_states_are_those_of_reference_equations(
    name: str, T: float, bar: float, density: float, exponent: float
) -> None:
    rho = gas_density(GASES_BY_NAME[name], bar * 1e5, T)
    assert rho == pytest.approx(density, rel=0.03)
    assert isentropic_exponent(GASES_BY_NAME[name], T, rho) == pytest.approx(exponent, rel=0.05)
    ideal = bar * 1e5 / (GASES_BY_NAME[name].constant * T)
    if bar > 100.0 and name != "nitrogen":
        assert abs(rho - density) < abs(ideal - density)


@given(gases, pressures, temperatures)
def test_density_and_temperature_are_inverses(gas: RealGas, p: float, T: float) -> None:
    rho = gas_density(gas, p, T)
    assert gas_pressure(gas, T, rho) == pytest.approx(p, rel=1e-9)
    assert gas_temperature(gas, gas_energy(gas, T, rho), rho) == pytest.approx(T, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "bar", "T"), [("argon", 195.0, 200.7), ("argon", 113.8, 152.3), ("air", 400.0, 134.2)]
)
def test_inverses_hold_in_a_cold_dense_gas_too(name: str, bar: float, T: float) -> None:
    gas, p = GASES_BY_NAME[name], 1e5 * bar
    rho = gas_density(gas, p, T)
    assert is_gas(gas, p, T)
    assert gas_pressure(gas, T, rho) == pytest.approx(p, rel=1e-9)
    assert gas_temperature(gas, gas_energy(gas, T, rho), rho) == pytest.approx(T, rel=1e-9)


@given(st.sampled_from(list(GASES_BY_NAME.values())), st.floats(1.0, 4.0), st.floats(1e3, 400e5))
def test_inverses_hold_in_every_gas_above_its_critical_temperature(gas: RealGas, ratio: float, p: float) -> None:
    T = ratio * (gas.attraction / (4.934 * gas.constant * gas.covolume)) ** (2.0 / 3.0)
    rho = gas_density(gas, p, T)
    assert gas_pressure(gas, T, rho) == pytest.approx(p, rel=1e-9)
    assert gas_temperature(gas, gas_energy(gas, T, rho), rho) == pytest.approx(T, rel=1e-9)


@given(gases, pressures, temperatures)
def test_energy_and_pressure_obey_one_thermodynamics(gas: RealGas, p: float, T: float) -> None:
    # (du/drho)_T = (p - T (dp/dT)_rho)/rho^2, or a cycle would make work.
    rho = gas_density(gas, p, T)
    h = 1e-4 * rho
    slope = (gas_energy(gas, T, rho + h) - gas_energy(gas, T, rho - h)) / (2 * h)
    by_density, by_temperature = gas_stiffness(gas, T, rho)
    rounding = 1e-15 * gas_energy(gas, T, rho) / h
    assert slope == pytest.approx((p - T * by_temperature) / rho**2, rel=1e-5, abs=rounding)
    assert by_density == pytest.approx(
        (gas_pressure(gas, T, rho + h) - gas_pressure(gas, T, rho - h)) / (2 * h), rel=1e-6
    )
    d = 1e-3
    by_warming = (gas_pressure(gas, T + d, rho) - gas_pressure(gas, T - d, rho)) / (2 * d)
    assert by_temperature == pytest.approx(by_warming, rel=1e-6)


@given(temperatures)
def test_thin_gas_is_ideal(T: float) -> None:
    gas = GASES_BY_NAME["air"]
    ideal = gas._replace(attraction=gas.attraction * THIN, covolume=gas.covolume * THIN)
    p = 5e5
    E, m = gas_contents(ideal, VESSEL, p, T, 1e5)
    E_air, m_air = gas_contents(IDEAL_AIR, VESSEL, p, T, 1e5)
    assert (E, m) == pytest.approx((E_air, m_air), rel=1e-9)
    assert gas_state(ideal, VESSEL, E, m, 1e5) == pytest.approx((p, T), rel=1e-9)
    assert gas_outflow(ideal, p, T) == pytest.approx(gas_outflow(IDEAL_AIR, p, T), rel=1e-6)


def test_choked_flow_of_ideal_air_is_that_of_the_conductance() -> None:
    assert choked_flow_factor(GAMMA) == pytest.approx(0.6847, rel=1e-4)
    area = 3e-6
    C = sonic_conductance(area, 0.8)
    assert effective_area(C) == pytest.approx(0.8 * area)
    p, T = 6e5, 310.0
    flow = orifice(C, 0.3, laminar_slope(0.3), p, T, 1e5, T)[0]
    assert flow == pytest.approx(0.8 * area * choked_flow_factor(GAMMA) * p / sqrt(GAS_CONSTANT * T), rel=1e-9)
    assert (
        pytest.approx(0.2, rel=0.01) == CONDUCTANCE_PER_AREA * 1e-6 * 1e8
    )  # dm3/(s bar) for 1 mm2: ISO 6358's C = A/5


@given(st.floats(2e4, 9e5), st.floats(2e4, 9e5), temperatures)
def test_a_vessel_of_ideal_air_takes_the_flow_of_the_plant(p: float, beyond: float, T: float) -> None:
    chamber = Chamber(1e-3, 0.0, 0.4)
    path = VesselPath(1e-8, 0.35)
    vessel = Vessel(chamber, Wall(0.1, 0.1, 0.0, 0.0, np.inf, 0.0), path)
    E, m = gas_contents(IDEAL_AIR, chamber, p, T, 1e5)
    state, outside = Filling(E, m, 300.0), Outside(beyond, 290.0, 1e5, 293.0)
    rate = state_rates(vessel, state, outside, compute_exchange(IDEAL_AIR, vessel, state, outside, 1.0))
    flow, enthalpy = orifice(path.conductance, 0.35, laminar_slope(0.35), beyond, 290.0, p, T)
    assert rate.mass == pytest.approx(flow, rel=1e-9, abs=1e-15)
    assert rate.energy == pytest.approx(enthalpy + 0.4 * (300.0 - T), rel=1e-9, abs=1e-9)
    assert rate.wall_temperature == 0.0


def test_what_condenses_is_no_gas() -> None:
    assert is_gas(GASES_BY_NAME["carbon dioxide"], 40e5, 293.0)
    assert not is_gas(GASES_BY_NAME["carbon dioxide"], 80e5, 288.0)
    assert not is_gas(GASES_BY_NAME["carbon dioxide"], 80e5, 220.0)
    assert is_gas(GASES_BY_NAME["nitrogen"], 400e5, 250.0)
