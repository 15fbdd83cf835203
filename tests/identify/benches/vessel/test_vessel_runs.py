"""Vessels that fill and empty, against SciPy and against what thermodynamics says in closed form."""

from itertools import islice
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from layflat.identify.benches import simulate_candidates
from layflat.identify.benches.vessel.gas import GASES_BY_NAME, IDEAL_AIR, IdealAir, RealGas, gas_contents, gas_state
from layflat.identify.benches.vessel.laws import (
    Filling,
    Outside,
    Vessel,
    VesselInputs,
    VesselPath,
    VesselSetup,
    Wall,
    compute_exchange,
    run_vessel,
    state_rates,
)
from layflat.physics.air import GAMMA, GAS_CONSTANT, REFERENCE_DENSITY, REFERENCE_TEMPERATURE
from layflat.physics.chamber import Chamber

pytestmark = pytest.mark.compiled

Array = NDArray[np.float64]

USUAL: dict[str, Any] = {
    "volume": 0.01, "compliance": 0.0, "wall_conductance": 0.0, "area": 0.26, "diameter": 0.2,
    "natural": 0.0, "forced": 0.0, "heat_capacity": np.inf, "outer_conductance": 0.0,
    "conductance": 5e-9, "critical_ratio": 0.45, "outside_pressure": 1e5, "outside_temperature": 295.0,
    "ambient_pressure": 1e5, "ambient_temperature": 295.0, "start_pressure": 8e5, "start_temperature": 295.0,
}  # fmt: skip
WARM = {"natural": 0.13, "forced": 0.56, "heat_capacity": 3000.0, "outer_conductance": 1.5}


def setup(**changed: Any) -> VesselSetup:
    given = iter({**USUAL, **changed}.values())
    kinds: tuple[Any, ...] = (Chamber, Wall, VesselPath, Outside)
    chamber, wall, path, outside = (kind(*islice(given, len(kind._fields))) for kind in kinds)
    return VesselSetup(Vessel(chamber, wall, path), outside, *given)


def simulate(
    gas: IdealAir | RealGas, given: VesselSetup, course: VesselInputs, count: int = 1, refined: float = 1.0
) -> Array:
    """Pressure and temperatures, (candidates, samples, 3)."""
    return simulate_candidates(run_vessel, count, [(given, gas, course, refined)], [(len(course.time), 3)])[0]


def course(time: Array, supply: float | Array = np.nan, opening: float | Array = 1.0) -> VesselInputs:
    return VesselInputs(time, np.full(len(time), supply), np.full(len(time), opening))


def by_scipy(gas: IdealAir | RealGas, given: VesselSetup, time: Array) -> Array:
    """Pressure, temperature and wall temperature, open all the time, (samples, 3)."""
    vessel, outside, p, T = given
    E, m = gas_contents(gas, vessel.chamber, p, T, outside.ambient_pressure)

    def change(_t: float, y: Array) -> list[float]:
        state = Filling(*map(float, y))
        return list(state_rates(vessel, state, outside, compute_exchange(gas, vessel, state, outside, 1.0)))

    found = solve_ivp(
        change, (0.0, time[-1]), [E, m, T], "LSODA", time, rtol=1e-9, atol=[1e-6, 1e-12, 1e-9], max_step=0.5
    )
    states = [gas_state(gas, vessel.chamber, E, m, outside.ambient_pressure) for E, m, _ in found.y.T]
    return np.column_stack([np.array(states), found.y[2]])


@pytest.mark.parametrize(
    ("gas", "changed"),
    [
        (GASES_BY_NAME["nitrogen"], {**WARM, "start_pressure": 150e5, "conductance": 2e-8}),
        (GASES_BY_NAME["hydrogen"], {**WARM, "start_pressure": 10e5, "outside_pressure": 60e5, "conductance": 3e-9}),
        (IDEAL_AIR, {**WARM, "start_pressure": 5e3}),
        (IDEAL_AIR, {"wall_conductance": 0.8, "compliance": 2e-9}),
    ],
    ids=["nitrogen out", "hydrogen in", "air into vacuum", "hose"],
)
def test_a_run_is_scipys(gas: IdealAir | RealGas, changed: dict[str, Any]) -> None:
    time = np.concatenate([np.linspace(0.0, 5.0, 11), np.linspace(6.0, 40.0, 12)])
    found = simulate(gas, setup(**changed), course(time))[0]
    reference = by_scipy(gas, setup(**changed), time)
    span = np.ptp(reference[:, 0])
    assert np.abs(found[:, 0] - reference[:, 0]).max() < 2e-6 * span
    assert np.abs(found[:, 1:] - reference[:, 1:]).max() < 1e-3
    assert abs(found[-1, 0] - setup(**changed).outside.pressure) < 0.5 * span


