"""Rotary joint between two air chambers, each with a pressure-regulating valve, by its external behaviour.

| symbol | meaning | unit |
|---|---|---|
| s | lagged set-point of a valve, absolute | Pa |
| p | pressure of its chamber | Pa |
| x | opening, 1 fully towards the supply, -1 fully towards the exhaust | 1 |
| B, C | error s - p at which a side is fully open, and its sonic conductance then | Pa, m3/(s Pa) |
| q, v | joint angle from the middle of the stroke, and velocity | rad, rad/s |
| K | torque per pressure = volume that a chamber gains per radian | m3/rad |
| V_0 | volume of a chamber in the middle of the stroke | m3 |
| I, c | moment of inertia, damping | kg m2, N m s/rad |
| T_0, k | load torque in the middle of the stroke, and stiffness | N m, N m/rad |
| Q, tau | lagged angle, and the lag with which it follows q | rad, s |
| F_l, F_u | level of the friction well below Q = a, and well above it | N m |
| a, b | angle in the middle of the change from F_l to F_u, and how wide this is | rad |
| r | static over sliding friction | 1 |
| h | step | s |

The internals of a valve (a pilot stage, two switching valves, an amplifier) appear as a lag of first order from the
command to the set-point, and as an opening in proportion to the error.

I v' = K (p_a - p_b) - c v - T_0 - k q - friction, V_a = V_0 + K q, V_b = V_0 - K q. One K for torque
and volume, so that the air does no other work than on the joint. Chamber A drives the joint forward.

friction = F_u + (F_l - F_u)/(1 + exp((Q - a)/b)) against the motion, and r times as much at rest. Q' = (q - Q)/tau is
empirical: the friction in the elbow of a pneumatic android depends on its angle in the seconds before, not on the
present one (see docs/derivations.md). With F_l = F_u and r = 1 it is Coulomb friction.
"""

from math import ceil, exp, isfinite
from typing import NamedTuple

from layflat.arrays import Array
from layflat.jit import kernel, law
from layflat.lanes import select
from layflat.physics.chamber import (
    Chamber,
    air_mass,
    energy,
    pressure_after_expansion,
    temperature_and_roots,
    wall_heat,
)
from layflat.physics.flow import root_temperature
from layflat.physics.friction.turning import brake_one
from layflat.physics.valves import chamber_flow

MAX_CHANGE_WIDTHS = 40.0  # from the change, beyond which friction is constant; exp would overflow


class PressureRegulator(NamedTuple):
    """Parameters of both valves; the set-point is gain (command - ambient pressure) + offset, above ambient."""

    gain: float
    offset_a: float  # Pa
    offset_b: float  # Pa
    lag: float  # s
    conductance_in: float  # m3/(s Pa)
    conductance_out: float
    band_in: float  # error at which it is fully open, Pa
    band_out: float
    critical_ratio: float
    laminar_slope: float


@law
def lag_fraction(h, lag):
    """Return the fraction of a change that a lag of first order follows in a step of h seconds, exactly."""
    return 1.0 - exp(-h / lag)


@law
def target_setpoint(regulator, offset, command, p_ambient):
    """Return the set-point (Pa) to which a command (absolute, Pa) leads a valve with this offset (Pa)."""
    return p_ambient + regulator.gain * (command - p_ambient) + offset


@law
def regulator_opening(regulator, s, p):
    """Return the opening at set-point s and pressure p, from -1 (exhaust) to 1 (supply)."""
    error = s - p
    return min(max(error / select(error > 0.0, regulator.band_in, regulator.band_out), -1.0), 1.0)


@law
def regulator_conductances(regulator, s, p):
    """Return the conductances to supply and exhaust at set-point s and pressure p, m3/(s Pa)."""
    x = regulator_opening(regulator, s, p)
    return regulator.conductance_in * max(x, 0.0), regulator.conductance_out * max(-x, 0.0)


class LaggingFriction(NamedTuple):
    """Friction whose level depends on a lagged angle."""

    lower: float  # N m
    upper: float  # N m
    change_angle: float  # rad
    change_width: float  # rad
    lag: float  # s
    static_ratio: float


