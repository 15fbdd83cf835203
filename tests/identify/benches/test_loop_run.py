import numpy as np
import pytest

from layflat.identify.benches.turned_joint import TurnedJoint, TurnedLog, turned_torque
from layflat.machine import load, parameters
from layflat.sim.sweep import sweep


def test_a_joint_turned_through_a_log_is_the_slow_sweep() -> None:
    machine = load("paper-small-joint")
    described = machine.joint["small"]
    hose = parameters.hose(described)
    loop = sweep(machine, "small", 3e5)
    angle = np.concatenate([loop.angle, loop.angle])
    same = np.ones_like(angle)
    log = TurnedLog(angle, 3e5 * same, 0.0 * same, same, float(loop.torque[0]), 1e-9)
    torque = np.empty(len(angle))
    turned_torque(TurnedJoint(hose, hose, parameters.friction(described), described.brake.torque, 0.0), log, torque)
    assert torque[len(loop.angle) :] == pytest.approx(loop.torque, abs=1e-6)
