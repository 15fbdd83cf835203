"""What moves and measures a joint: valve and sensors."""

from __future__ import annotations

from math import pi

from layflat.errors import MachineError
from layflat.machine.model import AngleSensor, Machine, PressureSensor, SpoolValve, SwitchingValves
from layflat.machine.parameters.hoses import each
from layflat.physics.flow import laminar_slope
from layflat.physics.sensor import Sensor
from layflat.physics.spool import Spool
from layflat.physics.spool_valve import SpoolValve as SpoolLaw
from layflat.physics.switching_valve import Switch, SwitchingPair


def valve(described: SpoolValve | SwitchingValves) -> SpoolLaw | SwitchingPair:
    """A valve with its driver."""
    return spool_valve(described) if isinstance(described, SpoolValve) else switching_pair(described)


def spool_valve(described: SpoolValve) -> SpoolLaw:
    """Spool valve with its driver."""
    b = described.critical_ratio
    return SpoolLaw(
        Spool(2 * pi * described.natural_frequency, described.damping_ratio, described.friction),
        described.conductance,
        described.leakage,
        b,
        each(laminar_slope, b),
        described.overlap,
        described.centre_voltage,
        described.volts_to_full,
        described.dither.amplitude,
        described.dither.frequency,
        described.delay,
    )


def switching_pair(described: SwitchingValves) -> SwitchingPair:
    """Two on/off valves with their driver."""
    b = described.critical_ratio
    return SwitchingPair(
        Switch(
            described.opening_delay,
            described.opening_time,
            described.closing_delay,
            described.closing_time,
        ),
        described.conductance,
        described.leakage,
        b,
        each(laminar_slope, b),
        described.centre_voltage,
        described.volts_to_full,
        described.frequency,
        described.dead_band,
        described.least_pulse,
        described.delay,
    )


def sensor(described: AngleSensor | PressureSensor) -> Sensor:
    """A sensor centred on zero."""
    half = described.range / 2
    return Sensor(-half, half, described.range / 2**described.bits, described.offset, described.noise)


def drive_parts(machine: Machine) -> tuple[SpoolValve | SwitchingValves, AngleSensor, PressureSensor]:
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
