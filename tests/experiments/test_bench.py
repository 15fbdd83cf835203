import pytest

from layflat.experiments import bench
from layflat.experiments.axis_one import limit_within
from layflat.experiments.bench import maximum_torque, payload_for_inertia
from layflat.machine import changed, load


def test_inertia_and_payload() -> None:
    assert payload_for_inertia(load("paper-small-joint"), "small", 0.32) == pytest.approx(2.0)


def test_axis_one_and_the_earlier_actuator_share_a_controller_scaled_to_torque() -> None:
    on = bench()
    own, scaled = on.axis_one.joint["small"].gains, on.earlier_scaled.joint["small"].gains
    assert own is not None
    assert scaled is not None
    ratio = maximum_torque(on.earlier, "small") / maximum_torque(on.arm, "small")
    assert scaled.far.error == own.far.error
    assert scaled.far.pressure == pytest.approx(ratio * own.far.pressure)


def test_gains_tuned_for_the_arm_do_not_touch_axis_one() -> None:
    arm = load("paper-arm")
    tuned = changed(arm, "joint.small.gains.close.error", 100.0)
    assert bench(tuned).axis_one == bench(arm).axis_one
    assert bench(tuned).earlier_scaled == bench(arm).earlier_scaled


def test_a_limit_ends_at_the_first_inertia_that_takes_too_long() -> None:
    times = {1.0: 0.5, 2.0: 1.4, 3.0: 2.5, 4.0: 1.0}
    assert limit_within(times, 1.5) == 2.0
    assert limit_within(times, 3.0) == 4.0
    assert limit_within(times, 0.1) == 0.0
