"""Arms in space: the cost of a step of four and of seven joints, alone and in an ensemble, and of compiling them.

Run by itself (`python -m benchmarks.chains paper`, or `tracking`) it prints how long a first rollout takes, s.
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
from copy import deepcopy
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from benchmarks import mujoco_arm
from benchmarks.timing import STEP, median_seconds
from layflat.description.change import value_at
from layflat.machine import Machine, load
from layflat.machine.loader import tables
from layflat.machine.model import build
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble
from layflat.sim.run import prepare_run

SECONDS = 4.0
STEPS = round(SECONDS / STEP)
PAPER = "paper-arm-fast"  # whose law and gains these arms have: they cost what they do whatever comes of them
SPREAD = "valve.conductance", "valve.friction", "supply.pressure_gauge", "arm.payload"
"""What differs from run to run, by 10 % either way."""


def four() -> Machine:
    """The built-in picking arm with the paper's control law."""
    plain, sources = tables("picking-arm")
    base, of_base = tables(PAPER)
    joints = {name: {**joint, "gains": base["joint"]["small"]["gains"]} for name, joint in plain["joint"].items()}
    changed = {**plain, "controller": {**base["controller"], "load_compensation": True}, "joint": joints}
    return build(changed, {**of_base, **sources}, "picking-arm-paper")


def seven() -> Machine:
    """Seven of the paper's small joints, axes in turn upright and level."""
    plain, sources = tables("paper-small-joint-fast")
    names = [f"joint-{i}" for i in range(1, 8)]
    links = {
        name: {
            "axis": [0.0, 0.0, 1.0] if i % 2 == 0 else [0.0, -1.0, 0.0],
            "position": ["0 m", "0 m", "0 m" if i == 0 else "0.15 m"],
            "mass": "0.2 kg",
            "centre": ["0 m", "0 m", "0.075 m"],
            "inertia": ["0.0004 kg m^2", "0.0004 kg m^2", "0.0001 kg m^2"],
            "rotor_inertia": "0.001 kg m^2",
        }
        for i, name in enumerate(names)
    }
    arm = {
        "kind": "chain",
        "joints": names,
        "link": links,
        "tool": ["0 m", "0 m", "0.15 m"],
        "gravity": ["0 m/s^2", "0 m/s^2", "-9.81 m/s^2"],
        "payload": "0.3 kg",
        "bodies": "in links",
    }
    joints = {name: deepcopy(plain["joint"]["small"]) for name in names}
    return build({**plain, "arm": arm, "joint": joints}, sources, "seven")


def moves(machine: Machine) -> Scenario:
    """All joints, to and fro."""
    n = len(machine.joints)
    return Scenario(demand=[(0.0, (-0.2,) * n), (0.5, (0.2,) * n), (2.0, (-0.1,) * n)], duration=SECONDS)


def step_seconds(machine: Machine) -> float:
    """Time of a step of 0.25 ms in a rollout, s."""
    return median_seconds(prepare_run(machine, moves(machine), step=STEP).run) / STEPS


def ensemble_seconds(machine: Machine, runs: int, precision: str = "double") -> float:
    """Time of a step of a run among others, all different, on one core, s."""
    factors = np.random.default_rng(1).uniform(0.9, 1.1, (len(SPREAD), runs))
    vary: dict[str, Any] = {path: value_at(machine, path) * own for path, own in zip(SPREAD, factors, strict=True)}
    begin = time.perf_counter()
    ensemble(machine, moves(machine), {"seed": np.arange(runs), **vary}, threads=1, step=STEP, precision=precision)
    return (time.perf_counter() - begin) / (runs * STEPS)


def cold_seconds(name: str) -> float:
    """Time of the first rollout of an arm where nothing was compiled before, s, all but Python's own start."""
    with TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "benchmarks.chains", name]
        environment = {**os.environ, "LAYFLAT_CACHE_DIR": folder}
        return float(subprocess.run(command, env=environment, capture_output=True, check=True, text=True).stdout)


def measure() -> dict[str, float]:
    """All figures by name."""
    arm = four()
    for precision in ("double", "single"):
        ensemble_seconds(arm, 64, precision)
    # Turn and turn about, so that a busy moment of the machine meets all.
    rounds = [
        (
            ensemble_seconds(arm, 256),
            ensemble_seconds(arm, 256, "single"),
            mujoco_arm.batched_seconds(arm, 8, 4000) / (8 * 4000),
        )
        for _ in range(5)
    ]
    ours, single, theirs = (float(np.median(each)) for each in zip(*rounds, strict=True))
    return {
        "chain4_rollout_ns_per_step": 1e9 * step_seconds(arm),
        "chain4_tracking_rollout_ns_per_step": 1e9 * step_seconds(load("picking-arm")),
        "chain7_rollout_ns_per_step": 1e9 * step_seconds(seven()),
        "chain4_ensemble_ns_per_step_per_core": 1e9 * ours,
        "chain4_ensemble_single_ns_per_step_per_core": 1e9 * single,
        "chain4_mujoco_rollout_ns_per_step_per_core": 1e9 * theirs,
        "chain4_ensemble_mujoco_ratio": theirs / ours,
        "chain4_ensemble_single_mujoco_ratio": theirs / single,
        "chain4_cold_compile_s": cold_seconds("paper"),
        "chain4_tracking_cold_compile_s": cold_seconds("tracking"),
    }


MEANING = {
    "chain4_rollout_ns_per_step": "four joints in space with the paper's law, sensors and records, per step; aim 250",
    "chain4_tracking_rollout_ns_per_step": "the same with the tracking law",
    "chain7_rollout_ns_per_step": "seven joints in space with the paper's law; aim 600",
    "chain4_ensemble_ns_per_step_per_core": "four joints, each run with its own parameters",
    "chain4_ensemble_single_ns_per_step_per_core": "the same in single precision",
    "chain4_mujoco_rollout_ns_per_step_per_core": "mujoco.rollout, the bodies of the same arm alone, per step",
    "chain4_ensemble_mujoco_ratio": "mujoco.rollout's step over ours, both in double precision; aim 40",
    "chain4_ensemble_single_mujoco_ratio": "mujoco.rollout's step over ours in single precision; aim 40",
    "chain4_cold_compile_s": "the first rollout of four joints with nothing compiled; aim 20",
    "chain4_tracking_cold_compile_s": "the same with the tracking law; aim 20",
}


if __name__ == "__main__":
    machine = {"paper": four, "tracking": lambda: load("picking-arm")}[sys.argv[1]]()
    begun = time.perf_counter()
    prepare_run(machine, moves(machine)).run()
    sys.stdout.write(f"{time.perf_counter() - begun:.1f}\n")
