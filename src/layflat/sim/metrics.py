"""What a run is worth: one definition for each metric.

All take a run (see dataset.py) and look at the stretch between two times.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.physics.air import NORMAL_DENSITY
from layflat.sim.tally import last_records, tallied

if TYPE_CHECKING:
    import xarray

BAND = radians(0.3)  # within this of its demand a joint has settled, rad
MOST_MOVES = 100  # a demand that changes more often is taken for one that moves all the time


@dataclass(frozen=True)
class Move:
    """Metrics of one joint over one move; `settling` is infinite where it does not settle."""

    joint: str
    settling: float  # s
    overshoot: float  # rad
    steady_error: float  # rad, mean over the last fifth of the move
    ripple: float  # rad, peak to peak over the last fifth of the move


def settling_time(time: NDArray[np.floating[Any]], error: Array, band: float) -> float:
    """Time of the last exit from +-band, counted from the first instant; infinite if the end lies outside."""
    records = int(tallied(np.ascontiguousarray(error), 0.0, band).settled)
    return float(time[records] - time[0]) if records < len(error) else inf


def move(run: xarray.Dataset, joint: str, since: float = 0.0, until: float = inf, band: float = BAND) -> Move:
    """Metrics of a joint between two times, against the demand that holds at the end of them."""
    part = run.sel(joint=joint, time=slice(since, until))
    time, angle = part["time"].to_numpy(), part["angle"].to_numpy()
    demand = float(part["demand"][-1])
    tally = tallied(angle - demand, np.sign(demand - angle[0]), band)
    records = int(tally.settled)
    return Move(
        joint,
        float(time[records] - time[0]) if records < len(time) else inf,
        float(tally.overshoot),
        float(tally.last_sum / (len(time) - last_records(len(time)))),
        float(tally.last_high - tally.last_low),
    )


def disturbance(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """Return how far a joint is pushed from where it stands when another one begins to move, rad."""
    angle = run["angle"].sel(joint=joint, time=slice(since, until)).to_numpy()
    return float(np.abs(angle - angle[0]).max())


def move_windows(demand: Array) -> list[tuple[int, int]]:
    """First and last record of every move: from each change of any demand (records, joints) to the next.

    A demand that never changes is one move, and so is one that changes all the time.
    """
    changes = np.flatnonzero(np.any(np.diff(demand, axis=0) != 0.0, axis=1)) + 1
    starts = [0] if len(changes) == 0 or len(changes) > MOST_MOVES else [int(k) for k in changes]
    return list(zip(starts, [*(k - 1 for k in starts[1:]), len(demand) - 1], strict=True))


def moves_of(run: xarray.Dataset, band: float = BAND) -> list[tuple[float, Move]]:
    """Metrics of joints from each change of any demand to the next, with the time of the change.

    Joints are those that have somewhere to go then; all of them where none has.
    """
    time, angle, demand = (run[name].to_numpy() for name in ("time", "angle", "demand"))
    joints = [str(name) for name in run["joint"].to_numpy()]
    return [
        (float(time[first]), move(run, joints[j], float(time[first]), float(time[last]), band))
        for first, last in move_windows(demand)
        for j in _moving(angle, demand, first, last, band)
    ]


def _moving(angle: Array, demand: Array, first: int, last: int, band: float) -> list[int]:
    """Return the numbers of the joints that have somewhere to go between two records, or of all."""
    if first > 0:
        goes = demand[first] != demand[first - 1]
    else:
        goes = (np.abs(angle[0] - demand[0]) > band) | np.any(demand[: last + 1] != demand[0], axis=0)
    return [int(j) for j in np.flatnonzero(goes)] or list(range(demand.shape[1]))


def tip_settling(run: xarray.Dataset, since: float, until: float, band: float) -> float:
    """Time after which the tip stays within `band` (m) of where the demands put it; infinite if it does not."""
    from layflat.machine.model import restored  # noqa: PLC0415
    from layflat.motion.kinematics import tip_position  # noqa: PLC0415

    part = run.sel(time=slice(since, until))
    machine = restored(run.attrs["machine"])
    goal = tip_position(machine, part["demand"].to_numpy()[-1])
    distance = np.linalg.norm(part["tip"].to_numpy() - goal, axis=-1)
    return settling_time(part["time"].to_numpy(), distance, band)


def air_used(run: xarray.Dataset) -> float:
    """Air taken from the supply by all joints, normal litres."""
    return float(run["air_taken"][-1].sum() - run["air_taken"][0].sum()) / NORMAL_DENSITY * 1000.0


def peak_tip_acceleration(run: xarray.Dataset) -> float:
    """Greatest acceleration of the payload, m/s2, from second differences of its position at the records."""
    tip, time = run["tip"].to_numpy(), run["time"].to_numpy()
    if len(time) < 3:
        return 0.0
    second = np.diff(tip, 2, axis=0) / np.square(time[1] - time[0])
    return float(np.linalg.norm(second, axis=1).max())
