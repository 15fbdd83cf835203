"""Model of a regulated joint: both pressures and the angle from the set-points alone.

A joint that friction holds, and that no spring centres, integrates every small error of its pressures. So besides the
angle a fit compares the rotation in the last second, in which earlier errors no longer appear (as one takes the
differences of a random walk); and it goes by continuation, from easy to hard:

1. the motion is imposed as measured: parameters of valves and chambers;
2. the pressures are imposed as measured: parameters of friction and load;
3. nothing is imposed: all parameters, from the set-points.
"""

from collections.abc import Collection, Mapping, Sequence
from copy import copy
from typing import NamedTuple, Self

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description.change import changed
from layflat.errors import InputError
from layflat.identify.benches import (
    BenchKind,
    Logs,
    fitted_fraction,
    insert_columns,
    select_blocks,
    simulate_candidates,
)
from layflat.identify.benches.regulated import laws
from layflat.identify.benches.regulated.description import REGULATED_BLOCKS, RegulatedJointBench
from layflat.identify.benches.regulated.laws import AirConditions, LaggingFriction, PressureRegulator, RegulatedJoint
from layflat.identify.model import Model, ModelOutput
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope

ROTATION_TIME = 1.0  # in which the rotation is compared, s
ERROR_RATIOS = {"angle": 0.1, "rotation": 0.02}  # scales of errors, over the sensor's range
PRESSURE_SCALE = 4e3  # of errors, Pa
READING_MARGIN = 1e-3  # from an end of the sensor's range, as a fraction of it, within which a reading is at that end

LEVEL_PATHS = ("friction.upper_end", "friction.change_angle", "friction.change_width", "friction.lag")
"""Unknowns of a friction whose level depends on the lagged angle."""

SIGNALS = ("setpoint_a", "setpoint_b", "angle", "pressure_a", "pressure_b")


class RegulatedLog(NamedTuple):
    """Log of a regulated joint: its name, its signals, and the stop that its first reading is at, if any."""

    name: str
    signals: laws.RegulatedSignals
    stop: str | None


