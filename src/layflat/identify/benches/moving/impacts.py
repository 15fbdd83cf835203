"""Logs in which a joint is thrown to its stop end there.

Where it goes from its stop hangs on the last digits of how it came, and what a stop does is not fitted: a search that
has to explain an impact ends anywhere.
"""

import numpy as np

from layflat.arrays import Array, Dataset
from layflat.errors import InputError
from layflat.identify.benches.contract import Logs
from layflat.identify.model import Flags
from layflat.machine import Machine, parameters

HARD, BEFORE = 0.5, 4  # speed from which on a joint is thrown to its stop, rad/s, over so many samples before
SHORTEST = 3.0  # of what is left of a log, s
RIGHT = "log it again, slower or over a smaller reach"


def up_to_impacts(machine: Machine, logs: Logs) -> tuple[dict[str, Dataset], tuple[str, ...]]:
    """Logs up to their first impacts, and what is to be said of those that have one, a sentence each.

    Args:
        machine: whose joints they are of.
        logs: by name, with the angle of every joint; those without impacts stay as they are.

    Raises:
        InputError: too little is left of a log.
    """
    found, said = dict(logs), []
    for name, log in logs.items():
        thrown = _thrown(machine, _angles(machine, log))
        if not thrown.any():
            continue
        end = int(np.argmax(thrown.any(axis=1)))
        joint, when = list(machine.joints)[int(np.argmax(thrown[end]))], float(log["time"][end])
        what = f"joint {joint!r} is thrown to its stop at {when:.3g} s"
        if end * machine.cycle < SHORTEST:
            raise InputError(f"{what}, where the log ends for a fit", where=name, right=RIGHT)
        found[name] = log.isel(time=slice(end))
        said.append(f"In {name} {what}, and nothing from there on is used: {RIGHT}.")
    return found, tuple(said)


def _angles(machine: Machine, log: Dataset) -> Array:
    """Measured angles, (samples, joints), those of gaps between their neighbours."""
    rows = log["angle"].sel(joint=list(machine.joints)).transpose("joint", "time").to_numpy()
    time, known = log["time"].to_numpy(), np.isfinite(rows)
    return np.stack([np.interp(time, time[k], row[k]) for row, k in zip(rows, known, strict=True)], axis=1)


def _thrown(machine: Machine, angles: Array) -> Flags:
    """Where joints come to their stops at speed, (samples, joints), or beyond their strokes to where sensors end."""
    _, sensor, _ = parameters.drive_parts(machine)
    seen = 0.5 * sensor.range - sensor.range / 2**sensor.bits
    working, stops = (
        0.5 * np.array([getattr(joint.stops, stroke) for joint in machine.joints.values()])
        for stroke in ("working_stroke", "mechanical_stroke")
    )
    outwards = np.sign(angles[BEFORE:]) * (angles[BEFORE:] - angles[:-BEFORE]) / (BEFORE * machine.cycle)
    arrives = (np.abs(angles[BEFORE:]) > np.clip(seen, working, stops)) & (outwards > HARD)
    return np.pad(arrives, ((BEFORE, 0), (0, 0)))
