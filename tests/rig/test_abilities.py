"""How fast demands may be, against the dynamics of the arm, and what friction can hold."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import load, parameters
from layflat.motion.limits import abilities
from layflat.rig.abilities import demand_limits, swings_on

ARM = load("paper-arm-tracking")
LIMITS, ABLE = demand_limits(ARM), abilities(ARM)
SHARE = st.floats(-1.0, 1.0)


@given(st.tuples(SHARE, SHARE), st.tuples(SHARE, SHARE))
def test_no_posture_accelerates_faster_than_demands_may(place: tuple[float, float], push: tuple[float, float]) -> None:
    half = np.array([0.5 * joint.stops.working_stroke for joint in ARM.joints.values()])
    mass, _ = parameters.mass_and_pull(parameters.arm(ARM), ARM.arm.payload, (half * place).tolist())
    acceleration = np.linalg.solve(mass, ABLE.torque * push)
    assert (np.abs(acceleration) <= 1.02 * LIMITS.acceleration).all()  # looked at in a grid of postures
    # What every posture brakes with is within the torques of all, whatever the signs.
    assert (np.abs(mass @ (LIMITS.braking * np.sign(push))) <= 1.02 * ABLE.torque).all()


def test_limits_are_those_of_a_machine_that_can_move() -> None:
    assert (LIMITS.braking > 0.0).all()
    assert (LIMITS.braking < LIMITS.acceleration).all()
    assert (LIMITS.pace < LIMITS.speed).all()


def test_friction_holds_an_arm_at_rest_and_slow_but_neither_fast_nor_pushed() -> None:
    none, middle = np.zeros(2), (0.0, 0.0)
    assert not swings_on(ARM, middle, (0.0, 0.0), none)
    assert not swings_on(ARM, middle, (0.5, 0.5), none)
    assert swings_on(ARM, middle, (5.0, 5.0), none)
    assert swings_on(ARM, middle, (0.0, 0.0), 0.5 * ABLE.torque)
