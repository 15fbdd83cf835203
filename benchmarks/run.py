"""Measure speed in one run: `make bench`. Ratios within a run are worth more than seconds on somebody's machine."""

from __future__ import annotations

import argparse
import json
import os
import platform
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from benchmarks import accuracy, cell, chains, environments, many, mujoco_arm, rig_loop, scipy_plant, stepped
from benchmarks.timing import STEP, median_seconds
from layflat.experiments.controller import TIMED_CYCLES
from layflat.experiments.kernels import control_cycles
from layflat.files import whole_file
from layflat.machine import load, parameters
from layflat.sim import Scenario
from layflat.sim.run import prepare_run

SECONDS = 4.0
SCIPY_SECONDS = 0.2


def measure() -> dict[str, float | str]:
    """All figures by name."""
    machine = load("paper-arm")
    moves = Scenario(demand=[(0.0, (-0.35, -0.35)), (0.5, (0.35, -0.35)), (2.0, (0.35, 0.35))], duration=SECONDS)
    steps = round(SECONDS / STEP)
    rollout = median_seconds(prepare_run(machine, moves, step=STEP).run) / steps

    arm = mujoco_arm.build(machine)
    mujoco = median_seconds(lambda: mujoco_arm.run(arm, 4000)) / 4000
    braked_arm = mujoco_arm.build(machine, brakes=True)
    mujoco_braked = median_seconds(lambda: mujoco_arm.run(braked_arm, 4000)) / 4000

    scipy_seconds = median_seconds(lambda: scipy_plant.run(machine, SCIPY_SECONDS), rounds=3) / SCIPY_SECONDS

    settings = parameters.control(machine)
    noise = np.random.default_rng(5).standard_normal((3, 256))
    samples = (0.1 * noise[0], 1e5 * noise[1], 0.5 * noise[2])
    control = control_cycles.bind(settings, *samples, TIMED_CYCLES, np.empty(1))
    controller = median_seconds(control) / TIMED_CYCLES
    return {
        "rollout_ns_per_step": 1e9 * rollout,
        "mujoco_arm_ns_per_step": 1e9 * mujoco,
        "mujoco_arm_with_brakes_ns_per_step": 1e9 * mujoco_braked,
        "mujoco_ratio": mujoco / rollout,
        "scipy_seconds_per_simulated_second": scipy_seconds,
        "scipy_ratio": scipy_seconds / (rollout / STEP),
        "controller_ns_per_cycle": 1e9 * controller,
        **many.measure(machine),
        **stepped.measure(machine),
        **environments.measure(),
        **accuracy.measure(machine),
        **chains.measure(),
        **rig_loop.measure(),
        **cell.measure(),
        "processor": platform.processor() or platform.machine(),
        "cores": float(os.cpu_count() or 1),
    }


MEANING = {
    "rollout_ns_per_step": "whole two-axis plant with controller, sensors and records, per step of 0.25 ms",
    "mujoco_arm_ns_per_step": "MuJoCo, the same arm alone without friction, per step",
    "mujoco_arm_with_brakes_ns_per_step": "MuJoCo, the same arm with joint friction, per step",
    "mujoco_ratio": "MuJoCo's step (without friction) over ours; aim 15",
    "scipy_seconds_per_simulated_second": "SciPy's LSODA on the same plant, its laws compiled",
    "scipy_ratio": "SciPy's time over ours; aim 100",
    "controller_ns_per_cycle": "the controllers of both axes, per cycle; aim 1000",
    "ensemble_ns_per_step_per_core": "the same plant, each run with its own parameters, per step; aim 45 (AVX-512 35)",
    "ensemble_single_ns_per_step_per_core": "the same in single precision; aim 30 (AVX-512 20)",
    "single_precision_angle_error_deg": "angles in single less those in double precision, no controllers, deg rms",
    "mujoco_rollout_ns_per_step_per_core": "mujoco.rollout, the arm alone, per step",
    "ensemble_mujoco_ratio": "mujoco.rollout's step over ours, both in double precision; aim 100",
    "ensemble_single_mujoco_ratio": "mujoco.rollout's step over ours in single precision; aim 100",
    "ensemble_speedup_over_threads": "2048 runs of 4 s: one thread over one thread a core",
    "ensemble_100_runs_ns_per_step_per_core": "on all cores, 100 runs of 4 s",
    "ensemble_10000_runs_ns_per_step_per_core": "10 000 runs",
    "ensemble_100000_runs_ns_per_step_per_core": "100 000 runs",
    "ensemble_100000_runs_on_gpu_ns_per_step": "100 000 runs on the CUDA device, where there is one",
    "ensemble_100000_runs_on_gpu_single_ns_per_step": "the same in single precision",
    "mujoco_warp_ns_per_step": "MuJoCo Warp on that device, where installed, the arm alone, per step",
    "ensemble_100000_runs_peak_mib": "peak memory of 100 000 runs, MiB; aim 1024",
    **stepped.MEANING,
    **environments.MEANING,
    **accuracy.MEANING,
    **chains.MEANING,
    **rig_loop.MEANING,
    **cell.MEANING,
}


def main() -> None:
    """Measure, print, write."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--out", type=Path, default=Path("build/bench.json"))
    out = arguments.parse_args().out
    found = measure()
    table = Table("figure", "value", "what it is", header_style="bold", show_edge=False)
    for name, meaning in MEANING.items():
        if name in found:
            figure = found[name]
            table.add_row(name, figure if isinstance(figure, str) else f"{figure:.4g}", meaning)
    Console(width=100).print(table)
    with whole_file(out) as temporary:
        temporary.write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
