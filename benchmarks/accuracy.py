"""Work against accuracy: seconds of an arm that a core simulates in a second, over how far angles are off then.

Run by itself (`python -m benchmarks.accuracy MACHINE`) it prints that for every step, draws it (`--out`), and says
which metrics in closed loop a longer step changes.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console
from rich.table import Table
from scipy.stats import ks_2samp

from benchmarks import mujoco_arm, scipy_plant
from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.machine import Machine, load
from layflat.plot.style import HEAD_ROOM, SERIES_STYLES, draw_mark, save_figure, styled_figure
from layflat.sim import Scenario
from layflat.sim.ensemble import ensemble

SECONDS = 4.0
PARTS = 2, 3, 4, 5, 6, 8, 10, 13, 20, 40  # steps in a control cycle
FINEST, FINE = 320, 80  # steps in a cycle of what all are compared with, without controllers and with
GOOD, LEAST = 0.01, 1e-5  # deg rms: the error that methods are compared at, and the least that is drawn
METRICS = "settling", "steady_error", "overshoot", "ripple", "air_used"
TOLERANCES, SHORT = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7), 1.0  # of SciPy, and how long it simulates, s
BODIES = "Euler", "implicitfast", "RK4"  # MuJoCo's integrators
SWAYS = 0.25, 0.8  # how long a valve is opened, s, and how far
SWING = 0.1  # torque that bodies alone swing by, N m


class Point(NamedTuple):
    """What a step costs: its length (s) or tolerance, error of the angles (deg rms), arm-seconds per core-second."""

    step: float
    error: float
    speed: float


def sways(machine: Machine, lasting: float, most: float) -> Scenario:
    """Valves driven by hand, to and fro: openings up to `most` either way, each for so many seconds."""
    n = round(SECONDS / lasting)
    openings = np.random.default_rng(3).uniform(-most, most, (n, len(machine.joints)))
    openings[1::2] = 0.1 * openings[1::2] - openings[: n - n % 2 : 2]
    return Scenario(
        opening=[(lasting * k, tuple(own)) for k, own in enumerate(openings.tolist())], duration=SECONDS, noise=False
    )


def differing(machine: Machine, runs: int) -> dict[str, Array]:
    """Payloads of 0 to 1 kg, and pressures that differ by 10 % either way."""
    payloads, factors = np.random.default_rng(4).uniform(0.0, 1.0, (2, runs))
    pressure = value_at(machine, "supply.pressure_gauge")
    return {"scenario.payload": payloads, "supply.pressure_gauge": pressure * (0.9 + 0.2 * factors)}


def ours(machine: Machine, scenario: Scenario, precision: str, runs: int = 512) -> list[Point]:
    """Of every step, without controllers."""

    def simulate(parts: int, precision: str) -> tuple[Array, float]:
        begin = time.perf_counter()
        found = ensemble(
            machine, scenario, differing(machine, runs), threads=1, traces=("angle",),
            step=machine.cycle / parts, precision=precision,
        )  # fmt: skip
        return found["angle"].to_numpy(), SECONDS * runs / (time.perf_counter() - begin)

    exact, _ = simulate(FINEST, "double")
    simulate(PARTS[0], precision)
    found = []
    for parts in PARTS:
        speeds = [simulate(parts, precision) for _ in range(3)]
        found.append(
            Point(machine.cycle / parts, off_by(speeds[0][0], exact), float(np.median([s for _, s in speeds])))
        )
    return found


def off_by(angles: Array, exact: Array) -> float:
    """Error of angles (rad), deg rms."""
    return float(np.degrees(np.sqrt(np.mean((angles - exact) ** 2))))


def of_bodies(machine: Machine, integrator: str, runs: int = 8) -> list[Point]:
    """Of MuJoCo, the arm alone without friction, swung by torques that are constant in a control cycle."""
    mujoco: Any = mujoco_arm.mujoco
    model, data = mujoco_arm.build(machine)
    cycles = round(SECONDS / machine.cycle)
    swing = np.sin(np.arange(1, model.nu + 1) * 2 * np.pi * machine.cycle * np.arange(cycles)[:, None])

    def simulate(parts: int, method: str) -> tuple[Array, float]:
        model.opt.timestep = machine.cycle / parts
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{method.upper()}")
        controls = np.broadcast_to(np.repeat(SWING * swing, parts, axis=0), (runs, cycles * parts, model.nu)).copy()
        begin = time.perf_counter()
        states, _ = mujoco_arm.batched.rollout(model, [data], np.zeros((runs, 1 + model.nq + model.nv)), controls)
        speed = SECONDS * runs / (time.perf_counter() - begin)
        return states[0, parts - 1 :: parts, 1 : 1 + model.nq], speed

    exact, _ = simulate(FINEST, "RK4")
    found = {parts: simulate(parts, integrator) for parts in PARTS}
    return [Point(machine.cycle / parts, off_by(angles, exact), speed) for parts, (angles, speed) in found.items()]


def of_scipy(machine: Machine) -> list[Point]:
    """Of SciPy's LSODA, the whole plant with what is dry smoothed and valves opened a little; errors at the end."""
    joints = len(machine.joints)

    def angles(tolerance: float) -> Array:
        return scipy_plant.run(machine, SHORT, tolerance).reshape(joints, -1)[:, 0]

    angles(TOLERANCES[0])
    exact, found = angles(1e-9), []
    for tolerance in TOLERANCES:
        begin = time.perf_counter()
        reached = angles(tolerance)
        found.append(Point(tolerance, off_by(reached, exact), SHORT / (time.perf_counter() - begin)))
    return found


