"""An arm alone in MuJoCo Warp, with torques at its joints: the yardstick of speed on a CUDA device.

It needs `mujoco-warp`, which no extra brings along: it weighs a quarter of a gigabyte.
"""

from __future__ import annotations

import time
from importlib import import_module
from typing import Any

import mujoco as _mujoco

from benchmarks.mujoco_arm import build, torques
from layflat.machine import Machine

mujoco: Any = _mujoco

WARM_UP = 100  # steps; the first ones compile


def seconds_per_step(machine: Machine, worlds: int, steps: int) -> float:
    """Time that a step of an arm takes where so many move at once, s; a step is one graph that is launched again.

    Raises:
        ImportError: mujoco-warp is not installed.
    """
    warp: Any = import_module("warp")
    mjw: Any = import_module("mujoco_warp")
    model, data = build(machine)
    data.ctrl[:] = torques(model)
    mujoco.mj_forward(model, data)
    there, states = mjw.put_model(model), mjw.put_data(model, data, nworld=worlds)
    mjw.step(there, states)
    with warp.ScopedCapture() as capture:
        mjw.step(there, states)
    for count in (WARM_UP, steps):
        warp.synchronize()
        begin = time.perf_counter()
        for _ in range(count):
            warp.capture_launch(capture.graph)
        warp.synchronize()
    return (time.perf_counter() - begin) / (steps * worlds)
