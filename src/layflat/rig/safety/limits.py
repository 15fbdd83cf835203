"""Limits of one joint as plain numbers, from a machine's description."""

from __future__ import annotations

from typing import NamedTuple

from layflat.machine import Machine, parameters
from layflat.machine.model import SpoolValve
from layflat.machine.parameters.drives import drive_parts
from layflat.machine.parameters.drives import sensor as sensor_law

LIVELY = 0.3
"""Noise of a sensor, in counts, from which on it never reports the same count for 20 samples."""

RAIL = 2.0
"""Counts from the end of a converter's range, at which a sensor is taken to be open or shorted."""


class Limits(NamedTuple):
    """What a joint's signals are judged by; SI."""

    angle_low: float
    """At or below it, or at or above the next, the angle sensor is at its rail, rad."""
    angle_high: float
    lsb: float
    """Of the angle's converter, rad."""
    stroke: float
    """Beyond it on either side a joint is outside, rad."""
    speed: float
    pressure: float
    """Of differential pressure on either side, Pa."""
    friction_band: float
    """Change of the differential pressure that friction of brake, hose and strap can hide, Pa."""
    following: float
    following_time: float
    demand_speed: float
    surplus: float
    """Infinite where the air can't be watched: a joint of a single hose."""
    ripple: float
    """Amplitude below which there is no air (rule 1 of the controller), Pa; zero where the dither can't be seen."""
    lively: bool
    """Whether a sound pressure sensor changes all the time."""
    working: float
    """Half the working stroke: where demands may lie, rad."""
    mechanical: float
    """Half the mechanical stroke: where the stops are, rad."""


def limits(machine: Machine, name: str) -> Limits:
    """Limits of a joint.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, angle_part, pressure_part = drive_parts(machine)
    joint, safety, gauge = machine.joint[name], machine.safety, machine.supply.pressure_gauge
    angle, pressure = sensor_law(angle_part), sensor_law(pressure_part)
    working, mechanical = joint.stops.working_stroke / 2, joint.stops.mechanical_stroke / 2
    K = parameters.torque_constant(joint)
    friction = 2.0 * joint.brake.torque / K + parameters.loss_share(joint) * gauge
    seen = _dither_is_seen(machine)
    return Limits(
        angle.low + RAIL * angle.lsb,
        angle.high - RAIL * angle.lsb,
        angle.lsb,
        working + safety.overrun * (mechanical - working),
        safety.speed,
        min(safety.overpressure * gauge, pressure.high - RAIL * pressure.lsb),
        friction,
        safety.following_error,
        safety.following_time,
        safety.demand_speed,
        safety.surplus if joint.acting == "double" else float("inf"),
        machine.controller.air_ripple if machine.controller is not None and seen else 0.0,
        seen or pressure.noise > LIVELY * pressure.lsb or isinstance(valve, SpoolValve),
        working,
        mechanical,
    )


def _dither_is_seen(machine: Machine) -> bool:
    """Whether the ripple that the controller computes, at a quarter of its rate, is that of the dither."""
    valve, controller = machine.valve, machine.controller
    if not isinstance(valve, SpoolValve) or controller is None or valve.dither.amplitude == 0.0:
        return False
    return abs(valve.dither.frequency * controller.cycle - 0.25) < 0.01