@law
def friction_level(friction, Q, v):
    """Return the friction of a joint with the lagged angle Q that slides at velocity v, or breaks away at 0, N m."""
    x = (Q - friction.change_angle) / friction.change_width
    share = 1.0 / (1.0 + exp(min(max(x, -MAX_CHANGE_WIDTHS), MAX_CHANGE_WIDTHS)))
    level = friction.upper + share * (friction.lower - friction.upper)
    return select(v == 0.0, friction.static_ratio, 1.0) * level


class AirConditions(NamedTuple):
    """Air around both chambers: absolute pressures (Pa) and the one temperature of supply and surroundings (K)."""

    supply_pressure: float
    ambient_pressure: float
    temperature: float


class RegulatedJoint(NamedTuple):
    """Parameters of the joint; both chambers and both valves are alike."""

    valve: PressureRegulator
    chamber: Chamber
    torque_per_pressure: float  # K
    inertia: float  # I
    damping: float  # c
    load_torque: float  # T_0
    stiffness: float  # k
    friction: LaggingFriction
    lower_stop: float  # rad
    upper_stop: float  # rad


class LagFractions(NamedTuple):
    """Fraction of a change that each lag follows in a step."""

    set_point: float
    friction_angle: float


class ChamberState(NamedTuple):
    """State of a chamber: lagged set-point (Pa), energy (J), mass (kg), volume (m3), absolute pressure (Pa)."""

    set_point: float
    energy: float
    mass: float
    volume: float
    pressure: float


class RegulatedJointState(NamedTuple):
    """State of the joint: angle (rad), velocity (rad/s) and the lagged angle of its friction (rad)."""

    angle: float
    velocity: float
    lagged_angle: float


@law
def lag_fractions(joint, h):
    """Return the fractions that the lags follow in a step of h seconds."""
    return LagFractions(lag_fraction(h, joint.valve.lag), lag_fraction(h, joint.friction.lag))


@law
def resting_chamber(joint, travel, p, air):
    """Return the state of a chamber at rest, its pressure and set-point p; `travel` is q for chamber A, -q for B."""
    volume = joint.chamber.dead_volume + joint.torque_per_pressure * travel
    stored = energy(joint.chamber, p, volume, air.ambient_pressure)
    mass = air_mass(joint.chamber, p, air.temperature, volume, air.ambient_pressure)
    return ChamberState(p, stored, mass, volume, p)


@law
def resting_joint(q):
    """Return the state of a joint that has been at rest at q for long."""
    return RegulatedJointState(q, 0.0, q)


@law
def step_regulated_joint(joint, state, p_a, p_b, fractions, h):
    """Return the joint's state after a step at these pressures; its velocity is 0.0 if it sticks or meets a stop."""
    Q = state.lagged_angle + fractions.friction_angle * (state.angle - state.lagged_angle)
    load = joint.load_torque + joint.stiffness * state.angle
    momentum = joint.inertia * state.velocity + h * (joint.torque_per_pressure * (p_a - p_b) - load)
    F = friction_level(joint.friction, Q, state.velocity)
    v, _ = brake_one(joint.inertia + h * joint.damping, momentum, -h * F, h * F)
    q = state.angle + h * v
    stopped = min(max(q, joint.lower_stop), joint.upper_stop)
    return RegulatedJointState(stopped, select(stopped == q, v, 0.0), Q)


@law
def step_chamber(joint, state, travel, target, air, fractions, h):
    """Return the state of a chamber after a step in which it swells to its volume at `travel`, and air flows.

    `target` is the set-point to which its command leads, Pa.
    """
    p_a, supply = air.ambient_pressure, root_temperature(air.temperature)
    s = state.set_point + fractions.set_point * (target - state.set_point)
    C_in, C_out = regulator_conductances(joint.valve, s, state.pressure)
    volume = joint.chamber.dead_volume + joint.torque_per_pressure * travel
    # Half of the work at the pressure before, half at that after: no damping by the step.
    half = 0.5 * (volume - state.volume)
    stored = state.energy - state.pressure * half
    p, stiffness = pressure_after_expansion(joint.chamber, stored, volume, half, state.pressure, p_a)
    T, roots = temperature_and_roots(joint.chamber, p, state.mass, volume, p_a)
    flow, heat, _ = chamber_flow(joint.valve, C_in, C_out, p, roots, air.supply_pressure, supply, p_a)
    gained = h * (heat + wall_heat(joint.chamber, T, air.temperature))
    return ChamberState(s, stored - p * half + gained, state.mass + h * flow, volume, p + gained * stiffness)


