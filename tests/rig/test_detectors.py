"""The detectors of a joint, in the cycles of a signal; whole rigs are watched in test_faults.py."""

from math import inf, nan

import numpy as np
import pytest

from layflat.machine import changed, load
from layflat.physics.sensor import Sensor
from layflat.rig.safety import detectors
from layflat.rig.safety.detectors import air, angle_frozen, bounds, following
from layflat.rig.safety.detectors.sample import AIR_LEVEL, MOTION_LEVEL, SENSORS_LEVEL, JointSample
from layflat.rig.safety.faults import Fault
from layflat.rig.safety.limits import detector_limits, noise_never_rests

CYCLE = 0.005
SPEED = 14.0
LIMITS = detectors.DetectorLimits(
    bounds.RailLimits(-1.3, 1.3),
    5e5,
    SPEED,
    bounds.StrokeLimits(1.2, rests=1.2, inside=1.2, thrown=0.0),
    air.SuspicionLimits(6e-4, 1.0, 0.25, 0.0125),
    angle_frozen.FrozenAngleLimits(6e-4, 1e5, CYCLE, 0.0375, 0.09),
    air.ValveResponseLimits(1000.0, 0.17, 2.4e5, 0.8),
    air.FrozenPressureLimits(0.09, 0.0375),
    following.FollowingLimits(0.6, 0.1, 1.0, 0.09, 2.4e5),
)
SWING = (2000.0, 0.0, -2000.0, 0.0)


def follow(
    samples: int, angle: list[float], *, pressure: list[float] | None = None, demand: float | None = None,
    opening: float = 0.5, residual: float = 0.0, level: float = AIR_LEVEL, averaged: float = 0.0, others: float = 0.0,
    velocity: float = 0.0, inertia: float = 1e9, limits: detectors.DetectorLimits = LIMITS,
) -> tuple[detectors.DetectorMemory, list[Fault]]:  # fmt: skip
    """Memory after a signal, and the worst fault in each cycle."""
    memory, found = detectors.INITIAL_MEMORY, []
    for k in range(samples):
        x = angle[k % len(angle)]
        p = pressure[k % len(pressure)] if pressure else SWING[k % 4] + 0.3 * k
        wanted = x if demand is None else demand
        sample = JointSample(
            x,
            p,
            averaged * k,
            others * k,
            others * k,
            inertia,
            velocity,
            opening,
            residual,
            wanted,
            0.0,
            CYCLE,
            level,
            1.0,
        )
        memory, fault = detectors.find_joint_fault(limits, memory, sample)
        found.append(Fault(fault))
    return memory, found


def test_a_sound_joint_at_rest_has_no_fault() -> None:
    memory, found = follow(400, [0.5])
    assert not any(found)
    assert memory.trace.ripple == pytest.approx(2000.0, rel=1e-3)


@pytest.mark.parametrize("slope", [0.0, 3000.0])
def test_ripple_is_that_of_the_dither_whatever_the_slope(slope: float) -> None:
    memory, _ = follow(20, [0.0], pressure=[SWING[k % 4] + slope * k for k in range(20)])
    assert memory.trace.ripple == pytest.approx(2000.0)


@pytest.mark.parametrize("bad", [-1.3, 1.3, nan, inf])
def test_the_rail_counts_samples_with_or_without_air(bad: float) -> None:
    for level in (SENSORS_LEVEL, AIR_LEVEL):
        assert follow(3, [bad], level=level)[1][:2] == [0, 0]
        assert follow(3, [bad], level=level)[1][2] is Fault.ANGLE_AT_RAIL


def test_a_pressure_that_is_not_a_number_is_at_fault() -> None:
    assert follow(2, [0.0], pressure=[nan], level=SENSORS_LEVEL)[1] == [0, Fault.OVER_PRESSURE]


def test_speed_and_stroke_count_where_the_joint_may_move() -> None:
    leap = [0.0, 0.08, 0.16, 0.24, 0.32]
    assert follow(4, leap, level=MOTION_LEVEL)[1] == [0, 0, Fault.OVER_SPEED, Fault.OVER_SPEED]
    assert not any(follow(4, leap, level=SENSORS_LEVEL)[1])
    assert follow(2, [1.21, 1.2101], level=MOTION_LEVEL)[1] == [0, Fault.OUTSIDE_STROKE]
    assert follow(2, [1.25, 1.31], level=MOTION_LEVEL)[1] == [0, Fault.OUTSIDE_STROKE], "it went on to the rail"


