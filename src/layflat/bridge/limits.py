"""What a joint can at most, as formats of robots ask for it."""

from layflat.machine import Machine, parameters
from layflat.physics.air_balance import REFERENCE_PRESSURE


def effort(machine: Machine, name: str) -> float:
    """Return a joint's greatest torque at supply pressure, N m."""
    return float(parameters.torque_constant(machine.joints[name]) * machine.supply.pressure_gauge)


def velocity(machine: Machine, name: str) -> float:
    """Return the velocity (rad/s) at which a fully open valve just keeps a hose at supply pressure.

    It is the valve's conductance x 1 bar / (torque per pressure).
    """
    joint, (valve, *_) = machine.joints[name], parameters.drive_parts(machine)
    conductance = joint.valve_size * valve.conductance
    return float(conductance * REFERENCE_PRESSURE / parameters.torque_constant(joint))
