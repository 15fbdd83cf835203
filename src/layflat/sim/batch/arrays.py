"""Arrays of a batch: what the kernel reads and writes, and the views of them that users see.

The last axis has an item per arm and is contiguous, so that the kernel reads the lanes of neighbouring arms as vectors.
Users see the same memory with the arms first, (arms, joints). Arrays are padded with copies of the last arm until all
groups of lanes are full.
"""

from collections.abc import Mapping
from itertools import count
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.lanes import mapped
from layflat.motion.scenario import SIGNALS
from layflat.sim.loop import InjectionGains, JointSignals, Noise, SharedSignals

STREAM_WORDS = 5  # of a noise generator: state and step by halves, and whether there is noise


class ArmCarry(NamedTuple):
    """State of an arm between control cycles; tuples have an item per joint."""

    states: Any  # `JointState`
    lines: Any  # commands on their way to the valves
    shares: Any  # fractions of the adjustable inputs at the start of the coming cycle
    memory: Any  # of the control law, one item for all joints
    voltages: Any  # of the last cycle, V
    report: Any  # of the control law in the last cycle


class SeenJoint(NamedTuple):
    """Signals of a joint that follow from its state."""

    sensed_angle: float  # rad
    sensed_pressure: float  # differential, Pa
    valve_opening: float  # -1..1


class BatchArrays(NamedTuple):
    """Arrays of a batch, in its precision unless stated otherwise."""

    parameters: np.ndarray  # every number of the machines in order, (numbers, arms)
    carry: np.ndarray  # numbers of `ArmCarry`, (numbers, arms)
    acting: np.ndarray  # items of `JointSignals`, (joints, signals, arms)
    shared: np.ndarray  # items of `SharedSignals`, (signals, arms)
    injections: np.ndarray  # items of `InjectionGains`, (joints, 4, arms)
    noise: np.ndarray  # standard normal samples of the coming cycle, (1, joints, 2, arms)
    streams: np.ndarray  # generators of the noise, 64-bit words, (5, arms)
    cycles: np.ndarray  # control cycles since each arm's start, integers, (arms,)
    diverged: np.ndarray  # whether an arm has diverged and is held, (arms,)
    seen: np.ndarray  # items of `SeenJoint`, (joints, signals, arms)
    tips: np.ndarray  # coordinates of the tip, m, (3, arms)


Shapes = Mapping[str, tuple[int, ...]]
"""Shape of each of `BatchArrays` without its last axis, by name."""


def array_shapes(numbers: int, carried: int, joints: int) -> Shapes:
    """Return the shapes of the arrays.

    Args:
        numbers: numbers of a machine.
        carried: numbers of its `ArmCarry`.
        joints: number of joints.
    """
    return {
        "parameters": (numbers,),
        "carry": (carried,),
        "acting": (joints, len(JointSignals._fields)),
        "shared": (len(SharedSignals._fields),),
        "injections": (joints, len(InjectionGains._fields)),
        "noise": (1, joints, len(Noise._fields)),
        "streams": (STREAM_WORDS,),
        "cycles": (),
        "diverged": (),
        "seen": (joints, len(SeenJoint._fields)),
        "tips": (3,),
    }


def allocate_arrays(shapes: Shapes, arms: int, number: type[np.floating[Any]]) -> BatchArrays:
    """Return arrays of zeros.

    Args:
        shapes: shapes without the axis of arms.
        arms: number of arms, padding included.
        number: type of the numbers that are neither generators, counts nor flags.
    """
    others = {"streams": np.uint64, "cycles": np.int64, "diverged": np.bool_}
    return BatchArrays(**{name: np.zeros((*shape, arms), others.get(name, number)) for name, shape in shapes.items()})


def bytes_per_arm(shapes: Shapes, number: type[np.floating[Any]]) -> float:
    """Return the memory that an arm takes, bytes."""
    return float(sum(array.nbytes for array in allocate_arrays(shapes, 1, number)))


