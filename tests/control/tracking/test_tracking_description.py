from pathlib import Path

import numpy as np
import pytest

from layflat.control import FULL_FRACTIONS, Demand, Sensed, step, wake
from layflat.control.tracking import TrackingControllerPart
from layflat.description.change import changed_all, value_at
from layflat.errors import LayflatError, MachineError
from layflat.machine import load, parameters

TRACKING = 'extends = "{}"\nname = "mine"\n[controller]\nkind = "tracking"\ncycle = "5 ms"\n{}'


def machine(folder: Path, *lines: str, base: str = "paper-arm-fast") -> Path:
    path = folder / "mine.toml"
    path.write_text(TRACKING.format(base, "\n".join(lines)))
    return path


def test_all_follows_from_the_machine(tmp_path: Path) -> None:
    arm = load(machine(tmp_path))
    assert isinstance(arm.controller, TrackingControllerPart)
    settings = parameters.control(arm)
    # 92 % of the paper's 84 and 25 N m, and what simulated joints gain with an open valve.
    large, small = settings.actuators
    assert (large.torque, small.torque) == pytest.approx((76.0, 23.0), rel=0.05)
    assert (large.rate, small.rate) == pytest.approx((1035.0, 850.0), rel=0.25)
    assert settings.prior.usual[-1] == arm.arm.payload
    assert settings.prior.deviations[-1] == 0.0
    assert settings.plant.late == ()


def test_a_smaller_valve_is_slower_in_proportion(tmp_path: Path) -> None:
    arm = load(machine(tmp_path))
    half = changed_all(arm, {"valve.conductance": 0.5 * value_at(arm, "valve.conductance")})
    for whole, slow in zip(parameters.control(arm).actuators, parameters.control(half).actuators, strict=True):
        assert slow.rate == pytest.approx(0.5 * whole.rate)
        assert slow.speed == pytest.approx(0.5 * whole.speed)
        assert slow.torque == whole.torque


def test_commands_that_are_late_by_whole_cycles_are_counted(tmp_path: Path) -> None:
    for delay, late in ((0.004, 0), (0.005, 1), (0.012, 2)):
        arm = changed_all(load(machine(tmp_path)), {"valve.delay": delay})
        assert len(parameters.control(arm).plant.late) == late


def test_a_longer_cycle_is_stepped_through_and_followed_more_slowly(tmp_path: Path) -> None:
    path = machine(tmp_path)
    path.write_text(path.read_text().replace("5 ms", "20 ms"))
    slow, usual = parameters.control(load(path)), parameters.control(load("paper-arm-tracking"))
    assert (len(usual.plant.steps), len(slow.plant.steps)) == (2, 8)
    assert slow.feedback[0].damping == pytest.approx(usual.feedback[0].damping / 4.0)


def test_numbers_of_the_machine_may_be_arrays(tmp_path: Path) -> None:
    arm = load(machine(tmp_path))
    sizes = value_at(arm, "valve.conductance") * np.array([0.5, 1.0])
    settings = parameters.control(changed_all(arm, {"valve.conductance": sizes}))
    assert settings.actuators[0].rate.shape == (2,)
    assert settings.actuators[0].rate[1] == parameters.control(arm).actuators[0].rate


def test_called_from_python_an_arm_at_its_goal_stays_there() -> None:
    settings, nothing = parameters.control(load("paper-arm-tracking")), (0.0, 0.0)
    memory, demand = wake(settings, Sensed(nothing, nothing)), Demand(nothing, nothing, nothing, nothing)
    for _ in range(3):
        memory, command, report = step(settings, memory, Sensed(nothing, nothing), demand, 5e-3)
    assert command.voltage == pytest.approx((5.0, 5.0), abs=0.05)
    assert command.shares == (FULL_FRACTIONS, FULL_FRACTIONS)
    assert [joint.landed for joint in report] == [1.0, 1.0]
    assert [joint.estimated_angle for joint in report] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (['bandwidth = "0 1/s"'], "controller.bandwidth"),
        (["valve_fraction = 1.5"], "controller.valve_fraction"),
        (['payload_std = "-1 kg"'], "controller.payload_std"),
        (["reserve = 1.2"], "controller.reserve"),
        (["averaged = true"], "averaged"),
    ],
)
def test_what_does_not_fit_is_said(tmp_path: Path, lines: list[str], says: str) -> None:
    with pytest.raises(LayflatError, match=says):
        parameters.control(load(machine(tmp_path, *lines)))


def test_a_valve_of_which_no_mean_is_known_is_refused(tmp_path: Path) -> None:
    arm = load(machine(tmp_path, base="paper-arm-switching"))
    with pytest.raises(MachineError, match="a valve of kind 'switching' has no mean"):
        parameters.control(arm)
