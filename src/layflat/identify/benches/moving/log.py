"""A log of a machine that moves: what acted, what it began with, and what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray

from layflat.identify.model import FITTED, Array, Flags, Output
from layflat.identify.unknown import Unknown
from layflat.machine import Machine, parameters
from layflat.machine.model import AngleSensor, PressureSensor
from layflat.physics.joint import FILLED
from layflat.sim.ensemble.parallel import traced
from layflat.sim.scenario import Scenario

TRACES = ("angle", "pressure_a", "pressure_b")

SMOOTHED = 9
"""Samples over which an angle that is fed back is smoothed."""

FIRST = 4
"""Samples of which the mean is what a log begins with: one period of the dither."""

COUNTS = 2.0
"""A log begins within so many counts of the angle that was first measured."""


def sensor_offset(machine: Machine) -> float:
    """Of the differential pressure, Pa."""
    return machine.pressure_sensor.offset if machine.pressure_sensor is not None else 0.0


def _noise(sensor: AngleSensor | PressureSensor) -> float:
    """Standard deviation of what a sensor adds, its counts included."""
    return float(np.hypot(sensor.noise, sensor.range / 2**sensor.bits / np.sqrt(12.0)))


@dataclass(frozen=True)
class Record:
    """One log of a machine; what it says of paths that are `known` to be fitted is not used."""

    machine: Machine
    name: str
    log: xarray.Dataset
    whole: bool | None
    """Whether all of it is fitted, or all but its last third; None if it is only predicted."""
    known: set[str]

    @cached_property
    def joints(self) -> list[str]:
        """Names, from base to tip."""
        return list(self.machine.joints)

    @cached_property
    def time(self) -> Array:
        """Instants, s."""
        return self.log["time"].to_numpy()

    def signal(self, name: str) -> Array | None:
        """A signal of every joint, (samples, joints), or one that they share, (samples,)."""
        if name not in self.log:
            return None
        values = self.log[name]
        if "joint" in values.dims:
            values = values.sel(joint=self.joints).transpose("time", "joint")
        return np.asarray(values.to_numpy(), dtype=np.float64)

    @cached_property
    def measured(self) -> dict[str, Array]:
        """What was measured of every joint, (samples, joints)."""
        names = ("angle", "pressure_a", "pressure_b", "measured_pressure")
        return {name: values for name in names if (values := self.signal(name)) is not None}

    @cached_property
    def first(self) -> dict[str, Array]:
        """What the log begins with, (joints,)."""
        return {name: np.nanmean(values[:FIRST], axis=0) for name, values in self.measured.items()}

    @cached_property
    def fitted(self) -> Flags:
        """Which samples are."""
        end = {None: 0.0, True: np.inf, False: FITTED * self.time[-1]}[self.whole]
        return np.asarray(self.time < end)

    def scenario_of(self, samples: int) -> Scenario:
        """What acts on the machine, from the beginning on."""
        brake, load, supply, payload, voltage = (
            values if (values := self.signal(name)) is None else values[:samples]
            for name in ("brake", "load", "supply", "payload", "voltage")
        )
        ambient = self.machine.supply.ambient_pressure
        return Scenario(
            duration=samples * self.machine.cycle,
            demand=self._fed_back[:samples],
            voltage=voltage,
            start=dict(zip(self.joints, self._angles, strict=True)),
            pressures={name: (a, b) for name, a, b in zip(self.joints, *self._pressures, strict=True)},
            supply=None if supply is None else supply - ambient,
            payload=None if payload is None or "arm.payload" in self.known else payload,
            brake=1.0 if brake is None else brake,
            load=0.0 if load is None else load,
            noise=False,
        )

    @cached_property
    def _fed_back(self) -> Array:
        """Measured angles without gaps and with less noise, for a joint with feedback."""
        from scipy.signal import savgol_filter  # noqa: PLC0415  # scipy.signal takes long to import

        angles = self.log["angle"].interpolate_na("time", fill_value="extrapolate").sel(joint=self.joints)
        values = np.asarray(angles.transpose("time", "joint").to_numpy(), dtype=np.float64)
        window = min(SMOOTHED, 2 * ((len(values) - 1) // 2) + 1)
        return np.asarray(savgol_filter(values, window, 3, axis=0)) if window > 3 else values

    @cached_property
    def _angles(self) -> list[float]:
        limits = [0.5 * joint.stops.working_stroke for joint in self.machine.joints.values()]
        return [float(np.clip(q, -b, b)) for q, b in zip(self.first["angle"], limits, strict=True)]

    @cached_property
    def _pressures(self) -> tuple[list[float], list[float]]:
        """Of hoses A and B; where only their difference was measured, about the mean of equal leakage."""
        supply = self.signal("supply")
        usual = FILLED * (self.machine.supply.pressure if supply is None else float(supply[0]))
        if "pressure_a" in self.first and "pressure_b" in self.first:
            return list(self.first["pressure_a"]), list(self.first["pressure_b"])
        offset = sensor_offset(self.machine)
        both = np.broadcast_to(0.5 * (self.first.get("measured_pressure", offset) - offset), len(self.joints))
        return list(usual + both), list(usual - both)

    @cached_property
    def nuisances(self) -> list[Unknown]:
        """What a log begins with, to be fitted along with the rest; for validation the first measured samples hold."""
        if self.whole is None:
            return []
        _, angle, _ = parameters.drive_parts(self.machine)
        reach, found = COUNTS * angle.range / 2**angle.bits, []
        low, high = 0.9 * self.machine.supply.ambient_pressure, 1.05 * self.machine.supply.pressure
        for name, q, a, b in zip(self.joints, self._angles, *self._pressures, strict=True):
            where = f"start.{self.name}"
            found.append(Unknown(f"{where}.angle.{name}", "rad", q, q - reach, q + reach, log=False, nuisance=True))
            for hose, p in (("a", a), ("b", b)):
                path = f"{where}.pressure_{hose}.{name}"
                found.append(Unknown(path, "Pa", p, min(low, p), max(high, p), log=False, nuisance=True))
        return found

    @cached_property
    def outputs(self) -> list[Output]:
        """Every measured signal of every joint."""
        _, angle, pressure = parameters.drive_parts(self.machine)
        scales = {"angle": ("rad", _noise(angle))}
        voltage, found = self.signal("voltage"), []
        assert voltage is not None
        for signal, values in self.measured.items():
            unit, scale = scales.get(signal, ("Pa", _noise(pressure)))
            for j, name in enumerate(self.joints):
                label = f"{signal} {name}" if len(self.joints) > 1 else signal
                found.append(Output(label, unit, self.name, self.time, values[:, j], self.fitted, scale, voltage[:, j]))
        return found

    def simulate(
        self, shared: Mapping[str, Array], given: Mapping[str, Array], offset: Array, step: float, share: float | None
    ) -> Array:
        """Outputs of every candidate, (candidates, samples): all, or only a share of what is fitted.

        Args:
            shared: what is varied in all logs.
            given: values of all unknowns, those that this log begins with among them.
            offset: of the differential pressure, Pa, one or an item a candidate.
            step: of the simulation, s.
            share: None for the whole log.
        """
        count = len(shared["scenario.load"])
        found = np.full((count, len(self.measured), len(self.joints), len(self.time)), np.nan)
        samples = len(self.time) if share is None else int(np.ceil(share * self.fitted.sum()))
        if samples == 0:
            return found.reshape(count, -1)
        own = f"start.{self.name}."
        begun = {f"start.{path.removeprefix(own)}": c for path, c in given.items() if path.startswith(own)}
        run = traced(self.machine, self.scenario_of(samples), {**shared, **begun}, TRACES, step=step)
        angle, a, b = np.moveaxis(run, (3, 2), (0, 2))
        signals = {"angle": angle, "pressure_a": a, "pressure_b": b}
        signals["measured_pressure"] = a - b + np.broadcast_to(offset, count)[:, None, None]
        for i, name in enumerate(self.measured):
            found[:, i, :, :samples] = signals[name]
        return found.reshape(count, -1)
