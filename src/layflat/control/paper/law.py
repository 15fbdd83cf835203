"""The paper's control law, Eq. (2): each joint by itself, in three phases of a move.

V = k_e (d - x) - k_p dp + N + F + FL

| symbol | meaning | unit |
|---|---|---|
| x, d | actual and demanded angle | rad |
| dp | differential pressure, hose A less hose B | Pa |
| k_e, k_p | gains of the present phase | V/rad, V/Pa |
| N | null value | V |
| F | short-term integral: in phase 3 only | V |
| FL | long-term integral: corrects a drifting null | V |

Signs: a positive voltage above N fills hose A and turns the joint forward (see docs/conventions.md).

Eq. (2) uses differential pressure as a measure of acceleration. Under gravity or against a spring it is none: a joint
at rest needs some pressure, which would count as motion. With `load_compensation`, the pressure that the described
arm needs at its demand is therefore subtracted from the feedback; the paper's arm moves in a level plane and needs
none.
"""

from typing import Any, NamedTuple

from layflat.control.kind import voltages_alone
from layflat.control.signals import SIGNALS as AVERAGED
from layflat.control.signals import mean4, ripple4
from layflat.jit import by_kind, composition, law
from layflat.lanes import each, select
from layflat.physics.arms import dynamics
from layflat.physics.joint import Surroundings, pressures_at_rest


class NoLoad(NamedTuple):
    """Load model of a law that feeds the differential pressure back unchanged."""


class DescribedLoad(NamedTuple):
    """Load model of the described arm: parameters of its laws, its joints' and the surroundings."""

    arm: Any
    joints: tuple[Any, ...]
    around: Surroundings


@law
def _zero_velocity(q):
    return 0.0 * q


@law
def _subtract_load(dp, joint, q, pull, around):
    """Return dp less the differential pressure that holds a joint at q (rad) against a pull (N m), Pa."""
    p_1, p_2 = pressures_at_rest(joint, q, pull, around)
    return dp - (p_1 - p_2)


@composition
def _keep_pressure(load, q, dp):  # noqa: ARG001
    return dp


@composition
def _remove_load(load, q, dp):
    """Return the differential pressures less those that hold the described arm at angles q, tuples, Pa."""
    _, _, pulls = dynamics(load.arm, load.around.payload, q, each(_zero_velocity, q))
    return each(_subtract_load, dp, load.joints, q, pulls, load.around)


feedback_pressure = by_kind({NoLoad: _keep_pressure, DescribedLoad: _remove_load})
"""Differential pressures less those that hold the arm at angles q: `feedback_pressure(load, q, dp)`, tuples, Pa."""


class FeedbackGains(NamedTuple):
    """Gains of one phase of a move."""

    error_gain: float  # k_e, V/rad
    pressure_gain: float  # k_p, V/Pa


class Gains(NamedTuple):
    """Settings of one joint's controller; phase 1 is far or fast, 2 near, 3 close."""

    far: FeedbackGains
    near: FeedbackGains
    close: FeedbackGains
    near_error: float  # below which, and below `near_speed`, phase 2 holds, rad
    near_speed: float  # rad/s
    close_error: float  # below which, and below `close_speed`, phase 3 holds, rad
    close_speed: float  # rad/s
    null: float  # N, the valve's nominal centre, V
    integral_gain: float  # of the short-term integral F, V/(rad s)
    integral_limit: float  # of F, V
    drift_time: float  # time constant of the long-term integral FL, s
    drift_limit: float  # of FL, V
    air_ripple: float  # rule 1: pressure ripple above which the hoses are supplied with air, Pa
    rest_speed: float  # rule 2: speed below which the joint may be at rest, rad/s
    rest_time: float  # rule 2: min duration of this, s, since a joint that reverses is slow for a moment too
    load_pressure: float  # rule 3: differential pressure below which there is no offset load, Pa
    voltage_low: float  # V
    voltage_high: float  # V
    averaged: float  # 1: signals are averaged over four cycles (a dither period); 0: only the last sample is used


class Settings(NamedTuple):
    """Settings of the whole arm: `Gains` of every joint."""

    joints: tuple[Gains, ...]
    load: NoLoad | DescribedLoad = NoLoad()


class Memory(NamedTuple):
    """Memory of one joint: last samples of both signals (newest first), last averaged angle, integrals, rest time."""

    angle_0: float  # rad
    angle_1: float  # rad
    angle_2: float  # rad
    pressure_0: float  # differential, Pa
    pressure_1: float  # likewise, Pa
    pressure_2: float  # likewise, Pa
    last_angle: float  # rad
    short_term: float  # F, V
    long_term: float  # FL, V
    slow_time: float  # time for which the joint has been slow, s


class Report(NamedTuple):
    """Signals of a joint that the law reports in a cycle; `SIGNALS` has units and meanings."""

    averaged_angle: float
    averaged_velocity: float
    averaged_pressure: float
    ripple: float
    phase: float
    short_term: float
    long_term: float
    learning: float


