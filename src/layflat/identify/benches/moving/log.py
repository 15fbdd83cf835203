"""Logs in which a joint is thrown to its stop end there."""

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.benches.contract import Logs
from layflat.identify.benches.moving.leading import Leads, Stage
from layflat.identify.logs.checks.stops import RIGHT, impact
from layflat.identify.model import FITTED, Flags, Output
from layflat.identify.unknown import Unknown
from layflat.machine import Machine, parameters
from layflat.machine.model import AngleSensor, PressureSensor
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.physics.joint import FILLED
from layflat.sim.ensemble.parallel import traced

SHORTEST = 3.0  # of what is left of a log, s


def up_to_impacts(machine: Machine, logs: Logs) -> tuple[dict[str, Dataset], tuple[str, ...]]:
    """Logs up to their first impacts, and what is to be said of those that have one, a sentence each.

    Args:
        machine: whose joints they are of.
        logs: by name, with the angle of every joint; those without impacts stay as they are.

    Raises:
        InputError: too little is left of a log.
    """
    found, said = dict(logs), []
    for name, log in logs.items():
        angles = {joint: np.asarray(log["angle"].sel(joint=joint), dtype=np.float64) for joint in machine.joints}
        first = {joint: impact(machine, joint, of, machine.cycle) for joint, of in angles.items()}
        thrown = {joint: sample for joint, sample in first.items() if sample is not None}
        if not thrown:
            continue
        joint, end = min(thrown.items(), key=lambda one: one[1])
        what = f"up to {float(log['time'][end]):.3g} s, where joint {joint!r} is thrown to its stop"
        if end * machine.cycle < SHORTEST:
            raise InputError(f"is of use only {what}", where=name, right=RIGHT)
        found[name] = log.isel(time=slice(end))
        said.append(f"Log {name!r} is used {what}: {RIGHT}.")
    return found, tuple(said)


TRACES = ("angle", "pressure_a", "pressure_b")

SMOOTHED = 9  # samples over which an angle that is fed back is smoothed
FIRST = 4  # samples of which the mean is what a log begins with: one period of the dither
COUNTS, NOISES = 2.0, 4.0  # a log begins within so many counts, or standard deviations, of the angle first measured


def sensor_offset(machine: Machine) -> float:
    """Offset of the sensor of the differential pressure, Pa."""
    return machine.pressure_sensor.offset if machine.pressure_sensor is not None else 0.0


def _noise(sensor: AngleSensor | PressureSensor) -> float:
    """Standard deviation of what a sensor adds, its counts included."""
    return float(np.hypot(sensor.noise, sensor.range / 2**sensor.bits / np.sqrt(12.0)))


def _beginning(values: Array) -> Array:
    """Mean of what is known of the first samples, (joints,); not a number where nothing is."""
    known = np.isfinite(values[:FIRST])
    counts = known.sum(axis=0)
    return np.where(counts, np.where(known, values[:FIRST], 0.0).sum(axis=0) / np.maximum(counts, 1), np.nan)


ACTS = [name for name in SIGNALS if not name.startswith("demand")]  # what a log says of what acted on a machine


