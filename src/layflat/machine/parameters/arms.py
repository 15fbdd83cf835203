"""Masses of the arm, and what surrounds it."""

from __future__ import annotations

import numpy as np

from layflat.machine.model import Machine
from layflat.physics.arm import LevelTwoLink, OneLink, TwoLink
from layflat.physics.joint import Surroundings

Arm = OneLink | TwoLink | LevelTwoLink


def arm(machine: Machine) -> Arm:
    """Masses of the arm, without payload."""
    g_x = machine.arm.gravity * np.cos(machine.arm.gravity_direction)
    g_y = machine.arm.gravity * np.sin(machine.arm.gravity_direction)
    joints = list(machine.joints.values())
    first = joints[0].link
    own_1 = first.rotor_inertia + first.inertia + first.mass * first.centre**2
    if len(joints) == 1:
        return OneLink(own_1, first.mass * first.centre, first.length, g_x, g_y)
    second, carried = joints[1].link, joints[1].body.mass
    own_2 = second.rotor_inertia + second.inertia + second.mass * second.centre**2
    masses = (
        own_1 + own_2 + (carried + second.mass) * first.length**2,
        second.mass * first.length * second.centre,
        own_2,
    )
    if np.all(machine.arm.gravity == 0.0):
        return LevelTwoLink(*masses, first.length, second.length, machine.arm.elbow)
    return TwoLink(
        *masses,
        first.mass * first.centre + (carried + second.mass) * first.length,
        second.mass * second.centre,
        first.length,
        second.length,
        machine.arm.elbow,
        g_x,
        g_y,
    )


def surroundings(machine: Machine) -> Surroundings:
    """Air outside and at the supply, and the payload."""
    air = machine.supply
    return Surroundings(
        air.pressure, air.temperature, air.ambient_pressure, air.ambient_temperature, machine.arm.payload
    )