class RegulatedModel(Model):
    """Model of angle, rotation and both pressures of every log; built as `BenchKind` says.

    Logs have `SIGNALS` in SI, from rest. `fitted_share` of the time of each is fitted, from its start; the rest is for
    validation. Default: all, or two thirds where there is no other log for validation. A stop is an unknown only where
    a fitted log reaches that end of the reading.
    """

    cross_validated = True
    one_level = False  # whether the friction at high angles equals that at low ones

    def __init__(
        self,
        bench: RegulatedJointBench,
        logs: Logs,
        validation: Logs | None = None,
        *,
        blocks: Collection[str] = tuple(REGULATED_BLOCKS),
        fitted_share: float | None = None,
    ) -> None:
        specs = select_blocks(REGULATED_BLOCKS, blocks)
        fraction = fitted_fraction(logs, validation, fitted_share)
        all_logs = {name: _drop_joint(name, log) for name, log in (*logs.items(), *(validation or {}).items())}
        self.bench, self.imposed, self.blocks = bench, laws.NOTHING_IMPOSED, set(blocks)
        self.described_ratio = bench.friction.static_ratio
        self.logs = tuple(_read_regulated_log(bench, name, log) for name, log in all_logs.items())
        angles = np.concatenate([log.signals.angle for log in self.logs[: len(logs)]])
        limit = (0.5 - READING_MARGIN) * bench.stroke.reading
        reached = {"stroke.lower_stop": angles.min() <= -limit, "stroke.upper_stop": angles.max() >= limit}
        self.unknowns = tuple(spec.unknown(bench) for spec in specs if reached.get(spec.path, True))
        self.outputs = tuple(
            output
            for log in self.logs
            for output in _model_outputs(bench, log, all_logs[log.name], fraction if log.name in logs else 0.0)
        )

    def continuations(self) -> Sequence[Sequence[Model]]:
        """Return one continuation: motion imposed (to fit valve or gas), pressures imposed (to fit motion), neither."""
        easier = ((laws.MOTION_IMPOSED, {"valve", "gas"}), (laws.PRESSURES_IMPOSED, {"motion"}))
        return [[*(self._with_imposed(imposed) for imposed, fitted in easier if fitted & self.blocks), self]]

    def simpler_models(self) -> Mapping[str, Model]:
        """Return models "Coulomb friction" and "static friction" (Coulomb and static) of one level over the angle.

        Empty where the motion is not identified.
        """
        if "motion" not in self.blocks:
            return {}
        sticking = self.hold(LEVEL_PATHS)
        sticking.one_level = True
        sliding = copy(sticking)
        sliding.bench = changed(self.bench, "friction.static_ratio", 1.0)
        return {"Coulomb friction": sliding.hold(["friction.static_ratio"]), "static friction": sticking}

    def columns(self, values: Array) -> dict[str, Array]:
        """Return values by path, see `Model.columns`; with one level of friction, that of both ends."""
        columns = super().columns(values)
        return columns | {"friction.upper_end": columns["friction.lower_end"]} if self.one_level else columns

    def described_values(self, values: Array) -> dict[str, float]:
        """Return values by path, see `Model.described_values`; also those that follow from a simpler law."""
        level = {"friction.upper_end": float(self.columns(values)["friction.upper_end"])} if self.one_level else {}
        ratio = self.bench.friction.static_ratio
        static = {"friction.static_ratio": ratio} if ratio != self.described_ratio else {}
        return super().described_values(values) | level | static

    def simulate(self, values: Array) -> Array:
        """Simulate all logs: of each angle, clipped to the reading, rotation, and pressures; see `Model.simulate`."""
        bench, half = insert_columns(self.bench, self.columns(values)), 0.5 * self.bench.stroke.reading
        cases = [(parameters(bench, log), log.signals, self.imposed, laws.MAX_STEP_TIME) for log in self.logs]
        runs = simulate_candidates(
            laws.run_regulated, len(values), cases, [(len(log.signals.time), 3) for log in self.logs]
        )
        columns = []
        for log, run in zip(self.logs, runs, strict=True):
            angle = np.clip(run[:, :, 0], -half, half)
            columns += [angle, _rotation(log.signals.time, angle), run[:, :, 1], run[:, :, 2]]
        return np.concatenate(columns, axis=1)

    def _with_imposed(self, imposed: int) -> Self:
        """Return the same model with measured motion or pressures imposed."""
        other = copy(self)
        other.imposed = imposed
        return other


def parameters(bench: RegulatedJointBench, log: RegulatedLog) -> laws.RegulatedSetup:
    """Return the parameters of the laws; a joint whose first reading is at its end starts at its stop."""
    valve, chamber, load, stroke, supply = bench.valve, bench.chamber, bench.load, bench.stroke, bench.supply
    part = bench.friction
    friction = LaggingFriction(
        part.lower_end, part.upper_end, part.change_angle, part.change_width, part.lag, part.static_ratio
    )  # fmt: skip
    regulator = PressureRegulator(
        valve.gain, valve.offset + 0.5 * valve.mismatch, valve.offset - 0.5 * valve.mismatch, valve.lag,
        valve.conductance_in, valve.conductance_out, valve.band_in, valve.band_out, valve.critical_ratio,
        laminar_slope(valve.critical_ratio),
    )  # fmt: skip
    joint = RegulatedJoint(
        regulator, Chamber(chamber.volume, 0.0, chamber.wall_conductance), chamber.torque_per_pressure,
        load.inertia, load.damping, load.torque, load.stiffness, friction,
        stroke.lower_stop, stroke.upper_stop,
    )  # fmt: skip
    start = getattr(stroke, log.stop) if log.stop else log.signals.angle[0]
    return laws.RegulatedSetup(
        joint, AirConditions(supply.pressure, supply.ambient_pressure, supply.temperature), valve.delay, start
    )


