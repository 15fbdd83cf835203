"""How fast demands may be, against the dynamics of the arm, and what friction can hold."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from layflat.machine import changed, load, parameters
from layflat.motion.limits import joint_capabilities
from layflat.rig.abilities import (
    MAX_CONFIGURATIONS,
    demand_limits,
    falls_without_air,
    find_sinking_joints,
    max_gravity_torques,
    may_reach_stops,
    payload_range,
    resting_angles,
    sample_configurations,
    vent_time,
)
from tests.physics.arms.chain.chains import random_arm
from tests.rig.hanging_arm import lifting_arm

ARM = load("paper-arm-tracking")
LIMITS, ABLE = demand_limits(ARM), joint_capabilities(ARM)
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
    assert not may_reach_stops(ARM, middle, (0.0, 0.0), none)
    assert not may_reach_stops(ARM, middle, (0.5, 0.5), none)
    assert may_reach_stops(ARM, middle, (5.0, 5.0), none)
    assert may_reach_stops(ARM, middle, (0.0, 0.0), 0.5 * ABLE.torque)


LIFTS = lifting_arm()
HALVES = np.array([0.5 * joint.stops.working_stroke for joint in LIFTS.joints.values()])


@given(st.tuples(SHARE, SHARE, SHARE), st.tuples(SHARE, SHARE, SHARE), st.floats(0.0, 1.0))
def test_limits_of_an_arm_in_space_hold_in_any_posture_with_any_payload(
    place: tuple[float, ...], push: tuple[float, ...], share: float
) -> None:
    limits, able, (lightest, heaviest) = demand_limits(LIFTS), joint_capabilities(LIFTS), payload_range(LIFTS)
    payload = lightest + share * (heaviest - lightest)
    mass, gravity = parameters.mass_and_pull(parameters.arm(LIFTS), payload, HALVES * place)
    acceleration = np.linalg.solve(mass, able.torque * push + gravity)
    assert (np.abs(acceleration) <= 1.1 * limits.acceleration).all()  # looked at in a grid of postures
    assert (np.abs(mass @ (limits.braking * np.sign(push))) + np.abs(gravity) <= 1.1 * able.torque).all()
    assert (np.abs(gravity) <= 1.1 * max_gravity_torques(LIFTS)).all()


def test_a_payload_that_is_not_told_is_anything_up_to_the_end_of_its_spread() -> None:
    assert payload_range(LIFTS) == (0.0, 0.2 + 3.0**0.5 * 0.1)
    assert payload_range(changed(LIFTS, "controller.payload_std", 0.0)) == (0.2, 0.2)
    assert payload_range(load("paper-arm")) == (0.0, 1.5)


def test_many_joints_are_looked_at_in_a_bounded_number_of_postures() -> None:
    for n in range(1, 8):
        found = sample_configurations(random_arm(n, 1))
        assert found.shape[1] == n
        assert 2**n <= len(found) <= MAX_CONFIGURATIONS


def test_an_arm_that_its_brakes_do_not_hold_is_let_down_slowly() -> None:
    assert find_sinking_joints(LIFTS).tolist() == [
        False,
        True,
        False,
    ]  # the base turns about the vertical, the elbow's brake holds
    assert falls_without_air(LIFTS)
    assert vent_time(LIFTS) == 5.0 * LIFTS.safety.vent_time
    assert not falls_without_air(ARM)
    assert vent_time(ARM) == ARM.safety.vent_time
    ends = np.array([0.5 * joint.stops.mechanical_stroke for joint in LIFTS.joints.values()])
    # The shoulder is pressed into its stop, which gives way; the others' brakes may keep them where they were pushed.
    base, shoulder, elbow = (resting_angles(LIFTS) - ends).tolist()
    assert shoulder > max(base, elbow)
    assert min(base, elbow) > 0.0


def test_what_gravity_takes_to_its_stop_is_no_arm_that_swings_on() -> None:
    assert not may_reach_stops(LIFTS, (0.0, 0.5, 0.0), (0.0, 0.0, 0.0), np.zeros(3))
    assert may_reach_stops(LIFTS, (0.0, 0.5, 0.0), (9.0, 9.0, 0.0), np.zeros(3))
