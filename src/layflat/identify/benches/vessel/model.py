"""A vessel that is filled or vented: logs of its pressure, and perhaps its temperature, and a description make a model.

A log is a data set over `time` (s) with `pressure` (absolute, Pa) and, where measured, `temperature` (of the gas) and
`wall_temperature` (K), not a number where nothing was read. What acts may be given in it: `supply`, the absolute
pressure on the other side of the path, and `opening` of the path, 0..1; without them the path is open from the log's
start on, to the pressure that the description gives. Gas and wall are at rest, and of one temperature, when it begins.

A log of one vessel identifies C/V, not C and V: pressures do not change where conductances, volume, area and heat
capacity all grow alike. A second log, with a known volume joined to the vessel, separates them.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, check_known, chosen, fitted_share_of, simulated, with_columns
from layflat.identify.benches.vessel.description import BLOCKS, Place, VesselBench
from layflat.identify.benches.vessel.gas import GASES, IDEAL_AIR, is_gas
from layflat.identify.benches.vessel.laws import Course, Outside, Path, Setup, Vessel, Wall, run_vessel
from layflat.identify.model import Model, Output
from layflat.identify.unknown import Unknown
from layflat.physics.chamber import Chamber

SIGNALS = {"pressure": ("Pa", 1e-3), "temperature": ("K", 1e-2), "wall_temperature": ("K", 1e-2)}
"""What may be measured: unit, and how large an error matters as a share of the signal's range."""

NEAR = 0.05  # a log identifies the pressure outside if it ends within this share of it


@dataclass(frozen=True)
class VesselLog:
    """A log as the simulation takes it: what acted, and by signal the samples at which it was measured."""

    name: str
    course: Course
    added_volume: float
    picked: dict[str, NDArray[np.int64]]


class VesselModel(Model):
    """Pressures and temperatures of a vessel, by the laws of laws.py; made as `Bench` says.

    Args:
        bench, logs, validation, blocks: see `Bench`.
        volume: whether the vessel's volume is fitted too, in the block "gas".
        added_volumes: known volumes that were joined to the vessel, m3, by the log's name.
        fitted_share: of the time of each log to fit, from its start; the rest is for validation. Default: all, or two
            thirds where there is no other log for validation.
        fitted_signals: of `SIGNALS`; others are only predicted.

    Raises:
        InputError: a log without pressure or with gaps in what acts, an option that fits no log, or a gas that would
            condense.
    """

    def __init__(
        self,
        bench: VesselBench,
        logs: Logs,
        validation: Logs | None = None,
        *,
        blocks: Collection[str] = tuple(BLOCKS),
        volume: bool = False,
        added_volumes: Mapping[str, float] | None = None,
        fitted_share: float | None = None,
        fitted_signals: Collection[str] = ("pressure",),
    ) -> None:
        _check_gas(bench, bench.start, "start")
        _check_gas(bench, bench.outside, "outside")
        added, every = added_volumes or {}, {**logs, **(validation or {})}
        check_known(added, every, "added_volumes", "log")
        check_known(fitted_signals, SIGNALS, "fitted_signals", "signal")
        share = fitted_share_of(logs, validation, fitted_share)
        self.bench = bench
        self.logs = tuple(_read(name, log, added.get(name, 0.0)) for name, log in every.items())
        self.outputs = tuple(
            _output(one, every[one.name], signal, share, signal in fitted_signals and one.name in logs)
            for one in self.logs
            for signal in one.picked
        )
        pressures = {output.log: output for output in self.outputs if output.name == "pressure"}
        left = set() if volume else {"space.volume"}
        courses = [output.measured[output.fitted] for output in pressures.values() if output.fitted.any()]
        if not any(course.max() > 1.02 * course[0] for course in courses):
            left.add("wall.forced")  # no gas flows in
        found = [spec.unknown(bench) for spec in chosen(BLOCKS, blocks) if spec.path not in left]
        self.unknowns = (
            *(unknown for unknown in found if unknown.guess != 0.0),
            *_of_outside(bench, [pressures[log.name] for log in self.logs if np.isnan(log.course.supply).any()]),
            *(_of_start(bench, output) for output in pressures.values()),
        )

    def simulate(self, values: Array) -> Array:
        """Pressures and temperatures by candidate: see `Model.simulate`."""
        parts = []
        for log in self.logs:
            found = self.run(log, values)
            parts += [found[:, rows, list(SIGNALS).index(signal)] for signal, rows in log.picked.items()]
        return np.concatenate(parts, axis=1)

    def run(self, log: VesselLog, values: Array) -> Array:
        """Pressure and temperatures at all times of a log, (candidates, samples, 3)."""
        columns = self.columns(values)
        own = {path: column for path, column in columns.items() if not path.startswith("start.")}
        own["start.pressure"] = columns[f"start.pressure.{log.name}"]
        gas = IDEAL_AIR if self.bench.gas.law == "ideal" else GASES[self.bench.gas.name]
        case = parameters(with_columns(self.bench, own), log.added_volume), gas, log.course, 1.0
        return simulated(run_vessel, len(values), [case], [(len(log.course.time), 3)])[0]


