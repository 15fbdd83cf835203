"""A regulated joint: from the set-points alone to both pressures and the angle.

A joint that friction holds, and that no spring centres, adds up every small error of its pressures. So besides the
angle a fit compares the rotation in the last second, in which an error of long ago no longer shows (as one takes the
differences of a random walk); and it goes by continuation, from easy to hard:

1. the joint moves as measured: what valves and chambers do;
2. the chambers have the pressures that were measured: what friction and load do;
3. nothing is given but the set-points.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from layflat.errors import InputError
from layflat.identify.benches.contract import Bench, Logs, check_known, check_logs
from layflat.identify.benches.regulated.description import RegulatedJointBench, friction_law
from layflat.identify.benches.regulated.run import MOTION, NOTHING, PRESSURES, Candidates, Course, simulate_regulated
from layflat.identify.benches.regulated.unknowns import BLOCKS, unknowns_of
from layflat.identify.model import FITTED, Array, Model, Output

if TYPE_CHECKING:
    import xarray

ROTATION_TIME = 1.0
"""The rotation compared is that in so much time, s."""

SCALES = {"angle": 0.1, "rotation": 0.02}
"""An error of this share of the reading matters."""

PRESSURE_SCALE = 4e3
"""Pa."""

AT_END = 1e-3
"""A reading within this share of its range from an end is at that end."""

SIGNALS = ("setpoint_a", "setpoint_b", "angle", "pressure_a", "pressure_b")


class Log(NamedTuple):
    """A log as it is used: its name, its signals, and whether the reading begins at the lower or upper end."""

    name: str
    course: Course
    at_lower: bool
    at_upper: bool


class RegulatedModel(Model):
    """Angle, rotation and both pressures of every log.

    Args:
        bench: where the search begins, and what is held.
        logs: by name: time from 0, and `SIGNALS` in SI; from rest.
        blocks: what to fit, of `BLOCKS`.
        validation: names of logs that are only predicted.
        fitted_share: of the time of each other log, from its start, that is fitted; the rest is for validation.

    Raises:
        InputError: a log lacks a signal or begins with none, or a block or log is unknown.
    """

    def __init__(
        self,
        bench: RegulatedJointBench,
        logs: Mapping[str, xarray.Dataset],
        *,
        blocks: Collection[str] = BLOCKS,
        validation: Collection[str] = (),
        fitted_share: float = 1.0,
    ) -> None:
        check_known(blocks, BLOCKS, "blocks", "block")
        check_logs(logs, validation, fitted_share)
        logs = {name: _of_one_joint(name, log) for name, log in logs.items()}
        self.bench, self.given, self.blocks = bench, NOTHING, tuple(blocks)
        self.logs = tuple(_read(bench, name, log) for name, log in logs.items())
        fitted = [log for log in self.logs if log.name not in validation] or list(self.logs)
        near = (0.5 - AT_END) * bench.stroke.reading
        at_lower = min(log.course.angle.min() for log in fitted) <= -near
        at_upper = max(log.course.angle.max() for log in fitted) >= near
        self.unknowns = unknowns_of(bench, self.blocks, bool(at_lower), bool(at_upper))
        self.outputs = tuple(
            output
            for log in self.logs
            for output in _outputs(bench, log, logs[log.name], 0.0 if log.name in validation else fitted_share)
        )

    def continuation(self) -> Sequence[Model]:
        """The joint as measured, the pressures as measured, then neither."""
        easier = ((MOTION, {"valve", "gas"}), (PRESSURES, {"motion"}))
        return [*(_as_measured(self, given) for given, fitted in easier if fitted & set(self.blocks)), self]

    def simulate(self, values: Array) -> Array:
        """All outputs of candidates, one after the other, (candidates, samples)."""
        found = {unknown.path: column for unknown, column in zip(self.unknowns, values.T, strict=True)}
        candidates = candidates_of(self.bench, self.logs, found, len(values))
        runs = simulate_regulated(candidates, [log.course for log in self.logs], given=self.given)
        columns, half = [], 0.5 * self.bench.stroke.reading
        for log, run in zip(self.logs, runs, strict=True):
            angle = np.clip(run[:, :, 0], -half, half)
            columns += [angle, _rotation(log.course.time, angle), run[:, :, 1], run[:, :, 2]]
        return np.concatenate(columns, axis=1)


def candidates_of(
    bench: RegulatedJointBench, logs: Sequence[Log], found: Mapping[str, Array], count: int
) -> Candidates:
    """Parameters of candidates: those of the description, but for what was found, by its path."""

    def at(path: str) -> Array:
        part, key = path.split(".")
        return found[path] if path in found else np.full(count, float(getattr(getattr(bench, part), key)))

    torque, fade = friction_law(at("friction.lower_end"), at("friction.upper_end"), bench.stroke.reading)
    valve = ("gain", "offset", "lag", "delay", "conductance_in", "conductance_out", "band_in", "band_out")
    return Candidates(
        **{key: at(f"valve.{key}") for key in valve},
        critical_ratio=at("valve.critical_ratio"),
        volume=at("chamber.volume"),
        wall_conductance=at("chamber.wall_conductance"),
        torque_per_pressure=at("chamber.torque_per_pressure"),
        supply_pressure=at("supply.pressure"),
        ambient_pressure=at("supply.ambient_pressure"),
        temperature=at("supply.temperature"),
        inertia=at("load.inertia"),
        damping=at("load.damping"),
        load_torque=at("load.torque"),
        stiffness=at("load.stiffness"),
        friction_torque=torque,
        friction_fade=fade,
        friction_lag=at("friction.lag"),
        lower_stop=at("stroke.lower_stop"),
        upper_stop=at("stroke.upper_stop"),
        start_angle=np.array([_start(log, at) for log in logs]),
    )


def _as_measured(model: RegulatedModel, given: int) -> Model:
    """The same unknowns and outputs, with motion or pressures given."""
    other = copy(model)
    other.given = given
    return other


def _start(log: Log, at: Callable[[str], Array]) -> Array:
    """Angle that a log begins with: a reading at its end is that of a joint at its stop, (candidates,)."""
    if log.at_lower:
        return at("stroke.lower_stop")
    return at("stroke.upper_stop") if log.at_upper else np.full_like(at("stroke.lower_stop"), log.course.angle[0])


def _rotation(time: Array, angle: Array) -> Array:
    """Rotation in the last `ROTATION_TIME` seconds along the last axis; not a number before."""
    earlier = np.searchsorted(time, time - ROTATION_TIME + 1e-9, side="right") - 1
    return np.asarray(np.where(earlier >= 0, angle - angle[..., np.maximum(earlier, 0)], np.nan))


def _of_one_joint(name: str, log: xarray.Dataset) -> xarray.Dataset:
    """A log without the dimension `joint`."""
    if "joint" not in log.dims:
        return log
    if log.sizes["joint"] != 1:
        raise InputError(f"has {log.sizes['joint']} joints", where=name, right="map the columns of one joint")
    return log.isel(joint=0)


def _read(bench: RegulatedJointBench, name: str, data: xarray.Dataset) -> Log:
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
    return Log(name, Course(time=time, **columns), bool(first <= close - half), bool(first >= half - close))


def _outputs(bench: RegulatedJointBench, log: Log, data: xarray.Dataset, share: float) -> list[Output]:
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


def _model(bench: RegulatedJointBench, logs: Logs, blocks: Sequence[str], validation: Logs) -> Model:
    share = 1.0 if validation else FITTED
    every = {**logs, **validation}
    return RegulatedModel(bench, every, blocks=blocks, validation=list(validation), fitted_share=share)


BENCH = Bench(BLOCKS, BLOCKS, _model, even=True)
