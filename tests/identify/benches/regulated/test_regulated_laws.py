from collections.abc import Iterator
from math import exp

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from layflat.identify.benches.regulated.laws import (
    AirConditions,
    ChamberState,
    LaggingFriction,
    PressureRegulator,
    RegulatedJoint,
    RegulatedJointState,
    friction_level,
    lag_fraction,
    lag_fractions,
    regulator_conductances,
    regulator_opening,
    resting_chamber,
    resting_joint,
    step_chamber,
    step_regulated_joint,
    target_setpoint,
)
from layflat.physics.air import GAMMA
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope

AIR = AirConditions(7e5, 101325.0, 293.15)
K = 6e-6


def joint(*, conductance: float = 2e-10, friction: float = 0.1, damping: float = 0.1) -> RegulatedJoint:
    valve = PressureRegulator(1.0, 0.0, 0.0, 0.03, conductance, conductance, 5e4, 5e4, 0.3, laminar_slope(0.3))
    chamber = Chamber(2e-5, 0.0, 0.0)
    rubs = LaggingFriction(friction, friction, 0.0, 0.2, 2.0, 1.0)
    return RegulatedJoint(valve, chamber, K, 0.005, damping, 0.0, 0.0, rubs, -1.0, 1.0)


def run(
    made: RegulatedJoint, q: float, p: tuple[float, float], asked: tuple[float, float], h: float, seconds: float
) -> Iterator[tuple[RegulatedJointState, ChamberState, ChamberState]]:
    shares = lag_fractions(made, h)
    motion, a, b = resting_joint(q), resting_chamber(made, q, p[0], AIR), resting_chamber(made, -q, p[1], AIR)
    yield motion, a, b
    for _ in range(round(seconds / h)):
        motion = step_regulated_joint(made, motion, a.pressure, b.pressure, shares, h)
        a = step_chamber(made, a, motion.angle, asked[0], AIR, shares, h)
        b = step_chamber(made, b, -motion.angle, asked[1], AIR, shares, h)
        yield motion, a, b


def test_friction_holds_the_joint_exactly_and_the_valves_hold_their_pressures() -> None:
    # 10 kPa on 6 ml/rad are 0.06 N m, less than the friction.
    for motion, a, b in run(joint(), 0.3, (4.1e5, 4.0e5), (4.1e5, 4.0e5), 1e-3, 5.0):
        assert (motion.angle, motion.velocity) == (0.3, 0.0)
        assert a.pressure == pytest.approx(4.1e5, rel=1e-9)
        assert b.pressure == pytest.approx(4.0e5, rel=1e-9)


def test_chambers_come_to_their_set_points() -> None:
    *_, (_, a, b) = run(joint(friction=10.0), 0.0, (1.01325e5, 6.6e5), (4.5e5, 3.5e5), 1e-3, 4.0)
    assert a.pressure == pytest.approx(4.5e5, rel=1e-3)
    assert b.pressure == pytest.approx(3.5e5, rel=1e-3)


def test_pressure_ends_at_the_supply_and_at_ambient() -> None:
    *_, (_, a, b) = run(joint(friction=10.0), 0.0, (3e5, 3e5), (9e5, 0.5e5), 1e-3, 4.0)
    assert a.pressure == pytest.approx(AIR.supply_pressure, rel=5e-3)
    assert b.pressure == pytest.approx(AIR.ambient_pressure, rel=5e-3)


def test_shut_chambers_without_losses_conserve_energy() -> None:
    made = joint(conductance=0.0, friction=1e-9, damping=0.0)
    energies = [
        a.energy + b.energy + 0.5 * made.inertia * motion.velocity**2
        for motion, a, b in run(made, 0.0, (5e5, 4e5), (5e5, 4e5), 1e-4, 1.0)
    ]
    assert max(energies) - min(energies) < 2e-3 * K * 1e5  # of the work that these pressures do in a radian


def test_a_stop_ends_the_motion_and_lets_go_again() -> None:
    made = joint(friction=0.01)
    *_, (motion, _, _) = run(made, 0.9, (5e5, 3e5), (5e5, 3e5), 1e-3, 1.0)
    assert (motion.angle, motion.velocity) == (1.0, 0.0)
    *_, (motion, _, _) = run(made, 1.0, (5e5, 3e5), (3e5, 5e5), 1e-3, 1.0)
    assert motion.angle < 0.9


