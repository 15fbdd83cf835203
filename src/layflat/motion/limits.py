"""Speeds and accelerations that an arm's joints can reach, from what their hoses and valves can do.

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
from layflat.machine.tube import TubePart
from layflat.physics.air_balance import REFERENCE_PRESSURE
from layflat.physics.flow import effective_pressure, laminar_slope
from layflat.physics.joint import REST_PRESSURE_RATIO
from layflat.physics.stops_and_springs import spring_torque

MOVE_SAMPLES = 9  # configurations along a move at which limits are evaluated
FEEDBACK_RESERVE = 0.35  # fraction of the joints' capabilities that planned motions leave to feedback (docs/motion.md)


@dataclass(frozen=True)
class MotionLimits:
    """Greatest speed (rad/s or m/s), acceleration and jerk of each axis."""

    speed: tuple[float, ...]
    acceleration: tuple[float, ...]
    jerk: tuple[float, ...]

    def slowed(self, factor: float) -> Self:
        """Return limits with which every motion takes the same path in `factor` times its duration."""
        speed, acceleration = tuple(v / factor for v in self.speed), tuple(a / factor**2 for a in self.acceleration)
        return replace(self, speed=speed, acceleration=acceleration, jerk=tuple(j / factor**3 for j in self.jerk))

    def scaled(self, speed: float, acceleration: float, jerk: float) -> Self:
        """Return fractions of the limits of all axes.

        Args:
            speed: factor on the speeds.
            acceleration: factor on the accelerations.
            jerk: factor on the jerks.
        """
        parts = zip((speed, acceleration, jerk), (self.speed, self.acceleration, self.jerk), strict=True)
        return type(self)(*(tuple(factor * limit for limit in limits) for factor, limits in parts))


class TipLimits(NamedTuple):
    """Limits of the tip."""

    speed: float = inf  # m/s
    acceleration: float = inf  # m/s2
    jerk: float = inf  # along its path, m/s3


class JointCapabilities(NamedTuple):
    """Capabilities of a machine's joints with fully open valves, and their friction; (joints,) each."""

    speed: Array  # greatest, rad/s
    torque: Array  # greatest: of a full hose against an empty one, N m
    min_torque: Array  # the greatest in the other direction, negative; 0 with a single hose, N m
    rate: Array  # greatest rate of the torque, N m/s
    stiffness: Array  # with closed valves, N m/rad
    friction: Array  # dry friction of brake and bearings, N m
    loss: Array  # hysteresis torque of hoses and straps, N m
    damping: Array  # N m s/rad

    def torque_fractions(self, torques: Array) -> Array:
        """Return the distance of torques (..., joints), N m, from the middle of their range, 1 at either end."""
        middle = (self.torque + self.min_torque) / 2
        return np.abs(torques - middle) / (self.torque - middle)

    def torque_bounds(self, velocity: Array) -> tuple[Array, Array]:
        """Return upper and lower bounds of the torque, less dry friction, (points, joints), N m.

        Of the velocity, (points, joints), only the sign counts.
        """
        dry_friction = (self.friction + self.loss) * np.sign(velocity)
        return self.torque - dry_friction, self.min_torque - dry_friction

    def with_reserve(self, reserve: float) -> "JointCapabilities":
        """Return the capabilities less a reserve: a fraction of speeds, torque ranges and torque rates, 0 to 1."""
        usable, middle = 1.0 - reserve, (self.torque + self.min_torque) / 2
        half_range = usable * (self.torque - middle)
        return self._replace(
            speed=usable * self.speed,
            torque=middle + half_range,
            min_torque=middle - half_range,
            rate=usable * self.rate,
        )


