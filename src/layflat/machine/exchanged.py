"""Other machines in place of one: with another kind of losses or control law, and the members of a cloud."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.control.tracking.description import TrackingControllerPart
from layflat.description.change import changed_all, value_at
from layflat.errors import InputError, MachineError
from layflat.machine import parameters
from layflat.machine.cloud import PAPER, cloud
from layflat.machine.loader import load
from layflat.machine.model import Machine

KEPT = ("reference_pressure_gauge", "pressure_free", "damping_time")
"""What losses of every kind have: how they go with pressure, and with velocity."""


def with_losses(machine: Machine, kind: str, values: Mapping[str, Any], joints: Sequence[str] | None = None) -> Machine:
    """Return a machine whose joints have a kind of losses, what every kind has as before.

    Args:
        machine: which is not changed.
        kind: of losses.
        values: what else a description of this kind says, by key.
        joints: by name; None: all.
    """
    kept = {name: {key: getattr(machine.joint[name].losses, key) for key in KEPT} for name in joints or machine.joint}
    return changed_all(machine, {f"joint.{name}.losses": {"kind": kind, **own, **values} for name, own in kept.items()})


def with_tracking(machine: Machine) -> Machine | None:
    """Return the machine with a tracking controller, as it is where it has one; None if the law can't model it."""
    if isinstance(machine.controller, TrackingControllerPart):
        return machine
    gains = {f"joint.{name}.gains": None for name in machine.joint}
    controller = TrackingControllerPart(kind="tracking", cycle=f"{machine.cycle!r} s")
    tracking = changed_all(machine, {**gains, "controller": controller})
    try:
        parameters.control(tracking)
    except MachineError:
        return None
    return tracking


def members(where: str, path: Path = PAPER) -> list[str]:
    """Return the names of a machine's members, in the order of the cloud that a file keeps.

    Raises:
        MachineError: the file is no cloud, or of another version.
    """
    at = "" if path == PAPER else f"{path}:"
    return [f"{where}@{at}{number}" for number in range(len(cloud(path).members))]


def differing(where: str, path: Path = PAPER) -> dict[str, Array]:
    """Return the numbers (SI) in which a machine's members differ, by dotted path: all but gains, an item a member.

    Raises:
        MachineError: the file is no cloud of this machine.
    """
    machines = [load(name) for name in members(where, path)]
    found = {}
    for column in cloud(path).columns:
        for key in (key for key in column.paths if ".gains." not in key):
            try:
                numbers = np.array([value_at(machine, key) for machine in machines], dtype=float)
            except InputError:  # of a joint that it does not have
                continue
            if np.ptp(numbers) > 0.0:
                found[key] = numbers
    return found
