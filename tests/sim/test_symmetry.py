"""What mechanics says of runs without a second simulation: mirrored, turned and shifted they are the same."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np
import pytest
import xarray

from layflat.machine import Machine, changed, load
from layflat.sim import rollout

pytestmark = pytest.mark.compiled

MACHINES = ("paper-small-joint-fast", "paper-arm-fast")


def calm(name: str) -> Machine:
    """A machine without dither, which has a phase, in a plane without gravity."""
    return changed(load(name), "valve.dither.amplitude", 0.0)


def opened(machine: Machine, sign: float, **more: Any) -> xarray.Dataset:
    """An open-loop run in which the valves open to one side, then to the other."""
    steps = [("0 s", 0.0), ("20 ms", 0.2 * sign), ("0.2 s", -0.1 * sign), ("0.4 s", 0.0)]
    return rollout(machine, opening=steps, duration="0.6 s", noise=False, **more)


@pytest.mark.parametrize("name", MACHINES)
def test_with_its_hoses_exchanged_a_joint_turns_the_other_way(name: str) -> None:
    machine = calm(name)
    if len(machine.joints) > 1:
        machine = changed(machine, "arm.elbow", pi)  # an elbow that is not bent has no side
    one, other = opened(machine, 1.0, start=0.0), opened(machine, -1.0, start=0.0)
    assert np.ptp(one["angle"].to_numpy(), axis=0).min() > 0.01
    for mine, its, sign in (
        ("angle", "angle", -1.0),
        ("velocity", "velocity", -1.0),
        ("pressure_a", "pressure_b", 1.0),
    ):
        scale = float(np.abs(one[mine]).max())
        assert one[mine].to_numpy() == pytest.approx(sign * other[its].to_numpy(), rel=0.0, abs=1e-9 * scale)
    for same in ("air_taken", "brake_heat"):
        assert one[same].to_numpy() == pytest.approx(other[same].to_numpy(), rel=1e-9, abs=1e-12)


def test_the_direction_of_no_gravity_does_not_matter() -> None:
    one, other = (opened(changed(calm("paper-arm"), "arm.gravity_direction", turn), 1.0) for turn in (0.0, 2.0))
    for name in ("angle", "pressure_a", "air_taken"):
        assert np.array_equal(one[name], other[name])


def test_what_comes_later_changes_nothing_before() -> None:
    late = [("0 s", 0.0), ("0.3 s", "2 N m")]
    one, other = opened(calm("paper-arm"), 1.0), opened(calm("paper-arm"), 1.0, load=late)
    before = one["time"].to_numpy() <= 0.3
    for name in ("angle", "pressure_a", "voltage"):
        assert np.array_equal(one[name][before], other[name][before])
    assert not np.array_equal(one["angle"], other["angle"])


def test_a_shorter_run_is_the_beginning_of_a_longer_one() -> None:
    short, long = (rollout("paper-arm", "10 deg", start=0.0, duration=seconds, seed=6) for seconds in (0.2, 0.4))
    rows = len(short["time"]) - 1
    for name in ("angle", "measured_angle", "voltage", "pressure_a"):
        assert np.array_equal(short[name][:rows], long[name][:rows])


@pytest.mark.parametrize("name", MACHINES)
def test_more_records_show_the_same_run(name: str) -> None:
    coarse, fine = (rollout(name, "10 deg", start=0.0, duration="0.2 s", records=records) for records in (1, 5))
    for signal in ("angle", "pressure_b", "voltage", "air_taken"):
        assert np.array_equal(coarse[signal], fine[signal][::5])
