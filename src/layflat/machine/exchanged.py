"""Machines with another kind of losses in their joints, or of control law."""

from collections.abc import Mapping, Sequence
from typing import Any

from layflat.control.tracking.description import TrackingControllerPart
from layflat.description.change import changed_all
from layflat.errors import MachineError
from layflat.machine import parameters
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