def _rotation(time: Array, angle: Array) -> Array:
    """Return the rotation in the last `ROTATION_TIME` seconds, along the last axis; NaN in the first of them."""
    earlier = np.searchsorted(time, time - ROTATION_TIME + 1e-9, side="right") - 1
    return np.asarray(np.where(earlier >= 0, angle - angle[..., np.maximum(earlier, 0)], np.nan))


def _drop_joint(name: str, log: Dataset) -> Dataset:
    """Return a log without the dimension `joint`; raise InputError unless it has one joint, or no dimension."""
    if "joint" not in log.dims:
        return log
    if log.sizes["joint"] != 1:
        raise InputError(f"has {log.sizes['joint']} joints", where=name, right="map the columns of one joint")
    return log.isel(joint=0)


def _read_regulated_log(bench: RegulatedJointBench, name: str, data: Dataset) -> RegulatedLog:
    """Return the signals of a log, gaps in measured ones interpolated.

    Raises:
        InputError: a signal is missing or begins with a gap, a set-point has gaps, time does not rise or has fewer than
            3 samples, or the first angle is outside the reading.
    """
    for signal in SIGNALS:
        if signal not in data:
            raise InputError(f"has no {signal}", where=name, right=f"a regulated joint needs {', '.join(SIGNALS)}")
    time = np.asarray(data["time"].values, dtype=np.float64)
    if len(time) < 3 or not (np.diff(time) > 0.0).all():
        raise InputError("its time does not rise, or has fewer than 3 samples", where=name, right="give more, in order")
    columns = {}
    for signal in SIGNALS:
        values = np.asarray(data[signal].values, dtype=np.float64)
        finite = np.isfinite(values)
        if not finite.all() and signal.startswith("setpoint"):
            raise InputError(
                "has gaps", where=f"{name}: {signal}", right="fill them: a command has to be known throughout"
            )
        if not finite[0]:
            raise InputError("begins with a gap", where=f"{name}: {signal}", right="begin the log where it is known")
        columns[signal] = np.interp(time, time[finite], values[finite])
    half, close = 0.5 * bench.stroke.reading, READING_MARGIN * bench.stroke.reading
    first = columns["angle"][0]
    if abs(first) > half + close:
        right = f"stroke.reading allows {-half:.4g} to {half:.4g} rad: check the angle's unit and zero, or that range"
        raise InputError(f"begins with {first:.4g} rad", where=f"{name}: angle", right=right)
    stop = "lower_stop" if first <= close - half else "upper_stop" if first >= half - close else None
    return RegulatedLog(name, laws.RegulatedSignals(time=time, **columns), stop)


def _model_outputs(bench: RegulatedJointBench, log: RegulatedLog, data: Dataset, fraction: float) -> list[ModelOutput]:
    """Return angle, rotation and pressures of a log as model outputs; only its first `fraction` is fitted."""
    time, reading = log.signals.time, bench.stroke.reading
    flags = time < time[0] + fraction * (time[-1] - time[0]) if fraction < 1.0 else np.ones(len(time), dtype=bool)
    angle = np.asarray(data["angle"].values, dtype=np.float64)
    measured = {"angle": angle, "rotation": _rotation(time, angle)}
    outputs = [
        ModelOutput(key, "rad", log.name, time, values, flags, ERROR_RATIOS[key] * reading)
        for key, values in measured.items()
    ]
    for key in ("pressure_a", "pressure_b"):
        values = np.asarray(data[key].values, dtype=np.float64)
        outputs.append(ModelOutput(key, "Pa", log.name, time, values, flags, PRESSURE_SCALE))
    return outputs


DESCRIPTION = RegulatedJointBench
BENCH = BenchKind(tuple(REGULATED_BLOCKS), tuple(REGULATED_BLOCKS), RegulatedModel, even=True)
