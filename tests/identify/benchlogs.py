"""A small joint's log as a CSV file, and ways to spoil it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from layflat.machine import Machine, changed, load
from layflat.sim import rollout

Array = NDArray[np.float64]

NAMES = {
    "time": "time [s]",
    "angle": "angle.small [deg]",
    "voltage": "voltage.small [V]",
    "pressure": "measured_pressure.small [bar]",
}


def real() -> Machine:
    """The small joint with another brake than described."""
    machine = changed(load("paper-small-joint"), "joint.small.brake.torque", 3.1)
    return changed(machine, "joint.small.brake.viscous", 0.05)


@lru_cache(maxsize=8)
def columns(brake: float = 3.1, seed: int = 0) -> dict[str, Array]:
    """What the sensors saw in 4 s of moves, by signal."""
    levels = (0.0, 0.35, -0.25, 0.4, -0.4, 0.1, 0.15, 0.0)
    machine = changed(real(), "joint.small.brake.torque", brake)
    run = rollout(machine, lambda t: [levels[int(2.0 * t) % 8]], duration=4.0, start=0.0, seed=seed)
    one = run.sel(joint="small")
    return {
        "time": one["time"].to_numpy(),
        "angle": np.degrees(one["measured_angle"].to_numpy()),
        "voltage": one["voltage"].to_numpy(),
        "pressure": 1e-5 * one["measured_pressure"].to_numpy(),
    }


def written(path: Path, table: dict[str, Array], **names: str) -> Path:
    """A table as CSV, its columns called as layflat calls them, or as `names` say."""
    header = ",".join(names.get(key, NAMES.get(key, key)) for key in table)
    np.savetxt(path, np.stack(list(table.values()), axis=1), delimiter=",", header=header, comments="", fmt="%.9g")
    return path
