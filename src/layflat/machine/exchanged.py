"""Variants of a machine: with another kind of losses or control law, and the members of a cloud."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from layflat.arrays import Array
from layflat.control.tracking import TrackingControllerPart
from layflat.description.change import annotation_at, changed_all, quantity_of, value_at
from layflat.description.units import quantity
from layflat.errors import InputError, MachineError
from layflat.machine import parameters
from layflat.machine.cloud import PAPER_CLOUD, load_cloud
from layflat.machine.loader import load
from layflat.machine.model import Machine

COMMON_LOSS_KEYS = ("reference_pressure_gauge", "pressure_free", "damping_time")
"""Keys that losses of every kind have: dependence on pressure and on velocity."""


def with_losses(machine: Machine, kind: str, values: Mapping[str, Any], joints: Sequence[str] | None = None) -> Machine:
    """Return a machine whose joints have another kind of losses; `COMMON_LOSS_KEYS` keep their values.

    Args:
        machine: the original, which is not changed.
        kind: name of the kind of losses.
        values: further values of the description of this kind, by key.
        joints: names of the joints; None: all.
    """
    kept = {
        name: {key: getattr(machine.joint[name].losses, key) for key in COMMON_LOSS_KEYS}
        for name in joints or machine.joint
    }
    return changed_all(
        machine, {f"joint.{name}.losses": {"kind": kind, **common, **values} for name, common in kept.items()}
    )


def with_tracking(machine: Machine) -> Machine | None:
    """Return the machine with a tracking controller, without gains; None if that law can't model its valves.

    A machine that has such a controller is returned as it is.
    """
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


def member_names(machine_name: str, path: Path = PAPER_CLOUD) -> list[str]:
    """Return the names by which all members of a cloud are loaded: "NAME@0", or "NAME@FILE:0" for one's own file.

    NAME is not checked: the cloud may have no values of this machine.

    Raises:
        MachineError: the file can't be read, is no cloud, or is of another version.
    """
    at = "" if path == PAPER_CLOUD else f"{path}:"
    return [f"{machine_name}@{at}{number}" for number in range(len(load_cloud(path).members))]


def member_values(where: str, path: Path = PAPER_CLOUD) -> dict[str, Array]:
    """Return the values (SI) in which a machine's members differ, by dotted path, an item a member; gains left out.

    Raises:
        MachineError: the file can't be read, or is no cloud of this machine.
    """
    cloud, members = load_cloud(path), member_names(where, path)
    first, last = load(members[0]), load(members[-1])
    values = {}
    for i, column in enumerate(cloud.columns):
        texts = [f"{member[i]:g} {column.unit}" if column.unit else member[i] for member in cloud.members]
        for key in (key for key in column.paths if ".gains." not in key):
            try:
                ends = float(value_at(first, key)), float(value_at(last, key))
                kind = quantity_of(annotation_at(first, key))
            except InputError:  # of a joint that it does not have
                continue
            numbers = np.array([float(text) if kind is None else quantity(text, kind, key) for text in texts])
            # The description may replace a value of the cloud, and the cloud have columns of other machines.
            if ends == (numbers[0], numbers[-1]) and np.ptp(numbers) > 0.0:
                values[key] = numbers
    return values
