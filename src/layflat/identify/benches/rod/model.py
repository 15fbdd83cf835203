"""A friction test bench: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive the way the position is. Logs at two pressures or more show how friction grows with pressure.
"""

from collections.abc import Sequence

import numpy as np

from layflat.arrays import Array
from layflat.description.change import value_at
from layflat.identify.benches.contract import Bench, Logs, chosen, simulated
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.model import CurveModel, element_unknowns, within
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import Rod, RodLog, rod_force
from layflat.identify.model import Unknown

BLOCKS = ("piston", "friction", "viscous")  # `viscous` is for logs of speeds that differ at each pressure
DEFAULT_BLOCKS = ("piston", "friction")

LINEAR = (
    "piston.area", "piston.area_slope", "piston.spring", "piston.offset", "friction.base", "friction.slope",
    "friction.viscous",
)  # fmt: skip
"""Where the parameters of a `Rod` stand in the description."""

SLOPES = "loops at two pressures or more, the higher the further apart"


class RodModel(CurveModel[RodBench]):
    """Forces in the logs of a friction test bench; made as `Bench` says."""

    losses = "friction"

    def __init__(
        self, bench: RodBench, logs: Logs, validation: Logs | None = None, *, blocks: Sequence[str] = DEFAULT_BLOCKS
    ) -> None:
        self.origin = bench
        self.outputs = curves.outputs(logs, validation, "force", "N")
        self.logs = []
        for log, out in zip([*logs.values(), *(validation or {}).values()], self.outputs, strict=True):
            position = curves.moving(log, "position", out.log)
            pressure = curves.without_spikes(curves.signal(log, "pressure", out.log)) - bench.ambient_pressure
            self.logs.append(RodLog(position, curves.rate(out.time, position), pressure, curves.first_of(out)))
        self.motions = tuple(log.position for log in self.logs)
        self.unknowns = tuple(chosen(self._unknowns(), blocks))

    def simulate(self, values: Array) -> Array:
        """Forces by candidate: see `Model.simulate`."""
        rod = parameters(self.candidates(values))
        return self._forces(len(values), [(rod, log) for log in self.logs])

    def starts(self) -> Array:
        """A start from linear least squares, with deflections as described: all but these enters nearly linearly."""
        sought = [(LINEAR.index(one.path), i) for i, one in enumerate(self.unknowns) if one.path in LINEAR]
        if not sought:
            return super().starts()
        rod, friction = parameters(self.candidates(self.guess[None])), self.origin.friction
        level = friction.base + friction.slope * friction.reference_pressure_gauge
        bare = Rod(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, rod.weights, tuple(one / level for one in rod.stiffness))
        slipping = self._forces(1, [(bare, log._replace(first=0.0)) for log in self.logs])[0]
        rows, wanted = [], []
        for place, log, out in zip(self.slices, self.logs, self.outputs, strict=True):
            x, p, f, used = log.position, log.pressure, slipping[place], out.fitted & np.isfinite(out.measured)
            columns = np.stack([p, x * p, x, np.ones_like(p), f, p * f, log.speed], axis=1)
            rows.append(columns[used] / out.scale)
            wanted.append(out.measured[used] / out.scale)
        A = np.concatenate(rows)[:, [i for i, _ in sought]]
        norms = np.linalg.norm(A, axis=0) + np.finfo(float).tiny
        found = np.linalg.lstsq(A / norms, np.concatenate(wanted), rcond=None)[0] / norms
        start = self.guess.copy()
        for (_, i), value in zip(sought, found, strict=True):
            start[i] = np.clip(value, self.unknowns[i].low, self.unknowns[i].high)
        return start[None]

    def _forces(self, count: int, cases: list[tuple[Rod, RodLog]]) -> Array:
        return np.concatenate(simulated(rod_force, count, cases, [one.shape for one in self.motions]), axis=1)

    def _unknowns(self) -> dict[str, list[Unknown]]:
        """By block; bounds come from the greatest force, its range within a log, pressure, travel and speed."""
        piston, friction = self.origin.piston, self.origin.friction
        measured = [out.measured[np.isfinite(out.measured)] for out in self.outputs]
        most, reach = max(float(np.abs(one).max()) for one in measured), max(float(np.ptp(one)) for one in measured)
        pressure = max(float(np.abs(log.pressure).max()) for log in self.logs) + 1e3
        travel = max(float(np.ptp(log.position)) for log in self.logs)
        speed = max(float(np.abs(log.speed).max()) for log in self.logs) + 1e-6
        area, tilt, fastest = most / pressure, reach / travel, reach / speed
        steep, speeds = tilt / pressure, "speeds that differ at each pressure"
        return {
            "piston": [
                within("piston.area", "m^2", piston.area, 1e-3 * area, 1e2 * area, SLOPES, log=True),
                within("piston.area_slope", "m", piston.area_slope, -steep, steep, SLOPES),
                within("piston.spring", "N/m", piston.spring, -tilt, tilt, "long strokes"),
                within("piston.offset", "N", piston.offset, -most, most, SLOPES),
            ],
            "friction": [
                within("friction.base", "N", friction.base, 0.0, reach, SLOPES),
                within("friction.slope", "N/Pa", friction.slope, 0.0, reach / pressure, SLOPES),
                *element_unknowns("friction", "m", friction.deflections, friction.weights, travel),
            ],
            "viscous": [within("friction.viscous", "N*s/m", friction.viscous, 0.0, fastest, speeds)],
        }


def parameters(bench: RodBench) -> Rod:
    """What the laws take of a description."""
    friction = bench.friction
    level = friction.base + friction.slope * friction.reference_pressure_gauge
    elements = zip(friction.weights, friction.deflections, strict=True)
    stiffness = tuple(weight * level / deflection for weight, deflection in elements)
    area, slope, spring, offset, base, rise, viscous = (value_at(bench, path) for path in LINEAR)
    return Rod(area, slope, spring, offset, base, rise, viscous, friction.weights, stiffness)


BENCH = Bench(BLOCKS, DEFAULT_BLOCKS, RodModel, even=False)
