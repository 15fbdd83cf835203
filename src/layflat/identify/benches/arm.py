"""A machine that moves: from the voltages of its valves to pressures and angles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray
from numpy.typing import NDArray

from layflat.errors import InputError
from layflat.identify.benches.arm_blocks import unknowns
from layflat.identify.model import Flags, Model, Output
from layflat.identify.unknown import Unknown
from layflat.machine import Machine, parameters
from layflat.machine.model import AngleSensor, PressureSensor
from layflat.sim.ensemble.parallel import traced
from layflat.sim.run import FILLED, STEP
from layflat.sim.scenario import Scenario

Array = NDArray[np.float64]

TRACES = ("angle", "pressure_a", "pressure_b")

SMOOTHED = 9
"""Samples over which an angle that leads is smoothed."""

FIRST = 4
"""Samples of which the mean is what a log begins with: one period of the dither."""

FITTED = 2.0 / 3.0
"""Share of a log that is fitted where no other log is there to judge."""

REFERENCE_PRESSURE = 1e5
"""Of the air that a sonic conductance is given for, Pa (ISO 6358)."""

COUNTS = 2.0
"""A log begins within so many counts of the angle that was first measured."""


class Rung(NamedTuple):
    """How values are sought: the rate at which joints are drawn along their measured angles (1/s), and the step (s)."""

    led: float
    step: float


LEADS, COARSE = (8.0, 4.0, 12.0), 4.0 * STEP
"""From afar with a coarse step, led strongly: which rate finds its way depends on where the search begins."""

LADDER = (Rung(2.0, STEP), Rung(0.5, STEP))
"""Then as exactly as a run is simulated, and led weakly in the end.

What leads brings its noise along, which widens errors more than a free run's roughness does: the less the better.
"""


FREE = Rung(0.0, STEP)
"""Led by nothing: how a fitted machine is judged."""


class ArmModel(Model):
    """Angles and pressures of every joint, from the voltages in the logs.

    Args:
        machine: where the search begins, and what is held.
        logs: to fit, by name: uniform in time at the machine's control cycle, from rest.
        blocks: what to fit, of `BLOCKS`.
        judged: logs that are only predicted; without any, the last third of each log is.

    Raises:
        InputError: a log lacks what is needed, or a block is unknown.
    """

    def __init__(
        self,
        machine: Machine,
        logs: Mapping[str, xarray.Dataset],
        blocks: Sequence[str],
        judged: Mapping[str, xarray.Dataset] | None = None,
    ) -> None:
        self.machine, self.rung = machine, FREE
        found = unknowns(machine, blocks)
        known = {unknown.path for unknown in found}
        self.records = [_Record(machine, name, log, bool(judged), known) for name, log in logs.items()]
        self.records += [_Record(machine, name, log, None, known) for name, log in (judged or {}).items()]
        nuisances = [unknown for record in self.records for unknown in record.nuisances]
        self.unknowns = (*found, *_nulls(machine, known), *nuisances)
        self.outputs = tuple(output for record in self.records for output in record.outputs)

    def ladder(self) -> Sequence[Model]:
        """The same, led along the measured angles, less and less.

        A joint integrates what its valve lets through: over a whole log, a small error of a parameter becomes a large
        one of the angle, and one more of stick and slip with it. Led at 0.5/s it forgets in two seconds, which is
        hundreds of samples: errors stay small, and the right values still leave none.
        """
        return self.ladders()[0]

    def ladders(self) -> Sequence[Sequence[Model]]:
        """Ladders that begin led more or less strongly."""
        return [[self._on(rung) for rung in (Rung(led, COARSE), *LADDER)] for led in LEADS]

    def _on(self, rung: Rung) -> ArmModel:
        easier = copy(self)
        easier.rung = rung
        return easier

    @cached_property
    def _leads(self) -> dict[str, float]:
        """Voltage per error of the angle by which each joint is drawn along at 1/s, V/rad."""
        valve = self.machine.valve
        if valve is None:
            return {}
        flow = valve.conductance * REFERENCE_PRESSURE / FILLED
        joints = self.machine.joints.items()
        return {name: valve.volts_to_full * parameters.torque_constant(joint) / flow for name, joint in joints}

    def simulate(self, values: Array) -> Array:
        """All logs from their starts, whatever the candidates' values say."""
        given = {unknown.path: values[:, i] for i, unknown in enumerate(self.unknowns)}
        offset = given.get("pressure_sensor.offset", _offset(self.machine))
        shared = {path: column for path, column in given.items() if not path.startswith(("log.", "start."))}
        shared |= {f"scenario.lead.{name}": np.full(len(values), self.rung.led * v) for name, v in self._leads.items()}
        shared |= {path.replace("log.", "scenario.", 1): c for path, c in given.items() if path.startswith("log.")}
        asked = len(values), self.rung.step, self.rung is FREE
        found = [record.simulate(shared, given, np.asarray(offset), *asked) for record in self.records]
        return np.concatenate(found, axis=1)


def _nulls(machine: Machine, known: set[str]) -> list[Unknown]:
    """A valve's null differs from joint to joint: what those after the first have on top."""
    if "valve.centre_voltage" not in known or machine.valve is None:
        return []
    reach = 0.1 * machine.valve.volts_to_full
    later = list(machine.joints)[1:]
    return [Unknown(f"log.drift.{name}", "V", 0.0, -reach, reach, log=False, nuisance=True) for name in later]