def parameters(bench: VesselBench, added_volume: float = 0.0) -> Setup:
    """Return what the laws take of a description."""
    space, wall, path, outside, ambient = bench.space, bench.wall, bench.path, bench.outside, bench.ambient
    capacity = np.inf if wall.heat_capacity is None else wall.heat_capacity
    vessel = Vessel(
        Chamber(space.volume + added_volume, space.compliance, wall.conductance),
        Wall(space.area, space.diameter, wall.natural, wall.forced, capacity, wall.outer_conductance),
        Path(path.conductance, path.critical_ratio),
    )
    around = Outside(outside.pressure, outside.temperature, ambient.pressure, ambient.temperature)
    return Setup(vessel, around, bench.start.pressure, bench.start.temperature)


def _check_gas(bench: VesselBench, place: Place, where: str) -> None:
    if not is_gas(GASES[bench.gas.name], place.pressure, place.temperature):
        what = f"{bench.gas.name} is not a gas at {place.pressure / 1e5:g} bar and {place.temperature:g} K"
        right = "give a lower pressure or a higher temperature"
        raise InputError(what, where=f"{bench.name}: {where}", right=right)


def _read(name: str, log: Dataset, added_volume: float) -> VesselLog:
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


def _output(log: VesselLog, data: Dataset, signal: str, fitted_share: float, fitted: bool) -> Output:
    rows, (unit, share) = log.picked[signal], SIGNALS[signal]
    time, measured = log.course.time, np.asarray(data[signal].values, dtype=np.float64)[rows]
    early = time[rows] <= time[0] + fitted_share * (time[-1] - time[0])
    # What is for validation may not act on the fit, not even by its range.
    scale = max(share * float(np.ptp(measured[early])), 1e-9) if early.any() else 1.0
    return Output(signal, unit, log.name, time[rows], measured, early & fitted, scale)


def _of_outside(bench: VesselBench, pressures: list[Output]) -> list[Unknown]:
    """The pressure outside, where a log comes near it without giving it."""
    usual = bench.outside.pressure
    lasts = [output.measured[output.fitted][-1] for output in pressures if output.fitted.any()]
    if not any(abs(last - usual) < NEAR * usual for last in lasts):
        return []
    return [Unknown("outside.pressure", "Pa", usual, usual / 1.1, usual * 1.1, True, "an end at rest", nuisance=True)]


def _of_start(bench: VesselBench, output: Output) -> Unknown:
    """Pressure that a log begins with: it need not have been read just then."""
    first, path = float(output.measured[0]), f"start.pressure.{output.log}"
    guess = first if output.time[0] == 0.0 else bench.start.pressure
    low, high = 0.8 * min(first, guess), 1.25 * max(first, guess)
    return Unknown(path, "Pa", guess, low, high, excitation="a sample near its start", nuisance=True)


BENCH = Bench(tuple(BLOCKS), tuple(BLOCKS), VesselModel, even=False)
