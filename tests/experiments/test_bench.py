import pytest

from layflat.experiments import bench
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
