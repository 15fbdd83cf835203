"""Statics: Table 1, torques, mass, and the constancy of torque and stiffness (section 2.2, Table 1, Fig. 6)."""

import csv
from functools import cache, cached_property
from importlib.resources import files

import numpy as np
import xarray

from layflat.arrays import Array
from layflat.design import JointDesign, Table1, design_joint, table1
from layflat.experiments.bench import alone, maximum_torque
from layflat.experiments.claim import Evaluated, Experiment, Quantity, claim
from layflat.machine import Machine, changed, parameters
from layflat.machine.model import restored
from layflat.motion.scenario import Scenario
from layflat.sim import rollout
from layflat.sim.sweep import Loop

PRINTED_MEAN = 82.10202  # mean torque of the printed Table 1, N m
MEASURED = {"large": 84.0, "small": 27.0}  # measured maximum torques at 4 bar, N m (section 4.1)
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


def squeeze(arm: Machine, pressure: float) -> xarray.Dataset:
    """Push the large joint slowly to and fro with a fiftieth of its torque, its valve closed and tight."""
    tight = changed(changed(arm, "valve.leakage", 0.0), "valve.dither.amplitude", 0.0)
    push = 0.02 * maximum_torque(arm, "large")

    def load(t: float) -> float:
        return push * float(np.sin(2 * np.pi * t / 20.0))

    filled = (pressure, pressure)
    closed = Scenario(opening=0.0, load=load, brake=0.0, duration=40.0, pressures=filled, noise=False)
    return rollout(alone(tight, "large", 0.5), scenario=closed, step=5e-4)


def stiffness(run: xarray.Dataset) -> float:
    """Return the slope of the air's torque against angle over the last period, N m/rad."""
    last = run.sel(time=slice(20.0, None))
    K = parameters.torque_constant(restored(run.attrs["machine"]).joint["large"])
    torque = K * (last["pressure_a"] - last["pressure_b"]).to_numpy()[:, 0]
    return -float(np.polyfit(last["angle"].to_numpy()[:, 0], torque, 1)[0])


def cam_torque(design: JointDesign) -> Array:
    """Return a cam's torque over its stroke, N m: Eq. (1)'s force through the strap, times the profile's lever."""
    cam = design.with_cam()
    normals = np.stack([np.cos(cam.normal), np.sin(cam.normal)])
    lever = np.max(cam.profile @ normals, axis=0)
    return np.asarray(design.characteristic.force * design.pressure / cam.alignment * lever)


def _slope(loop: Loop) -> float:
    """Greatest change of torque per radian that geometry causes, N m/rad."""
    half = len(loop.angle) // 2
    return float(np.max(np.abs(np.gradient(loop.lossless[:half], loop.angle[:half]))))


class Statics(Experiment):
    """Table 1; hysteresis curves at supply pressure; the large joint's design; and closed-valve stiffness."""

    @cached_property
    def table(self) -> Table1:
        """Table 1, computed."""
        return table1()

    @cached_property
    def design(self) -> JointDesign:
        """The large joint, designed."""
        self.bench.joint("large")
        return design_joint(self.bench.arm, "large")

    @claim("table-1")
    def table_1(self) -> Evaluated:
        """Count the cells of the table that round to the printed digits."""
        wrong = wrong_cells(self.table)
        cells = sum(len(column) for column in printed_table().values())
        return [Quantity("cells as printed", float(cells - len(wrong)), paper=f"{cells}")], not wrong

    @claim("mean-torque")
    def mean_torque(self) -> Evaluated:
        """Compare the mean torque of the table, and of exact integration, with the printed one."""
        joint = self.bench.joint("large")
        mean = joint.geometry.even_stroke(joint.output.radius).k0
        crude, exact = self.table.mean_torque, mean * self.bench.arm.supply.pressure_gauge
        return [
            Quantity("as the table", crude, "N m", f"{PRINTED_MEAN}"),
            Quantity("exact", exact, "N m", f"{PRINTED_MEAN}"),
        ], round(crude, 5) == PRINTED_MEAN and abs(exact / PRINTED_MEAN - 1.0) <= 0.005

    def _torque(self, name: str, percent: float) -> Evaluated:
        top, measured = self.bench.curve(name, brake=self.bench.brake).maximum_torque, MEASURED[name]
        return [Quantity("maximum torque", top, "N m", f"{measured:g}")], abs(top / measured - 1.0) <= percent / 100.0

    @claim("large-joint-torque")
    def large_joint_torque(self) -> Evaluated:
        """Compare the large joint's torque."""
        return self._torque("large", 5.0)

    @claim("small-joint-torque")
    def small_joint_torque(self) -> Evaluated:
        """Compare the small joint's torque."""
        return self._torque("small", 8.0)

    @claim("torque-per-mass")
    def torque_per_mass(self) -> Evaluated:
        """Compare torque per mass."""
        curves = {name: self.bench.curve(name, brake=self.bench.brake) for name in MEASURED}
        each = {name: own.maximum_torque / self.bench.joint(name).body.mass / 4.0 for name, own in curves.items()}
        mean = float(np.mean(list(each.values())))
        unit = "N m/(kg bar)"
        return [
            *(Quantity(name, value, unit) for name, value in each.items()),
            Quantity("mean", mean, unit, "3.5"),
        ], abs(mean / 3.5 - 1.0) <= 0.1

    @claim("constant-torque")
    def constant_torque(self) -> Evaluated:
        """Compare torque over the stroke, and stiffness over position and pressure."""
        over_stroke = cam_torque(self.design)
        spread = 100.0 * float(np.ptp(over_stroke) / np.mean(over_stroke))
        with_roller = changed(self.bench.arm, "joint.large.output.kind", "roller")
        cam, roller = (self.bench.curve("large", one, brake=self.bench.brake) for one in (None, with_roller))
        geometric = 100.0 * _slope(cam) / _slope(roller)
        found = [stiffness(squeeze(self.bench.arm, pressure)) / pressure for pressure in STIFFNESS_PRESSURES]
        follows = 100.0 * float(np.ptp(found) / np.mean(found))
        left = 100.0 * float(roller.lossless.min() / roller.lossless.max())
        return [
            Quantity("torque varies with cam", spread, "%", "0"),
            Quantity("torque left at the end without cam", left, "%"),
            Quantity("stiffness of geometry, of that without cam", geometric, "%", "0"),
            Quantity("closed-valve stiffness per pressure varies", follows, "%", "0"),
        ], spread <= 1.0 and geometric < 2.0 and follows <= 10.0
