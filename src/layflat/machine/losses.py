"""Losses of another kind in a machine's joints."""

from collections.abc import Mapping, Sequence
from typing import Any

from layflat.description.change import changed_all
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
