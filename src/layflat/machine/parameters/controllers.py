"""Settings of the control law."""

from __future__ import annotations

from typing import Any

from layflat.control import CONTROL_LAWS
from layflat.control.paper.description import idle_gains
from layflat.control.paper.gains import Settings
from layflat.errors import MachineError
from layflat.machine.model import Machine
from layflat.machine.parameters.drives import drive_parts


def control(machine: Machine, *, closed_loop: bool = True) -> Any:
    """Settings of the machine's control law; of one that only watches where an open-loop run needs no more.

    Raises:
        MachineError: the machine has no valve, controller or gains.
    """
    valve, _, _ = drive_parts(machine)
    law = machine.control_law
    if not closed_loop and (machine.controller is None or (law.gains is not None and not _all_have_gains(machine))):
        return Settings(tuple(idle_gains(valve) for _ in machine.joints))
    if machine.controller is None:
        raise MachineError("has no controller", where=machine.origin, right="copy that of paper-arm, gains included")
    return CONTROL_LAWS.parameters(machine.controller, machine)


def _all_have_gains(machine: Machine) -> bool:
    return all(joint.gains is not None for joint in machine.joints.values())
