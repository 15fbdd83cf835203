import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.physics.air import CV, GAMMA, GAS_CONSTANT
from layflat.physics.chamber import (
    Chamber,
    air_mass,
    energy,
    internal_energy,
    pressure,
    pressure_after_expansion,
    temperature,
    temperature_and_roots,
    wall_heat,
)
from layflat.physics.flow import root_temperature

P_A = 1.013e5
chambers = st.builds(Chamber, st.just(1e-4), st.floats(0.0, 2e-10), st.just(1.0))
pressures = st.floats(8e4, 9e5)
volumes = st.floats(5e-5, 1e-3)


@given(chambers, pressures, volumes)
def test_pressure_and_energy_undo_each_other(chamber: Chamber, p: float, V: float) -> None:
    assert pressure(chamber, energy(chamber, p, V, P_A), V, P_A) == pytest.approx(p, rel=1e-12)


@given(pressures, volumes)
def test_a_rigid_chamber_is_an_ideal_gas(p: float, V: float) -> None:
    rigid = Chamber(1e-4, 0.0, 1.0)
    assert energy(rigid, p, V, P_A) == pytest.approx(p * V / (GAMMA - 1), rel=1e-12)


@given(chambers, pressures, volumes, st.floats(200.0, 400.0))
def test_mass_and_temperature_undo_each_other(chamber: Chamber, p: float, V: float, T: float) -> None:
    m = air_mass(chamber, p, T, V, P_A)
    assert temperature(chamber, p, m, V, P_A) == pytest.approx(T, rel=1e-12)
    assert m * GAS_CONSTANT * T == pytest.approx(p * (V + chamber.compliance * (p - P_A)), rel=1e-12)


@given(chambers, pressures, volumes, st.floats(200.0, 400.0))
def test_energy_is_that_of_air_and_stretched_wall(chamber: Chamber, p: float, V: float, T: float) -> None:
    air = internal_energy(air_mass(chamber, p, T, V, P_A), T)
    wall = 0.5 * chamber.compliance * (p * p - P_A * P_A)
    assert energy(chamber, p, V, P_A) == pytest.approx(air + wall, rel=1e-12)


@given(chambers, pressures, volumes)
def test_pressure_rises_with_energy_by_its_slope(chamber: Chamber, p: float, V: float) -> None:
    E = energy(chamber, p, V, P_A)
    dE = 1e-5 * E
    slope = (pressure(chamber, E + dE, V, P_A) - pressure(chamber, E - dE, V, P_A)) / (2 * dE)
    assert pressure_after_expansion(chamber, E, V, 0.0, p, P_A) == pytest.approx((p, slope), rel=1e-6)


@given(chambers, pressures, volumes, st.floats(-0.02, 0.02))
def test_swelling_does_work_at_the_pressure_it_ends_with(chamber: Chamber, p: float, V: float, share: float) -> None:
    E, dV = energy(chamber, p, V, P_A), share * V
    after, _ = pressure_after_expansion(chamber, E, V + dV, dV, p, P_A)
    # What is left out of the energy is of second order in the swelling.
    assert (
        abs(energy(chamber, after, V + dV, P_A) - (E - after * dV))
        <= 3.0 * E * share**2 * chamber.compliance * p / V + 1e-9 * E
    )


@given(chambers, pressures, volumes, st.floats(200.0, 400.0))
def test_temperature_and_its_roots(chamber: Chamber, p: float, V: float, T: float) -> None:
    m = air_mass(chamber, p, T, V, P_A)
    found, roots = temperature_and_roots(chamber, p, m, V, P_A)
    assert found == pytest.approx(T, rel=1e-12)
    assert roots == pytest.approx(root_temperature(T), rel=1e-12)
    assert temperature(chamber, p, m, V, P_A) == pytest.approx(T, rel=1e-12)


def test_slow_swelling_is_adiabatic() -> None:
    rigid, p, V, n = Chamber(1e-4, 0.0, 0.0), 5e5, 1e-4, 4000
    E, end = energy(rigid, p, V, P_A), 2.0 * V
    dV = (end - V) / (2 * n)
    for _ in range(n):
        # As in a step: first implicit, then explicit.
        V += dV
        p, _ = pressure_after_expansion(rigid, E, V, dV, p, P_A)
        V += dV
        E -= p * 2 * dV
    assert pressure(rigid, E, V, P_A) == pytest.approx(5e5 * 0.5**GAMMA, rel=1e-6)


def test_heat_flows_from_warm_to_cold() -> None:
    assert wall_heat(Chamber(1e-4, 0.0, 2.0), 280.0, 300.0) == pytest.approx(40.0)
    assert internal_energy(1e-3, 300.0) == pytest.approx(0.3 * CV)
