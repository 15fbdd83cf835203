"""A vessel that is filled or vented: logs of its pressure, and perhaps its temperature, and a description make a model.

A log is a data set over `time` (s) with `pressure` (absolute, Pa) and, where measured, `temperature` (of the gas) and
`wall_temperature` (K), not a number where nothing was read. What acts may be given in it: `supply`, the absolute
pressure on the other side of the path, and `opening` of the path, 0..1; without them the path is open from the log's
start on, to the pressure that the description gives. Gas and wall are at rest, and of one temperature, when it begins.

A log of one vessel identifies C/V, not C and V: pressures do not change where conductances, volume, area and heat
capacity all grow alike. A second log, with a known volume joined to the vessel, separates them.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.description.change import value_at
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, check_known, check_logs
from layflat.identify.benches.vessel.description import Place, VesselBench
from layflat.identify.benches.vessel.gas import GASES, IDEAL_AIR, is_gas
from layflat.identify.benches.vessel.run import Candidates, Course, simulate_vessels
from layflat.identify.model import FITTED, Array, Model, Output
from layflat.identify.unknown import Unknown
from layflat.physics.flow import sonic_conductance

if TYPE_CHECKING:
    import xarray

BLOCKS = {
    "flow": ("path.conductance", "path.critical_ratio"),
    "gas": ("space.volume", "wall.natural", "wall.forced", "wall.conductance"),
}
"""What is fitted, by block; a vessel's volume only where it is asked for."""

SIGNALS = {"pressure": ("Pa", 1e-3), "temperature": ("K", 1e-2), "wall_temperature": ("K", 1e-2)}
"""What may be measured: unit, and how large an error matters as a share of the signal's range."""

NEAR = 0.05
"""A log identifies the pressure outside if it ends within this share of it."""

COLUMNS = {
    "volume": "space.volume",
    "compliance": "space.compliance",
    "wall_conductance": "wall.conductance",
    "area": "space.area",
    "diameter": "space.diameter",
    "natural": "wall.natural",
    "forced": "wall.forced",
    "heat_capacity": "wall.heat_capacity",
    "outer_conductance": "wall.outer_conductance",
    "conductance": "path.conductance",
    "critical_ratio": "path.critical_ratio",
    "outside_pressure": "outside.pressure",
    "outside_temperature": "outside.temperature",
    "ambient_pressure": "ambient.pressure",
    "ambient_temperature": "ambient.temperature",
    "start_pressure": "start.pressure",
    "start_temperature": "start.temperature",
}
"""Where the parameters of a candidate stand in the description."""


@dataclass(frozen=True)
class VesselLog:
    """A log as the simulation takes it: what acted, and by signal the samples at which it was measured."""

    name: str
    course: Course
    added_volume: float
    picked: dict[str, NDArray[np.int64]]


class VesselModel(Model):
    """Vessels by the laws of laws.py: see `vessel_model`."""

    def __init__(
        self,
        bench: VesselBench,
        logs: tuple[VesselLog, ...],
        unknowns: tuple[Unknown, ...],
        outputs: tuple[Output, ...],
    ) -> None:
        self.bench, self.logs, self.unknowns, self.outputs = bench, logs, unknowns, outputs
        self._gas = IDEAL_AIR if bench.gas.law == "ideal" else GASES[bench.gas.name]

    def simulate(self, values: Array) -> Array:
        """Pressures and temperatures by candidate: see `Model.simulate`."""
        parts = []
        for log in self.logs:
            found = self.run(log, values)
            parts += [found[:, rows, list(SIGNALS).index(signal)] for signal, rows in log.picked.items()]
        return np.concatenate(parts, axis=1)

    def run(self, log: VesselLog, values: Array) -> Array:
        """Pressure and temperatures at all times of a log, (candidates, samples, 3)."""
        place = {unknown.path: i for i, unknown in enumerate(self.unknowns)}
        columns = {}
        for column, path in COLUMNS.items():
            own, given = place.get(path, place.get(f"{path}.{log.name}")), value_at(self.bench, path)
            usual = np.inf if given is None else given
            columns[column] = np.full(len(values), usual) if own is None else values[:, own].copy()
        columns["volume"] += log.added_volume
        return simulate_vessels(self._gas, Candidates(**columns), log.course)


