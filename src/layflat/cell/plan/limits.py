"""How fast an arm's joints can be moved, from what their hoses and valves can do.

| symbol | meaning | unit |
|---|---|---|
| K | torque per pressure = volume swept per radian | m3/rad |
| C | sonic conductance of a fully open path of the valve | m3/(s Pa) |
| p_0 | pressure at which ISO 6358 counts volumes | Pa |
| p_s, p_h | absolute pressure of the supply, and in hoses that leak equally to supply and exhaust | Pa |
| V | volume of a hose in the middle of its travel | m3 |
| M | mass matrix of the arm | kg m2 |

Speed: w = C p_0 / K. Acceleration: the torque of a full hose against an empty one, less brake and gravity, over M, for
all joints at once in their worst directions. Jerk: both hoses' pressures change by C p_0 (p_s phi + p_h phi) / V a
second, which is a rate of torque, over M likewise. Derived in docs/cell-plan.md.
"""

from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import MachineError
from layflat.machine import Machine, parameters, tube
from layflat.machine.tube import Line
from layflat.physics.air_balance import REFERENCE_PRESSURE
from layflat.physics.flow import effective_pressure, laminar_slope
from layflat.physics.joint import FILLED

POSTURES = 9  # looked at along a move


@dataclass(frozen=True)
class MotionLimits:
    """Greatest speed (rad/s or m/s), acceleration and jerk of each axis."""

    speed: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]

    def slower(self, factor: float) -> Self:
        """Return limits with which every motion goes the same way in `factor` times its time."""
        speed, acceleration = tuple(v / factor for v in self.speed), tuple(a / factor**2 for a in self.acceleration)
        return replace(self, speed=speed, acceleration=acceleration, jerk=tuple(j / factor**3 for j in self.jerk))

    def shares(self, speed: float, acceleration: float, jerk: float) -> Self:
        """Return these shares of the limits of all axes."""
        parts = zip((speed, acceleration, jerk), (self.speed, self.acceleration, self.jerk), strict=True)
        return type(self)(*(tuple(share * limit for limit in limits) for share, limits in parts))


def arm_limits(machine: Machine, start: Array, end: Array, *, payload: float | None = None) -> MotionLimits:
    """Return what hoses and valves can do in a move between two postures (joints,), rad, at the worst on its way.

    The payload is in kg, by default the machine's. Raise MachineError if the machine has no valves, or can't hold
    itself against gravity.
    """
    mass = machine.arm.payload if payload is None else payload
    speed, torque, rate = np.array([_joint_ability(machine, name) for name in machine.joints]).T
    # Greatest inertias (joints, joints; kg m2) and torques of gravity (joints,; N m) on the way.
    arm = parameters.arm(machine)
    on_way = [parameters.mass_and_pull(arm, mass, angles) for angles in np.linspace(start, end, POSTURES)]
    inertia, gravity = (np.abs(found).max(axis=0) for found in zip(*on_way, strict=True))
    torque = torque - gravity
    if torque.min() <= 0.0:
        name = list(machine.joints)[int(torque.argmin())]
        problem = f"joint {name!r} can't hold {mass:g} kg against gravity and its brake"
        right = "a smaller payload, a wider hose or more pressure"
        raise MachineError(problem, where=machine.origin, right=right)
    acceleration, jerk = _together(inertia, torque), _together(inertia, rate)
    return MotionLimits(tuple(speed.tolist()), tuple(acceleration.tolist()), tuple(jerk.tolist()))


def _joint_ability(machine: Machine, name: str) -> tuple[float, float, float]:
    """Return speed (rad/s), torque less friction (N m) and its rate (N m/s) of a joint with its valve fully open."""
    valve, _, _ = parameters.drive_parts(machine)
    joint = machine.joint[name]
    K = parameters.torque_constant(joint)
    volume = joint.hose.dead_volume + parameters.travel_volume(joint) / 2
    b, supply, outside = valve.critical_ratio, machine.supply.pressure, machine.supply.ambient_pressure
    slope, held = float(laminar_slope(b)), FILLED * supply
    volume, conductance = _with_line(machine.lines[name], volume, joint.valve_size * valve.conductance)
    through = conductance * REFERENCE_PRESSURE
    filling = through * float(effective_pressure(supply, held, b, slope)) / volume
    venting = through * float(effective_pressure(held, outside, b, slope)) / volume
    hoses = filling + venting if joint.acting == "double" else min(filling, venting)
    gauge = machine.supply.pressure_gauge
    return through / K, K * gauge - parameters.static_friction(joint, gauge), K * hoses


def _with_line(line: Line | None, volume: float, conductance: float) -> tuple[float, float]:
    """Return the volume of a hose (m3) and the conductance of its valve, with those of the tube between them."""
    if line is None:
        return volume, conductance
    return volume + tube.volume(line), float(1.0 / np.hypot(1.0 / conductance, 1.0 / tube.conductance(line)))


def _together(inertia: Array, ability: Array) -> Array:
    """Return accelerations (joints,) that the joints are able to have at once, whatever their signs."""
    alone = ability / inertia.diagonal()
    return alone * float(np.min(ability / (np.abs(inertia) @ alone)))
