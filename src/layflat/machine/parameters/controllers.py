"""Settings of the controllers."""

from __future__ import annotations

from layflat.control.gains import Gains, Phase
from layflat.errors import MachineError
from layflat.machine.model import Machine
from layflat.machine.parameters.drives import drive_parts


def gains(machine: Machine, name: str) -> Gains:
    """Settings of one joint's controller.

    Raises:
        MachineError: the machine has no controller, or the joint no gains.
    """
    own, shared, valve_part = machine.joint[name].gains, machine.controller, machine.valve
    if own is None or shared is None or valve_part is None:
        raise MachineError(
            "has no controller gains", where=f"{machine.origin}: joint.{name}.gains", right="copy those of paper-arm"
        )
    span = valve_part.volts_to_full
    return Gains(
        Phase(own.far.error, own.far.pressure),
        Phase(own.near.error, own.near.pressure),
        Phase(own.close.error, own.close.pressure),
        own.near_below.error,
        own.near_below.speed,
        own.close_below.error,
        own.close_below.speed,
        valve_part.centre_voltage,
        own.integral,
        own.integral_limit,
        shared.drift_time,
        shared.drift_limit,
        shared.air_ripple,
        shared.rest_speed,
        shared.rest_time,
        shared.load_pressure,
        valve_part.centre_voltage - span,
        valve_part.centre_voltage + span,
        1.0 if shared.averaged else 0.0,
    )


def idle_gains(machine: Machine) -> Gains:
    """Settings of a controller that only watches, for open-loop runs of machines without gains."""
    valve_part, _, _ = drive_parts(machine)
    nothing, centre = Phase(0.0, 0.0), valve_part.centre_voltage
    span = valve_part.volts_to_full
    thresholds = (1.0, 1.0, 0.1, 0.1)
    drift = (1.0, 0.0, 0.0, 1.0, 1.0, 1.0)
    return Gains(nothing, nothing, nothing, *thresholds, centre, 0.0, 0.0, *drift, centre - span, centre + span, 1.0)
