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
"""

from layflat.control.average import mean4, ripple4
from layflat.control.kind import voltages_alone
from layflat.control.paper.gains import Memories, Memory, Report, fed_back
from layflat.jit import composition, law
from layflat.lanes import each, select


@law
def wake_joint(gains, x, dp):  # noqa: ARG001  (as `step_joint`)
    """Memory of a joint at rest at an angle (rad) and a differential pressure (Pa)."""
    return Memory(x, x, x, dp, dp, dp, x, 0.0, 0.0, 0.0)


@law
def _phase(gains, error, speed):
    """Phase of the move, and its gains."""
    near = (abs(error) < gains.near_error) & (abs(speed) < gains.near_speed)
    close = (abs(error) < gains.close_error) & (abs(speed) < gains.close_speed)
    k_e = select(close, gains.close.error_gain, select(near, gains.near.error_gain, gains.far.error_gain))
    k_p = select(close, gains.close.pressure_gain, select(near, gains.near.pressure_gain, gains.far.pressure_gain))
    return select(close, 3.0, select(near, 2.0, 1.0)), k_e, k_p


@law
def _clamp(value, limit):
    return min(max(value, -limit), limit)


@law
def _integrals(gains, memory, phase, held, error, may_learn, elapsed):
    """F and FL after this cycle; `held` is what the other terms add to the null.

    At rest and without a load, all that the controller adds to its null makes up for a null that is wrong: FL learns
    it. F gives up what FL takes over from it, so that the hand-over does not disturb the joint.
    """
    share = select(may_learn, elapsed / gains.drift_time, 0.0)
    handed = share * memory.short_term
    short = memory.short_term - handed + gains.integral_gain * error * elapsed
    short = select(phase == 3.0, _clamp(short, gains.integral_limit), 0.0)
    long = _clamp(memory.long_term + handed + share * held, gains.drift_limit)
    return short, long


@law
def step_joint(gains, memory, x, dp, demand, elapsed):
    """One cycle of one joint: memory, voltage, report. Source: the paper's Eq. (2) and section 3."""
    x_mean = mean4(x, memory.angle_0, memory.angle_1, memory.angle_2)
    dp_mean = mean4(dp, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    ripple = ripple4(dp, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    x_used = x + gains.averaged * (x_mean - x)
    dp_used = dp + gains.averaged * (dp_mean - dp)
    speed = (x_used - memory.last_angle) / elapsed
    error = demand - x_used
    phase, k_e, k_p = _phase(gains, error, speed)
    rest = select(abs(speed) < gains.rest_speed, memory.rest + elapsed, 0.0)
    quiet = (rest >= gains.rest_time) & (abs(dp_used) < gains.load_pressure)
    may_learn = (ripple > gains.air_ripple) & quiet & (phase == 3.0)
    held = k_e * error - k_p * dp_used
    short, long = _integrals(gains, memory, phase, held, error, may_learn, elapsed)
    voltage = held + gains.null + short + long
    voltage = min(max(voltage, gains.voltage_low), gains.voltage_high)
    after = Memory(
        x, memory.angle_0, memory.angle_1, dp, memory.pressure_0, memory.pressure_1, x_used, short, long, rest
    )
    learning = select(may_learn, 1.0, 0.0)
    return after, voltage, Report(x_used, speed, dp_used, ripple, phase, short, long, learning)


@composition
def wake(settings, sensed):
    """Memory of a law that begins at these measurements."""
    dp = fed_back(settings.load, sensed.angle, sensed.differential_pressure)
    return Memories(each(wake_joint, settings.joints, sensed.angle, dp))


@composition
def step(settings, memory, sensed, demand, elapsed):
    """One cycle: memory, command, report (see control/kind.py)."""
    x, dp = sensed.angle, fed_back(settings.load, demand.angle, sensed.differential_pressure)
    joints, voltages, reports = each(step_joint, settings.joints, memory.joints, x, dp, demand.angle, elapsed)
    return Memories(joints), voltages_alone(voltages), reports


@law
def _learnt(memory):
    return memory.long_term


@law
def centre_shift(settings, memory, joints):  # noqa: ARG001
    """Return what the long-term integral has learnt of each valve's centre, V."""
    return each(_learnt, memory.joints)
