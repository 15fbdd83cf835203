"""Statics: Table 1, torques, mass, and the constancy of torque and stiffness (section 2.2, Fig. 6)."""

import csv
from functools import cache, cached_property
from importlib.resources import files

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.design import JointDesign, Table1, design_joint, table1
from layflat.experiments.bench import isolate_joint, maximum_torque
from layflat.experiments.claim import ClaimQuantity, Evaluation, Experiment, claim
from layflat.machine import Machine, changed, parameters
from layflat.machine.model import restore
from layflat.motion.scenario import Scenario
from layflat.sim import rollout
from layflat.sim.sweep import HysteresisLoop

PRINTED_MEAN_TORQUE = 82.10202  # mean torque of the printed Table 1, N m
MEASURED_TORQUES = {"large": 84.0, "small": 27.0}  # measured maximum torques at 4 bar, N m (section 4.1)
STIFFNESS_PRESSURES = (2e5, 3e5, 4e5, 5e5)
"""Absolute pressures in both hoses at which closed-valve stiffness is measured, Pa."""


@cache
def printed_table() -> dict[str, list[str]]:
    """Return the printed cells of Table 1, as text, by column (misprints corrected)."""
    text = (files("layflat.experiments") / "table1.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return {name: [row[name] for row in rows] for name in rows[0]}


def wrong_cells(table: Table1) -> list[str]:
    """Return the cells of Table 1 that do not round to the printed digits, as "column, row"."""
    wrong = []
    computed = table.columns
    for name, cells in printed_table().items():
        for row, cell in enumerate(cells):
            digits = len(cell.partition(".")[2])
            if abs(round(float(computed[name][row]), digits) - float(cell)) > 0.5 * 10.0**-digits:
                wrong.append(f"{name}, row {row + 1}")
    return wrong


def simulate_closed_valve(arm: Machine, pressure: float) -> xarray.Dataset:
    """Simulate a slow sinusoidal load on the large joint, a fiftieth of its torque, with its valve closed and tight.

    Args:
        arm: machine that has the joint.
        pressure: pressure in both hoses at first, absolute, Pa.
    """
    tight = changed(changed(arm, "valve.leakage", 0.0), "valve.dither.amplitude", 0.0)
    push = 0.02 * maximum_torque(arm, "large")

    def load(t: float) -> float:
        return push * float(np.sin(2 * np.pi * t / 20.0))

    filled = (pressure, pressure)
    closed = Scenario(opening=0.0, load=load, brake=0.0, duration=40.0, pressures=filled, noise=False)
    return rollout(isolate_joint(tight, "large", 0.5), scenario=closed, step=5e-4)


def air_stiffness(run: xarray.Dataset) -> float:
    """Return the stiffness of the large joint's air, N m/rad: minus the slope of its torque in the last period."""
    last = run.sel(time=slice(20.0, None))
    K = parameters.torque_constant(restore(run.attrs["machine"]).joint["large"])
    torque = K * (last["pressure_a"] - last["pressure_b"]).to_numpy()[:, 0]
    return -float(np.polyfit(last["angle"].to_numpy()[:, 0], torque, 1)[0])


def cam_torque(design: JointDesign) -> Array:
    """Return the torque of a joint's cam over its stroke, N m: Eq. (1)'s force through the strap times the lever."""
    cam = design.with_cam()
    normals = np.stack([np.cos(cam.normal), np.sin(cam.normal)])
    lever = np.max(cam.profile @ normals, axis=0)
    return np.asarray(design.characteristic.force * design.pressure / cam.alignment * lever)


def _max_torque_slope(loop: HysteresisLoop) -> float:
    """Return the greatest slope of torque over angle that geometry causes, N m/rad."""
    half = len(loop.angle) // 2
    return float(np.max(np.abs(np.gradient(loop.lossless[:half], loop.angle[:half]))))


class StaticsExperiment(Experiment):
    """Table 1; hysteresis curves at supply pressure; the large joint's design; and closed-valve stiffness."""

    @cached_property
    def table(self) -> Table1:
        """Computed Table 1."""
        return table1()

    @cached_property
    def design(self) -> JointDesign:
        """Design of the large joint."""
        self.bench.joint("large")
        return design_joint(self.bench.arm, "large")

    @claim("table-1")
    def table_1(self) -> Evaluation:
        """Count the cells of the table that round to the printed digits."""
        wrong = wrong_cells(self.table)
        cells = sum(len(column) for column in printed_table().values())
        return [ClaimQuantity("cells as printed", float(cells - len(wrong)), paper=f"{cells}")], not wrong

    @claim("mean-torque")
    def mean_torque(self) -> Evaluation:
        """Compare the mean torque of the table, and of exact integration, with the printed one."""
        joint = self.bench.joint("large")
        mean = joint.geometry.even_stroke(joint.output.radius).k0
        tabulated, exact = self.table.mean_torque, mean * self.bench.arm.supply.pressure_gauge
        return [
            ClaimQuantity("as the table", tabulated, "N m", f"{PRINTED_MEAN_TORQUE}"),
            ClaimQuantity("exact", exact, "N m", f"{PRINTED_MEAN_TORQUE}"),
        ], round(tabulated, 5) == PRINTED_MEAN_TORQUE and abs(exact / PRINTED_MEAN_TORQUE - 1.0) <= 0.005

    def _torque(self, name: str, percent: float) -> Evaluation:
        """Return a joint's maximum torque (N m), and whether it is within some percent of the measured one."""
        maximum, measured = self.bench.curve(name, brake=self.bench.brake).maximum_torque, MEASURED_TORQUES[name]
        return [ClaimQuantity("maximum torque", maximum, "N m", f"{measured:g}")], abs(
            maximum / measured - 1.0
        ) <= percent / 100.0

    @claim("large-joint-torque")
    def large_joint_torque(self) -> Evaluation:
        """Compare the large joint's maximum torque with the measured one."""
        return self._torque("large", 5.0)

    @claim("small-joint-torque")
    def small_joint_torque(self) -> Evaluation:
        """Compare the small joint's maximum torque with the measured one."""
        return self._torque("small", 8.0)

    @claim("torque-per-mass")
    def torque_per_mass(self) -> Evaluation:
        """Compare torque per mass and pressure of both joints with the paper's."""
        curves = {name: self.bench.curve(name, brake=self.bench.brake) for name in MEASURED_TORQUES}
        bar = self.bench.arm.supply.pressure_gauge / 1e5
        ratios = {name: curve.maximum_torque / self.bench.joint(name).body.mass / bar for name, curve in curves.items()}
        mean = float(np.mean(list(ratios.values())))
        unit = "N m/(kg bar)"
        return [
            *(ClaimQuantity(name, value, unit) for name, value in ratios.items()),
            ClaimQuantity("mean", mean, unit, "3.5"),
        ], abs(mean / 3.5 - 1.0) <= 0.1

    @claim("constant-torque")
    def constant_torque(self) -> Evaluation:
        """Compare torque over the stroke, and stiffness over position and pressure."""
        over_stroke = cam_torque(self.design)
        torque_range = 100.0 * float(np.ptp(over_stroke) / np.mean(over_stroke))
        with_roller = changed(self.bench.arm, "joint.large.output.kind", "roller")
        cam, roller = (self.bench.curve("large", machine, brake=self.bench.brake) for machine in (None, with_roller))
        geometric = 100.0 * _max_torque_slope(cam) / _max_torque_slope(roller)
        stiffness_ratios = [
            air_stiffness(simulate_closed_valve(self.bench.arm, pressure)) / pressure
            for pressure in STIFFNESS_PRESSURES
        ]
        stiffness_range = 100.0 * float(np.ptp(stiffness_ratios) / np.mean(stiffness_ratios))
        remaining = 100.0 * float(roller.lossless.min() / roller.lossless.max())
        return [
            ClaimQuantity("torque varies with cam", torque_range, "%", "0"),
            ClaimQuantity("torque left at the end without cam", remaining, "%"),
            ClaimQuantity("stiffness of geometry, of that without cam", geometric, "%", "0"),
            ClaimQuantity("closed-valve stiffness per pressure varies", stiffness_range, "%", "0"),
        ], torque_range <= 1.0 and geometric < 2.0 and stiffness_range <= 10.0
