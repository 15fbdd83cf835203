"""The paper's arm alone in MuJoCo, with torques at its joints: the yardstick of speed."""

from __future__ import annotations

from typing import Any

import mujoco as _mujoco

from layflat.bridge import arm_spec
from layflat.machine import Machine

mujoco: Any = _mujoco


def build(machine: Machine, *, brakes: bool = False) -> tuple[Any, Any]:
    """Model and data of the arm with its payload, which moves freely between its stops."""
    spec = arm_spec(machine, passive=True)
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        if not brakes:
            joint.frictionloss = 0.0
        spec.add_actuator(target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    model = spec.compile()
    data = mujoco.MjData(model)
    data.ctrl[:] = (10.0, 3.0)
    return model, data


def run(arm: tuple[Any, Any], steps: int) -> None:
    """Advance by some steps, from rest."""
    model, data = arm
    mujoco.mj_resetData(model, data)
    data.ctrl[:] = (0.5, 0.2)
    mujoco.mj_step(model, data, steps)