SIGNALS = {
    **AVERAGED,
    "phase": ("1", "phase of the controller"),
    "short_term": ("V", "short-term integral F"),
    "long_term": ("V", "long-term integral FL"),
    "learning": ("1", "1 while the long-term integral may build"),
}
"""Unit and meaning of each field of `Report`."""


class ArmMemory(NamedTuple):
    """Memory of the law: that of every joint."""

    joints: tuple[Memory, ...]


@law
def wake_joint(gains, x, dp):  # noqa: ARG001  (as `step_joint`)
    """Return the memory of a joint at rest at an angle (rad) and a differential pressure (Pa)."""
    return Memory(x, x, x, dp, dp, dp, x, 0.0, 0.0, 0.0)


@law
def _select_phase(gains, error, speed):
    """Return the number of the phase (1 to 3) at an error (rad) and a speed (rad/s), and its gains k_e and k_p."""
    near = (abs(error) < gains.near_error) & (abs(speed) < gains.near_speed)
    close = (abs(error) < gains.close_error) & (abs(speed) < gains.close_speed)
    k_e = select(close, gains.close.error_gain, select(near, gains.near.error_gain, gains.far.error_gain))
    k_p = select(close, gains.close.pressure_gain, select(near, gains.near.pressure_gain, gains.far.pressure_gain))
    return select(close, 3.0, select(near, 2.0, 1.0)), k_e, k_p


@law
def _clamp(value, limit):
    return min(max(value, -limit), limit)


@law
def _update_integrals(gains, memory, phase, correction, error, may_learn, elapsed):
    """Return F and FL after this cycle, V, clamped; F is 0 outside phase 3. `correction`: proportional terms, V.

    At rest and without a load, everything that the controller adds to its null compensates an error of the null, which
    FL learns. F decreases by the part that FL takes over from it, so that the transfer does not disturb the joint.
    """
    share = select(may_learn, elapsed / gains.drift_time, 0.0)
    transfer = share * memory.short_term
    short = memory.short_term - transfer + gains.integral_gain * error * elapsed
    short = select(phase == 3.0, _clamp(short, gains.integral_limit), 0.0)
    long = _clamp(memory.long_term + transfer + share * correction, gains.drift_limit)
    return short, long


@law
def step_joint(gains, memory, x, dp, demand, elapsed):
    """Return memory, voltage (V, within the valve's range) and report of one joint after a cycle.

    Source: the paper's Eq. (2) and section 3.
    """
    x_mean = mean4(x, memory.angle_0, memory.angle_1, memory.angle_2)
    dp_mean = mean4(dp, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    ripple = ripple4(dp, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    x_used = x + gains.averaged * (x_mean - x)
    dp_used = dp + gains.averaged * (dp_mean - dp)
    speed = (x_used - memory.last_angle) / elapsed
    error = demand - x_used
    phase, k_e, k_p = _select_phase(gains, error, speed)
    rest = select(abs(speed) < gains.rest_speed, memory.slow_time + elapsed, 0.0)
    quiet = (rest >= gains.rest_time) & (abs(dp_used) < gains.load_pressure)
    may_learn = (ripple > gains.air_ripple) & quiet & (phase == 3.0)
    correction = k_e * error - k_p * dp_used
    short, long = _update_integrals(gains, memory, phase, correction, error, may_learn, elapsed)
    voltage = correction + gains.null + short + long
    voltage = min(max(voltage, gains.voltage_low), gains.voltage_high)
    after = Memory(
        x, memory.angle_0, memory.angle_1, dp, memory.pressure_0, memory.pressure_1, x_used, short, long, rest
    )
    learning = select(may_learn, 1.0, 0.0)
    return after, voltage, Report(x_used, speed, dp_used, ripple, phase, short, long, learning)


@composition
def wake(settings, sensed):
    """Return the memory of the law at the start, at the sensors' readings."""
    dp = feedback_pressure(settings.load, sensed.angle, sensed.differential_pressure)
    return ArmMemory(each(wake_joint, settings.joints, sensed.angle, dp))


@composition
def step(settings, memory, sensed, demand, elapsed):
    """Return memory, command and report of one control cycle (see control/kind.py)."""
    x, dp = sensed.angle, feedback_pressure(settings.load, demand.angle, sensed.differential_pressure)
    joints, voltages, reports = each(step_joint, settings.joints, memory.joints, x, dp, demand.angle, elapsed)
    return ArmMemory(joints), voltages_alone(voltages), reports


@law
def _long_term(memory):
    return memory.long_term


@law
def centre_shift(settings, memory, joints):  # noqa: ARG001
    """Return the long-term integral of each joint: the estimated error of its valve's centre, V."""
    return each(_long_term, memory.joints)