def test_a_joint_that_rests_at_the_border_of_its_stroke_may_be_led_inside_from_there() -> None:
    limits, rails = bounds.StrokeLimits(1.2, rests=1.25, inside=1.0, thrown=3.0), LIMITS.rail
    shaking = [1.199, 1.201, 1.202, 1.24, 1.1, 1.201, 1.202]

    def after(angles: list[float]) -> list[int]:
        memory, found = bounds.NOT_YET_INSIDE, []
        for angle in angles:
            taken = JointSample(angle, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, CYCLE, MOTION_LEVEL, 1.0)
            memory, fault = bounds.find_outside(limits, memory, rails, taken)
            found.append(fault)
        return found

    assert not any(after(shaking))
    assert after([*shaking, 0.99, 1.201, 1.202])[-1] == Fault.OUTSIDE_STROKE, "it was inside"
    thrown = [1.24, 1.1, 1.24, 1.26, 1.27, 1.27, 1.26]
    assert not any(after([*thrown, 1.24, *thrown, 1.24, 0.99])), "others threw it to its stop"
    assert after([*thrown, 1.26])[-1] == Fault.OUTSIDE_STROKE, "no joint rests there"
    assert after([*thrown, 1.31])[-1] == Fault.OUTSIDE_STROKE, "it went on to the rail"
    assert after([*thrown, 1.24, 0.99, 1.26, 1.26])[-1] == Fault.OUTSIDE_STROKE, "it was inside"


STILL = LIMITS._replace(
    angle_frozen=LIMITS.angle_frozen._replace(hides=5e4), suspicion=LIMITS.suspicion._replace(still=0.1, filling=0.4)
)


def frozen_after(pressure: float, light: float, heavy: float, inertia: float = 1e3, residual: float = 0.0) -> float:
    """Time in which an angle that stays is told to be frozen, s."""
    memory = detectors.INITIAL_MEMORY
    for k in range(17):
        p = SWING[k % 4] + 0.3 * k
        taken = JointSample(
            0.5, p, pressure, light, heavy, inertia, 0.0, 0.0, residual, 0.5, 0.0, CYCLE, AIR_LEVEL, 1.0
        )  # fmt: skip
        memory, fault = detectors.find_joint_fault(STILL, memory, taken)
        if fault:
            assert fault == Fault.ANGLE_FROZEN
            return CYCLE * k
    return inf


def test_a_joint_that_bears_what_friction_cannot_hold_would_have_gone_on() -> None:
    assert frozen_after(9e4, 0.0, 2e4) < 0.06
    assert frozen_after(-9e4, 0.0, -2e4) < 0.06
    assert frozen_after(9e4, 0.0, 2e4, inertia=1e6) == inf, "a heavy one does not in this time"
    assert frozen_after(9e4, 0.0, 5e4) == inf, "with some payload friction holds it"
    assert frozen_after(9e4, 4e4, 2e5) == inf, "with one payload it is pushed one way, with another the other way"


def test_air_that_moves_around_a_joint_at_rest_tells_that_it_moves() -> None:
    assert frozen_after(0.0, 0.0, 0.0, residual=0.09) == inf
    assert frozen_after(0.0, 0.0, 0.0, residual=-0.12) < 0.07


def test_of_payloads_that_may_be_there_the_one_counts_with_which_a_joint_bears_least() -> None:
    swing, others = 4e5, (0.0, 8e5)  # between none and the most there is one that bears all of it
    memory = detectors.INITIAL_MEMORY
    for k in range(30):
        turned = 1.0 if k > 15 else -1.0
        p, (light, heavy) = turned * swing, (turned * other for other in others)
        taken = JointSample(
            0.5, SWING[k % 4] + 0.3 * k, p, light, heavy, 1e9, 0.0, 0.0, 0.0, 0.5, 0.0, CYCLE, AIR_LEVEL, 1.0
        )
        memory, fault = detectors.find_joint_fault(LIMITS, memory, taken)
        assert not fault


