"""A machine's file becomes the law's settings."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from layflat.control.paper import PaperControllerPart, idle_gains, paper_settings
from layflat.control.paper.law import Gains, step_joint, wake_joint
from layflat.machine import Machine, changed, load
from layflat.machine.parameters import plant

ARM = load("paper-arm-fast")
CENTRE = 5.0  # V


def of(arm: Machine) -> tuple[Gains, ...]:
    """Settings of each joint."""
    assert isinstance(arm.controller, PaperControllerPart)
    return paper_settings(arm.controller, arm, lambda: plant(arm)).joints


def test_settings_are_what_the_file_says_of_each_joint() -> None:
    for name, found in zip(ARM.joints, of(ARM), strict=True):
        said = ARM.joint[name].gains
        assert said is not None
        for phase in ("far", "near", "close"):
            assert getattr(found, phase) == (getattr(said, phase).error, getattr(said, phase).pressure)
        assert (found.near_error, found.near_speed) == (said.near_below.error, said.near_below.speed)
        assert (found.close_error, found.close_speed) == (said.close_below.error, said.close_below.speed)
        assert (found.integral_gain, found.integral_limit) == (said.integral, said.integral_limit)
        for same in ("drift_time", "drift_limit", "air_ripple", "rest_speed", "rest_time", "load_pressure"):
            assert getattr(found, same) == getattr(ARM.controller, same)
        assert found.null == CENTRE
        assert (found.voltage_low, found.voltage_high) == pytest.approx((0.0, 10.0))


@pytest.mark.parametrize("averaged", [True, False])
def test_signals_are_averaged_where_the_file_says_so(averaged: bool) -> None:
    arm = changed(ARM, "controller.averaged", averaged)
    assert [one.averaged for one in of(arm)] == [float(averaged)] * 2


@given(st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), st.floats(-3e5, 3e5), st.floats(-3e5, 3e5))
def test_a_law_that_only_watches_leaves_the_valve_in_its_centre(x: float, d: float, before: float, dp: float) -> None:
    gains = idle_gains(ARM.valve)
    memory = wake_joint(gains, 0.0, before)
    for _ in range(300):
        memory, voltage, _ = step_joint(gains, memory, x, dp, d, 0.005)
        assert voltage == CENTRE