def arm_limits(machine: Machine, start: Array, end: Array, *, payload: float | None = None) -> MotionLimits:
    """Return the limits of the joints in a move, by the capabilities of hoses and valves at its worst point.

    Args:
        machine: machine whose arm moves.
        start: configuration, (joints,), rad.
        end: configuration, likewise; the move between is straight in joint space.
        payload: kg; default: the machine's.

    Raises:
        MachineError: the machine has no valves, or can't hold itself against gravity.
    """
    mass = machine.arm.payload if payload is None else payload
    capabilities = joint_capabilities(machine)
    arm, path = parameters.arm(machine), np.linspace(start, end, MOVE_SAMPLES)
    masses, gravity = zip(*(parameters.mass_and_pull(arm, mass, angles) for angles in path), strict=True)
    inertia, static = np.abs(masses).max(axis=0), static_torques(machine, np.array(gravity), path)
    upper, lower = capabilities.torque - capabilities.friction, capabilities.min_torque + capabilities.friction
    torque = np.minimum(upper - static, static - lower).min(axis=0)
    if torque.min() <= 0.0:
        name = list(machine.joints)[int(torque.argmin())]
        problem = f"joint {name!r} can't hold {mass:g} kg against gravity and its brake"
        right = "give a smaller payload, a wider hose or more pressure"
        raise MachineError(problem, where=machine.origin, right=right)
    acceleration = simultaneous_accelerations(inertia, torque)
    jerk = simultaneous_accelerations(inertia, capabilities.rate)
    return MotionLimits(tuple(capabilities.speed.tolist()), tuple(acceleration.tolist()), tuple(jerk.tolist()))


def static_torques(machine: Machine, gravity: Array, angles: Array) -> Array:
    """Return the torques that hoses and friction have to exert on an arm at rest.

    Args:
        machine: machine whose springs are counted.
        gravity: torques of gravity on the joints, (points, joints), N m.
        angles: angles of the joints, (points, joints), rad.

    Returns:
        Torques (points, joints), N m.
    """
    required = -gravity
    for j, spring in enumerate(parameters.springs(machine)):
        required[:, j] -= spring_torque(spring, angles[:, j])
    return required


def joint_capabilities(machine: Machine) -> JointCapabilities:
    """Return the capabilities of the joints; raise MachineError if the machine has no valves."""
    return JointCapabilities(*np.array([_joint_capability(machine, name) for name in machine.joints]).T)


def check_holding_torque(machine: Machine, gravity: Array, upper: Array, lower: Array, payload: float) -> None:
    """Raise MachineError if a joint can't hold itself against gravity somewhere on a path.

    Args:
        machine: machine whose arm moves.
        gravity: torques to hold, (points, joints), N m.
        upper: bounds of the torque, likewise.
        lower: bounds of the torque, likewise.
        payload: kg, for the message.

    Raises:
        MachineError: a torque is not within its bounds.
    """
    lacking = np.maximum(gravity - upper, lower - gravity).max(axis=0)
    if lacking.max() >= 0.0:
        name = list(machine.joints)[int(lacking.argmax())]
        problem = f"joint {name!r} can't hold {payload:g} kg against gravity and friction on its way"
        raise MachineError(problem, where=machine.origin, right="give a smaller payload or reserve, or more pressure")


def _joint_capability(machine: Machine, name: str) -> Sequence[float]:
    """Return the values of `JointCapabilities` of one joint, in order."""
    valve, _, _ = parameters.valve_and_sensors(machine)
    joint = machine.joint[name]
    K = parameters.torque_constant(joint)
    volume = joint.hose.dead_volume + joint.geometry.volume / 2
    b, supply, outside = valve.critical_ratio, machine.supply.pressure, machine.supply.ambient_pressure
    slope, held = float(laminar_slope(b)), REST_PRESSURE_RATIO * supply
    volume, conductance = _add_line(machine.lines[name], volume, joint.valve_size * valve.conductance)
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
        0.5 * parameters.loss_fraction(joint) * K * gauge,
        joint.brake.viscous + hoses * (damping.base + damping.slope * (held - outside)),
    )


def _add_line(line: TubePart | None, volume: float, conductance: float) -> tuple[float, float]:
    """Return the volume of a hose (m3) and the conductance of its valve, with those of the tube between them."""
    if line is None:
        return volume, conductance
    return volume + tube.volume(line), float(1.0 / np.hypot(1.0 / conductance, 1.0 / tube.conductance(line)))


def simultaneous_accelerations(inertia: Array, torque: Array) -> Array:
    """Return accelerations that all joints can have at the same time, with any signs.

    Args:
        inertia: mass matrix, (joints, joints), kg m2.
        torque: greatest magnitude, (joints,), N m; or rate of the torque, N m/s, for jerks.

    Returns:
        Accelerations (joints,), rad/s2; or jerks, rad/s3.
    """
    alone = torque / inertia.diagonal()
    return alone * float(np.min(torque / (np.abs(inertia) @ alone)))
