"""Log of a machine that moves: its inputs and measured signals, and output injection that keeps a simulation near them.

A valve corrects its joint by the error of the angle, and its air by the error of the differential pressure; a torque
corrects it as a spring and a damper would, so that its error of angle decays, critically damped, whatever gravity does.
The inertia of a joint is here the one that a torque on it alone meets while all others are free, the least of the log's
configurations: a spring for more would be too stiff for the control cycle. A log in which a joint hits its stop ends
there.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple, Self

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.benches import Logs
from layflat.identify.logs.checks.stops import IMPACT_ADVICE, find_impact
from layflat.identify.model import FITTED_FRACTION, Flags, ModelOutput, Unknown
from layflat.machine import Machine, parameters
from layflat.machine.model import AngleSensor, PressureSensor
from layflat.motion.dynamics import min_inertias
from layflat.motion.path import half_strokes
from layflat.motion.scenario import SIGNALS, Scenario
from layflat.physics.hose import swept_volume
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.physics.step import STEP
from layflat.sim.ensemble.parallel import simulate_traces

REFERENCE_PRESSURE = 1e5  # of the air that a sonic conductance is given for, Pa (ISO 6358)


class ContinuationStage(NamedTuple):
    """Stage of the continuation; feedback of a rate or frequency of zero is off."""

    angle: float = 0.0  # rate at which valves reduce the error of angles, 1/s
    air: float = 0.0  # rate at which they reduce the error of differential pressures, 1/s
    torque: float = 0.0  # natural frequency of the springs that pull at angles, rad/s
    step: float = STEP  # of the simulation, s
    bodies: bool = True  # whether links are replaced by the nearest feasible ones
    fraction: float | None = 1.0  # of the fitted time, from the start of each log on; None: all of the log


class OutputInjectionGains(NamedTuple):
    """Gains of the output injection, per rate, one per joint."""

    voltage: Array  # that makes a joint follow its angle at 1/s, V/rad
    pressure: Array  # the same of its differential pressure, V/Pa
    inertia: Array  # of the springs and dampers, kg m2

    @classmethod
    def from_machine(cls, machine: Machine, configurations: Array) -> Self:
        """Return the output injection gains of a machine with a valve, one for each joint.

        They are V s/rad and V s/Pa for a rate of 1/s, and kg m2.

        Args:
            machine: machine with valves.
            configurations: joint angles of its logs, rad, (configurations, joints), for the least inertias.
        """
        assert machine.valve is not None
        middle = REST_PRESSURE_RATIO * machine.supply.pressure
        full, joints = machine.valve.volts_to_full, list(machine.joints.values())
        sizes = np.array([joint.valve_size for joint in joints])
        flow = machine.valve.conductance * REFERENCE_PRESSURE / REST_PRESSURE_RATIO * sizes
        hoses = [joint.hose_a for joint in parameters.joints(machine)]
        volume = np.array([hose.chamber.dead_volume + swept_volume(hose.stroke, hose.neutral) for hose in hoses])
        per_angle = np.array([parameters.torque_constant(joint) for joint in joints])
        inertia = min_inertias(machine, configurations, machine.arm.payload)
        return cls(full * per_angle / flow, full * volume / (2.0 * middle * flow), inertia)

    def varied_paths(self, joints: Sequence[str], stage: ContinuationStage, count: int) -> dict[str, Array]:
        """Return the injection of a stage as values that an ensemble varies, by path.

        Paths are `scenario.KEY.JOINT` with the keys lead, pressure_lead, spring and damper.

        Args:
            joints: names, in the order of the gains.
            stage: stage with the rates.
            count: number of candidates.
        """
        gains = {
            "lead": stage.angle * self.voltage,
            "pressure_lead": stage.air * self.pressure,
            "spring": stage.torque**2 * self.inertia,
            "damper": 2.0 * stage.torque * self.inertia,
        }
        return {
            f"scenario.{key}.{name}": np.full(count, gain)
            for key, each in gains.items()
            for name, gain in zip(joints, each, strict=True)
        }


MIN_DURATION = 3.0  # of a log before its first impact, s


def cut_at_impacts(machine: Machine, logs: Logs) -> tuple[dict[str, Dataset], tuple[str, ...]]:
    """Return logs up to the sample before their first impact, and a remark for each log that has one.

    Args:
        machine: machine whose joints the logs are of.
        logs: logs by name, with the angle of every joint; those without impacts stay as they are.

    Raises:
        InputError: less than `MIN_DURATION` is left of a log.
    """
    used, remarks = dict(logs), []
    for name, log in logs.items():
        angles = {joint: np.asarray(log["angle"].sel(joint=joint), dtype=np.float64) for joint in machine.joints}
        first = {joint: find_impact(machine, joint, angle, machine.cycle) for joint, angle in angles.items()}
        impacts = {joint: sample for joint, sample in first.items() if sample is not None}
        if not impacts:
            continue
        joint, end = min(impacts.items(), key=lambda item: item[1])
        what = f"up to {float(log['time'][end]):.3g} s, where joint {joint!r} is thrown to its stop"
        if end * machine.cycle < MIN_DURATION:
            raise InputError(f"is of use only {what}", where=name, right=IMPACT_ADVICE)
        used[name] = log.isel(time=slice(end))
        remarks.append(f"Log {name!r} is used {what}: {IMPACT_ADVICE}.")
    return used, tuple(remarks)


SIMULATED_SIGNALS = ("angle", "pressure_a", "pressure_b")

SMOOTHING_SAMPLES = 9  # window of the filter of an angle that is fed back
INITIAL_SAMPLES = 4  # whose mean is the state at the start: one period of the dither
START_COUNTS, START_NOISE_RATIO = 2.0, 4.0  # bounds of the first angle about the measured one, counts and deviations


def sensor_offset(machine: Machine) -> float:
    """Return the offset of the sensor of the differential pressure, Pa; 0 without a sensor."""
    return machine.pressure_sensor.offset if machine.pressure_sensor is not None else 0.0


def _noise_deviation(sensor: AngleSensor | PressureSensor) -> float:
    """Return the standard deviation of a sensor's noise, quantisation included."""
    return float(np.hypot(sensor.noise, sensor.range / 2**sensor.bits / np.sqrt(12.0)))


