from typing import Any

import numpy as np
import pytest

from layflat.errors import LayflatError
from layflat.machine import load, parameters
from layflat.sim.sweep import sweep

ARM = load("paper-arm")


def test_without_losses_the_loop_is_a_line() -> None:
    from layflat.machine import changed

    smooth = changed(ARM, "joint.small.hose.loss_fraction", 0.0)
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


ODD: list[Any] = [
    float("nan"), float("inf"), 1j, True, b"x", "x", "", [], {}, -9, 10**400, object(), np.timedelta64(1, "s"),
    np.array([1.0, 2.0]), lambda: 1, {1, 2},
]  # fmt: skip


@pytest.mark.parametrize("odd", ODD, ids=lambda odd: type(odd).__name__ + repr(odd)[:4])
@pytest.mark.parametrize("name", ["machine", "joint", "pressure", "centre", "stroke", "brake", "points"])
def test_what_can_not_be_swept_is_one_line(name: str, odd: Any) -> None:
    given: Any = {"machine": "paper-arm", "joint": "small", "pressure": "3 bar", "points": 101} | {name: odd}
    with pytest.raises(LayflatError) as caught:
        sweep(**given)
    assert "\n" not in str(caught.value)


def test_texts_are_swept_as_numbers_are() -> None:
    one, other = sweep("paper-arm", "small", "3 bar", stroke="90 deg"), sweep(ARM, "small", 3e5, stroke=np.pi / 2)
    assert np.allclose(one.torque, other.torque)
