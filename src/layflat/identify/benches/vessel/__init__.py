"""Vessel that is filled or vented, or a hose chamber with its joint locked: its description and its model.

A log is a data set over `time` (s) with `pressure` (absolute, Pa) and, where measured, `temperature` (of the gas) and
`wall_temperature` (K), not a number where nothing was read. Inputs may be in it: `supply`, the absolute pressure on the
other side of the path, and `opening` of the path, 0..1; without them the path is open from the log's start on, to the
pressure of the description. Gas and wall are at rest, and of one temperature, when it begins.

A log of one vessel identifies C/V, not C and V: pressures do not change where conductances, volume, area and heat
capacity all grow alike. A second log, with a known volume joined to the vessel, separates them.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from math import pi
from typing import Annotated, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from layflat.arrays import Array, Dataset
from layflat.description import Part
from layflat.description import units as u
from layflat.errors import InputError
from layflat.identify.benches import (
    BenchDescription,
    BenchKind,
    Logs,
    check_choices,
    fitted_fraction,
    insert_columns,
    select_blocks,
    simulate_candidates,
)
from layflat.identify.benches.vessel.gas import GASES_BY_NAME, IDEAL_AIR, is_gas
from layflat.identify.benches.vessel.laws import (
    Outside,
    Vessel,
    VesselInputs,
    VesselPath,
    VesselSetup,
    Wall,
    run_vessel,
)
from layflat.identify.model import Model, ModelOutput, ParameterSpec, Unknown, factor_range, fixed_range
from layflat.physics.chamber import Chamber
from layflat.physics.flow import sonic_conductance

GasName = Literal["air", "nitrogen", "oxygen", "hydrogen", "helium", "argon", "methane", "carbon dioxide"]


class Gas(Part):
    """Gas in the vessel."""

    name: GasName = "air"
    law: Literal["ideal", "real"] = Field(default="real", description="real: Redlich-Kwong; ideal: air as in a joint")

    @model_validator(mode="after")
    def _check_law(self) -> Self:
        """Raise ValueError if the ideal law is combined with another gas than air."""
        if self.law == "ideal" and self.name != "air":
            raise ValueError(f'the ideal law is that of air; give law = "real" for {self.name}')
        return self


class Space(Part):
    """Volume of the gas, and the wall around it."""

    volume: u.Volume
    compliance: u.Compliance = Field(default=0.0, description="volume gained per pressure by a stretching wall")
    area: u.Area = Field(description="of the wall inside")
    diameter: u.Length = Field(description="of the vessel inside: the width that a jet that fills it has")


class VesselWall(Part):
    """Heat transfer between gas, wall and surroundings."""

    natural: u.Share = Field(default=0.13, description="c of Nu = c Ra^(1/3), natural convection; 0 for none")
    forced: float = Field(default=0.56, ge=0, le=10, description="c_f of Nu = c_f Re^0.67, jet that fills; 0 for none")
    conductance: u.HeatConductance = Field(default=0.0, description="constant part, whatever the state of the gas")
    heat_capacity: u.HeatCapacity | None = Field(default=None, description="without it, the wall keeps its temperature")
    outer_conductance: u.HeatConductance = Field(default=0.0, description="from the wall to the surroundings")


class FlowPath(Part):
    """Hole, valve or tube through which the vessel fills or empties."""

    conductance: u.Conductance = Field(description="ISO 6358 sonic conductance (of air)")
    critical_ratio: Annotated[u.Share, Field(lt=0.99)] = Field(description="ISO 6358 critical pressure ratio")
    hole: u.Length | None = Field(default=None, description="diameter of an orifice, for its discharge coefficient")


class GasConditions(Part):
    """Pressure and temperature of a gas."""

    pressure: u.PositivePressure = Field(description="absolute")
    temperature: u.Temperature


class VesselBench(BenchDescription):
    """Bench of a vessel, its path to the outside, and its start: gas and wall at rest, of one temperature."""

    kind: Literal["vessel"] = "vessel"
    gas: Gas
    space: Space
    wall: VesselWall
    path: FlowPath
    outside: GasConditions = Field(description="on the other side of the path, where the log does not have it")
    ambient: GasConditions
    start: GasConditions

    @model_validator(mode="after")
    def _check_rigid_for_real_gas(self) -> Self:
        """Raise ValueError if a real gas is in a vessel whose wall stretches."""
        if self.gas.law == "real" and self.space.compliance > 0.0:
            raise ValueError('a stretching wall needs the ideal law of air; give gas.law = "ideal" or compliance 0')
        return self


FAST_FLOW = "a fill or blow-down that is fast for the size of the vessel"


def _conductance_range(bench: VesselBench, C: float) -> tuple[float, float, bool]:
    """Return lower bound, upper bound and whether to search by logarithm, for a conductance C in m3/(s Pa).

    A hole bounds it by the conductance of its whole area.
    """
    if bench.path.hole is None:
        return C / 30.0, C * 30.0, True
    whole = float(sonic_conductance(0.25 * pi * bench.path.hole**2, 1.0))
    return min(0.2 * whole, 0.9 * C), max(1.1 * whole, 1.1 * C), True


VESSEL_BLOCKS = {
    "flow": (
        ParameterSpec("path.conductance", "m^3/(s Pa)", _conductance_range, "a fill or blow-down over a wide range"),
        ParameterSpec("path.critical_ratio", "1", fixed_range(0.05, 0.7), "flow down to nearly equal pressures"),
    ),
    "gas": (
        ParameterSpec("space.volume", "m^3", factor_range(10.0), "a second log with a known volume joined to it"),
        ParameterSpec("wall.natural", "1", fixed_range(0.01, 1.0, log=True), FAST_FLOW),
        ParameterSpec("wall.forced", "1", fixed_range(0.02, 10.0, log=True), f"{FAST_FLOW}: a fill"),
        ParameterSpec("wall.conductance", "W/K", factor_range(30.0), FAST_FLOW),
    ),
}
"""Parameters by block: of the heat paths those are fitted that the description has and the logs excite."""


SIGNALS = {"pressure": ("Pa", 1e-3), "temperature": ("K", 1e-2), "wall_temperature": ("K", 1e-2)}
"""Measured signals: unit, and scale of the error as a fraction of the signal's range."""