@pytest.mark.parametrize("when", np.linspace(0.0, 0.9, 10))
@pytest.mark.parametrize("rate", [200.0, 500.0])
def test_a_joint_that_speeds_up_is_found_two_samples_after_it_is_too_fast(when: float, rate: float) -> None:
    times = CYCLE * (np.arange(14.0) - 10.0 + when)
    speeds = SPEED + rate * times
    angles = np.where(speeds > 0.0, speeds**2, 0.0) / (2.0 * rate)
    found = follow(len(angles), list(angles - angles.max()), level=MOTION_LEVEL)[1]
    first, last = int(np.argmax(times > 0.0)), int(np.argmax([bits is Fault.OVER_SPEED for bits in found]))
    assert first <= last <= first + 1


def test_a_pressure_that_repeats_itself_is_found() -> None:
    found = follow(40, [0.1, 0.1006], pressure=[500.0])[1]
    assert (np.flatnonzero(found)[0] + 1) * CYCLE <= 0.1
    assert found[int(np.flatnonzero(found)[0])] == Fault.PRESSURE_FROZEN


def test_too_much_air_is_no_answer() -> None:
    assert follow(5, [0.5, 0.5006], residual=0.26)[1][-1] is Fault.VALVE_UNRESPONSIVE
    assert not any(follow(5, [0.5, 0.5006], residual=-0.24)[1])


def test_a_joint_that_stands_still_at_once_has_a_frozen_sensor() -> None:
    found = follow(30, [0.0, 0.004, 0.008, *[0.012] * 27])[1]
    assert np.flatnonzero(found)[0] == 11
    assert found[11] == Fault.ANGLE_FROZEN


def test_a_joint_that_bears_more_than_friction_is_blocked_unless_others_hold_it() -> None:
    """A rise by 10 kPa a sample: friction hides 100 kPa, and nearly twice that is borne."""
    found = follow(40, [0.5], averaged=1e4)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == Fault.ANGLE_FROZEN
    assert first * CYCLE == pytest.approx(0.1, abs=0.01)
    assert not any(follow(40, [0.5], averaged=1e4, others=9e3)[1])
    assert not any(follow(40, [0.5], averaged=1e3, others=9e3)[1]), "others that are held themselves shake nothing"


def test_a_driven_joint_that_stays_where_it_is_but_for_noise_is_blocked() -> None:
    noise = [0.0, 0.0007]
    found = follow(200, noise, demand=0.2)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == Fault.ANGLE_FROZEN
    assert first * CYCLE == pytest.approx(0.6, abs=0.02)
    assert not any(follow(200, noise, demand=0.05)[1])
    assert not any(follow(200, noise, demand=0.15, opening=0.01)[1]), "friction may hold one whose valve is centred"
    assert any(follow(200, noise, demand=0.25, opening=0.01)[1])


def test_a_sensor_whose_noise_never_rests_is_frozen_where_it_repeats_itself_though_its_joint_may_rest() -> None:
    limits = LIMITS._replace(angle_frozen=LIMITS.angle_frozen._replace(noisy=1.0))
    found = follow(40, [0.5], limits=limits)[1]
    assert np.flatnonzero(found)[0] * CYCLE == pytest.approx(0.09, abs=0.01)
    assert found[-1] == Fault.ANGLE_FROZEN
    assert not any(follow(400, [0.5, *[0.5001] * 17], limits=limits)[1])
    assert not any(follow(40, [0.5], limits=limits, level=MOTION_LEVEL)[1]), "it is asked for nothing without air"


def test_a_sensor_is_told_by_its_noise_where_that_never_leaves_it_at_one_count() -> None:
    sound = load("picking-arm")
    assert detector_limits(sound, "wrist").angle_frozen.noisy == 1.0
    slow = changed(sound, "controller.cycle", "20 ms")
    assert detector_limits(slow, "wrist").angle_frozen.noisy == 0.0, "three samples may well be the same"
    assert detector_limits(load("paper-arm"), "small").angle_frozen.noisy == 0.0


