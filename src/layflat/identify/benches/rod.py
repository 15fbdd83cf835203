"""A friction rig: force on a rod from its position and the pressure in the chamber.

A log is a data set over `time` (s) with `position` (m), `pressure` (absolute, Pa) and `force` (N), the force that moves
the rod, positive the way the position is. Logs at two pressures or more tell how friction grows with pressure.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from layflat.description.change import changed_all, value_at
from layflat.errors import InputError
from layflat.identify.benches import loop_logs
from layflat.identify.benches.loop_logs import Logs, elements, of_range, rounded, shares_of
from layflat.identify.model import Array, Model, Output
from layflat.identify.unknown import Unknown
from layflat.machine.rigs.friction import FrictionRig
from layflat.physics.rod import Rod
from layflat.sim.loops import RodLog, pushed_forces

if TYPE_CHECKING:
    import xarray

BLOCKS = ("piston", "friction", "viscous")
"""What can be found; `viscous` only where it is asked for, with logs of speeds that differ at each pressure."""

PATHS: tuple[str, ...] = (
    "piston.area",
    "piston.area_slope",
    "piston.spring",
    "piston.offset",
    "friction.base",
    "friction.slope",
    "friction.viscous",
)
"""Where the parameters of a `Rod` stand in the description, in order."""

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
    """Forces in the logs of a friction rig.

    Args:
        rig: where the search begins, and what is held.
        logs: to fit, by name.
        judged: logs that are only predicted; without any, the last third of each log is.
        blocks: what to find, of `BLOCKS`.

    Raises:
        InputError: a log lacks a signal, or a block is unknown.
    """

    def __init__(
        self,
        rig: FrictionRig,
        logs: Logs,
        judged: Logs | None = None,
        *,
        blocks: Collection[str] = ("piston", "friction"),
    ) -> None:
        loop_logs.check_blocks(blocks, BLOCKS)
        self.rig = rig
        self.outputs = loop_logs.outputs(logs, judged, "force", "N")
        every = [*logs.values(), *(judged or {}).values()]
        self.logs = tuple(_given(rig, log, out) for log, out in zip(every, self.outputs, strict=True))
        self.unknowns = tuple(self._piston() * ("piston" in blocks) + self._friction() * ("friction" in blocks))
        self.unknowns += tuple(self._viscous() * ("viscous" in blocks))

    def simulate(self, values: Array) -> Array:
        """Forces by candidate: see `Model.simulate`."""
        rods, weights, stiffness = self._elements(values)
        return np.concatenate([pushed_forces(rods, weights, stiffness, log) for log in self.logs], axis=1)

    def starts(self, seed: int) -> Array:  # noqa: ARG002
        """A start from linear least squares, with deflections as described: all but these enters nearly linearly."""
        weights, stiffness = self._elements(self.guess[None])[1:]
        bare = [Rod(0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0)]
        rows, wanted = [], []
        size = self.rig.friction.base + self.rig.friction.slope * self.rig.friction.reference_pressure_gauge
        for log, out in zip(self.logs, self.outputs, strict=True):
            x, p, used = log.position, log.pressure, out.fitted & np.isfinite(out.measured)
            slipping = pushed_forces(bare, weights, stiffness / size, log._replace(first=0.0))[0]
            columns = np.stack([p, x * p, x, np.ones_like(p), slipping, p * slipping, log.speed], axis=1)
            rows.append(columns[used] / out.scale)
            wanted.append(out.measured[used] / out.scale)
        sought = [i for i, path in enumerate(PATHS) if path in self._place]
        if not sought:
            return np.empty((0, len(self.unknowns)))
        A = np.concatenate(rows)[:, sought]
        norms = np.linalg.norm(A, axis=0) + np.finfo(float).tiny
        found = np.linalg.lstsq(A / norms, np.concatenate(wanted), rcond=None)[0] / norms
        start = self.guess.copy()
        for i, value in zip(sought, found, strict=True):
            unknown = self.unknowns[self._place[PATHS[i]]]
            start[self._place[unknown.path]] = np.clip(value, unknown.low, unknown.high)
        return start[None]

    def described(self, values: Array) -> FrictionRig:
        """The rig with values of the unknowns (SI) in their places."""
        found = {path: float(values[place]) for path, place in self._place.items() if ".split." not in path}
        return changed_all(self.rig, found | {"friction.weights": rounded(self._weights(values[None])[0])})

    def written(self, values: Array) -> dict[str, float]:
        """What was found, by its path in the description: weights in place of how they are split."""
        rig = self.described(values)
        paths = [path for path in self._place if ".split." not in path]
        if "friction.base" in self._place:
            paths += [f"friction.weights.{j}" for j in range(len(rig.friction.weights))]
        return {path: float(value_at(cast(Any, rig), path)) for path in paths}

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
        return np.full(len(values), value_at(cast(Any, self.rig), path)) if place is None else values[:, place]

    def _weights(self, values: Array) -> Array:
        """Weights of the elements, (candidates, elements)."""
        friction = self.rig.friction
        if "friction.base" not in self._place:
            return np.tile(friction.weights, (len(values), 1))
        split = [values[:, self._place[f"friction.split.{j}"]] for j in range(len(friction.weights) - 1)]
        return shares_of(np.stack(split, axis=1) if split else np.empty((len(values), 0)))

    def _elements(self, values: Array) -> tuple[list[Rod], Array, Array]:
        """Rods, weights and stiffness of the candidates."""
        friction = self.rig.friction
        columns = np.stack([self._column(values, path) for path in PATHS], axis=1)
        rods = [Rod(*(float(number) for number in row)) for row in columns]
        weights = self._weights(values)
        turns = [self._column(values, f"friction.deflections.{j}") for j in range(len(friction.deflections))]
        level = columns[:, 4] + columns[:, 5] * friction.reference_pressure_gauge
        return rods, weights, weights * level[:, None] / np.stack(turns, axis=1)

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
        size, piston = self._scales, self.rig.piston
        area = size.force / size.pressure
        tilt = size.reach / size.travel
        return [
            of_range(PATHS[0], "m^2", piston.area, 1e-3 * area, 1e2 * area, SLOPES, log=True),
            of_range(PATHS[1], "m", piston.area_slope, -tilt / size.pressure, tilt / size.pressure, SLOPES),
            of_range(PATHS[2], "N/m", piston.spring, -tilt, tilt, "long strokes"),
            of_range(PATHS[3], "N", piston.offset, -size.force, size.force, SLOPES),
        ]

    def _friction(self) -> list[Unknown]:
        size, friction = self._scales, self.rig.friction
        return [
            of_range(PATHS[4], "N", friction.base, 0.0, size.reach, SLOPES),
            of_range(PATHS[5], "N/Pa", friction.slope, 0.0, size.reach / size.pressure, SLOPES),
            *elements("friction", "m", friction.deflections, friction.weights, size.travel),
        ]

    def _viscous(self) -> list[Unknown]:
        size = self._scales
        most = size.reach / size.speed
        return [
            of_range(PATHS[6], "N*s/m", self.rig.friction.viscous, 0.0, most, "speeds that differ at each pressure")
        ]


def _given(rig: FrictionRig, log: xarray.Dataset, out: Output) -> RodLog:
    position = loop_logs.without_spikes(loop_logs.signal(log, "position", out.log))
    if not np.ptp(position) > 0.0:
        raise InputError("the position never changes", where=out.log, right="leave the log out")
    pressure = loop_logs.without_spikes(loop_logs.signal(log, "pressure", out.log)) - rig.ambient_pressure
    return RodLog(position, loop_logs.rate(out.time, position), pressure, loop_logs.first_of(out.measured))
