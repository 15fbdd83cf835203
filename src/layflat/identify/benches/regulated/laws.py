"""A rotary joint between two air chambers, each held by a pressure-regulating valve, seen from outside.

| symbol | meaning | unit |
|---|---|---|
| s | set-point that a valve works towards, absolute | Pa |
| p | pressure of its chamber | Pa |
| x | opening, 1 fully towards the supply, -1 fully towards the exhaust | 1 |
| B, C | error s - p at which a side is fully open, and its sonic conductance then | Pa, m3/(s Pa) |
| q, v | joint angle from the middle of the stroke, and velocity | rad, rad/s |
| K | torque per pressure = volume that a chamber gains per radian | m3/rad |
| V_0 | volume of a chamber in the middle of the stroke | m3 |
| I, c | moment of inertia, damping | kg m2, N m s/rad |
| T_0, k | load torque in the middle of the stroke, and stiffness | N m, N m/rad |
| Q, tau | remembered angle, and the lag with which it follows q | rad, s |
| F_l, F_u | level of the friction well below Q = a, and well above it | N m |
| a, b | angle in the middle of the change from F_l to F_u, and how wide this is | rad |
| r | static over sliding friction | 1 |
| h | step | s |

What is inside a valve (a pilot stage, two switching valves, an amplifier) shows as a lag of first order from the
command to the set-point, and as an opening in proportion to the error.

I v' = K (p_a - p_b) - c v - T_0 - k q - friction, V_a = V_0 + K q, V_b = V_0 - K q. One K for torque
and volume, so that the air does no other work than on the joint. Chamber A turns the joint forward.

friction = F_u + (F_l - F_u)/(1 + exp((Q - a)/b)) against the motion, and r times as much at rest. Q' = (q - Q)/tau is
empirical: what the elbow of a pneumatic android rubs depends on where it was in the seconds before, not on where it is
(see docs/derivations.md). With F_l = F_u and r = 1 it is Coulomb friction.
"""

from math import exp
from typing import NamedTuple

from layflat.jit import law
from layflat.lanes import select
from layflat.physics.chamber import Chamber, air_mass, energy, pressure_after_swelling, temperature_and_roots, wall_heat
from layflat.physics.flow import root_temperature
from layflat.physics.friction.turning import brake_one
from layflat.physics.valves import chamber_flow

FAR = 40.0  # so many widths from its change a friction stays as it is; exp would overflow


class Regulator(NamedTuple):
    """Parameters; the set-point is gain (command - ambient pressure) + offset above the ambient pressure."""

    gain: float
    offset_a: float
    offset_b: float
    lag: float
    conductance_in: float
    conductance_out: float
    band_in: float
    band_out: float
    critical_ratio: float
    laminar_slope: float


@law
def share_in(h, lag):
    """Share of the way that a lag of first order goes in a step of h seconds, exactly."""
    return 1.0 - exp(-h / lag)


@law
def asked_set_point(regulator, offset, command, p_ambient):
    """Set-point that a command (absolute, Pa) asks for in the end, of a valve with this offset, Pa."""
    return p_ambient + regulator.gain * (command - p_ambient) + offset


@law
def regulator_opening(regulator, s, p):
    """Opening at set-point s and pressure p."""
    error = s - p
    return min(max(error / select(error > 0.0, regulator.band_in, regulator.band_out), -1.0), 1.0)


@law
def regulator_conductances(regulator, s, p):
    """Conductances towards supply and exhaust at set-point s and pressure p, m3/(s Pa)."""
    x = regulator_opening(regulator, s, p)
    return regulator.conductance_in * max(x, 0.0), regulator.conductance_out * max(-x, 0.0)


class LaggingFriction(NamedTuple):
    """Friction whose level goes by the angle that it remembers."""

    lower: float  # N m
    upper: float  # N m
    change_angle: float  # rad
    change_width: float  # rad
    lag: float  # s
    static_ratio: float


