"""What moves and measures a joint: valve and sensors."""

from __future__ import annotations

from layflat.errors import MachineError
from layflat.machine.model import AngleSensor, Machine, PressureSensor
from layflat.physics.sensor import Sensor
from layflat.physics.valves import ValvePart


def sensor(described: AngleSensor | PressureSensor) -> Sensor:
    """A sensor centred on zero."""
    half = described.range / 2
    return Sensor(-half, half, described.range / 2**described.bits, described.offset, described.noise)


def drive_parts(machine: Machine) -> tuple[ValvePart, AngleSensor, PressureSensor]:
    """Valve and sensors of a machine that moves by itself.

    Raises:
        MachineError: it has none, as the open-loop rigs.
    """
    if machine.valve is None or machine.angle_sensor is None or machine.pressure_sensor is None:
        raise MachineError(
            "has no valve or sensors: it is a rig for torque-angle loops",
            where=machine.origin,
            right="`layflat loop` sweeps it at constant pressure",
        )
    return machine.valve, machine.angle_sensor, machine.pressure_sensor
