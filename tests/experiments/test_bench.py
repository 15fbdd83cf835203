import pytest

from layflat.experiments import bench
from layflat.experiments.axis_one import limit_within
from layflat.experiments.bench import maximum_torque, payload_for_inertia
from layflat.machine import load


def test_inertia_and_payload() -> None:
    assert payload_for_inertia(load("paper-small-joint"), "small", 0.32) == pytest.approx(2.0)


def test_the_earlier_actuator_gets_the_arms_controller_scaled_to_its_torque() -> None:
    on = bench()
    own, scaled = on.arm.joint["small"].gains, on.earlier_scaled.joint["small"].gains
    assert own is not None
    assert scaled is not None
    ratio = maximum_torque(on.earlier, "small") / maximum_torque(on.arm, "small")
    assert scaled.far.error == own.far.error
    assert scaled.far.pressure == pytest.approx(ratio * own.far.pressure)


def test_a_limit_ends_at_the_first_inertia_that_takes_too_long() -> None:
    times = {1.0: 0.5, 2.0: 1.4, 3.0: 2.5, 4.0: 1.0}
    assert limit_within(times, 1.5) == 2.0
    assert limit_within(times, 3.0) == 4.0
    assert limit_within(times, 0.1) == 0.0
