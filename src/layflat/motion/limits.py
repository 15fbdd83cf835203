"""How fast an arm's joints can be moved, from what their hoses and valves can do.

| symbol | meaning | unit |
|---|---|---|
| K | torque per pressure = volume swept per radian | m3/rad |
| C | sonic conductance of a fully open path of the valve | m3/(s Pa) |
| p_0 | pressure at which ISO 6358 counts volumes | Pa |
| p_s, p_h | absolute pressure of the supply, and in hoses that leak equally to supply and exhaust | Pa |
| V | volume of a hose in the middle of its travel | m3 |
| M | mass matrix of the arm | kg m2 |
| k | stiffness of a joint whose hoses are shut: torque per angle | N m/rad |

Speed: w = C p_0 / K. Acceleration: the torque of a full hose against an empty one, less brake and gravity, over M, for
all joints at once in their worst directions. Jerk: both hoses' pressures change by C p_0 (p_s phi + p_h phi) / V a
second, which is a rate of torque, over M likewise. Derived in docs/cell-plan.md. Stiffness: a hose that keeps its air
and its temperature changes its pressure by p_h K / V per radian, so that two of them give k = 2 K^2 p_h / V.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple, Self

import numpy as np

from layflat.arrays import Array
from layflat.errors import MachineError
from layflat.machine import Machine, parameters, tube
from layflat.machine.single_acting import needed_at_rest
from layflat.machine.tube import Line
from layflat.physics.air_balance import REFERENCE_PRESSURE
from layflat.physics.flow import effective_pressure, laminar_slope
from layflat.physics.joint import FILLED

POSTURES = 9  # looked at along a move
RESERVE = 0.35  # share of what joints can do that planned motions leave to feedback (docs/motion.md)


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


class TipLimits(NamedTuple):
    """Limits of the tip."""

    speed: float = inf  # m/s
    acceleration: float = inf  # m/s2
    jerk: float = inf  # along its path, m/s3


class Ability(NamedTuple):
    """Abilities of a machine's joints with their valves fully open, and what opposes them; (joints,) each."""

    speed: Array  # rad/s
    torque: Array  # of a full hose against an empty one, N m
    least_torque: Array  # that the other way, negative; 0 with a single hose
    rate: Array  # of the torque, N m/s
    stiffness: Array  # of hoses that are shut, N m/rad
    friction: Array  # of brake and bearings, N m
    loss: Array  # torque by which hoses and straps oppose motion, N m
    damping: Array  # N m s/rad

    def share(self, torques: Array) -> Array:
        """Return how far torques (..., joints) are from the middle of what the hoses give, 1 at either end."""
        middle = (self.torque + self.least_torque) / 2
        return np.abs(torques - middle) / (self.torque - middle)

    def room(self, way: Array) -> tuple[Array, Array]:
        """Return the most and the least torque, (points, joints), that dry friction leaves to motions of some sign."""
        rubbing = (self.friction + self.loss) * np.sign(way)
        return self.torque - rubbing, self.least_torque - rubbing

    def less(self, reserve: float) -> "Ability":
        """Return what is left if a share of speeds, torques and their rates is kept as a reserve."""
        left, middle = 1.0 - reserve, (self.torque + self.least_torque) / 2
        reach = left * (self.torque - middle)
        return self._replace(
            speed=left * self.speed, torque=middle + reach, least_torque=middle - reach, rate=left * self.rate
        )


def arm_limits(machine: Machine, start: Array, end: Array, *, payload: float | None = None) -> MotionLimits:
    """Return what hoses and valves can do in a move between two postures (joints,), rad, at the worst on its way.

    The payload is in kg, by default the machine's. Raise MachineError if the machine has no valves, or can't hold
    itself against gravity.
    """
    mass = machine.arm.payload if payload is None else payload
    able = abilities(machine)
    arm, way = parameters.arm(machine), np.linspace(start, end, POSTURES)
    masses, pulls = zip(*(parameters.mass_and_pull(arm, mass, angles) for angles in way), strict=True)
    inertia, held = np.abs(masses).max(axis=0), needed_at_rest(machine, np.array(pulls), way)
    torque = np.minimum(able.torque - able.friction - held, held - able.least_torque - able.friction).min(axis=0)
    if torque.min() <= 0.0:
        name = list(machine.joints)[int(torque.argmin())]
        problem = f"joint {name!r} can't hold {mass:g} kg against gravity and its brake"
        right = "a smaller payload, a wider hose or more pressure"
        raise MachineError(problem, where=machine.origin, right=right)
    acceleration, jerk = together(inertia, torque), together(inertia, able.rate)
    return MotionLimits(tuple(able.speed.tolist()), tuple(acceleration.tolist()), tuple(jerk.tolist()))


def abilities(machine: Machine) -> Ability:
    """Return what the joints can do; raise MachineError if the machine has no valves."""
    return Ability(*np.array([_joint_ability(machine, name) for name in machine.joints]).T)


def check_holds(machine: Machine, gravity: Array, most: Array, least: Array, payload: float) -> None:
    """Raise MachineError if a joint can't hold itself against gravity (points, joints) on the way."""
    lacking = np.maximum(gravity - most, least - gravity).max(axis=0)
    if lacking.max() >= 0.0:
        name = list(machine.joints)[int(lacking.argmax())]
        problem = f"joint {name!r} can't hold {payload:g} kg against gravity and friction on its way"
        raise MachineError(problem, where=machine.origin, right="a smaller payload or reserve, or more pressure")


def _joint_ability(machine: Machine, name: str) -> Sequence[float]:
    """Return the values of `Ability` of a joint."""
    valve, _, _ = parameters.drive_parts(machine)
    joint = machine.joint[name]
    K = parameters.torque_constant(joint)
    volume = joint.hose.dead_volume + joint.geometry.volume / 2
    b, supply, outside = valve.critical_ratio, machine.supply.pressure, machine.supply.ambient_pressure
    slope, held = float(laminar_slope(b)), FILLED * supply
    volume, conductance = _with_line(machine.lines[name], volume, joint.valve_size * valve.conductance)
    through = conductance * REFERENCE_PRESSURE
    filling = through * float(effective_pressure(supply, held, b, slope)) / volume
    venting = through * float(effective_pressure(held, outside, b, slope)) / volume
    double = joint.acting == "double"
    gauge, hoses = machine.supply.pressure_gauge, 2 if double else 1
    _, damping = parameters.loss(joint)
    return (
        through / K,
        K * gauge,
        -K * gauge if double else 0.0,
        K * (filling + venting if double else min(filling, venting)),
        hoses * K**2 * held / volume,
        parameters.static_friction(joint, gauge),
        0.5 * parameters.loss_share(joint) * K * gauge,
        joint.brake.viscous + hoses * (damping.base + damping.slope * (held - outside)),
    )


def _with_line(line: Line | None, volume: float, conductance: float) -> tuple[float, float]:
    """Return the volume of a hose (m3) and the conductance of its valve, with those of the tube between them."""
    if line is None:
        return volume, conductance
    return volume + tube.volume(line), float(1.0 / np.hypot(1.0 / conductance, 1.0 / tube.conductance(line)))


def together(inertia: Array, ability: Array) -> Array:
    """Return accelerations (joints,) that the joints are able to have at once, whatever their signs."""
    alone = ability / inertia.diagonal()
    return alone * float(np.min(ability / (np.abs(inertia) @ alone)))