def best(points: Sequence[Point]) -> float:
    """Arm-seconds per core-second where angles are within `GOOD`; zero if they never are."""
    return max((point.speed for point in points if point.error <= GOOD), default=0.0)


def measure(machine: Machine) -> dict[str, float]:
    """All figures by name."""
    swaying = sways(machine, *SWAYS)
    return {
        "arm_seconds_per_core_second": best(ours(machine, swaying, "double")),
        "arm_seconds_per_core_second_single": best(ours(machine, swaying, "single")),
    }


MEANING = {
    "arm_seconds_per_core_second": f"simulated at the longest step within {GOOD:g} deg rms; aim 12 000",
    "arm_seconds_per_core_second_single": "the same in single precision; aim 25 000",
}


def draw(curves: dict[str, list[Point]], title: str) -> Figure:
    """Speed over error, a curve for each way to simulate."""
    with styled_figure(width=6.4, height=4.2, above=2 * HEAD_ROOM) as (made, (axes,)):
        for (name, points), style, marker in zip(curves.items(), SERIES_STYLES, "os^vDx", strict=False):
            errors, speeds = [max(point.error, LEAST) for point in points], [point.speed for point in points]
            axes.loglog(errors, speeds, **style, marker=marker, ms=4, label=name)
        draw_mark(axes, GOOD, f"{GOOD:g} degrees", upright=True)
        axes.set_xlim(LEAST, 1.0)
        axes.set_xlabel(f"Error of the angles over {SECONDS:g} s (degrees rms; on the left edge: {LEAST:g} or less)")
        axes.set_ylabel("Arm-seconds per core-second")
        axes.set_title(title, y=1.16, fontsize=10)
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, fontsize=8)
    return made


def in_closed_loop(machine: Machine, runs: int = 4000) -> Table:
    """How far distributions of metrics are from those of fine steps: the largest distance of the shares up to a value.

    Two sets of runs of the same distribution come that far apart by chance: 3 % in one case of twenty (Kolmogorov and
    Smirnov), here the largest of all joints and moves.
    """
    n = len(machine.joints)
    moves = Scenario(demand=[(0.0, (-0.2,) * n), (0.3, (0.2,) * n), (1.5, (-0.1,) * n)], duration="2.5 s")
    vary = {**differing(machine, runs), "seed": np.arange(runs)}

    def metrics(parts: int) -> dict[str, Array]:
        found = ensemble(machine, moves, vary, step=machine.cycle / parts)
        return {name: found[name].fillna(np.inf).to_numpy().reshape(runs, -1).T for name in METRICS}

    table = Table("step, in closed loop", *METRICS, header_style="bold", show_edge=False)
    exact = metrics(FINE)
    for parts in (*PARTS, FINE - 1):
        found = metrics(parts)
        apart = [
            max(ks_2samp(one, other).statistic for one, other in zip(found[name], exact[name], strict=True))
            for name in METRICS
        ]
        table.add_row(f"{1e3 * machine.cycle / parts:.3g} ms", *(f"{100.0 * share:.1f} %" for share in apart))
    return table


def main() -> None:
    """Measure, print, draw."""
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("machine", nargs="?", default="paper-arm")
    arguments.add_argument("--out", type=Path, default=Path("build/accuracy.png"))
    arguments.add_argument("--sways", nargs=2, type=float, default=SWAYS, metavar=("SECONDS", "OPENING"))
    given = arguments.parse_args()
    machine, console = load(given.machine), Console(width=100)
    swaying = sways(machine, *given.sways)
    curves = {f"layflat, {precision}": ours(machine, swaying, precision) for precision in ("double", "single")}
    curves |= {f"MuJoCo {name}, bodies alone": of_bodies(machine, name) for name in BODIES}
    if given.machine == "paper-arm":
        curves["SciPy LSODA"] = of_scipy(machine)
    for name, points in curves.items():
        table = Table(name, "deg rms", "arm-s per core-s", header_style="bold", show_edge=False)
        for point in points:
            step = f"{point.step:g}" if name.startswith("SciPy") else f"{1e3 * point.step:.3g} ms"
            table.add_row(step, f"{point.error:.2g}", f"{point.speed:.0f}")
        console.print(table)
    console.print(in_closed_loop(machine))
    given.out.parent.mkdir(parents=True, exist_ok=True)
    sys.stdout.write(f"{save_figure(draw(curves, given.machine), given.out)}\n")


if __name__ == "__main__":
    main()
