"""Many arms at once: the ensemble against MuJoCo's batched rollout, its scaling, and its memory.

Run by itself (`python -m benchmarks.many RUNS`) it prints the peak memory of so many runs of 4 s, MiB.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import time
from contextlib import suppress
from typing import Any

import numpy as np

from benchmarks import mujoco_arm, warp_arm
from benchmarks.timing import STEP
from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.machine import Machine, load
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

SECONDS = 4.0
STEPS = round(SECONDS / STEP)
MOVES = Scenario(demand=[(0.0, (-0.35, -0.35)), (0.5, (0.35, -0.35)), (2.0, (0.35, 0.35))], duration=SECONDS)
SWAYS = Scenario(
    opening=[(0.0, (0.3, -0.2)), (1.0, (-0.4, 0.3)), (2.0, (0.1, 0.1)), (3.0, (-0.1, -0.1))],
    duration=SECONDS,
    noise=False,
)
SPREAD = (
    "valve.conductance",
    "valve.friction",
    "valve.natural_frequency",
    "supply.pressure_gauge",
    "arm.payload",
    "joint.large.gains.close.error",
    "joint.small.gains.close.error",
    "joint.large.brake.torque",
    "joint.small.brake.torque",
    "joint.large.losses.deflections.1",
    "joint.small.losses.deflections.1",
    "joint.small.hose.dead_volume",
)
"""What differs from run to run, by 10 % either way."""


def vary(machine: Machine, runs: int) -> dict[str, Any]:
    """Machines and seeds, all different."""
    factors = np.random.default_rng(1).uniform(0.9, 1.1, (len(SPREAD), runs))
    return {
        "seed": np.arange(runs),
        **{path: value_at(machine, path) * own for path, own in zip(SPREAD, factors, strict=True)},
    }


def seconds(machine: Machine, runs: int, threads: int, **options: Any) -> float:
    """Time of so many runs of 4 s, s."""
    begin = time.perf_counter()
    ensemble(machine, MOVES, vary(machine, runs), threads=threads, step=STEP, **options)
    return time.perf_counter() - begin


def angle_error(machine: Machine, runs: int) -> float:
    """How far angles in single precision are from those in double precision, without controllers, deg rms."""
    varied = {path: values for path, values in vary(machine, runs).items() if path != "seed"}
    double, single = (
        ensemble(machine, SWAYS, varied, precision=precision, traces=("angle",))["angle"].to_numpy()
        for precision in ("double", "single")
    )
    return float(np.degrees(np.sqrt(np.mean((single - double) ** 2))))


def on_device(machine: Machine) -> dict[str, float]:
    """Figures of the CUDA device, beside MuJoCo Warp's where that is installed."""
    found = {}
    for key, precision in (("", "double"), ("single_", "single")):
        seconds(machine, 64, 1, device="cuda", precision=precision)
        taken = seconds(machine, 100_000, 1, device="cuda", precision=precision)
        found[f"ensemble_100000_runs_on_gpu_{key}ns_per_step"] = 1e9 * taken / (1e5 * STEPS)
    with suppress(ImportError):
        found["mujoco_warp_ns_per_step"] = 1e9 * warp_arm.seconds_per_step(machine, 262_144, 200)
    return found


def measure(machine: Machine) -> dict[str, float]:
    """All figures by name."""
    cores = os.cpu_count() or 1
    for precision in ("double", "single"):
        seconds(machine, 64, 1, precision=precision)
    # Turn and turn about, so that a busy moment of the machine meets all.
    rounds = [
        (
            seconds(machine, 512, 1) / (512 * STEPS),
            seconds(machine, 512, 1, precision="single") / (512 * STEPS),
            mujoco_arm.batched_seconds(machine, 8, 4000) / (8 * 4000),
        )
        for _ in range(5)
    ]
    double, single, theirs = (float(np.median(each)) for each in zip(*rounds, strict=True))
    found = {
        "ensemble_ns_per_step_per_core": 1e9 * double,
        "ensemble_single_ns_per_step_per_core": 1e9 * single,
        "single_precision_angle_error_deg": angle_error(machine, 512),
        "mujoco_rollout_ns_per_step_per_core": 1e9 * theirs,
        "ensemble_mujoco_ratio": theirs / double,
        "ensemble_single_mujoco_ratio": theirs / single,
        "ensemble_speedup_over_threads": seconds(machine, 2048, 1) / seconds(machine, 2048, cores),
    }
    for runs in (100, 10_000, 100_000):
        found[f"ensemble_{runs}_runs_ns_per_step_per_core"] = (
            1e9 * cores * seconds(machine, runs, cores) / (runs * STEPS)
        )
    with suppress(InputError):  # no CUDA device
        found |= on_device(machine)
    peak = subprocess.run(
        [sys.executable, "-m", "benchmarks.many", "100000"], capture_output=True, check=True, text=True
    )
    return {**found, "ensemble_100000_runs_peak_mib": float(peak.stdout)}


if __name__ == "__main__":
    arm = load("paper-arm")
    seconds(arm, int(sys.argv[1]), os.cpu_count() or 1)
    sys.stdout.write(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f}\n")
