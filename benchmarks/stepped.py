"""Arms that a caller steps by control cycles: `Batch` against MuJoCo's batches, whose arms are bodies alone.

Run by itself (`python -m benchmarks.stepped NAME`) it prints the figures of a machine.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from mujoco import __version__ as mujoco_version
from mujoco import batch as _batch

from benchmarks import mujoco_arm
from benchmarks.timing import STEP
from layflat.machine import Machine, load
from layflat.sim.batch import Batch

mujoco_batch: Any = _batch

MANY, FEW = 4096, 64  # arms
ROUNDS = 5
SECONDS = 0.4  # of a measurement
FEW_MUJOCO = 256  # arms of MuJoCo, which takes as long for each of more


def cycles_per_second(step: Callable[[], object], arms: int) -> float:
    """Return the arms times control cycles a second of a function that moves all arms by a cycle."""
    step()
    cycles, begin = 0, time.perf_counter()
    while (taken := time.perf_counter() - begin) < SECONDS:
        step()
        cycles += 1
    return arms * cycles / taken


def our_step(machine: Machine, arms: int, precision: str) -> Callable[[], object]:
    """Return the function that moves arms with different payloads by a cycle under demands that are set anew."""
    payloads = np.linspace(0.5, 2.5, arms)
    batch = Batch(machine, arms, vary={"arm.payload": payloads}, precision=precision)
    demands = np.random.default_rng(1).uniform(-0.35, 0.35, (arms, len(batch.joints)))
    return lambda: batch.step(demands)


def mujoco_steps(machine: Machine, arms: int) -> dict[str, Callable[[], object]]:
    """Return the functions that move as many arms in MuJoCo, on all cores, by the name of the way."""
    model, data = mujoco_arm.build(machine)
    model.opt.timestep = STEP
    substeps = round(machine.cycle / STEP)
    threads = os.cpu_count() or 1
    own = mujoco_batch.Batch(model, arms, threads)
    own.bind("ctrl")[:] = mujoco_arm.torques(model)
    controls = np.broadcast_to(mujoco_arm.torques(model), (arms, substeps, model.nu)).copy()
    start = np.zeros((arms, 1 + model.nq + model.nv))
    copies = [type(data)(model) for _ in range(threads)]
    rolling = mujoco_arm.batched.Rollout(nthread=threads)
    return {
        "mujoco.batch.Batch.step": lambda: own.step(nstep=substeps),
        "mujoco.rollout": lambda: rolling.rollout(model, copies, start, controls),
    }


def measure(machine: Machine) -> dict[str, float | str]:
    """Return all figures by name: medians of rounds in which each way has its turn."""
    ours = {
        (arms, precision): our_step(machine, arms, precision)
        for arms in (MANY, FEW)
        for precision in ("single", "double")
    }
    theirs = mujoco_steps(machine, FEW_MUJOCO)
    rounds = [
        {key: cycles_per_second(step, key[0]) for key, step in ours.items()}
        | {key: cycles_per_second(step, FEW_MUJOCO) for key, step in theirs.items()}
        for _ in range(ROUNDS)
    ]
    found = {key: float(np.median([each[key] for each in rounds])) for key in rounds[0]}
    faster = max(theirs, key=lambda way: found[way])
    return {
        "batch_arm_cycles_per_second": found[MANY, "single"],
        "batch_double_arm_cycles_per_second": found[MANY, "double"],
        "batch_64_arm_cycles_per_second": found[FEW, "single"],
        "batch_mujoco_arm_cycles_per_second": found[faster],
        "batch_single_mujoco_ratio": found[MANY, "single"] / found[faster],
        "batch_mujoco_ratio": found[MANY, "double"] / found[faster],
        "batch_mujoco_way": f"{faster} of {mujoco_version}",
    }


MEANING = {
    "batch_arm_cycles_per_second": (
        f"{MANY} arms with the paper's law, a control cycle a call, in single precision; aim 3e6 (AVX2 1.5e6)"
    ),
    "batch_double_arm_cycles_per_second": "the same in double precision",
    "batch_64_arm_cycles_per_second": f"{FEW} arms in single precision; aim: a third of that of {MANY}",
    "batch_mujoco_arm_cycles_per_second": "MuJoCo, the bodies of the same arm alone, in steps of 0.25 ms",
    "batch_single_mujoco_ratio": "ours over MuJoCo's in single precision; aim 100",
    "batch_mujoco_ratio": "ours over MuJoCo's in double precision; aim 50",
    "batch_mujoco_way": "the faster way of MuJoCo, and its version",
}

if __name__ == "__main__":
    for name, figure in measure(load(sys.argv[1] if len(sys.argv) > 1 else "paper-arm")).items():
        sys.stdout.write(f"{name}: {figure if isinstance(figure, str) else f'{figure:.4g}'}\n")
