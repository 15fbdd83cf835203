"""Statics: Table 1, torques, mass, and the constancy of torque and stiffness (section 2.2, Table 1, Fig. 6)."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.design import JointDesign, Table1, design_joint, table1
from layflat.experiments.bench import Bench, maximum_torque
from layflat.experiments.claim import Claim
from layflat.machine import Machine, changed, parameters
from layflat.sim import rollout
from layflat.sim.sweep import Loop, sweep

if TYPE_CHECKING:
    import xarray

PRINTED_MEAN = 82.10202
"""Mean torque of the printed Table 1, N m."""
MEASURED = {"large": 84.0, "small": 27.0}
"""Measured maximum torques at 4 bar, N m (section 4.1)."""
STIFFNESS_PRESSURES = (2e5, 3e5, 4e5, 5e5)
"""Absolute pressures in both hoses at which closed-valve stiffness is measured, Pa."""


@dataclass(frozen=True)
class Statics:
    """Table 1; loops at 4 bar; the large joint's design; and closed-valve stiffness (N m/rad) by pressure (Pa)."""

    table: Table1
    torque: dict[str, Loop]
    uncompensated: Loop
    design: JointDesign
    exact_mean: float
    mass: dict[str, float]
    stiffness: dict[float, float]
    squeeze: xarray.Dataset


