"""Random machines, identified from logs that they are simulated to give: how often the truth lies within the intervals.

python -m benchmarks.identification [--machine paper-arm] [--count 40] [--first 0] [--seed 0] [--out FILE]
python -m benchmarks.identification --arms [--count 5] [--loaded]
    another random arm of four joints each time, logged with its payload and without, or only with it

Every number that is fitted is drawn anew for each machine, around the description that the search begins with; sensors
are noisy and have 12 bits, of random arms 16.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.description.change import changed, changed_all
from layflat.design.arm import read_task
from layflat.design.arm.sizing import size_arm
from layflat.identify import Fit, Unknown, fit
from layflat.identify.benches.moving import ArmModel
from layflat.identify.benches.moving.blocks import machine_unknowns
from layflat.identify.benches.moving.bodies import feasible_columns
from layflat.identify.excite import plan_sequence
from layflat.machine import Machine, load
from layflat.sim import rollout

BLOCKS = ("valve", "hose", "losses", "friction", "inertia")
KEPT = {
    "voltage": "voltage",
    "measured_pressure": "measured_pressure",
    "measured_angle": "angle",
    "dither_share": "dither",
    "payload": "payload",
}

SPREAD = 0.25
"""Logarithms of the truth lie within this of the description's; other values within this share of what is searched."""

AGAIN = 1000  # what is added to the seed of a log's noise for the log after it
LINKS, LENGTHS, PAYLOADS, SUPPLIES = 4, (0.12, 0.35), (0.3, 1.0), (4.0, 6.0)  # of random arms, m, kg, bar


def random_arm(seed: int) -> Machine:
    """An arm of four joints whose axes and links point anywhere, sized for what it carries."""
    draw = np.random.default_rng(seed)
    joints = []
    for number in range(LINKS):
        axis = draw.standard_normal(3) if number else np.array([0.3, 0.3, 1.0]) * draw.standard_normal(3)
        way = np.cross(axis, draw.standard_normal(3)) + 0.3 * axis
        link = draw.uniform(*LENGTHS) * way / np.linalg.norm(way)
        joints.append({
            "name": f"joint_{number}",
            "axis": (axis / np.linalg.norm(axis)).tolist(),
            "link": [f"{one:.4f} m" for one in link],
        })  # fmt: skip
    payload, supply = f"{draw.uniform(*PAYLOADS):.2f} kg", f"{draw.uniform(*SUPPLIES):.2f} bar"
    return size_arm(
        read_task(None, name=f"random-{seed}", joint=joints, payload=payload, supply=supply, time="1 s")
    ).machine


def drawn(machine: Machine, sought: list[Unknown], random: np.random.Generator) -> tuple[Machine, dict[str, float]]:
    """A machine whose values are random, and these."""
    truth = {}
    for unknown in sought:
        away = random.uniform(-SPREAD, SPREAD)
        value = unknown.guess * np.exp(away) if unknown.log else unknown.guess + away * (unknown.high - unknown.low)
        truth[unknown.path] = float(np.clip(value, unknown.low, unknown.high))
    columns = feasible_columns(machine, {path: np.array([value]) for path, value in truth.items()})
    truth = {path: float(values[0]) for path, values in columns.items()}
    return changed_all(machine, truth), truth


def log_of(machine: Machine, base: Machine, followed: tuple[Array, Array], seed: int) -> xarray.Dataset:
    """Return a log of a machine that follows a bench sequence, controlled as the described one would be."""
    times, demand = followed
    duration = float(len(times) * (times[1] - times[0]))
    run = rollout(machine, demand, duration=duration, start=0.0, seed=seed, controller=base)
    return run[[name for name in KEPT if name in run]].rename({n: to for n, to in KEPT.items() if n in run and n != to})


def logs_of(machine: Machine, base: Machine, seed: int, *, bare: bool) -> dict[str, xarray.Dataset]:
    """Logs of a machine with its payload and, if it is to go `bare` too, of the same sequence without."""
    followed = plan_sequence(base)
    logs = {"loaded": log_of(machine, base, followed, seed)}
    if bare:
        unloaded, described = (changed(one, "arm.payload", 0.0) for one in (machine, base))
        logs["bare"] = log_of(unloaded, described, followed, seed + AGAIN)
    return logs


def validation(found: Fit, truth: dict[str, float]) -> list[dict[str, Any]]:
    """For every value: whether it is told, whether the truth lies within its interval, and the error."""
    return [
        {
            "path": path,
            "identified": bool(found.estimate(path).identified),
            "inside": bool(found.estimate(path).low <= value <= found.estimate(path).high),
            "error": abs(found.estimate(path).value - value) / abs(value) if value else 0.0,
        }
        for path, value in truth.items()
    ]


def _middle(told: list[dict[str, Any]]) -> float:
    """Median error of the values that are told; not a number where none is."""
    return float(np.median([value["error"] for value in told])) if told else np.nan


def _named(path: str) -> str:
    """Return the end of a path, without the joint before it."""
    first, *rest = path.split(".")
    return ".".join(rest[-2:]) if first in ("joint", "arm") else path


def main() -> None:
    """Identify them all, one after the other."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--machine", default="paper-arm")
    parser.add_argument("--arms", action="store_true", help="another random arm of four joints each time")
    parser.add_argument("--loaded", action="store_true", help="log these arms with their payload alone")
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--first", type=int, default=0, help="number of the first machine")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("build/identification.json"))
    given = parser.parse_args()
    rows: list[dict[str, Any]] = []
    for number in range(given.first, given.first + given.count):
        base = random_arm(number) if given.arms else load(given.machine)
        sought = machine_unknowns(base, BLOCKS)
        random = np.random.default_rng((given.seed, number))
        machine, truth = drawn(base, sought, random)
        logs = logs_of(machine, base, number, bare=given.arms and not given.loaded)
        begun = time.perf_counter()
        found = fit(ArmModel(base, logs, blocks=BLOCKS), seed=number)
        taken = time.perf_counter() - begun
        values = validation(found, truth)
        worst = max(quality.relative_rms for quality in found.qualities() if quality.validation)
        rows.append({"seconds": taken, "converged": found.converged, "judged_share": worst, "values": values})
        told = [value for value in values if value["identified"]]
        inside = sum(value["inside"] for value in told)
        error = _middle(told)
        print(
            f"{number}: {inside} of {len(told)} told inside ({len(values)} sought), median error {100 * error:.2f} %, "
            f"free run {100 * worst:.2f} % of range, {taken:.1f} s", flush=True,
        )  # fmt: skip
    told = [value for row in rows for value in row["values"] if value["identified"]]
    summary = {
        "machine": "arms of four joints" if given.arms else given.machine,
        "machines": given.count,
        "identified": len(told),
        "sought": sum(len(row["values"]) for row in rows),
        "inside": float(np.mean([value["inside"] for value in told])) if told else None,
        "median_error": _middle(told) if told else None,
        "seconds": float(np.median([row["seconds"] for row in rows])),
        "by_value": {
            name: float(np.mean([value["inside"] for value in told if _named(value["path"]) == name]))
            for name in dict.fromkeys(_named(value["path"]) for value in told)
        },
    }
    given.out.parent.mkdir(parents=True, exist_ok=True)
    given.out.write_text(json.dumps({"summary": summary, "machines": rows}, indent=1))
    print(json.dumps(summary, indent=1))


if __name__ == "__main__":
    main()
