"""Logs in which a joint is thrown to its stop end there."""

import numpy as np

from layflat.arrays import Dataset
from layflat.errors import InputError
from layflat.identify.benches.contract import Logs
from layflat.identify.logs.checks.stops import RIGHT, impact
from layflat.machine import Machine

SHORTEST = 3.0  # of what is left of a log, s


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
        angles = {joint: np.asarray(log["angle"].sel(joint=joint), dtype=np.float64) for joint in machine.joints}
        first = {joint: impact(machine, joint, of, machine.cycle) for joint, of in angles.items()}
        thrown = {joint: sample for joint, sample in first.items() if sample is not None}
        if not thrown:
            continue
        joint, end = min(thrown.items(), key=lambda one: one[1])
        what = f"up to {float(log['time'][end]):.3g} s, where joint {joint!r} is thrown to its stop"
        if end * machine.cycle < SHORTEST:
            raise InputError(f"is of use only {what}", where=name, right=RIGHT)
        found[name] = log.isel(time=slice(end))
        said.append(f"Log {name!r} is used {what}: {RIGHT}.")
    return found, tuple(said)