@cache
def printed_table() -> dict[str, list[str]]:
    """The printed cells of Table 1, as text, by column (misprints corrected)."""
    text = (files("layflat.experiments") / "table1.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return {name: [row[name] for row in rows] for name in rows[0]}


def wrong_cells(table: Table1) -> list[str]:
    """Cells of Table 1 that do not round to the printed digits, as "column, row"."""
    wrong = []
    computed = table.columns()
    for name, cells in printed_table().items():
        for row, cell in enumerate(cells):
            digits = len(cell.partition(".")[2])
            if abs(round(float(computed[name][row]), digits) - float(cell)) > 0.5 * 10.0**-digits:
                wrong.append(f"{name}, row {row + 1}")
    return wrong


def perform(bench: Bench) -> Statics:
    """Compute the table and the design, sweep both joints at supply pressure, squeeze the large one's closed hoses."""
    at = bench.arm.supply.pressure_gauge
    design = design_joint(bench.arm, "large")
    roller = changed(bench.arm, "joint.large.output.kind", "roller")
    runs = {p: squeeze(bench.arm, p) for p in STIFFNESS_PRESSURES}
    return Statics(
        table1(),
        {name: sweep(bench.arm, name, at, brake=bench.brake) for name in ("large", "small")},
        sweep(roller, "large", at, brake=bench.brake),
        design,
        parameters.travel_volume(bench.arm.joint["large"]) / parameters.full_travel(bench.arm.joint["large"]) * at,
        {name: bench.arm.joint[name].body.mass for name in ("large", "small")},
        {p: stiffness(run) for p, run in runs.items()},
        runs[STIFFNESS_PRESSURES[-1]],
    )


def squeeze(arm: Machine, pressure: float) -> xarray.Dataset:
    """Push the large joint slowly to and fro with a fiftieth of its torque, its valve closed and tight."""
    tight = changed(changed(arm, "valve.leakage", 0.0), "valve.dither.amplitude", 0.0)
    alone = changed(changed(tight, "arm.joints", ("large",)), "arm.payload", 0.5)
    push = 0.02 * maximum_torque(arm, "large")

    def load(t: float) -> float:
        return push * float(np.sin(2 * np.pi * t / 20.0))

    return rollout(
        alone, opening=0.0, load=load, brake=0.0, duration=40.0, pressures=(pressure, pressure), noise=False, step=5e-4
    )


def stiffness(run: xarray.Dataset) -> float:
    """Slope of the air's torque against angle over the last period, N m/rad."""
    last = run.sel(time=slice(20.0, None))
    angle = last["angle"].to_numpy()[:, 0]
    torque = _gas_torque(last)
    return -float(np.polyfit(angle, torque, 1)[0])


def _gas_torque(run: xarray.Dataset) -> NDArray[np.float64]:
    machine = Machine.model_validate_json(run.attrs["machine"])
    K = parameters.torque_constant(machine.joint["large"])
    return np.asarray(K * (run["pressure_a"] - run["pressure_b"]).to_numpy()[:, 0])


def claims(found: Statics) -> list[Claim]:
    """What the paper says of torque and mass."""
    return [
        _table(found),
        _mean(found),
        _torque(found, "large", "85 N m by design, 84 N m measured, at 4 bar", 5.0),
        _torque(found, "small", "25 N m by design, 27 N m measured, at 4 bar", 8.0),
        _torque_per_mass(found),
        _constant(found),
    ]


def _table(found: Statics) -> Claim:
    wrong = wrong_cells(found.table)
    cells = sum(len(column) for column in printed_table().values())
    return Claim(
        "table-1",
        "Table 1",
        "11 rows of intermediate values, torque, work, move, force, cam radius and cam angle",
        float(cells - len(wrong)),
        f"of {cells} cells round to the printed digits",
        not wrong,
        "every cell, with the table's own constants",
    )


def _mean(found: Statics) -> Claim:
    crude, exact = found.table.mean_torque, found.exact_mean
    return Claim(
        "mean-torque",
        "Table 1",
        "82.10202 N m at 4 bar after cam compensation",
        {"as the table": crude, "exact": exact},
        "N m",
        round(crude, 5) == PRINTED_MEAN and abs(exact / PRINTED_MEAN - 1.0) <= 0.005,
        "rounds to it with the table's constants; within 0.5 % by exact integration",
    )


def _torque(found: Statics, name: str, says: str, percent: float) -> Claim:
    top = found.torque[name].maximum_torque
    return Claim(
        f"{name}-joint-torque",
        "2.3, 4.1",
        says,
        top,
        "N m",
        abs(top / MEASURED[name] - 1.0) <= percent / 100.0,
        f"within {percent:g} % of {MEASURED[name]:g} N m",
    )


def _torque_per_mass(found: Statics) -> Claim:
    each = {name: found.torque[name].maximum_torque / found.mass[name] / 4.0 for name in found.mass}
    mean = float(np.mean(list(each.values())))
    return Claim(
        "torque-per-mass",
        "5",
        "3.5 N m/kg per bar",
        {**each, "mean": mean},
        "N m/kg per bar",
        abs(mean / 3.5 - 1.0) <= 0.1,
        "mean of both joints within 10 %",
    )


def _slope(loop: Loop) -> float:
    """Greatest change of torque per radian that geometry causes, N m/rad."""
    half = len(loop.angle) // 2
    return float(np.max(np.abs(np.gradient(loop.lossless[:half], loop.angle[:half]))))


def cam_torque(design: JointDesign) -> NDArray[np.float64]:
    """Torque of a cam over its stroke, N m: Eq. (1)'s force through the strap, times the lever that the profile has."""
    cam = design.with_cam()
    normals = np.stack([np.cos(cam.normal), np.sin(cam.normal)])
    lever = np.max(cam.profile @ normals, axis=0)
    return np.asarray(design.characteristic.force * design.pressure / cam.alignment * lever)


def _constant(found: Statics) -> Claim:
    cam = cam_torque(found.design)
    spread = 100.0 * float(np.ptp(cam) / np.mean(cam))
    bare = found.uncompensated.lossless
    geometric = 100.0 * _slope(found.torque["large"]) / _slope(found.uncompensated)
    per_pressure = np.array([k / p for p, k in found.stiffness.items()])
    follows = 100.0 * float(np.ptp(per_pressure) / np.mean(per_pressure))
    return Claim(
        "constant-torque",
        "2.2",
        "with the cam torque does not vary over the stroke; stiffness does not vary with position, only with pressure",
        {
            "torque varies with cam (%)": spread,
            "left at the end without cam (%)": 100.0 * float(bare.min() / bare.max()),
            "stiffness of geometry, of that without cam (%)": geometric,
            "closed-valve stiffness per pressure varies (%)": follows,
        },
        "as named",
        spread <= 1.0 and geometric < 2.0 and follows <= 10.0,
        "torque within 1 % over 120 deg; geometric stiffness below 2 %; stiffness follows pressure within 10 %",
    )