def test_the_order_of_the_steps_is_four_where_the_laws_are_smooth() -> None:
    # Choked throughout, and heat by a constant conductance; one step from sample to sample.
    given = setup(wall_conductance=1.0, outside_pressure=1e3)
    exact, coarse, fine = (
        simulate(IDEAL_AIR, given, course(np.linspace(0.0, 8.0, samples)), refined=1e-9)[0, -1, :2]
        for samples in (257, 5, 9)
    )
    order = np.log2(np.abs(coarse - exact) / np.abs(fine - exact))
    assert np.all(order > 3.5)
    assert np.all(order < 4.5)


def test_a_choked_blow_down_without_heat_is_the_closed_form() -> None:
    time = np.linspace(0.0, 10.0, 21)
    p = simulate(IDEAL_AIR, setup(outside_pressure=1e3), course(time))[0, :, 0]
    flow = USUAL["conductance"] * REFERENCE_DENSITY * np.sqrt(REFERENCE_TEMPERATURE / 295.0)
    tau = USUAL["volume"] / (flow * GAS_CONSTANT * 295.0)
    closed = 8e5 * (1.0 + 0.5 * (GAMMA - 1.0) * time / tau) ** (-2.0 * GAMMA / (GAMMA - 1.0))
    np.testing.assert_allclose(p, closed, rtol=1e-7)


def test_a_fill_without_heat_ends_as_hot_as_thermodynamics_says() -> None:
    p_0, T_0, p, T_s = 2e4, 280.0, 6e5, 295.0
    given = setup(start_pressure=p_0, start_temperature=T_0, outside_pressure=p)
    end = simulate(IDEAL_AIR, given, course(np.array([0.0, 60.0])))[0, -1]
    assert end[0] == pytest.approx(p, rel=1e-9)
    assert end[1] == pytest.approx(GAMMA * T_s / (1.0 + p_0 / p * (GAMMA * T_s / T_0 - 1.0)), rel=1e-6)


def test_a_shut_vessel_keeps_its_gas_and_comes_to_the_walls_temperature() -> None:
    time = np.array([0.0, 500.0, 5000.0])
    shut = course(time, opening=0.0)
    still = simulate(GASES_BY_NAME["nitrogen"], setup(), shut)[0]
    assert np.ptp(still[:, 0]) < 1e-6 * still[0, 0]
    warm = setup(wall_conductance=1.0, heat_capacity=100.0, outer_conductance=1.0, ambient_temperature=320.0)
    end = simulate(IDEAL_AIR, warm, shut)[0, -1]
    assert end[1:] == pytest.approx([320.0, 320.0], rel=1e-6)
    assert end[0] == pytest.approx(8e5 * 320.0 / 295.0, rel=1e-6)


def test_supply_and_opening_act_as_the_log_says() -> None:
    time = np.linspace(0.0, 20.0, 201)
    opening = np.where(time < 5.0, 0.0, np.where(time < 10.0, 1.0, 0.5))
    given = setup(start_pressure=1e5, volume=0.02)
    p = simulate(IDEAL_AIR, given, course(time, 3e5 + 2e4 * time, opening))[0, :, 0]
    assert np.ptp(p[time <= 5.0]) < 1e-3
    # Choked while it begins, the flow goes with the supply; the pressure of an insulated vessel rises by gamma R T w/V.
    flow = USUAL["conductance"] * REFERENCE_DENSITY * np.sqrt(REFERENCE_TEMPERATURE / 295.0)
    rise = GAMMA * GAS_CONSTANT * 295.0 * flow / 0.02
    assert p[60] - p[50] == pytest.approx(rise * (3e5 + 2e4 * 5.5), rel=1e-6)
    assert p[100] - p[99] > 1.9 * (p[101] - p[100]) > 0.0


def test_candidates_are_on_their_own_and_a_lost_one_is_not_a_number() -> None:
    C = np.array([2e-9, 1e-1, 5e-9, 8e-9])
    time = course(np.linspace(0.0, 10.0, 5))
    together = simulate(IDEAL_AIR, setup(conductance=C), time, 4)
    assert np.isnan(together[1, 1:]).all()
    for i in (0, 2, 3):
        alone = simulate(IDEAL_AIR, setup(conductance=C[i]), time)
        np.testing.assert_array_equal(together[i], alone[0])