@pytest.mark.parametrize("noise", [0.0, 0.27, 1.0, 2.0, 4.4])
def test_how_long_noise_leaves_a_sensor_at_one_count(noise: float) -> None:
    samples = np.round(noise * np.random.default_rng(1).standard_normal(1_000_000))
    longest = np.diff(np.flatnonzero(np.diff(samples, prepend=np.nan, append=np.nan) != 0.0)).max()
    never = next((n for n in range(1, 1000) if noise_never_rests(Sensor(-1e3, 1e3, 1.0, 0.0, noise), n)), np.inf)
    # A million is the square root of the samples in which that many would be the same.
    assert 0.35 * never < longest < 0.75 * never or longest == len(samples)


def test_a_step_is_no_following_error_and_a_joint_left_behind_is() -> None:
    ramp = [0.005 * k for k in range(200)]
    assert not any(follow(200, ramp, demand=1.0)[1])
    slow = [0.0, 0.002]
    found = follow(400, slow, demand=1.0)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == Fault.FOLLOWING_ERROR
    assert first * CYCLE == pytest.approx(0.6 + 0.09, abs=0.02)


def test_a_joint_that_hardly_moves_with_most_of_the_pressure_there_is_is_held_back() -> None:
    creeping, swift = ([v * CYCLE * k for k in range(100)] for v in (0.2, 0.5))
    found = follow(100, creeping, demand=0.4, averaged=1e5, velocity=0.2)[1]
    first = int(np.flatnonzero(found)[0])
    assert found[first] == Fault.FOLLOWING_ERROR
    assert first * CYCLE == pytest.approx(0.3, abs=0.02)
    assert not any(follow(30, swift, demand=0.4, averaged=1e5, velocity=0.5)[1])


def test_a_joint_that_another_may_hold_back_is_given_four_times_the_time() -> None:
    strained, push = 2.5e5, 3e5
    for others, cycles in ((0.0, 60), (push, 240)):
        memory, found = following.FollowingMemory(), []
        for _ in range(250):
            sample = JointSample(
                0.0, strained, strained, others, others, 1e9, 0.1, 0.5, 0.0, 0.2, 0.0, CYCLE, AIR_LEVEL, 1.0
            )
            memory, fault = following.find_following_error(LIMITS.following, memory, sample)
            found.append(fault)
        assert np.flatnonzero(found)[0] == pytest.approx(cycles, abs=2)


def test_a_ripple_that_is_gone_is_a_valve_that_does_not_respond() -> None:
    found = follow(60, [0.5, 0.5006], pressure=[0.3 * k for k in range(60)])[1]
    assert found[int(np.flatnonzero(found)[0])] is Fault.VALVE_UNRESPONSIVE
    assert np.flatnonzero(found)[0] * CYCLE == pytest.approx(0.17 + 3 * CYCLE, abs=0.011)


def judged(pressures: list[float], *, still: bool = False, level: float = AIR_LEVEL) -> list[Fault]:
    limits, memory, found = bounds.SupplyLimits(3e5, 6e5, 0.06), bounds.SupplyMemory(), []
    for pressure in pressures:
        memory, fault = bounds.find_supply(limits, memory, pressure, still, CYCLE, level)
        found.append(Fault(fault))
    return found


@pytest.mark.parametrize("pressure", [6e5, 7e5, nan, inf])
def test_a_supply_that_is_too_high_is_found_in_two_samples_with_or_without_air(pressure: float) -> None:
    for level in (SENSORS_LEVEL, AIR_LEVEL):
        assert judged([pressure] * 2, level=level) == [Fault.NONE, Fault.OVER_PRESSURE]


def test_a_supply_that_is_lost_is_found_while_there_should_be_air() -> None:
    assert judged([2e5] * 3) == [Fault.NONE, Fault.NONE, Fault.SUPPLY_LOST]
    assert judged([2e5, 2e5, 4e5, 2e5, 2e5]) == [Fault.NONE] * 5, "dips are none"
    assert judged([2e5] * 9, level=MOTION_LEVEL) == [Fault.NONE] * 9


def test_ripple_that_all_joints_lack_is_the_supply_s() -> None:
    found = judged([4e5] * 20, still=True)
    assert found.index(Fault.SUPPLY_LOST) * CYCLE == pytest.approx(0.06, abs=CYCLE)