MAX_STEP_TIME = 2e-3  # longest step of the simulation, s
NOTHING_IMPOSED, MOTION_IMPOSED, PRESSURES_IMPOSED = 0, 1, 2  # signals of the log that are inputs besides the commands


class RegulatedSetup(NamedTuple):
    """Joint with the air around it, the delay of its valves (s), and its first angle (rad)."""

    joint: RegulatedJoint
    air: AirConditions
    delay: float
    start_angle: float


class RegulatedSignals(NamedTuple):
    """Signals of a log, (samples,) each."""

    time: Array  # s, increasing
    setpoint_a: Array  # command, absolute, Pa; holds until the next sample
    setpoint_b: Array
    angle: Array  # rad; used where the motion is imposed
    pressure_a: Array  # absolute, Pa; the first is the start, others are used where pressures are imposed
    pressure_b: Array


@law
def _mean_target(valve, offset, commands, j, fraction, before, p_a):
    """Return the mean set-point over a step, Pa: that of command j, and in its last `fraction` that of the next one.

    Before the first command (j < 0) the valve keeps the set-point `before`.
    """
    last = len(commands) - 1
    now = target_setpoint(valve, offset, commands[j], p_a) if j >= 0 else before
    after = target_setpoint(valve, offset, commands[min(j + 1, last)], p_a)
    return now + fraction * (after - now)


@law
def _interpolate(values, k, fraction):
    return values[k] + fraction * (values[k + 1] - values[k])


@kernel
def run_regulated(setup, signals, imposed, step, out):
    """Simulate a joint from rest through a log.

    Args: `RegulatedSetup`, `RegulatedSignals`, one of the constants that say which signals are `imposed`, the longest
    step (s), and an array for angle and both pressures by sample, (samples, 3), not a number from where it diverged.
    """
    time, samples = signals.time, len(signals.time)
    joint, valve, air = setup.joint, setup.joint.valve, setup.air
    motion = resting_joint(setup.start_angle)
    a = resting_chamber(joint, motion.angle, signals.pressure_a[0], air)
    b = resting_chamber(joint, -motion.angle, signals.pressure_b[0], air)
    delay, j = setup.delay, -1
    for k in range(samples):
        if not (isfinite(motion.angle) and a.pressure > 0.0 and b.pressure > 0.0 and a.mass * b.mass > 0.0):
            break
        out[k, 0], out[k, 1], out[k, 2] = motion.angle, a.pressure, b.pressure
        if imposed == PRESSURES_IMPOSED:
            out[k, 1], out[k, 2] = signals.pressure_a[k], signals.pressure_b[k]
        if k == samples - 1:
            break
        count = ceil((time[k + 1] - time[k]) / step - 1e-9)
        h = (time[k + 1] - time[k]) / count
        fractions = lag_fractions(joint, h)
        for n in range(count):
            fraction = (n + 1.0) / count
            if imposed == MOTION_IMPOSED:
                q = _interpolate(signals.angle, k, fraction)
                motion = RegulatedJointState(q, (q - motion.angle) / h, motion.lagged_angle)
            elif imposed == PRESSURES_IMPOSED:
                p_a, p_b = _interpolate(signals.pressure_a, k, fraction), _interpolate(signals.pressure_b, k, fraction)
                motion = step_regulated_joint(joint, motion, p_a, p_b, fractions, h)
            else:
                motion = step_regulated_joint(joint, motion, a.pressure, b.pressure, fractions, h)
            if imposed == PRESSURES_IMPOSED:
                continue
            end = time[k] + fraction * (time[k + 1] - time[k]) - delay
            while j + 1 < samples and time[j + 1] <= end - h:
                j += 1
            late = (end - time[j + 1]) / h if j + 1 < samples else 0.0
            late = min(max(late, 0.0), 1.0)
            p_out = air.ambient_pressure
            target_a = _mean_target(valve, valve.offset_a, signals.setpoint_a, j, late, a.set_point, p_out)
            target_b = _mean_target(valve, valve.offset_b, signals.setpoint_b, j, late, b.set_point, p_out)
            a = step_chamber(joint, a, motion.angle, target_a, air, fractions, h)
            b = step_chamber(joint, b, -motion.angle, target_b, air, fractions, h)