def vessel_model(
    bench: VesselBench,
    logs: Mapping[str, xarray.Dataset],
    *,
    blocks: Collection[str] = tuple(BLOCKS),
    volume: bool = False,
    added_volumes: Mapping[str, float] | None = None,
    validation: Collection[str] = (),
    fitted_share: float = 1.0,
    fitted_signals: Collection[str] = ("pressure",),
) -> VesselModel:
    """A model of a vessel for its logs.

    Args:
        bench: its description; the search begins at the values there.
        logs: by name.
        blocks: what to fit, of `BLOCKS`.
        volume: whether the vessel's volume is fitted too, in the block "gas".
        added_volumes: known volumes that were joined to the vessel, m3, by the log's name.
        validation: names of logs that are only predicted.
        fitted_share: of the time of each other log, from its start, that is fitted; the rest is for validation.
        fitted_signals: of `SIGNALS`; others are only predicted.

    Raises:
        InputError: a log without pressure or with gaps in what acts, an option that fits no log, or a gas that would
            condense.
    """
    _check_gas(bench, bench.start, "start")
    _check_gas(bench, bench.outside, "outside")
    added = added_volumes or {}
    check_known(added, logs, "added_volumes", "log")
    check_known(blocks, BLOCKS, "blocks", "block")
    check_known(fitted_signals, SIGNALS, "fitted_signals", "signal")
    check_logs(logs, validation, fitted_share)
    read = tuple(_read(name, log, added.get(name, 0.0)) for name, log in logs.items())
    outputs = tuple(
        _output(one, logs[one.name], signal, fitted_share, signal in fitted_signals and one.name not in validation)
        for one in read
        for signal in one.picked
    )
    pressures = {output.log: output for output in outputs if output.name == "pressure"}
    unknowns = (
        *_of_blocks(bench, blocks, volume, any(map(_fills, pressures.values()))),
        *_of_outside(bench, [pressures[log.name] for log in read if np.isnan(log.course.supply).any()]),
        *(_of_start(bench, output) for output in pressures.values()),
    )
    return VesselModel(bench, read, unknowns, outputs)


def _check_gas(bench: VesselBench, place: Place, where: str) -> None:
    if not is_gas(GASES[bench.gas.name], place.pressure, place.temperature):
        raise InputError(
            f"{bench.gas.name} is no gas at {place.pressure / 1e5:g} bar and {place.temperature:g} K",
            where=f"{bench.name}: {where}",
            right="give a lower pressure or a higher temperature",
        )


def _read(name: str, log: xarray.Dataset, added_volume: float) -> VesselLog:
    time = np.asarray(log["time"].values, dtype=np.float64)

    def acting(key: str, usual: float) -> Array:
        if key not in log:
            return np.full(len(time), usual)
        values = np.asarray(log[key].values, dtype=np.float64)
        if not np.isfinite(values).all():
            raise InputError("has gaps", where=f"{name}: {key}", right="what acts has to be known throughout")
        return values

    found = {key: np.flatnonzero(np.isfinite(log[key].values)) for key in SIGNALS if key in log}
    picked = {key: rows for key, rows in found.items() if len(rows)}
    if len(picked.get("pressure", ())) < 3:
        raise InputError("has no pressure", where=name, right="a vessel is identified by 3 samples or more")
    return VesselLog(name, Course(time, acting("supply", np.nan), acting("opening", 1.0)), added_volume, picked)


