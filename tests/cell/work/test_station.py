from __future__ import annotations

import numpy as np
import pytest

from layflat.cell.work.station import CellArm
from layflat.errors import RigStoppedError
from layflat.machine import load
from layflat.rig.clock import NS_PER_SECOND, VirtualClock
from layflat.rig.device.virtual import SimulatedDriver, VirtualDevice
from layflat.sim.plant import SteppedPlant

MACHINE = load("paper-arm-fast-tuned")


def arm_of(seed: int = 0) -> tuple[CellArm, VirtualDevice]:
    clock = VirtualClock()
    device = VirtualDevice(MACHINE, SteppedPlant(MACHINE, seed=seed, payload=1.2), clock, running=True)
    return CellArm(MACHINE, SimulatedDriver(device), clock, load=1.2, tip_speed=2.5), device


def test_it_goes_where_it_is_told_and_stays_there() -> None:
    arm, device = arm_of()
    for target in ((0.4, -0.3), (-0.2, 0.5)):
        arm.go(target)
        for _ in range(round(2.0 / arm.cycle)):
            arm.advance()
            arm.go(target)  # again and again, as a pick does
        assert arm.angles == pytest.approx(target, abs=np.radians(0.3))
        assert device.plant.angles.tolist() == pytest.approx(target, abs=np.radians(0.3))
        assert max(abs(v) for v in arm.velocities) < np.radians(3.0)


def test_another_target_on_the_way_is_followed_from_where_the_demand_is() -> None:
    arm, _ = arm_of()
    arm.go((0.5, 0.0))
    demands = []
    for k in range(300):
        arm.advance()
        if k == 20:
            arm.go((-0.3, 0.2))
        demands.append(arm.loop.supervisor.demands.copy())
    leaps = np.abs(np.diff(demands, axis=0)).max()
    assert leaps < np.radians(3.0)
    assert demands[-1] == pytest.approx([-0.3, 0.2])


def test_a_rig_that_stops_is_told_with_its_fault() -> None:
    arm, device = arm_of()
    arm.advance()
    device.stopped = True
    with pytest.raises(RigStoppedError, match="the rig stopped: e-stop"):
        arm.advance()


def test_joints_that_shake_each_other_in_a_move_are_not_blocked() -> None:
    """Both hoses fill at once: the elbow bears what the base's torque does to it, and stands still for a while."""
    random = np.random.default_rng(5)
    arm, _ = arm_of()
    for target in random.uniform(-0.8, 0.8, (25, 2)).tolist():
        arm.go(tuple(target))
        for _ in range(round(1.2 / arm.cycle)):
            arm.advance()
    assert arm.loop.clock.now() > 29 * NS_PER_SECOND