def _offset(machine: Machine) -> float:
    return machine.pressure_sensor.offset if machine.pressure_sensor is not None else 0.0


def _noise(sensor: AngleSensor | PressureSensor) -> float:
    """Standard deviation of what a sensor adds, its counts included."""
    return float(np.hypot(sensor.noise, sensor.range / 2**sensor.bits / np.sqrt(12.0)))


@dataclass(frozen=True)
class _Record:
    """One log of a machine.

    Args:
        machine: what it is a log of.
        name: of the log.
        log: its signals.
        whole: whether all of it is fitted, or all but its last third; None if it is only predicted.
        known: paths that are found; what the log says of these is not used.
    """

    machine: Machine
    name: str
    log: xarray.Dataset
    whole: bool | None
    known: set[str]

    @cached_property
    def joints(self) -> list[str]:
        return list(self.machine.joints)

    @cached_property
    def time(self) -> Array:
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
        found = {name: values for name in names if (values := self.signal(name)) is not None}
        if "angle" not in found:
            raise InputError("has no angle", where=self.name, right="map a column to the signal angle of every joint")
        return found

    @cached_property
    def voltage(self) -> Array:
        """Of every valve, (samples, joints)."""
        found = self.signal("voltage")
        if found is None:
            raise InputError("has no voltage", where=self.name, right="map a column to the signal voltage")
        return found

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

        def first(name: str) -> Array | None:
            values = self.signal(name)
            return None if values is None else values[:samples]

        brake, load, supply, payload = map(first, ("brake", "load", "supply", "payload"))
        ambient = self.machine.supply.ambient_pressure
        return Scenario(
            duration=samples * self._cycle,
            demand=self._followed[:samples],
            voltage=self.voltage[:samples],
            start=dict(zip(self.joints, self._angles, strict=True)),
            pressures={name: (a, b) for name, a, b in zip(self.joints, *self._pressures, strict=True)},
            supply=None if supply is None else supply - ambient,
            payload=None if payload is None or "arm.payload" in self.known else payload,
            brake=1.0 if brake is None else brake,
            load=0.0 if load is None else load,
            noise=False,
        )

    @cached_property
    def _followed(self) -> Array:
        """Measured angles without gaps and with less noise, for a joint that is led."""
        from scipy.signal import savgol_filter  # noqa: PLC0415  # scipy.signal takes long to import

        angles = self.log["angle"].interpolate_na("time", fill_value="extrapolate").sel(joint=self.joints)
        values = np.asarray(angles.transpose("time", "joint").to_numpy(), dtype=np.float64)
        window = min(SMOOTHED, 2 * ((len(values) - 1) // 2) + 1)
        return np.asarray(savgol_filter(values, window, 3, axis=0)) if window > 3 else values

    @cached_property
    def _cycle(self) -> float:
        return self.machine.controller.cycle if self.machine.controller is not None else 0.005

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
        half = (
            0.5 * (self.first["measured_pressure"] - _offset(self.machine))
            if "measured_pressure" in self.first
            else 0.0
        )
        both = np.broadcast_to(half, len(self.joints))
        return list(usual + both), list(usual - both)

    @cached_property
    def nuisances(self) -> list[Unknown]:
        """What a log begins with, to be found along with the rest; of a judged log, what was first measured holds."""
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
        _, angle, pressure = parameters.drive_parts(self.machine)
        scales = {"angle": ("rad", _noise(angle))}
        voltage, found = self.voltage, []
        for signal, values in self.measured.items():
            unit, scale = scales.get(signal, ("Pa", _noise(pressure)))
            for j, name in enumerate(self.joints):
                label = f"{signal} {name}" if len(self.joints) > 1 else signal
                found.append(Output(label, unit, self.name, self.time, values[:, j], self.fitted, scale, voltage[:, j]))
        return found

    def simulate(
        self,
        shared: Mapping[str, Array],
        given: Mapping[str, Array],
        offset: Array,
        count: int,
        step: float,
        whole: bool,
    ) -> Array:
        """Outputs of every candidate, (candidates, samples); only of what is fitted if not the whole is asked for."""
        found = np.full((count, len(self.measured), len(self.joints), len(self.time)), np.nan)
        samples = len(self.time) if whole else int(self.fitted.sum())
        if samples == 0:
            return found.reshape(count, -1)
        own = f"start.{self.name}."
        vary = dict(shared) | {
            f"start.{path.removeprefix(own)}": c for path, c in given.items() if path.startswith(own)
        }
        vary.pop("pressure_sensor.offset", None)
        vary.setdefault("scenario.load", np.zeros(count))
        run = traced(self.machine, self.scenario_of(samples), vary, TRACES, step=step)
        angle, a, b = np.moveaxis(run, (3, 2), (0, 2))
        signals = {"angle": angle, "pressure_a": a, "pressure_b": b}
        signals["measured_pressure"] = a - b + np.broadcast_to(offset, count)[:, None, None]
        for i, name in enumerate(self.measured):
            found[:, i, :, :samples] = signals[name]
        return found.reshape(count, -1)
