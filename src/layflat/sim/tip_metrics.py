"""What a run is worth at the tip of the arm, in the plane or in space, against where the demands put it.

All take a run (see dataset.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.machine.model import restored
from layflat.motion.kinematics import tip_position
from layflat.sim.metrics import move_windows, settling_time
from layflat.sim.tally import last_records

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True)
class TipMove:
    """Metrics of the tip over one move, from where it is to come at the end of it."""

    settling: tuple[float, ...]  # within each band, s; infinite where it does not settle
    error: float  # greatest distance over the last fifth of the move, m


@dataclass(frozen=True)
class Missed:
    """Distances of the tip while demands change, m: rms and greatest."""

    behind: tuple[float, float]  # from where it should be
    beside: tuple[float, float]  # from the nearest place on the path of where it should be


def demanded_tip(run: xarray.Dataset) -> Array:
    """Return where the demands put the tip, (instants, axes), m."""
    return tip_position(restored(run.attrs["machine"]), run["demand"].to_numpy())


def tip_moves_of(run: xarray.Dataset, bands: tuple[float, ...]) -> list[tuple[float, TipMove]]:
    """Return metrics of the tip from each change of any demand to the next, with the time of the change.

    Args:
        run: of any arm.
        bands: distances within which the tip has settled, m.
    """
    time, tip, goals, found = run["time"].to_numpy(), run["tip"].to_numpy(), demanded_tip(run), []
    for first, last in move_windows(run["demand"].to_numpy()):
        part = slice(first, last + 1)
        away = np.linalg.norm(tip[part] - goals[last], axis=1)
        settling = tuple(settling_time(time[part], away, band) for band in bands)
        found.append((float(time[first]), TipMove(settling, float(away[last_records(len(away)) :].max()))))
    return found


def tip_missed(run: xarray.Dataset) -> Missed:
    """Return how far the tip was from where it should be, and from its path, in a run whose demands change."""
    tip, goals = run["tip"].to_numpy(), demanded_tip(run)
    behind = np.linalg.norm(tip - goals, axis=1)
    return Missed(_sizes(behind), _sizes(_from_path(tip, goals)))


def _sizes(distances: Array) -> tuple[float, float]:
    return float(np.sqrt(np.mean(distances**2))), float(distances.max())


def _from_path(points: Array, path: Array) -> Array:
    """Return the distances of points (points, axes) from a line through others (instants, axes), m."""
    from scipy.spatial import KDTree  # noqa: PLC0415  # takes long to import

    nearest = KDTree(path).query(points)[1]
    apart = []
    for begin in (np.maximum(nearest - 1, 0), np.minimum(nearest, len(path) - 2)):
        start, way = path[begin], path[begin + 1] - path[begin]
        share = np.sum((points - start) * way, axis=1) / np.maximum(np.sum(way**2, axis=1), 1e-18)
        apart.append(np.linalg.norm(points - start - np.clip(share, 0.0, 1.0)[:, None] * way, axis=1))
    nearer: Array = np.minimum(*apart)
    return nearer
