"""Metrics of a run: settling time, overshoot, steady error, ripple, air, each defined once.

Every function takes a run (see dataset.py); `since` and `until` bound the interval that counts, s.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf, radians
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from layflat.arrays import Array
from layflat.physics.air import NORMAL_DENSITY
from layflat.sim.tally import last_records, tally_errors

if TYPE_CHECKING:
    import xarray

__all__ = [
    "SETTLING_BAND", "TIP_BAND", "MoveMetrics", "air_used", "disturbance", "measure_move", "measure_moves",
    "peak_tip_acceleration", "settling_time", "tip_settling",
]  # fmt: skip

SETTLING_BAND = radians(0.3)  # within this of its demand a joint has settled, rad
TIP_BAND = 2e-3  # settling band of the tip, m: section 5 of the paper
MAX_MOVES = 100  # a demand that changes more often counts as one continuous motion


@dataclass(frozen=True)
class MoveMetrics:
    """Metrics of one joint over one move; `settling` is infinite where it does not settle."""

    joint: str
    settling: float  # s
    overshoot: float  # rad
    steady_error: float  # rad, angle less demand, mean over the last fifth of the move
    ripple: float  # rad, peak to peak over the last fifth of the move


def settling_time(time: NDArray[np.floating[Any]], error: Array, band: float) -> float:
    """Return the time from the first instant until the error stays within +-band; infinite if it ends outside.

    The band's ends count as inside, NaN as outside.

    Args:
        time: instants, (instants,), s.
        error: error at these instants, (instants,).
        band: limit of the error's magnitude, in its unit.
    """
    records = int(tally_errors(error, 0.0, band).settled)
    return float(time[records] - time[0]) if records < len(error) else inf


def measure_move(
    run: xarray.Dataset, joint: str, since: float = 0.0, until: float = inf, band: float = SETTLING_BAND
) -> MoveMetrics:
    """Return metrics of a joint between two times, against the demand that holds at the end.

    Args:
        run: the run.
        joint: name of the joint.
        since: start of the move, s.
        until: end of the move, s.
        band: band of settling, rad.
    """
    part = run.sel(joint=joint, time=slice(since, until))
    time, angle = part["time"].to_numpy(), part["angle"].to_numpy()
    demand = float(part["demand"][-1])
    tally = tally_errors(angle - demand, np.sign(demand - angle[0]), band)
    records = int(tally.settled)
    return MoveMetrics(
        joint,
        float(time[records] - time[0]) if records < len(time) else inf,
        float(tally.overshoot),
        float(tally.last_sum / (len(time) - last_records(len(time)))),
        float(tally.last_high - tally.last_low),
    )


def disturbance(run: xarray.Dataset, joint: str, since: float, until: float) -> float:
    """Return the maximum deflection of a joint, either way, from its angle at `since`, by another joint's motion, rad.

    Args:
        run: the run.
        joint: name of the joint that stands still.
        since: time at which the other joint begins to move, s.
        until: end of the interval, s.
    """
    angle = run["angle"].sel(joint=joint, time=slice(since, until)).to_numpy()
    return float(np.abs(angle - angle[0]).max())


def move_windows(demand: Array) -> list[tuple[int, int]]:
    """Return the first and last record of every move: from each change of any demand (records, joints) to the next.

    A demand that never changes is one move, and so is one that changes more than `MAX_MOVES` times.
    """
    changes = np.flatnonzero(np.any(np.diff(demand, axis=0) != 0.0, axis=1)) + 1
    starts = [0] if len(changes) == 0 or len(changes) > MAX_MOVES else [int(k) for k in changes]
    return list(zip(starts, [*(k - 1 for k in starts[1:]), len(demand) - 1], strict=True))


def measure_moves(run: xarray.Dataset, band: float = SETTLING_BAND) -> list[tuple[float, MoveMetrics]]:
    """Return metrics of the moving joints from each change of any demand to the next, with the time of the change (s).

    Joints are those whose demand changes or, at the start, whose angle is outside the band; all joints if none does.
    """
    time, angle, demand = (run[name].to_numpy() for name in ("time", "angle", "demand"))
    joints = [str(name) for name in run["joint"].to_numpy()]
    return [
        (float(time[first]), measure_move(run, joints[j], float(time[first]), float(time[last]), band))
        for first, last in move_windows(demand)
        for j in _moving_joints(angle, demand, first, last, band)
    ]


def _moving_joints(angle: Array, demand: Array, first: int, last: int, band: float) -> list[int]:
    """Return the numbers of the joints that are to move between two records, or of all joints if none is."""
    if first > 0:
        moves = demand[first] != demand[first - 1]
    else:
        moves = (np.abs(angle[0] - demand[0]) > band) | np.any(demand[: last + 1] != demand[0], axis=0)
    return [int(j) for j in np.flatnonzero(moves)] or list(range(demand.shape[1]))


def tip_settling(run: xarray.Dataset, since: float, until: float, band: float) -> float:
    """Return the time from `since` until the tip stays within a distance of its goal, s; infinite if it does not.

    The goal is the tip at the demands of the interval's last instant.

    Args:
        run: the run.
        since: start of the move, s.
        until: end of the move, s.
        band: distance from the goal, m.
    """
    from layflat.machine.model import restore  # noqa: PLC0415
    from layflat.motion.kinematics import tip_position  # noqa: PLC0415

    part = run.sel(time=slice(since, until))
    machine = restore(run.attrs["machine"])
    goal = tip_position(machine, part["demand"].to_numpy()[-1])
    distance = np.linalg.norm(part["tip"].to_numpy() - goal, axis=-1)
    return settling_time(part["time"].to_numpy(), distance, band)


def air_used(run: xarray.Dataset) -> float:
    """Return the air that all joints consumed from the supply, normal litres."""
    return float(run["air_taken"][-1].sum() - run["air_taken"][0].sum()) / NORMAL_DENSITY * 1000.0


def peak_tip_acceleration(run: xarray.Dataset) -> float:
    """Return the maximum acceleration of the tip, m/s2, by second differences; 0 for fewer than 3 records."""
    tip, time = run["tip"].to_numpy(), run["time"].to_numpy()
    if len(time) < 3:
        return 0.0
    second = np.diff(tip, 2, axis=0) / np.square(time[1] - time[0])
    return float(np.linalg.norm(second, axis=1).max())