OUTSIDE_MARGIN = 0.05  # relative; a log that ends within this of the pressure outside identifies it


@dataclass(frozen=True)
class VesselLog:
    """Log of a vessel: its inputs, and by signal the samples at which it was measured."""

    name: str
    inputs: VesselInputs
    added_volume: float  # known one that was joined to the vessel, m3
    samples: dict[str, NDArray[np.int64]]


class VesselModel(Model):
    """Model of the pressures and temperatures of a vessel, by the laws of laws.py; built as `BenchKind` says.

    Args:
        bench, logs, validation, blocks: see `BenchKind`.
        volume: whether the vessel's volume is fitted too, in the block "gas".
        added_volumes: known volumes that were joined to the vessel, m3, by the log's name.
        fitted_share: of the time of each log to fit, from its start; the rest is for validation. Default: all, or two
            thirds where there is no other log for validation.
        fitted_signals: signals of `SIGNALS`; others are only predicted.

    Raises:
        InputError: a log without pressure or with gaps in its inputs, an option that fits no log, or a gas that would
            condense.
    """

    def __init__(
        self,
        bench: VesselBench,
        logs: Logs,
        validation: Logs | None = None,
        *,
        blocks: Collection[str] = tuple(VESSEL_BLOCKS),
        volume: bool = False,
        added_volumes: Mapping[str, float] | None = None,
        fitted_share: float | None = None,
        fitted_signals: Collection[str] = ("pressure",),
    ) -> None:
        _check_gas(bench, bench.start, "start")
        _check_gas(bench, bench.outside, "outside")
        added, all_logs = added_volumes or {}, {**logs, **(validation or {})}
        check_choices(added, all_logs, "added_volumes", "log")
        check_choices(fitted_signals, SIGNALS, "fitted_signals", "signal")
        fraction = fitted_fraction(logs, validation, fitted_share)
        self.bench = bench
        self.logs = tuple(_read_vessel_log(name, log, added.get(name, 0.0)) for name, log in all_logs.items())
        self.outputs = tuple(
            _model_output(log, all_logs[log.name], signal, fraction, signal in fitted_signals and log.name in logs)
            for log in self.logs
            for signal in log.samples
        )
        pressures = {output.log: output for output in self.outputs if output.name == "pressure"}
        held = set() if volume else {"space.volume"}
        fitted = [output.measured[output.fitted] for output in pressures.values() if output.fitted.any()]
        if not any(pressure.max() > 1.02 * pressure[0] for pressure in fitted):
            held.add("wall.forced")  # no gas flows in
        described = [spec.unknown(bench) for spec in select_blocks(VESSEL_BLOCKS, blocks) if spec.path not in held]
        self.unknowns = (
            *(unknown for unknown in described if unknown.guess != 0.0),
            *_outside_unknowns(bench, [pressures[log.name] for log in self.logs if np.isnan(log.inputs.supply).any()]),
            *(_start_unknown(bench, output) for output in pressures.values()),
        )

    def simulate(self, values: Array) -> Array:
        """Return all measured signals, (candidates, samples): see `Model.simulate`."""
        parts = []
        for log in self.logs:
            run = self.run(log, values)
            parts += [run[:, rows, list(SIGNALS).index(signal)] for signal, rows in log.samples.items()]
        return np.concatenate(parts, axis=1)

    def run(self, log: VesselLog, values: Array) -> Array:
        """Return pressure and temperatures of gas and wall at all times of a log, (candidates, samples, 3)."""
        columns = self.columns(values)
        described = {path: column for path, column in columns.items() if not path.startswith("start.")}
        described["start.pressure"] = columns[f"start.pressure.{log.name}"]
        gas = IDEAL_AIR if self.bench.gas.law == "ideal" else GASES_BY_NAME[self.bench.gas.name]
        case = vessel_setup(insert_columns(self.bench, described), log.added_volume), gas, log.inputs, 1.0
        return simulate_candidates(run_vessel, len(values), [case], [(len(log.inputs.time), 3)])[0]


