"""Metrics of a run at the tip of the arm, in the plane or in space, against the tip that the demands define.

Every function takes a run (see dataset.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.machine.model import restore
from layflat.motion.kinematics import tip_position
from layflat.sim.metrics import move_windows, settling_time
from layflat.sim.tally import last_records

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class TipMoveMetrics:
    """Metrics of the tip over one move, against the goal: the demanded tip at the move's end."""

    settling: tuple[float, ...]  # settling time for each band, s; infinite where the tip does not settle
    error: float  # maximum distance from the goal over the last fifth of the move, m


@dataclass(frozen=True)
class PathErrors:
    """Errors of the tip while demands change, m: each rms and maximum."""

    tracking: tuple[float, float]  # distance from the demanded tip at the same instant
    contour: tuple[float, float]  # distance from the nearest point of the demanded tip's path


def demanded_tip(run: xarray.Dataset) -> Array:
    """Return the tip's position at the demanded angles, (instants, axes), m."""
    return tip_position(restore(run.attrs["machine"]), run["demand"].to_numpy())


def measure_tip_moves(run: xarray.Dataset, bands: tuple[float, ...]) -> list[tuple[float, TipMoveMetrics]]:
    """Return metrics of the tip from each change of any demand to the next, with the time of the change.

    Args:
        run: run of any arm.
        bands: distances within which the tip has settled, m.
    """
    time, tip, goals, moves = run["time"].to_numpy(), run["tip"].to_numpy(), demanded_tip(run), []
    for first, last in move_windows(run["demand"].to_numpy()):
        part = slice(first, last + 1)
        distance = np.linalg.norm(tip[part] - goals[last], axis=1)
        settling = tuple(settling_time(time[part], distance, band) for band in bands)
        error = float(distance[last_records(len(distance)) :].max())
        moves.append((float(time[first]), TipMoveMetrics(settling, error)))
    return moves


def measure_path_errors(run: xarray.Dataset) -> PathErrors:
    """Return tracking and contour errors of the tip over all instants of a run, whose demands are to change."""
    tip, goals = run["tip"].to_numpy(), demanded_tip(run)
    tracking = np.linalg.norm(tip - goals, axis=1)
    return PathErrors(_rms_and_max(tracking), _rms_and_max(_path_distances(tip, goals)))


def _rms_and_max(distances: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(distances**2))), float(distances.max())


def _path_distances(points: Array, path: Array) -> Array:
    """Return the distances of points (points, axes) from the polyline through `path` (instants, axes), m."""
    from scipy.spatial import KDTree  # noqa: PLC0415  # takes long to import

    nearest = KDTree(path).query(points)[1]
    distances = []
    for first in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(path) - 2)):  # segments before and after
        start, segment = path[first], path[first + 1] - path[first]
        fraction = np.sum((points - start) * segment, axis=1) / np.maximum(np.sum(segment**2, axis=1), 1e-18)
        distances.append(np.linalg.norm(points - start - np.clip(fraction, 0.0, 1.0)[:, None] * segment, axis=1))
    nearer: Array = np.minimum(*distances)
    return nearer
