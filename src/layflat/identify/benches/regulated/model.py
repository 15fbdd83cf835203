"""A regulated joint: from the set-points alone to both pressures and the angle.

A joint that friction holds, and that no spring centres, adds up every small error of its pressures. So besides the
angle a fit compares the rotation in the last second, in which an error of long ago no longer shows (as one takes the
differences of a random walk); and it goes by continuation, from easy to hard:

1. the joint moves as measured: what valves and chambers do;
2. the chambers have the pressures that were measured: what friction and load do;
3. nothing is given but the set-points.
"""

from collections.abc import Collection, Mapping, Sequence
from copy import copy
from typing import NamedTuple, Self

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.description.change import changed
from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, chosen, fitted_share_of, simulated, with_columns
from layflat.identify.benches.regulated import run
from layflat.identify.benches.regulated.description import BLOCKS, RegulatedJointBench
from layflat.identify.benches.regulated.laws import Air, LaggingFriction, RegulatedJoint, Regulator
from layflat.identify.model import Model, Output
from layflat.physics.chamber import Chamber
from layflat.physics.flow import laminar_slope

ROTATION_TIME = 1.0  # the rotation compared is that in so much time, s
SCALES = {"angle": 0.1, "rotation": 0.02}  # an error of this share of the reading matters
PRESSURE_SCALE = 4e3  # pa
AT_END = 1e-3  # a reading within this share of its range from an end is at that end

LEVELS = ("friction.upper_end", "friction.change_angle", "friction.change_width", "friction.lag")
"""Unknowns of a friction whose level changes."""

SIGNALS = ("setpoint_a", "setpoint_b", "angle", "pressure_a", "pressure_b")


class Log(NamedTuple):
    """A log as it is used: its name, its signals, and the stop that its reading begins at, if it does."""

    name: str
    course: run.Course
    stop: str | None


class RegulatedModel(Model):
    """Angle, rotation and both pressures of every log; made as `Bench` says.

    Logs have `SIGNALS` in SI, from rest. `fitted_share` of the time of each is fitted, from its start; the rest is for
    validation. Default: all, or two thirds where there is no other log for validation.
    """

    cross_validated = True
    one_level = False  # whether the friction at high angles is that at low ones

    def __init__(
        self,
        bench: RegulatedJointBench,
        logs: Logs,
        validation: Logs | None = None,
        *,
        blocks: Collection[str] = tuple(BLOCKS),
        fitted_share: float | None = None,
    ) -> None:
        specs = chosen(BLOCKS, blocks)
        share = fitted_share_of(logs, validation, fitted_share)
        every = {name: _of_one_joint(name, log) for name, log in (*logs.items(), *(validation or {}).items())}
        self.bench, self.given, self.blocks = bench, run.NOTHING, set(blocks)
        self.described_ratio = bench.friction.static_ratio
        self.logs = tuple(_read(bench, name, log) for name, log in every.items())
        angles = np.concatenate([log.course.angle for log in self.logs[: len(logs)]])
        near = (0.5 - AT_END) * bench.stroke.reading
        there = {"stroke.lower_stop": angles.min() <= -near, "stroke.upper_stop": angles.max() >= near}
        self.unknowns = tuple(spec.unknown(bench) for spec in specs if there.get(spec.path, True))
        self.outputs = tuple(
            output
            for log in self.logs
            for output in _outputs(bench, log, every[log.name], share if log.name in logs else 0.0)
        )

    def continuations(self) -> Sequence[Sequence[Model]]:
        """The joint as measured, the pressures as measured, then neither."""
        easier = ((run.MOTION, {"valve", "gas"}), (run.PRESSURES, {"motion"}))
        return [[*(self._as_measured(given) for given, fitted in easier if fitted & self.blocks), self]]

    def simpler(self) -> Mapping[str, Model]:
        """Return a joint with Coulomb friction, and one with static friction beside it."""
        if "motion" not in self.blocks:
            return {}
        sticking = self.held(LEVELS)
        sticking.one_level = True
        sliding = copy(sticking)
        sliding.bench = changed(self.bench, "friction.static_ratio", 1.0)
        return {"Coulomb friction": sliding.held(["friction.static_ratio"]), "static friction": sticking}

    def columns(self, values: Array) -> dict[str, Array]:
        """See `Model.columns`."""
        found = super().columns(values)
        return found | {"friction.upper_end": found["friction.lower_end"]} if self.one_level else found

    def written(self, values: Array) -> dict[str, float]:
        """See `Model.written`; also what follows from a simpler law."""
        level = {"friction.upper_end": float(self.columns(values)["friction.upper_end"])} if self.one_level else {}
        ratio = self.bench.friction.static_ratio
        static = {"friction.static_ratio": ratio} if ratio != self.described_ratio else {}
        return super().written(values) | level | static

    def simulate(self, values: Array) -> Array:
        """All outputs of candidates, one after the other, (candidates, samples)."""
        bench, half = with_columns(self.bench, self.columns(values)), 0.5 * self.bench.stroke.reading
        cases = [(parameters(bench, log), log.course, self.given, run.STEP) for log in self.logs]
        runs = simulated(run.run_regulated, len(values), cases, [(len(log.course.time), 3) for log in self.logs])
        columns = []
        for log, found in zip(self.logs, runs, strict=True):
            angle = np.clip(found[:, :, 0], -half, half)
            columns += [angle, _rotation(log.course.time, angle), found[:, :, 1], found[:, :, 2]]
        return np.concatenate(columns, axis=1)

    def _as_measured(self, given: int) -> Self:
        """The same unknowns and outputs, with motion or pressures given."""
        other = copy(self)
        other.given = given
        return other


