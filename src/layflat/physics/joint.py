"""Parameters and state of one joint: two antagonistic hoses, their valve, losses, friction and stops.

Hose A turns the joint forward, hose B back. A single-acting joint has no hose B: a spring or the weight of its arm
turns it back, and that port of its valve is plugged. The laws of its motion are in step.py.
"""

from typing import Any, NamedTuple

from layflat.jit import by_kind, law
from layflat.physics.adjustable import NONE_ADJUSTABLE, JointFractionLimits
from layflat.physics.chamber import Chamber, air_mass, energy
from layflat.physics.hose import ConstantStroke, PolynomialStroke, swept_volume, torque_per_pressure
from layflat.physics.hysteresis import at_rest as relaxed
from layflat.physics.line import NoLine, line_air
from layflat.physics.sensor import Sensor
from layflat.physics.stops_and_springs import NoSpring, StopParameters, spring_torque
from layflat.physics.valves import at_rest

REST_PRESSURE_RATIO = 0.75
"""Initial pressure over that of the supply, at which equal choked leaks to supply and exhaust balance."""


class Damping(NamedTuple):
    """Damping without pressure (N m s/rad), and its slope by gauge pressure (N m s/(rad Pa))."""

    base: float  # without pressure, N m s/rad
    slope: float  # by gauge pressure, N m s/(rad Pa)


class HoseParameters(NamedTuple):
    """Parameters of a hose in its joint, with the line to its valve; `neutral` is the travel at angle zero, rad."""

    stroke: ConstantStroke | PolynomialStroke
    chamber: Chamber
    loss: Any
    neutral: float  # travel at angle zero, rad
    damping: Damping = Damping(0.0, 0.0)
    line: Any = NoLine()


class TwoHoses(NamedTuple):
    """Mark of a joint in a machine all of whose joints have hoses A and B."""


class SecondHose(NamedTuple):
    """Mark of a joint in a machine with single-acting joints: 1 where it has hose B, 0 where that is missing."""

    present: float  # 1 or 0


@law
def _always_present(second):  # noqa: ARG001
    return 1.0


@law
def _second_present(second):
    return second.present


has_second = by_kind({TwoHoses: _always_present, SecondHose: _second_present})
"""1 if a joint has hose B, else 0: `has_second(joint.second)`."""


class JointParameters(NamedTuple):
    """Parameters of a joint; hose A turns it forward, hose B back."""

    hose_a: HoseParameters
    hose_b: HoseParameters
    valve: Any
    stops: StopParameters
    viscous_friction: float  # N m s/rad
    brake_torque: float  # N m
    friction: Any  # parameters of a kind of friction (see friction/kind.py)
    angle_sensor: Sensor
    pressure_sensor: Sensor
    adjustables: JointFractionLimits = NONE_ADJUSTABLE
    second: TwoHoses | SecondHose = TwoHoses()
    spring: Any = NoSpring()


class Surroundings(NamedTuple):
    """Surroundings that the joints share: absolute pressures (Pa), temperatures (K), payload (kg)."""

    supply_pressure: float  # absolute, Pa
    supply_temperature: float  # K
    ambient_pressure: float  # absolute, Pa
    ambient_temperature: float  # K
    payload: float  # kg


class Drive(NamedTuple):
    """Inputs of a joint that are constant during one control cycle."""

    opening: float  # commanded opening of the valve, without dither, -1..1
    brake_torque: float  # torque at which the brake slips, N m
    load_torque: float  # external torque on the joint, N m
    supply_pressure: float  # absolute, at the valve, Pa


class HoseState(NamedTuple):
    """State of a hose: energy (J), mass (kg), geometric volume (m3), pressure (Pa), losses and line."""

    energy: float  # of air and stretched wall, J
    mass: float  # of air, kg
    volume: float  # geometric, m3
    pressure: float  # absolute, Pa
    pressure_change: float  # in the last step, Pa
    mass_change: float  # in the last step, kg
    loss: Any  # state of the hysteresis (see hysteresis/kind.py)
    line: Any  # air between valve and hose (see line.py)