def _initial_mean(values: Array) -> Array:
    """Return the mean of the numbers in the first `INITIAL_SAMPLES` of (samples, joints), (joints,); NaN for none."""
    finite = np.isfinite(values[:INITIAL_SAMPLES])
    counts = finite.sum(axis=0)
    sums = np.where(finite, values[:INITIAL_SAMPLES], 0.0).sum(axis=0)
    return np.where(counts, sums / np.maximum(counts, 1), np.nan)


INPUT_SIGNALS = [name for name in SIGNALS if not name.startswith("demand")]  # signals that act on a machine


class MachineLog:
    """One log of a machine: an angle and a voltage of every joint at least.

    All of it is fitted if it is `whole`, else all but its last third; it is only predicted if that is None. Its signals
    at paths that are `sought` are not used as inputs.
    """

    def __init__(self, machine: Machine, name: str, log: Dataset, whole: bool | None, sought: set[str]) -> None:
        self.machine, self.name, self.log, self.sought = machine, name, log, sought
        self.joints, self.time = list(machine.joints), log["time"].to_numpy()
        names = (*SIMULATED_SIGNALS, "measured_pressure")
        self.measured = {name: values for name in names if (values := self._signal(name)) is not None}
        first = {name: _initial_mean(values) for name, values in self.measured.items()}
        self.angles = [float(np.clip(q, -b, b)) for q, b in zip(first["angle"], half_strokes(machine), strict=True)]
        self.pressures = self._first_pressures(first)
        self.fitted: Flags = self.time < {None: 0.0, True: np.inf, False: FITTED_FRACTION * self.time[-1]}[whole]
        self.nuisances = [] if whole is None else self._nuisances()
        self.outputs = self._outputs()

    def build_scenario(self, samples: int, pressure_gains: Array) -> Scenario:
        """Return a scenario of the first samples: logged inputs that are not sought, and what the injection follows.

        Where differential pressures were measured, the gains times these are added to the voltages.

        Args:
            samples: number of control cycles.
            pressure_gains: gains of the feedback of differential pressures, V/Pa, (joints,).
        """
        logged = {name: values[:samples] for name in INPUT_SIGNALS if (values := self._signal(name)) is not None}
        inputs: dict[str, Any] = {n: values for n, values in logged.items() if SIGNALS[n].path not in self.sought}
        ambient = inputs.get("ambient", self.machine.supply.ambient_pressure)
        inputs |= {name: values - ambient for name, values in inputs.items() if SIGNALS[name].gauge}
        if self.difference is not None:
            inputs["voltage"] = inputs["voltage"] + pressure_gains * self.difference[:samples]
        return Scenario(
            duration=samples * self.machine.cycle,
            demand=self.angle[:samples],
            demand_velocity=self._velocity[:samples],
            start=dict(zip(self.joints, self.angles, strict=True)),
            pressures={name: (a, b) for name, a, b in zip(self.joints, *self.pressures, strict=True)},
            noise=False,
            **inputs,
        )

    def _signal(self, name: str) -> Array | None:
        """Return a signal of every joint, (samples, joints), or one that all share, (samples,); None without it."""
        if name not in self.log:
            return None
        values = self.log[name]
        if "joint" in values.dims:
            values = values.sel(joint=self.joints).transpose("time", "joint")
        return np.asarray(values.to_numpy(), dtype=np.float64)

    @cached_property
    def angle(self) -> Array:
        """Return the measured angles that are fed back, smoothed and without gaps, (samples, joints)."""
        return self._smooth(self.measured["angle"])

    @cached_property
    def _velocity(self) -> Array:
        return self._smooth(self.measured["angle"], 1)

    @cached_property
    def difference(self) -> Array | None:
        """Return smoothed pressures of hose A less B, Pa, (samples, joints); None if any joint's were not measured.

        They include the sensor's offset where it measured them; otherwise they are from the pressures of both hoses.
        """
        values = self.measured.get("measured_pressure")
        if values is None and "pressure_a" in self.measured and "pressure_b" in self.measured:
            values = self.measured["pressure_a"] - self.measured["pressure_b"]
        return self._smooth(values) if values is not None and np.isfinite(values).any(axis=0).all() else None

    def _smooth(self, values: Array, derivative: int = 0) -> Array:
        """Return values (samples, joints) or their derivative, smoothed by Savitzky and Golay; gaps interpolated.

        Fewer than 5 samples are not smoothed, and their derivative is 0.
        """
        from scipy.signal import savgol_filter  # noqa: PLC0415  # scipy.signal takes long to import

        finite = np.isfinite(values)
        columns = [np.interp(self.time, self.time[k], v[k]) for v, k in zip(values.T, finite.T, strict=True)]
        window = min(SMOOTHING_SAMPLES, 2 * ((len(values) - 1) // 2) + 1)
        if window <= 3:
            return np.stack(columns, axis=1) * (derivative == 0)
        smooth = savgol_filter(np.array(columns), window, 3, derivative, self.machine.cycle, axis=1)
        return np.ascontiguousarray(smooth.T)

    def _first_pressures(self, first: Mapping[str, Array]) -> tuple[list[float], list[float]]:
        """Return the first absolute pressures of hoses A and B, Pa, in the order of joints.

        Without both measured they lie about `REST_PRESSURE_RATIO` of the supply, apart by any measured difference.
        """
        supply, offset = self._signal("supply"), sensor_offset(self.machine)
        mean = REST_PRESSURE_RATIO * (self.machine.supply.pressure if supply is None else float(supply[0]))
        unknown = np.full(len(self.joints), np.nan)
        half = np.nan_to_num(0.5 * (first.get("measured_pressure", unknown) - offset))
        a, b = first.get("pressure_a", unknown), first.get("pressure_b", unknown)
        both = np.isfinite(a) & np.isfinite(b)
        return list(np.where(both, a, mean + half)), list(np.where(both, b, mean - half))

    def _nuisances(self) -> list[Unknown]:
        """Return the initial state of a fitted log as unknowns; a log for validation starts from its first samples."""
        _, angle, _ = parameters.valve_and_sensors(self.machine)
        reach, unknowns = max(START_COUNTS * angle.range / 2**angle.bits, START_NOISE_RATIO * angle.noise), []
        low, high = 0.9 * self.machine.supply.ambient_pressure, 1.05 * self.machine.supply.pressure
        for name, q, a, b in zip(self.joints, self.angles, *self.pressures, strict=True):
            where = f"start.{self.name}"
            unknowns.append(Unknown(f"{where}.angle.{name}", "rad", q, q - reach, q + reach, log=False, nuisance=True))
            for hose, p in (("a", a), ("b", b)):
                path = f"{where}.pressure_{hose}.{name}"
                unknowns.append(Unknown(path, "Pa", p, min(low, p), max(high, p), log=False, nuisance=True))
        return unknowns

    def _outputs(self) -> list[ModelOutput]:
        """Return every measured signal of every joint as a model output, scaled by its sensor's noise."""
        _, angle, pressure = parameters.valve_and_sensors(self.machine)
        voltage, outputs = self._signal("voltage"), []
        assert voltage is not None
        for signal, values in self.measured.items():
            unit, scale = ("rad", _noise_deviation(angle)) if signal == "angle" else ("Pa", _noise_deviation(pressure))
            for j, name in enumerate(self.joints):
                label = f"{signal} {name}" if len(self.joints) > 1 else signal
                outputs.append(
                    ModelOutput(label, unit, self.name, self.time, values[:, j], self.fitted, scale, voltage[:, j])
                )
        return outputs

    def simulate(
        self,
        shared: Mapping[str, Array],
        values: Mapping[str, Array],
        offset: Array,
        stage: ContinuationStage,
        gains: OutputInjectionGains,
    ) -> Array:
        """Simulate every candidate through the log, or through a fraction of its fitted time.

        Args:
            shared: values of candidates that all logs share, by path, (candidates,) each.
            values: values of all unknowns by path; those of this log's initial state are used.
            offset: offset of the sensor of the differential pressure, Pa: a number, or (candidates,).
            stage: rates of the injection, step, and fraction of the log.
            gains: gains of the injection.

        Returns:
            All outputs, (candidates, samples), one after the other, within `limits`; NaN beyond the fraction.
        """
        count = len(shared["scenario.load"])
        outputs = np.full((count, len(self.measured), len(self.joints), len(self.time)), np.nan)
        samples = len(self.time) if stage.fraction is None else int(np.ceil(stage.fraction * self.fitted.sum()))
        if samples == 0:
            return outputs.reshape(count, -1)
        prefix = f"start.{self.name}."
        varied = {**shared, **self._injection(shared, np.broadcast_to(offset, count), stage, gains)}
        varied |= {f"start.{path.removeprefix(prefix)}": c for path, c in values.items() if path.startswith(prefix)}
        scenario = self.build_scenario(samples, stage.air * gains.pressure)
        run = simulate_traces(self.machine, scenario, varied, SIMULATED_SIGNALS, step=stage.step, together=stage.bodies)
        signals = dict(zip(SIMULATED_SIGNALS, np.moveaxis(run, (3, 2), (0, 2)), strict=True))
        difference = signals["pressure_a"] - signals["pressure_b"]
        signals["measured_pressure"] = difference + np.broadcast_to(offset, count)[:, None, None]
        for i, name in enumerate(self.measured):
            outputs[:, i, :, :samples] = np.clip(signals[name], -self.limits[name], self.limits[name])
        return outputs.reshape(count, -1)

    @cached_property
    def limits(self) -> dict[str, float]:
        """Return the limit of each measured signal either way: half the sensor's range, or the greatest reading.

        Pressures of single hoses have none (inf).
        """
        _, angle, pressure = parameters.valve_and_sensors(self.machine)
        halves = {"angle": 0.5 * angle.range, "measured_pressure": 0.5 * pressure.range}
        return {
            name: max(halves.get(name, np.inf), float(np.nanmax(np.abs(values), initial=0.0)))
            for name, values in self.measured.items()
        }

    def _injection(
        self, shared: Mapping[str, Array], offset: Array, stage: ContinuationStage, gains: OutputInjectionGains
    ) -> dict[str, Array]:
        """Return the injection of every candidate, by path, corrected for the sensor's offset in fed back pressures."""
        varied = gains.varied_paths(self.joints, stage, len(offset))
        if stage.air > 0.0 and "measured_pressure" in self.measured:
            # The differential pressures that are fed back contain the sensor's offset.
            for name, gain in zip(self.joints, gains.pressure, strict=True):
                path = f"scenario.drift.{name}"
                varied[path] = shared.get(path, 0.0) + stage.air * gain * offset
        return varied