def parameters(bench: RegulatedJointBench, log: Log) -> run.Setup:
    """What the laws take of a description; a reading at its end is that of a joint at its stop."""
    valve, chamber, load, stroke, supply = bench.valve, bench.chamber, bench.load, bench.stroke, bench.supply
    rubs = bench.friction
    friction = LaggingFriction(
        rubs.lower_end, rubs.upper_end, rubs.change_angle, rubs.change_width, rubs.lag, rubs.static_ratio
    )
    regulator = Regulator(
        valve.gain, valve.offset + 0.5 * valve.mismatch, valve.offset - 0.5 * valve.mismatch, valve.lag,
        valve.conductance_in, valve.conductance_out, valve.band_in, valve.band_out, valve.critical_ratio,
        laminar_slope(valve.critical_ratio),
    )  # fmt: skip
    joint = RegulatedJoint(
        regulator, Chamber(chamber.volume, 0.0, chamber.wall_conductance), chamber.torque_per_pressure,
        load.inertia, load.damping, load.torque, load.stiffness, friction,
        stroke.lower_stop, stroke.upper_stop,
    )  # fmt: skip
    start = getattr(stroke, log.stop) if log.stop else log.course.angle[0]
    return run.Setup(joint, Air(supply.pressure, supply.ambient_pressure, supply.temperature), valve.delay, start)


def _rotation(time: Array, angle: Array) -> Array:
    """Rotation in the last `ROTATION_TIME` seconds along the last axis; not a number before."""
    earlier = np.searchsorted(time, time - ROTATION_TIME + 1e-9, side="right") - 1
    return np.asarray(np.where(earlier >= 0, angle - angle[..., np.maximum(earlier, 0)], np.nan))


def _of_one_joint(name: str, log: Dataset) -> Dataset:
    """A log without the dimension `joint`."""
    if "joint" not in log.dims:
        return log
    if log.sizes["joint"] != 1:
        raise InputError(f"has {log.sizes['joint']} joints", where=name, right="map the columns of one joint")
    return log.isel(joint=0)


def _read(bench: RegulatedJointBench, name: str, data: Dataset) -> Log:
    """The signals of a log; gaps in what was measured are bridged, as only the easier ways use them."""
    for signal in SIGNALS:
        if signal not in data:
            raise InputError(f"has no {signal}", where=name, right=f"a regulated joint needs {', '.join(SIGNALS)}")
    time = np.asarray(data["time"].values, dtype=np.float64)
    if len(time) < 3 or not (np.diff(time) > 0.0).all():
        raise InputError("its time does not grow", where=name, right="give 3 samples or more, in order")
    columns = {}
    for signal in SIGNALS:
        values = np.asarray(data[signal].values, dtype=np.float64)
        known = np.isfinite(values)
        if not known.all() and signal.startswith("setpoint"):
            raise InputError("has gaps", where=f"{name}: {signal}", right="commands have to be known throughout")
        if not known[0]:
            raise InputError("begins with a gap", where=f"{name}: {signal}", right="cut the log where it is known")
        columns[signal] = np.interp(time, time[known], values[known])
    half, close = 0.5 * bench.stroke.reading, AT_END * bench.stroke.reading
    first = columns["angle"][0]
    if abs(first) > half + close:
        right = f"it reads from {-half:.4g} to {half:.4g} rad: see stroke.reading"
        raise InputError(f"begins with {first:.4g} rad", where=f"{name}: angle", right=right)
    stop = "lower_stop" if first <= close - half else "upper_stop" if first >= half - close else None
    return Log(name, run.Course(time=time, **columns), stop)


def _outputs(bench: RegulatedJointBench, log: Log, data: Dataset, share: float) -> list[Output]:
    time, reading = log.course.time, bench.stroke.reading
    flags = time < time[0] + share * (time[-1] - time[0]) if share < 1.0 else np.ones(len(time), dtype=bool)
    angle = np.asarray(data["angle"].values, dtype=np.float64)
    measured = {"angle": angle, "rotation": _rotation(time, angle)}
    found = [
        Output(key, "rad", log.name, time, values, flags, SCALES[key] * reading) for key, values in measured.items()
    ]
    for key in ("pressure_a", "pressure_b"):
        values = np.asarray(data[key].values, dtype=np.float64)
        found.append(Output(key, "Pa", log.name, time, values, flags, PRESSURE_SCALE))
    return found


BENCH = Bench(tuple(BLOCKS), tuple(BLOCKS), RegulatedModel, even=True)
