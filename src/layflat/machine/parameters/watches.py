"""What a rig's supervisor knows of the joints."""

from __future__ import annotations

from layflat.machine.model import Machine
from layflat.machine.parameters.drives import drive_parts
from layflat.machine.parameters.hoses import full_travel, travel_volume
from layflat.physics.air_balance import AirParts
from layflat.physics.flow import laminar_slope

FOLLOW = 40.0
"""Rate at which estimate in the hoses' pressures follows what is measured: fast beside a move, 1/s."""

SMOOTHING = 0.05
"""Time over which the residual of air is averaged: a few periods of the dither, s."""


def air_parts(machine: Machine, name: str) -> AirParts:
    """What the watch over a joint's air has to know; a hose with a roller counts with its mean torque.

    Raises:
        MachineError: the machine has no valve or sensors.
    """
    valve, _, _ = drive_parts(machine)
    joint = machine.joint[name]
    return AirParts(
        joint.hose.dead_volume,
        travel_volume(joint) / full_travel(joint),
        full_travel(joint) / 2,
        valve.conductance,
        valve.leakage,
        valve.critical_ratio,
        float(laminar_slope(valve.critical_ratio)),
        valve.covered,
        valve.dithered.amplitude if valve.dithered is not None else 0.0,
        FOLLOW,
        SMOOTHING,
        machine.safety.speed,
    )
