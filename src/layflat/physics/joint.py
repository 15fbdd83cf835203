"""One joint: two hoses that work against each other, their valve, the losses and the stops; parameters and state.

Hose A turns the joint forward, hose B back. A single-acting joint has no hose B: a spring or the weight of its arm
turns it back, and that port of its valve is plugged. How a joint moves stands in step.py.
"""

from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.physics.adjustable import ALL_FIXED, Adjustables
from layflat.physics.chamber import Chamber, air_mass, energy
from layflat.physics.hose import ConstantStroke, Stroke, swept_volume, torque_per_pressure
from layflat.physics.hysteresis import at_rest as relaxed
from layflat.physics.line import NoLine, air_at
from layflat.physics.sensor import Sensor
from layflat.physics.stops_and_springs import NoSpring, Stops, spring_torque
from layflat.physics.valves import at_rest

FILLED = 0.75
"""Pressure over that of the supply at the start, where equal leaks to supply and exhaust balance when choked."""


class Damping(NamedTuple):
    """Torque per velocity without pressure (N m s/rad), and its growth with gauge pressure (N m s/(rad Pa))."""

    base: float
    slope: float


class Hose(NamedTuple):
    """Parameters of a hose in its joint, with the line to its valve; `neutral` is the travel at angle zero, rad."""

    stroke: ConstantStroke | Stroke
    chamber: Chamber
    loss: Any
    neutral: float
    damping: Damping = Damping(0.0, 0.0)
    line: Any = NoLine()


class TwoHoses(NamedTuple):
    """A joint with hoses on both sides, beside others that all have them."""


class SecondHose(NamedTuple):
    """A joint beside others that may have a single hose: 1 where it has hose B, 0 where that is missing."""

    there: float


@law
def _surely(second):  # noqa: ARG001
    return 1.0


@law
def _whether(second):
    return second.there


has_second = by_kind({TwoHoses: _surely, SecondHose: _whether})
"""1 where a joint has hose B, else 0: `has_second(joint.second)`."""


class Joint(NamedTuple):
    """Parameters of a joint; hose A turns it forward, hose B back."""

    hose_a: Hose
    hose_b: Hose
    valve: Any
    stops: Stops
    viscous_friction: float
    brake_torque: float
    friction: Any  # of the kind of friction (see friction/kind.py)
    angle_sensor: Sensor
    pressure_sensor: Sensor
    adjustables: Adjustables = ALL_FIXED
    second: TwoHoses | SecondHose = TwoHoses()
    spring: Any = NoSpring()


class Surroundings(NamedTuple):
    """Surroundings that the joints share: absolute pressures (Pa), temperatures (K), payload (kg)."""

    supply_pressure: float
    supply_temperature: float
    ambient_pressure: float
    ambient_temperature: float
    payload: float


class Drive(NamedTuple):
    """Drive of a joint during one control cycle."""

    opening: float  # opening asked of the valve, without dither, -1..1
    brake_torque: float  # torque at which the brake slips, N m
    load_torque: float  # external torque on the joint, N m
    supply_pressure: float  # absolute, at the valve, Pa


class HoseState(NamedTuple):
    """Energy (J), mass (kg), geometric volume (m3), pressure (Pa), last changes of both, state of the losses."""

    energy: float
    mass: float
    volume: float
    pressure: float
    pressure_change: float
    mass_change: float
    loss: Any  # of the hysteresis (see hysteresis/kind.py)
    line: Any  # air between valve and hose (see line.py)


class Motion(NamedTuple):
    """Angle (rad), velocity and its last change (rad/s)."""

    angle: float
    velocity: float
    velocity_change: float


class Ledger(NamedTuple):
    """Works since the start (J), and air taken from the supply (kg)."""

    gas_work: float
    load_work: float
    hose_work: float
    brake_heat: float
    damping_heat: float
    air_taken: float


class AirTaken(NamedTuple):
    """The only entry of a ledger that is worth its time in an ensemble: air taken from the supply (kg)."""

    air_taken: float


class JointState(NamedTuple):
    """All that changes in a joint."""

    motion: Motion
    valve: Any
    hose_a: HoseState
    hose_b: HoseState
    ledger: Ledger | AirTaken


@law
def supplied(around, drive):
    """The surroundings as a joint has them, with the supply at its valve."""
    p_s = drive.supply_pressure
    return Surroundings(
        p_s, around.supply_temperature, around.ambient_pressure, around.ambient_temperature, around.payload
    )


@law
def hose_at_rest(hose, travel, p, T, p_a):
    """State of a hose at a travel (rad), pressure (Pa) and temperature (K)."""
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    stored = energy(hose.chamber, p, volume, p_a)
    mass, loss, line = air_mass(hose.chamber, p, T, volume, p_a), relaxed(hose.loss), air_at(hose.line, p, T)
    return HoseState(stored, mass, volume, p, 0.0, 0.0, loss, line)


@law
def joint_at_rest(joint, q, p_1, p_2, around):
    """State of a joint at rest at angle q (rad) with absolute pressures p_1 in hose A and p_2 in hose B (Pa)."""
    T, p_a = around.ambient_temperature, around.ambient_pressure
    a = hose_at_rest(joint.hose_a, joint.hose_a.neutral + q, p_1, T, p_a)
    b = hose_at_rest(joint.hose_b, joint.hose_b.neutral - q, p_2, T, p_a)
    return JointState(Motion(q, 0.0, 0.0), at_rest(joint.valve), a, b, Ledger(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@law
def pressures_at_rest(joint, q, pull, around):
    """Return the absolute pressures in hoses A and B (Pa) that hold a joint against a pull (N m) as far as air can.

    Two hoses are as full as leaks leave them; the air in place of a missing one is that outside.
    """
    p_s, p_a, second = around.supply_pressure, around.ambient_pressure, has_second(joint.second)
    K = torque_per_pressure(joint.hose_a.stroke, joint.hose_a.neutral + q)
    K = K + second * torque_per_pressure(joint.hose_b.stroke, joint.hose_b.neutral - q)
    p = second * (FILLED * p_s) + (1.0 - second) * p_a
    shift = -(pull + spring_torque(joint.spring, q)) / K
    least = min(p, p_a)
    p_1, p_2 = min(max(p + shift, least), p_s), min(max(p - shift, least), p_s)
    return p_1, second * p_2 + (1.0 - second) * p_a


@law
def is_sound(state):
    """False once a joint has diverged: beyond any possible motion, without air, or not a number."""
    moves = (abs(state.motion.angle) < 10.0) & (abs(state.motion.velocity) < 1e4)
    return moves & (state.hose_a.mass > 0.0) & (state.hose_b.mass > 0.0)