def test_motion_between_shut_chambers_is_that_of_an_adiabatic_spring() -> None:
    made = joint(conductance=0.0, friction=1e-9)

    def rates(_: float, x: np.ndarray) -> list[float]:
        q, v = x
        p_a, p_b = (p * (2e-5 / (2e-5 + K * s * q)) ** GAMMA for p, s in ((5e5, 1), (4e5, -1)))
        return [v, (K * (p_a - p_b) - made.damping * v) / made.inertia]

    exact = solve_ivp(rates, (0.0, 0.5), [0.0, 0.0], rtol=1e-10, atol=1e-12).y[0, -1]
    errors = []
    for h in (2e-3, 1e-3, 5e-4):
        *_, (motion, _, _) = run(made, 0.0, (5e5, 4e5), (5e5, 4e5), h, 0.5)
        errors.append(abs(motion.angle - exact))
    assert errors[-1] < 1e-3
    assert errors[0] > 1.6 * errors[1] > 1.6**2 * errors[2]


VALVE = PressureRegulator(1.05, -2e4, -2e4, 0.04, 2e-10, 3e-10, 5e4, 8e4, 0.3, laminar_slope(0.3))
pressures = st.floats(1e5, 8e5)


@given(pressures, pressures)
def test_only_the_side_towards_the_set_point_is_open(s: float, p: float) -> None:
    C_in, C_out = regulator_conductances(VALVE, s, p)
    assert C_in * C_out == 0.0
    assert (C_in > 0.0) == (s > p)
    assert (C_out > 0.0) == (s < p)


@pytest.mark.parametrize(
    ("error", "opening"), [(0.0, 0.0), (2.5e4, 0.5), (5e4, 1.0), (3e5, 1.0), (-4e4, -0.5), (-3e5, -1.0)]
)
def test_it_opens_in_proportion_to_the_error_up_to_its_bands(error: float, opening: float) -> None:
    assert regulator_opening(VALVE, 4e5 + error, 4e5) == pytest.approx(opening, abs=1e-12)


def test_its_gain_and_offset_count_from_ambient_pressure() -> None:
    assert target_setpoint(VALVE, -2e4, 1e5, 1e5) == pytest.approx(1e5 - 2e4)
    assert target_setpoint(VALVE, 3e4, 5e5, 1e5) == pytest.approx(1e5 + 1.05 * 4e5 + 3e4)


@given(st.floats(1e-5, 0.1), st.floats(1e-3, 1.0))
def test_two_half_steps_of_a_lag_make_a_whole_one(h: float, lag: float) -> None:
    half = lag_fraction(0.5 * h, lag)
    assert 1.0 - (1.0 - half) ** 2 == pytest.approx(lag_fraction(h, lag), rel=1e-9)


RUBS = LaggingFriction(0.3, 0.1, -0.6, 0.15, 3.0, 1.3)


def test_friction_goes_from_one_level_to_the_other_around_an_angle() -> None:
    assert [friction_level(RUBS, Q, 1.0) for Q in (-20.0, -0.6, 20.0)] == pytest.approx([0.3, 0.2, 0.1], rel=1e-9)
    below, above = (friction_level(RUBS, -0.6 + way * 0.1, 1.0) for way in (-1.0, 1.0))
    assert below + above == pytest.approx(0.4, rel=1e-12)
    within = [friction_level(RUBS, -0.6 + way * 2.0 * RUBS.change_width, 1.0) for way in (-1.0, 1.0)]
    assert within[0] - within[1] == pytest.approx(0.75 * 0.2, rel=0.03)


@given(st.floats(-1e3, 1e3), st.floats(-20.0, 20.0), st.floats(1e-6, 10.0))
def test_levels_that_are_alike_make_coulomb_friction(Q: float, v: float, width: float) -> None:
    assert friction_level(LaggingFriction(0.2, 0.2, 0.0, width, 3.0, 1.0), Q, v) == pytest.approx(0.2, rel=1e-12)


def test_a_joint_that_is_held_elsewhere_is_remembered_exponentially() -> None:
    made, h = joint(friction=10.0), 1e-2
    shares, state = lag_fractions(made, h), resting_joint(0.5)._replace(angle=-0.2)
    for _ in range(200):
        state = step_regulated_joint(made, state, 4e5, 4e5, shares, h)
    assert state.angle == -0.2
    assert state.lagged_angle == pytest.approx(-0.2 + 0.7 * exp(-2.0 / made.friction.lag), rel=1e-9)


def test_a_joint_at_rest_takes_more_to_slip_than_to_slide_on() -> None:
    made = joint()._replace(friction=LaggingFriction(0.1, 0.1, 0.0, 0.2, 2.0, 1.3))
    shares, p = lag_fractions(made, 1e-3), 4e5 + 0.12 / K
    rest = resting_joint(0.0)
    assert step_regulated_joint(made, rest, p, 4e5, shares, 1e-3) == rest
    assert step_regulated_joint(made, rest._replace(velocity=0.1), p, 4e5, shares, 1e-3).velocity > 0.0
    assert step_regulated_joint(made, rest, p + 0.02 / K, 4e5, shares, 1e-3).velocity > 0.0
