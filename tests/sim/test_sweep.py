import numpy as np
import pytest

from layflat.machine import load, parameters
from layflat.sim.sweep import sweep

ARM = load("paper-arm")


def test_without_losses_the_loop_is_a_line() -> None:
    from layflat.machine import changed

    smooth = changed(ARM, "joint.small.hose.loss_share", 0.0)
    loop = sweep(smooth, "small", 3e5, brake=0.0)
    assert loop.height == pytest.approx(0.0, abs=1e-12)
    assert loop.maximum_torque == pytest.approx(3e5 * parameters.torque_constant(ARM.joint["small"]))


def test_the_brake_adds_twice_its_torque() -> None:
    free, braked = (sweep(ARM, "small", 3e5, brake=share) for share in (0.0, 1.0))
    assert braked.height - free.height == pytest.approx(2 * ARM.joint["small"].brake.torque, rel=1e-9)


def test_speed_does_not_matter() -> None:
    slow, fast = (sweep(ARM, "small", 3e5, points=points) for points in (4001, 201))
    assert fast.height == pytest.approx(slow.height, rel=1e-3)


@pytest.mark.parametrize("name", ["rig-polyester", "paper-arm", "earlier-actuator"])
def test_the_share_of_the_loss_falls_with_pressure(name: str) -> None:
    shares = [sweep(load(name), "small", pressure, brake=0.0).hysteresis for pressure in (1e5, 2e5, 3e5, 4e5)]
    assert np.all(np.diff(shares) < 0)
