"""The control law of a rig's joints, as its loop has it: numbers by name, and the signals that it tells."""

from __future__ import annotations

from layflat.control.controller import start
from layflat.control.gains import Measurement
from layflat.machine import Machine, parameters
from layflat.machine.signals import SIGNALS
from layflat.rig.named import NamedRows, blank
from layflat.rig.record import Layout
from layflat.rig.safety.cycle import Report


class JointLaws:
    """The law of every joint.

    Args:
        machine: with a controller and gains.

    Raises:
        MachineError: it has none.
    """

    def __init__(self, machine: Machine) -> None:
        n = len(machine.joints)
        self.settings = NamedRows([parameters.gains(machine, name) for name in machine.joints])
        self.memory = NamedRows([start(Measurement(0.0, 0.0, 1.0))] * n)
        self.memory.array[:] = 0.0
        self.report = NamedRows([blank(Report)] * n)
        self.layout = layout_of(machine)
        """Of the rows that a loop with it records."""

    def wake(self, j: int, angle: float, pressure: float) -> None:
        """Let a joint's law begin at this measurement, rad and Pa."""
        self.memory.put(j, start(Measurement(angle, pressure, 1.0)))


def layout_of(machine: Machine) -> Layout:
    """Where everything stands in the rows that a loop of a machine records."""
    return Layout.of(list(machine.joints), {name: SIGNALS[name] for name in Report._fields})