def vessel_setup(bench: VesselBench, added_volume: float = 0.0) -> VesselSetup:
    """Return the parameters of the vessel's laws, its surroundings, and initial pressure (Pa) and temperature (K).

    Args:
        bench: description of the vessel.
        added_volume: volume added to that of the description, m3.
    """
    space, wall, path, outside, ambient = bench.space, bench.wall, bench.path, bench.outside, bench.ambient
    capacity = np.inf if wall.heat_capacity is None else wall.heat_capacity
    vessel = Vessel(
        Chamber(space.volume + added_volume, space.compliance, wall.conductance),
        Wall(space.area, space.diameter, wall.natural, wall.forced, capacity, wall.outer_conductance),
        VesselPath(path.conductance, path.critical_ratio),
    )
    surroundings = Outside(outside.pressure, outside.temperature, ambient.pressure, ambient.temperature)
    return VesselSetup(vessel, surroundings, bench.start.pressure, bench.start.temperature)


def _check_gas(bench: VesselBench, conditions: GasConditions, where: str) -> None:
    """Raise InputError if the substance is no gas in these conditions."""
    if not is_gas(GASES_BY_NAME[bench.gas.name], conditions.pressure, conditions.temperature):
        what = f"{bench.gas.name} is not a gas at {conditions.pressure / 1e5:g} bar and {conditions.temperature:g} K"
        right = "give a lower pressure or a higher temperature"
        raise InputError(what, where=f"{bench.name}: {where}", right=right)


def _read_vessel_log(name: str, log: Dataset, added_volume: float) -> VesselLog:
    """Return the log of a vessel; raise InputError if inputs have gaps or there are fewer than 3 pressures."""
    time = np.asarray(log["time"].values, dtype=np.float64)

    def read_input(key: str, default: float) -> Array:
        """Return an input by sample, the default without it; raise InputError for gaps."""
        if key not in log:
            return np.full(len(time), default)
        values = np.asarray(log[key].values, dtype=np.float64)
        if not np.isfinite(values).all():
            raise InputError("has gaps", where=f"{name}: {key}", right="fill them: an input has to be known throughout")
        return values

    finite = {key: np.flatnonzero(np.isfinite(log[key].values)) for key in SIGNALS if key in log}
    samples = {key: rows for key, rows in finite.items() if len(rows)}
    if len(samples.get("pressure", ())) < 3:
        raise InputError(
            "has fewer than 3 samples of pressure", where=name, right="map a column to the signal pressure"
        )
    return VesselLog(
        name, VesselInputs(time, read_input("supply", np.nan), read_input("opening", 1.0)), added_volume, samples
    )


def _model_output(log: VesselLog, data: Dataset, signal: str, fitted_share: float, fitted: bool) -> ModelOutput:
    """Return the samples of a signal as a model output; fitted are those in the first `fitted_share`, if `fitted`."""
    rows, (unit, ratio) = log.samples[signal], SIGNALS[signal]
    time, measured = log.inputs.time, np.asarray(data[signal].values, dtype=np.float64)[rows]
    early = time[rows] <= time[0] + fitted_share * (time[-1] - time[0])
    # Validation samples must not influence the fit, not even by their range.
    scale = max(ratio * float(np.ptp(measured[early])), 1e-9) if early.any() else 1.0
    return ModelOutput(signal, unit, log.name, time[rows], measured, early & fitted, scale)


def _outside_unknowns(bench: VesselBench, pressures: list[ModelOutput]) -> list[Unknown]:
    """Return the pressure outside as the only unknown, if the fitted part of any of these outputs ends near it."""
    described = bench.outside.pressure
    lasts = [output.measured[output.fitted][-1] for output in pressures if output.fitted.any()]
    if not any(abs(last - described) < OUTSIDE_MARGIN * described for last in lasts):
        return []
    low, high = described / 1.1, described * 1.1
    return [Unknown("outside.pressure", "Pa", described, low, high, True, "an end at rest", nuisance=True)]


def _start_unknown(bench: VesselBench, output: ModelOutput) -> Unknown:
    """Return the pressure at a log's start as an unknown; guessed by a sample at time 0, else as described."""
    first, path = float(output.measured[0]), f"start.pressure.{output.log}"
    guess = first if output.time[0] == 0.0 else bench.start.pressure
    low, high = 0.8 * min(first, guess), 1.25 * max(first, guess)
    return Unknown(path, "Pa", guess, low, high, excitation="a sample near its start", nuisance=True)


DESCRIPTION = VesselBench
BENCH = BenchKind(tuple(VESSEL_BLOCKS), tuple(VESSEL_BLOCKS), VesselModel, even=False)
