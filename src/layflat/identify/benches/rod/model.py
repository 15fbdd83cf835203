"""A friction test bench: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive the way the position is. Logs at two pressures or more show how friction grows with pressure.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from layflat.description.change import changed_all, value_at
from layflat.identify.benches.contract import Bench, Logs, check_known
from layflat.identify.benches.hysteresis import logs as curves
from layflat.identify.benches.hysteresis.logs import element_unknowns, rounded, shares_of, within
from layflat.identify.benches.rod.description import RodBench
from layflat.identify.benches.rod.laws import Rod
from layflat.identify.benches.rod.run import RodLog, rod_forces
from layflat.identify.model import Array, Model, Output
from layflat.identify.unknown import Unknown

if TYPE_CHECKING:
    import xarray

BLOCKS = ("piston", "friction", "viscous")
"""What can be fitted; `viscous` only where it is asked for, with logs of speeds that differ at each pressure."""

DEFAULT_BLOCKS = ("piston", "friction")

PATHS = {
    "area": "piston.area",
    "area_slope": "piston.area_slope",
    "spring": "piston.spring",
    "offset": "piston.offset",
    "base": "friction.base",
    "slope": "friction.slope",
    "viscous": "friction.viscous",
}
"""Where the parameters of a `Rod` stand in the description."""

SPEEDS = "speeds that differ at each pressure"
SLOPES = "loops at two pressures or more, the higher the further apart"


@dataclass(frozen=True)
class _Scales:
    """Greatest sizes in all logs: force, its range within a log, gauge pressure, position, speed (SI)."""

    force: float
    reach: float
    pressure: float
    travel: float
    speed: float


class RodModel(Model):
    """Forces in the logs of a friction test bench.

    Args:
        bench: where the search begins, and what is held.
        logs: to fit, by name.
        validation: logs that are only predicted; without any, the last third of each log is.
        blocks: what to fit, of `BLOCKS`.

    Raises:
        InputError: a log lacks a signal, or a block is unknown.
    """

    def __init__(
        self,
        bench: RodBench,
        logs: Logs,
        validation: Logs | None = None,
        *,
        blocks: Sequence[str] = DEFAULT_BLOCKS,
    ) -> None:
        check_known(blocks, BLOCKS, "blocks", "block")
        self.bench = bench
        self.outputs = curves.outputs(logs, validation, "force", "N")
        every = [*logs.values(), *(validation or {}).values()]
        self.logs = tuple(_given(bench, log, out) for log, out in zip(every, self.outputs, strict=True))
        self.unknowns = tuple(self._piston() * ("piston" in blocks) + self._friction() * ("friction" in blocks))
        self.unknowns += tuple(self._viscous() * ("viscous" in blocks))

    def simulate(self, values: Array) -> Array:
        """Forces by candidate: see `Model.simulate`."""
        rods, weights, stiffness = self._elements(values)
        return np.concatenate([rod_forces(rods, weights, stiffness, log) for log in self.logs], axis=1)

    def starts(self, seed: int) -> Array:  # noqa: ARG002
        """A start from linear least squares, with deflections as described: all but these enters nearly linearly."""
        weights, stiffness = self._elements(self.guess[None])[1:]
        bare = [Rod(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)]
        rows, wanted = [], []
        size = self.bench.friction.base + self.bench.friction.slope * self.bench.friction.reference_pressure_gauge
        for log, out in zip(self.logs, self.outputs, strict=True):
            x, p, used = log.position, log.pressure, out.fitted & np.isfinite(out.measured)
            slipping = rod_forces(bare, weights, stiffness / size, log._replace(first=0.0))[0]
            columns = np.stack([p, x * p, x, np.ones_like(p), slipping, p * slipping, log.speed], axis=1)
            rows.append(columns[used] / out.scale)
            wanted.append(out.measured[used] / out.scale)
        sought = [(i, self._place[path]) for i, path in enumerate(PATHS.values()) if path in self._place]
        if not sought:
            return np.empty((0, len(self.unknowns)))
        A = np.concatenate(rows)[:, [i for i, _ in sought]]
        norms = np.linalg.norm(A, axis=0) + np.finfo(float).tiny
        found = np.linalg.lstsq(A / norms, np.concatenate(wanted), rcond=None)[0] / norms
        start = self.guess.copy()
        for (_, place), value in zip(sought, found, strict=True):
            start[place] = np.clip(value, self.unknowns[place].low, self.unknowns[place].high)
        return start[None]

    def described(self, values: Array) -> RodBench:
        """The description with values of the unknowns (SI) in their places."""
        found = {path: float(values[place]) for path, place in self._place.items() if ".split." not in path}
        return changed_all(self.bench, found | {"friction.weights": rounded(self._weights(values[None])[0])})

    def written(self, values: Array) -> dict[str, float]:
        """What was found, by its path in the description: weights in place of how they are split."""
        bench = self.described(values)
        paths = [path for path in self._place if ".split." not in path]
        if "friction.base" in self._place:
            paths += [f"friction.weights.{j}" for j in range(len(bench.friction.weights))]
        return {path: float(value_at(bench, path)) for path in paths}

    @property
    def motions(self) -> tuple[Array, ...]:
        """Position of every log, m."""
        return tuple(log.position for log in self.logs)

    @property
    def _place(self) -> dict[str, int]:
        return {unknown.path: i for i, unknown in enumerate(self.unknowns)}

    def _column(self, values: Array, path: str) -> Array:
        """A parameter of every candidate."""
        place = self._place.get(path)
        return np.full(len(values), value_at(self.bench, path)) if place is None else values[:, place]

    def _weights(self, values: Array) -> Array:
        """Weights of the elements, (candidates, elements)."""
        friction = self.bench.friction
        if "friction.base" not in self._place:
            return np.tile(friction.weights, (len(values), 1))
        split = [values[:, self._place[f"friction.split.{j}"]] for j in range(len(friction.weights) - 1)]
        return shares_of(np.stack(split, axis=1) if split else np.empty((len(values), 0)))

    def _elements(self, values: Array) -> tuple[list[Rod], Array, Array]:
        """Rods, weights and stiffness of the candidates."""
        friction = self.bench.friction
        columns = {field: self._column(values, path) for field, path in PATHS.items()}
        rods = [Rod(*map(float, row)) for row in zip(*columns.values(), strict=True)]
        weights = self._weights(values)
        travels = [self._column(values, f"friction.deflections.{j}") for j in range(len(friction.deflections))]
        level = columns["base"] + columns["slope"] * friction.reference_pressure_gauge
        return rods, weights, weights * level[:, None] / np.stack(travels, axis=1)

    @property
    def _scales(self) -> _Scales:
        measured = [out.measured[np.isfinite(out.measured)] for out in self.outputs]
        return _Scales(
            max(float(np.abs(force).max()) for force in measured),
            max(float(np.ptp(force)) for force in measured),
            max(float(np.abs(log.pressure).max()) for log in self.logs) + 1e3,
            max(float(np.ptp(log.position)) for log in self.logs),
            max(float(np.abs(log.speed).max()) for log in self.logs) + 1e-6,
        )

    def _piston(self) -> list[Unknown]:
        size, piston = self._scales, self.bench.piston
        area = size.force / size.pressure
        tilt = size.reach / size.travel
        return [
            within("piston.area", "m^2", piston.area, 1e-3 * area, 1e2 * area, SLOPES, log=True),
            within("piston.area_slope", "m", piston.area_slope, -tilt / size.pressure, tilt / size.pressure, SLOPES),
            within("piston.spring", "N/m", piston.spring, -tilt, tilt, "long strokes"),
            within("piston.offset", "N", piston.offset, -size.force, size.force, SLOPES),
        ]

    def _friction(self) -> list[Unknown]:
        size, friction = self._scales, self.bench.friction
        return [
            within("friction.base", "N", friction.base, 0.0, size.reach, SLOPES),
            within("friction.slope", "N/Pa", friction.slope, 0.0, size.reach / size.pressure, SLOPES),
            *element_unknowns("friction", "m", friction.deflections, friction.weights, size.travel),
        ]

    def _viscous(self) -> list[Unknown]:
        size = self._scales
        most = size.reach / size.speed
        return [within("friction.viscous", "N*s/m", self.bench.friction.viscous, 0.0, most, SPEEDS)]


def _given(bench: RodBench, log: xarray.Dataset, out: Output) -> RodLog:
    position = curves.moving(log, "position", out.log)
    pressure = curves.without_spikes(curves.signal(log, "pressure", out.log)) - bench.ambient_pressure
    return RodLog(position, curves.rate(out.time, position), pressure, curves.first_of(out))


def _model(bench: RodBench, logs: Logs, blocks: Sequence[str], validation: Logs) -> RodModel:
    return RodModel(bench, logs, validation, blocks=blocks)


BENCH = Bench(BLOCKS, DEFAULT_BLOCKS, _model, even=False)