@law
def friction_level(friction, Q, v):
    """Torque at which a joint that remembers the angle Q slides at velocity v, or slips where it is 0, N m."""
    x = (Q - friction.change_angle) / friction.change_width
    share = 1.0 / (1.0 + exp(min(max(x, -FAR), FAR)))
    level = friction.upper + share * (friction.lower - friction.upper)
    return select(v == 0.0, friction.static_ratio, 1.0) * level


class Air(NamedTuple):
    """Around both chambers: absolute pressures (Pa) and the one temperature of supply and surroundings (K)."""

    supply_pressure: float
    ambient_pressure: float
    temperature: float


class RegulatedJoint(NamedTuple):
    """Parameters; both chambers and both valves are alike."""

    valve: Regulator
    chamber: Chamber
    torque_per_pressure: float
    inertia: float
    damping: float
    load_torque: float
    stiffness: float
    friction: LaggingFriction
    lower_stop: float
    upper_stop: float


class Shares(NamedTuple):
    """Shares that each lag goes in a step."""

    set_point: float
    memory: float


class ChamberState(NamedTuple):
    """Set-point that the valve works towards (Pa), energy (J), mass (kg), volume (m3), absolute pressure (Pa)."""

    set_point: float
    energy: float
    mass: float
    volume: float
    pressure: float


class JointState(NamedTuple):
    """Angle (rad), velocity (rad/s) and the angle that the friction remembers (rad)."""

    angle: float
    velocity: float
    remembered: float


@law
def lag_shares(joint, h):
    """Return how far each lag goes in a step of h seconds."""
    return Shares(share_in(h, joint.valve.lag), share_in(h, joint.friction.lag))


@law
def chamber_at_rest(joint, travel, p, air):
    """A chamber whose valve holds it at pressure p; `travel` is q for chamber A, -q for chamber B."""
    volume = joint.chamber.dead_volume + joint.torque_per_pressure * travel
    stored = energy(joint.chamber, p, volume, air.ambient_pressure)
    mass = air_mass(joint.chamber, p, air.temperature, volume, air.ambient_pressure)
    return ChamberState(p, stored, mass, volume, p)


@law
def at_rest(q):
    """A joint that has been at rest at q for long."""
    return JointState(q, 0.0, q)


@law
def move(joint, state, p_a, p_b, shares, h):
    """State of the joint after a step at these pressures; a held joint has velocity 0.0."""
    Q = state.remembered + shares.memory * (state.angle - state.remembered)
    load = joint.load_torque + joint.stiffness * state.angle
    momentum = joint.inertia * state.velocity + h * (joint.torque_per_pressure * (p_a - p_b) - load)
    F = friction_level(joint.friction, Q, state.velocity)
    v, _ = brake_one(joint.inertia + h * joint.damping, momentum, -h * F, h * F)
    q = state.angle + h * v
    held = min(max(q, joint.lower_stop), joint.upper_stop)
    return JointState(held, select(held == q, v, 0.0), Q)


@law
def exchange_gas(joint, state, travel, asked, air, shares, h):
    """State of a chamber after a step in which it swells to its volume at `travel`, and air flows.

    `asked` is the set-point that its valve goes for, Pa.
    """
    p_a, supply = air.ambient_pressure, root_temperature(air.temperature)
    s = state.set_point + shares.set_point * (asked - state.set_point)
    C_in, C_out = regulator_conductances(joint.valve, s, state.pressure)
    volume = joint.chamber.dead_volume + joint.torque_per_pressure * travel
    # Half of the work at the pressure before, half at that after: no damping by the step.
    half = 0.5 * (volume - state.volume)
    stored = state.energy - state.pressure * half
    p, stiffness = pressure_after_swelling(joint.chamber, stored, volume, half, state.pressure, p_a)
    T, roots = temperature_and_roots(joint.chamber, p, state.mass, volume, p_a)
    flow, heat, _ = chamber_flow(joint.valve, C_in, C_out, p, roots, air.supply_pressure, supply, p_a)
    gained = h * (heat + wall_heat(joint.chamber, T, air.temperature))
    return ChamberState(s, stored - p * half + gained, state.mass + h * flow, volume, p + gained * stiffness)