class Record:
    """One log of a machine: an angle and a voltage of every joint at least.

    All of it is fitted if it is `whole`, else all but its last third; it is only predicted if that is None. What the
    log says of what is fitted, by the paths that are `known`, is not used.
    """

    def __init__(self, machine: Machine, name: str, log: Dataset, whole: bool | None, known: set[str]) -> None:
        self.machine, self.name, self.log, self.known = machine, name, log, known
        self.joints, self.time = list(machine.joints), log["time"].to_numpy()
        names = (*TRACES, "measured_pressure")
        self.measured = {name: values for name in names if (values := self._signal(name)) is not None}
        first = {name: _beginning(values) for name, values in self.measured.items()}
        limits = [0.5 * joint.stops.working_stroke for joint in machine.joints.values()]
        self.angles = [float(np.clip(q, -b, b)) for q, b in zip(first["angle"], limits, strict=True)]
        self.pressures = self._first_pressures(first)
        self.fitted: Flags = self.time < {None: 0.0, True: np.inf, False: FITTED * self.time[-1]}[whole]
        self.nuisances = [] if whole is None else self._nuisances()
        self.outputs = self._outputs()

    def scenario_of(self, samples: int, pressure_lead: Array) -> Scenario:
        """Return what acts on the machine, from the beginning on.

        Differential pressures are drawn to the measured ones, with a lead (V/Pa) of every joint.
        """
        logged = {name: values[:samples] for name in ACTS if (values := self._signal(name)) is not None}
        acting: dict[str, Any] = {n: values for n, values in logged.items() if SIGNALS[n].path not in self.known}
        around = acting.get("ambient", self.machine.supply.ambient_pressure)
        acting |= {name: values - around for name, values in acting.items() if SIGNALS[name].gauge}
        if self.difference is not None:
            acting["voltage"] = acting["voltage"] + pressure_lead * self.difference[:samples]
        return Scenario(
            duration=samples * self.machine.cycle,
            demand=self.angle[:samples],
            demand_velocity=self._velocity[:samples],
            start=dict(zip(self.joints, self.angles, strict=True)),
            pressures={name: (a, b) for name, a, b in zip(self.joints, *self.pressures, strict=True)},
            noise=False,
            **acting,
        )

    def _signal(self, name: str) -> Array | None:
        """A signal of every joint, (samples, joints), or one that they share, (samples,)."""
        if name not in self.log:
            return None
        values = self.log[name]
        if "joint" in values.dims:
            values = values.sel(joint=self.joints).transpose("time", "joint")
        return np.asarray(values.to_numpy(), dtype=np.float64)

    @cached_property
    def angle(self) -> Array:
        """Measured angles without gaps and with less noise, to which a joint is drawn, (samples, joints)."""
        return self._smooth(self.measured["angle"])

    @cached_property
    def _velocity(self) -> Array:
        return self._smooth(self.measured["angle"], 1)

    @cached_property
    def difference(self) -> Array | None:
        """Differential pressures likewise, a sensor's offset included; None where a joint's were not measured."""
        values = self.measured.get("measured_pressure")
        if values is None and "pressure_a" in self.measured and "pressure_b" in self.measured:
            values = self.measured["pressure_a"] - self.measured["pressure_b"]
        return self._smooth(values) if values is not None and np.isfinite(values).any(axis=0).all() else None

    def _smooth(self, values: Array, derivative: int = 0) -> Array:
        from scipy.signal import savgol_filter  # noqa: PLC0415  # scipy.signal takes long to import

        known = np.isfinite(values)
        columns = [np.interp(self.time, self.time[k], v[k]) for v, k in zip(values.T, known.T, strict=True)]
        window = min(SMOOTHED, 2 * ((len(values) - 1) // 2) + 1)
        if window <= 3:
            return np.stack(columns, axis=1) * (derivative == 0)
        smooth = savgol_filter(np.array(columns), window, 3, derivative, self.machine.cycle, axis=1)
        return np.ascontiguousarray(smooth.T)

    def _first_pressures(self, first: Mapping[str, Array]) -> tuple[list[float], list[float]]:
        """Return pressures of hoses A and B; without both measured, about the mean of equal leakage."""
        supply, offset = self._signal("supply"), sensor_offset(self.machine)
        usual = FILLED * (self.machine.supply.pressure if supply is None else float(supply[0]))
        unknown = np.full(len(self.joints), np.nan)
        both = np.nan_to_num(0.5 * (first.get("measured_pressure", unknown) - offset))
        a, b = first.get("pressure_a", unknown), first.get("pressure_b", unknown)
        each = np.isfinite(a) & np.isfinite(b)
        return list(np.where(each, a, usual + both)), list(np.where(each, b, usual - both))

    def _nuisances(self) -> list[Unknown]:
        """Return the start of a log, fitted along with the rest; for validation the first measured samples hold."""
        _, angle, _ = parameters.drive_parts(self.machine)
        reach, found = max(COUNTS * angle.range / 2**angle.bits, NOISES * angle.noise), []
        low, high = 0.9 * self.machine.supply.ambient_pressure, 1.05 * self.machine.supply.pressure
        for name, q, a, b in zip(self.joints, self.angles, *self.pressures, strict=True):
            where = f"start.{self.name}"
            found.append(Unknown(f"{where}.angle.{name}", "rad", q, q - reach, q + reach, log=False, nuisance=True))
            for hose, p in (("a", a), ("b", b)):
                path = f"{where}.pressure_{hose}.{name}"
                found.append(Unknown(path, "Pa", p, min(low, p), max(high, p), log=False, nuisance=True))
        return found

    def _outputs(self) -> list[Output]:
        """Every measured signal of every joint."""
        _, angle, pressure = parameters.drive_parts(self.machine)
        voltage, found = self._signal("voltage"), []
        assert voltage is not None
        for signal, values in self.measured.items():
            unit, scale = ("rad", _noise(angle)) if signal == "angle" else ("Pa", _noise(pressure))
            for j, name in enumerate(self.joints):
                label = f"{signal} {name}" if len(self.joints) > 1 else signal
                found.append(Output(label, unit, self.name, self.time, values[:, j], self.fitted, scale, voltage[:, j]))
        return found

    def simulate(
        self, shared: Mapping[str, Array], given: Mapping[str, Array], offset: Array, stage: Stage, leads: Leads
    ) -> Array:
        """Outputs of every candidate, (candidates, samples): all, or only a share of what is fitted.

        Of all values `given`, this log takes those that it begins with, and those `shared` by all logs; the `offset` of
        the differential pressure (Pa) is one, or an item a candidate.
        """
        count = len(shared["scenario.load"])
        found = np.full((count, len(self.measured), len(self.joints), len(self.time)), np.nan)
        samples = len(self.time) if stage.share is None else int(np.ceil(stage.share * self.fitted.sum()))
        if samples == 0:
            return found.reshape(count, -1)
        own = f"start.{self.name}."
        varied = {**shared, **self._led(shared, np.broadcast_to(offset, count), stage, leads)}
        varied |= {f"start.{path.removeprefix(own)}": c for path, c in given.items() if path.startswith(own)}
        scenario = self.scenario_of(samples, stage.air * leads.pressure)
        run = traced(self.machine, scenario, varied, TRACES, step=stage.step, together=stage.bodies)
        signals = dict(zip(TRACES, np.moveaxis(run, (3, 2), (0, 2)), strict=True))
        difference = signals["pressure_a"] - signals["pressure_b"]
        signals["measured_pressure"] = difference + np.broadcast_to(offset, count)[:, None, None]
        for i, name in enumerate(self.measured):
            found[:, i, :, :samples] = np.clip(signals[name], -self.ends[name], self.ends[name])
        return found.reshape(count, -1)

    @cached_property
    def ends(self) -> dict[str, float]:
        """Ends of the readings of every measured signal, both ways: a joint that is thrown to its stop is beyond."""
        _, angle, pressure = parameters.drive_parts(self.machine)
        halves = {"angle": 0.5 * angle.range, "measured_pressure": 0.5 * pressure.range}
        return {
            name: max(halves.get(name, np.inf), float(np.nanmax(np.abs(values), initial=0.0)))
            for name, values in self.measured.items()
        }

    def _led(self, shared: Mapping[str, Array], offset: Array, stage: Stage, leads: Leads) -> dict[str, Array]:
        """Return what draws candidates to the log."""
        varied = leads.vary(self.joints, stage, len(offset))
        if stage.air > 0.0 and "measured_pressure" in self.measured:
            # The sensor's offset is in what differential pressures are drawn to.
            for name, lead in zip(self.joints, leads.pressure, strict=True):
                path = f"scenario.drift.{name}"
                varied[path] = shared.get(path, 0.0) + stage.air * lead * offset
        return varied
