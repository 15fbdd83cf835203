"""An arm alone in MuJoCo, with torques at its joints: the yardstick of speed."""

from __future__ import annotations

import time
from typing import Any

import mujoco as _mujoco
import numpy as np
from mujoco import rollout as _batched

from layflat.bridge import arm_spec
from layflat.machine import Machine

mujoco: Any = _mujoco
batched: Any = _batched

SHARES = (0.5, 0.2)  # torques of the first joint and of the others, N m


def build(machine: Machine, *, brakes: bool = False) -> tuple[Any, Any]:
    """Model and data of the arm with its payload, which moves freely between its stops."""
    spec = arm_spec(machine, passive=True)
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        if not brakes:
            joint.frictionloss = 0.0
        spec.add_actuator(target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
    model = spec.compile()
    return model, mujoco.MjData(model)


def torques(model: Any) -> Any:
    """Torques of all joints (joints,), N m."""
    return np.where(np.arange(model.nu) == 0, *SHARES)


def run(arm: tuple[Any, Any], steps: int) -> None:
    """Advance by some steps, from rest."""
    model, data = arm
    mujoco.mj_resetData(model, data)
    data.ctrl[:] = torques(model)
    mujoco.mj_step(model, data, steps)


def batched_seconds(machine: Machine, runs: int, steps: int) -> float:
    """Time of MuJoCo's batched rollout of an arm alone, on one thread, s."""
    model, data = build(machine)
    controls = np.broadcast_to(torques(model), (runs, steps, model.nu)).copy()
    start = np.zeros((runs, 1 + model.nq + model.nv))
    batched.rollout(model, [data], start, controls[:, :10])
    begin = time.perf_counter()
    batched.rollout(model, [data], start, controls)
    return time.perf_counter() - begin