def _output(log: VesselLog, data: xarray.Dataset, signal: str, fitted_share: float, fitted: bool) -> Output:
    rows, (unit, share) = log.picked[signal], SIGNALS[signal]
    time, measured = log.course.time, np.asarray(data[signal].values, dtype=np.float64)[rows]
    early = time[rows] <= time[0] + fitted_share * (time[-1] - time[0])
    # What is for validation may not act on the fit, not even by its range.
    scale = max(share * float(np.ptp(measured[early])), 1e-9) if early.any() else 1.0
    return Output(signal, unit, log.name, time[rows], measured, early & fitted, scale)


def _fills(pressure: Output) -> bool:
    """Whether gas flows in while a log is fitted."""
    fitted = pressure.measured[pressure.fitted]
    return len(fitted) > 0 and bool(fitted.max() > 1.02 * fitted[0])


def _of_blocks(bench: VesselBench, blocks: Collection[str], volume: bool, fills: bool) -> list[Unknown]:
    """What of the description is fitted: of the heat paths those that it has and that the logs excite."""
    C, b, V, wall = bench.path.conductance, bench.path.critical_ratio, bench.space.volume, bench.wall
    low, high = C / 30.0, C * 30.0
    if bench.path.hole is not None:
        whole = float(sonic_conductance(0.25 * np.pi * bench.path.hole**2, 1.0))
        low, high = min(0.2 * whole, 0.9 * C), max(1.1 * whole, 1.1 * C)
    fast = "a fill or blow-down that is fast for the size of the vessel"
    G = wall.conductance
    unknowns = (
        Unknown("path.conductance", "m^3/(s Pa)", C, low, high, True, "a fill or blow-down over a wide range"),
        Unknown("path.critical_ratio", "1", b, min(0.05, b), max(0.7, b), False, "flow down to nearly equal pressures"),
        Unknown("space.volume", "m^3", V, V / 10.0, V * 10.0, True, "a second log with a known volume joined to it"),
        Unknown("wall.natural", "1", wall.natural, min(0.01, wall.natural), 1.0, True, fast),
        Unknown("wall.forced", "1", wall.forced, min(0.02, wall.forced), 10.0, True, f"{fast}: a fill"),
        Unknown("wall.conductance", "W/K", G, G / 30.0, G * 30.0, True, fast),
    )
    wanted = {path for block in blocks for path in BLOCKS[block]}
    wanted -= {unknown.path for unknown in unknowns if unknown.guess == 0.0}
    wanted -= (set() if volume else {"space.volume"}) | (set() if fills else {"wall.forced"})
    return [unknown for unknown in unknowns if unknown.path in wanted]


def _of_outside(bench: VesselBench, pressures: list[Output]) -> list[Unknown]:
    """The pressure outside, where a log comes near it without giving it."""
    usual = bench.outside.pressure
    lasts = [output.measured[output.fitted][-1] for output in pressures if output.fitted.any()]
    if not any(abs(last - usual) < NEAR * usual for last in lasts):
        return []
    return [Unknown("outside.pressure", "Pa", usual, usual / 1.1, usual * 1.1, True, "an end at rest", nuisance=True)]


def _of_start(bench: VesselBench, output: Output) -> Unknown:
    """Pressure that a log begins with: it need not have been read just then."""
    first = float(output.measured[0])
    guess = first if output.time[0] == 0.0 else bench.start.pressure
    low, high = 0.8 * min(first, guess), 1.25 * max(first, guess)
    excitation = "a sample near its start"
    return Unknown(f"start.pressure.{output.log}", "Pa", guess, low, high, True, excitation, nuisance=True)


def _model(bench: VesselBench, logs: Logs, blocks: Sequence[str], validation: Logs) -> Model:
    share = 1.0 if validation else FITTED
    return vessel_model(bench, {**logs, **validation}, blocks=blocks, validation=list(validation), fitted_share=share)


BENCH = Bench(tuple(BLOCKS), tuple(BLOCKS), _model, even=False)