def copy_arms(source: BatchArrays, taken: NDArray[np.intp], target: BatchArrays, places: NDArray[np.intp]) -> None:
    """Copy arms from one batch's arrays to another's.

    Args:
        source: arrays to read.
        taken: numbers of the arms there.
        target: arrays to write.
        places: numbers of the arms that are overwritten.
    """
    for of, to in zip(source, target, strict=True):
        to[..., places] = of[..., taken]


def rows_of(like: Any) -> Any:
    """Return a nested tuple of the structure of `like` whose leaves are the numbers of their rows."""
    places = count()
    return mapped(like, lambda _: next(places))


def joint_rows(block: Array, rows: list[int], arms: int) -> Array:
    """Return the rows of a signal, one per joint, as a view (arms, joints).

    Args:
        block: (rows, arms), padding included.
        rows: number of the row of each joint, evenly spaced.
        arms: number of arms without padding.
    """
    step = rows[1] - rows[0] if len(rows) > 1 else 1
    return block[rows[0] : rows[-1] + 1 : step, :arms].T


STATE_SIGNALS: Mapping[str, tuple[str, str]] = MappingProxyType({
    "angle": ("rad", "angle from mid-stroke"),
    "velocity": ("rad/s", "angular velocity"),
    "pressure_a": ("Pa", "absolute pressure in hose A"),
    "pressure_b": ("Pa", "absolute pressure in hose B"),
    "voltage": ("V", "control voltage of the last cycle"),
    "sensed_angle": ("rad", "angle as the A/D converter reports it"),
    "sensed_pressure": ("Pa", "differential pressure as the A/D converter reports it"),
    "valve_opening": ("1", "opening of the valve"),
    "tip": ("m", "position of the tip: x, y, z"),
    "time": ("s", "time since the arm's start"),
    "diverged": ("1", "whether the arm diverged and is held"),
})  # fmt: skip
"""Unit and meaning of the live arrays that a batch computes."""


def state_views(arrays: BatchArrays, carry: ArmCarry, arms: int) -> dict[str, Array]:
    """Return the live arrays of `STATE_SIGNALS`, but `time`, as read-only views without the padding.

    Args:
        arrays: arrays of the batch.
        carry: rows of `ArmCarry`.
        arms: number of arms.
    """
    of_states = {
        "angle": [state.motion.angle for state in carry.states],
        "velocity": [state.motion.velocity for state in carry.states],
        "pressure_a": [state.hose_a.pressure for state in carry.states],
        "pressure_b": [state.hose_b.pressure for state in carry.states],
        "voltage": list(carry.voltages),
    }
    views = {name: joint_rows(arrays.carry, rows, arms) for name, rows in of_states.items()}
    views |= {name: arrays.seen[:, i, :arms].T for i, name in enumerate(SeenJoint._fields)}
    return _read_only(views | {"tip": arrays.tips[:, :arms].T, "diverged": arrays.diverged[:arms]})


def report_views(arrays: BatchArrays, carry: ArmCarry, arms: int) -> dict[str, Array]:
    """Return the control law's report as read-only views (arms, joints), by the names of its signals.

    Args:
        arrays: arrays of the batch.
        carry: rows of `ArmCarry`.
        arms: number of arms.
    """
    names, rows = carry.report[0]._fields, zip(*carry.report, strict=True)
    return _read_only({n: joint_rows(arrays.carry, list(own), arms) for n, own in zip(names, rows, strict=True)})


def _read_only(views: dict[str, Array]) -> dict[str, Array]:
    """Return views that can't be written."""
    for view in views.values():
        view.flags.writeable = False
    return views


def input_views(arrays: BatchArrays, arms: int) -> dict[str, Array]:
    """Return the inputs as writable views: signals of joints (arms, joints), of the whole arm (arms,)."""
    of_joints = {name: arrays.acting[:, i, :arms].T for i, name in enumerate(JointSignals._fields)}
    return of_joints | {name: arrays.shared[i, :arms] for i, name in enumerate(SharedSignals._fields)}


INPUT_SIGNALS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {name: SIGNALS[name].recorded for name in (*JointSignals._fields, *SharedSignals._fields)}
    | {"supply": (SIGNALS["supply"].recorded[0], SIGNALS["supply"].meaning)}
)
"""Unit and meaning of the live inputs; the supply's pressure is a gauge pressure, as in a scenario."""