class JointMotion(NamedTuple):
    """Angle (rad), velocity, and its change in the last step (rad/s) of a joint."""

    angle: float  # rad
    velocity: float  # rad/s
    velocity_change: float  # in the last step, rad/s


class EnergyLedger(NamedTuple):
    """Works since the start (J), and mass of air drawn from the supply (kg)."""

    gas_work: float  # work of the air on the joint, J
    load_work: float  # work of the joint on its load, J
    hose_work: float  # work lost or stored in the hoses, J
    brake_heat: float  # J
    damping_heat: float  # J
    air_taken: float  # mass of air drawn from the supply, kg


class AirLedger(NamedTuple):
    """Mass of air drawn from the supply (kg): the only entry that ensembles compute."""

    air_taken: float  # kg


class JointState(NamedTuple):
    """State of a joint."""

    motion: JointMotion
    valve: Any
    hose_a: HoseState
    hose_b: HoseState
    ledger: EnergyLedger | AirLedger


@law
def with_supply(around, drive):
    """Return the surroundings with the supply pressure at a joint's valve."""
    p_s = drive.supply_pressure
    return Surroundings(
        p_s, around.supply_temperature, around.ambient_pressure, around.ambient_temperature, around.payload
    )


@law
def hose_at_rest(hose, travel, p, T, p_a):
    """Return the state of a hose at rest at a travel (rad), pressure (Pa) and temperature (K)."""
    volume = hose.chamber.dead_volume + swept_volume(hose.stroke, travel)
    stored = energy(hose.chamber, p, volume, p_a)
    mass, loss, line = air_mass(hose.chamber, p, T, volume, p_a), relaxed(hose.loss), line_air(hose.line, p, T)
    return HoseState(stored, mass, volume, p, 0.0, 0.0, loss, line)


@law
def joint_at_rest(joint, q, p_1, p_2, around):
    """Return the state of a joint at rest at q (rad), with absolute pressures p_1 in hose A and p_2 in hose B (Pa).

    Its air is at ambient temperature, its losses are without torque, and its valve was never driven. The pressures are
    used as they are, whether or not they hold the joint there.
    """
    T, p_a = around.ambient_temperature, around.ambient_pressure
    a = hose_at_rest(joint.hose_a, joint.hose_a.neutral + q, p_1, T, p_a)
    b = hose_at_rest(joint.hose_b, joint.hose_b.neutral - q, p_2, T, p_a)
    return JointState(JointMotion(q, 0.0, 0.0), at_rest(joint.valve), a, b, EnergyLedger(0.0, 0.0, 0.0, 0.0, 0.0, 0.0))


@law
def pressures_at_rest(joint, q, pull, around):
    """Return the absolute pressures in hoses A and B (Pa) that balance an external torque `pull` (N m) at q (rad).

    They are limited to ambient and supply pressure. The mean of two hoses is `REST_PRESSURE_RATIO` of the supply, which
    is taken to balance itself: exact on a cam, and in mid-stroke of a round roller. A missing hose B is at ambient
    pressure.
    """
    p_s, p_a, second = around.supply_pressure, around.ambient_pressure, has_second(joint.second)
    K = torque_per_pressure(joint.hose_a.stroke, joint.hose_a.neutral + q)
    K = K + second * torque_per_pressure(joint.hose_b.stroke, joint.hose_b.neutral - q)
    p = second * (REST_PRESSURE_RATIO * p_s) + (1.0 - second) * p_a
    shift = -(pull + spring_torque(joint.spring, q)) / K
    lower = min(p, p_a)
    p_1, p_2 = min(max(p + shift, lower), p_s), min(max(p - shift, lower), p_s)
    return p_1, second * p_2 + (1.0 - second) * p_a


@law
def is_sound(state):
    """Return whether a joint has not diverged: below 10 rad and 1e4 rad/s, with air in its hoses, and no nan."""
    moves = (abs(state.motion.angle) < 10.0) & (abs(state.motion.velocity) < 1e4)
    return moves & (state.hose_a.mass > 0.0) & (state.hose_b.mass > 0.0)
