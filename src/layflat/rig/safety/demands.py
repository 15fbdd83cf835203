"""Gate of the demands: inside the working stroke, and no faster than joints can go.

Demands of control laws that plan their own motion move: such a demand is an angle with velocity and acceleration at an
instant. Its motion is extrapolated for a while, unless another one comes: a host may send demands less often than the
loop cycles, or late. Where a host sends angles alone, velocity and acceleration are derived from them, by the rule of
`motion/trajectory.py`: a rate that lasts from one angle to the next is a motion, one that does not is a jump. Later
demands are unknown, so rates are those of the past, extrapolated to now.

A step inside the working stroke passes whole; a moving demand is slowed so that it comes to rest at the border. One
that would reverse a fast joint waits until the arm has nearly reached the demand before it: the torques of a reversal
would drive the other joints out of their strokes.

| symbol | meaning | unit |
|---|---|---|
| q, v, a | angle, velocity and acceleration of a demand | rad, rad/s, rad/s2 |
| b | deceleration that the arm has in every posture | rad/s2 |
| s | sign of the velocity | 1 |
| t | time since the target instant of the demand | s |
"""

from math import isfinite, nan
from typing import NamedTuple

from layflat.jit import law

DEMAND_LIMITED, DEMAND_REFUSED = 1, 2  # outcomes of a demand that does not pass unchanged
STROKE_TOLERANCE = 1e-9  # excess over the working stroke that counts as rounding, rad
EXTRAPOLATION_TIME = 0.05  # for which a motion with a velocity of the host goes on without another demand, s
MAX_STREAM_INTERVAL = 0.05  # between two angles that may be a motion, s
EXTRAPOLATION_RATIO = 1.5  # time for which a derived motion goes on over the interval of the angles; then they stand
REST_VELOCITY = 1e-3  # below which a demand is at rest, rad/s
JUMP_ANGLE = 0.1  # deviation of a demand from the extrapolated one before it that is a jump, rad
REVERSAL_VELOCITY = 1.0  # above which a reversed joint drives others out of their strokes, rad/s
SAME_INSTANT = 1e-6  # difference below which instants are the same, s


class DemandGate(NamedTuple):
    """Limits of the gate of a joint's demands, for control laws that do not plan."""

    working: float  # half the working stroke, rad
    mechanical: float  # half the mechanical stroke, rad
    speed: float  # of the reference, rad/s


class GatedDemand(NamedTuple):
    """Demand after its gate, and the reference that moves towards it, rad."""

    demand: float
    reference: float


@law
def demand_lead(now):
    """Return the distance between a demand and its reference, rad."""
    return abs(now.demand - now.reference)


@law
def stop_margin(gate, now, requested):
    """Return the smaller distance to the mechanical stops, from the requested angle or from the reference, rad.

    The present demand counts in place of a requested angle that is outside the working stroke.
    """
    target = abs(requested) if abs(requested) <= gate.working else abs(now.demand)
    return gate.mechanical - max(target, abs(now.reference))


@law
def advance_reference(gate, gated, elapsed):
    """Return the gated demand, its reference moved towards the demand by at most gate.speed * elapsed (rad/s, s)."""
    step, remaining = gate.speed * elapsed, gated.demand - gated.reference
    reference = gated.demand if abs(remaining) <= step else gated.reference + (step if remaining > 0.0 else -step)
    return GatedDemand(gated.demand, reference)


@law
def follow_demand(gate, now, requested, lead, elapsed):
    """Return the demand after a cycle in which an angle (rad) was requested, and its outcome.

    A demand may jump ahead of the reference by `lead`; the reference follows it. Small steps thus pass unchanged, and
    large ones become a step and a ramp. One outside the stroke is refused.
    """
    refused = not (isfinite(requested) and abs(requested) <= gate.working + STROKE_TOLERANCE)
    target = now.demand if refused else requested
    # One that turns back while the joint is moving would leap by twice the lead from the reference.
    turned_back = (target - now.demand) * (now.demand - now.reference) < 0.0
    reference = now.demand if turned_back else now.reference
    low, high = reference - lead, reference + lead
    allowed = low if target < low else high if target > high else target
    outcome = DEMAND_REFUSED if refused else (DEMAND_LIMITED if allowed != target else 0)
    return advance_reference(gate, GatedDemand(allowed, reference), elapsed), outcome


class MovingDemandLimits(NamedTuple):
    """Limits of the moving demands of a joint, for control laws that plan."""

    working: float  # half the working stroke, rad
    pace: float  # limit of the demand's speed in the machine's file; infinite: jumps pass, rad/s
    speed: float  # of the joint, rad/s
    acceleration: float  # greatest in any configuration, rad/s2
    braking: float  # b
    cycle: float  # s
    surge: float  # change of velocity per time up to which a stream of angles is a motion, rad/s2
    jerk: float  # change of acceleration per time, likewise, rad/s3


class DemandStream(NamedTuple):
    """Motion of a host's demands, derived from its last angles."""

    angle: float = nan  # the last one, rad
    rate: float = nan  # of the last two, rad/s
    velocity: float = 0.0  # the same where it lasts, else zero
    change: float = 0.0  # rate of that velocity, rad/s2
    acceleration: float = 0.0  # the same where it lasts, else zero
    since: float = 0.0  # t
    apart: float = 0.0  # time between the last two, s


class MovingDemand(NamedTuple):
    """Demand with its motion."""

    angle: float  # q
    velocity: float  # v
    acceleration: float  # a


@law
def derive_stream(limits, before, requested, since, elapsed):
    """Return the stream after a cycle of `elapsed` seconds in which an angle (rad) was requested.

    Its target instant was `since` seconds ago; one with the same instant as before is the same demand.
    """
    apart = before.since + elapsed - since
    if apart < SAME_INSTANT:
        return DemandStream(
            before.angle, before.rate, before.velocity, before.change, before.acceleration, since, before.apart
        )
    rate = (requested - before.angle) / apart
    lasts = apart <= MAX_STREAM_INTERVAL and abs(rate - before.rate) <= limits.surge * limits.cycle
    velocity = rate if lasts else 0.0
    change = (velocity - before.velocity) / apart
    acceleration = change if abs(change - before.change) <= limits.jerk * limits.cycle else 0.0
    return DemandStream(requested, rate, velocity, change, acceleration, since, apart)


@law
def _clip(value, limit):
    """Return the value within +-limit; 0 for NaN."""
    return 0.0 if value != value else min(max(value, -limit), limit)  # noqa: PLR0124


@law
def _extrapolate(q, v, a, t):
    return MovingDemand(q + t * (v + 0.5 * t * a), v + t * a, a)


@law
def _brake_to_rest(now, b, t):
    """Return the state, after t seconds, of a motion that brakes with deceleration b to rest."""
    lasts = abs(now.velocity) / b
    u, s = min(t, lasts), 1.0 if now.velocity > 0.0 else -1.0
    brakes = b if t < lasts else 0.0
    return MovingDemand(now.angle + u * (now.velocity - 0.5 * s * b * u), now.velocity - s * b * u, -s * brakes)


@law
def extrapolate_demand(limits, stream, requested, velocity, acceleration):
    """Return a requested demand extrapolated to now, and whether its rates were limited.

    A velocity of NaN is taken from the stream, with its acceleration; an acceleration of NaN is 0.
    """
    t = stream.since
    if velocity != velocity:  # noqa: PLR0124
        v, a = stream.velocity, stream.acceleration
        v_clipped, a_clipped = _clip(v, limits.speed), _clip(a, limits.acceleration)
        limited = v != v_clipped
        if t > EXTRAPOLATION_RATIO * stream.apart:
            return MovingDemand(requested, 0.0, 0.0), limited
        # Means over the time between two angles are those of half of it before.
        v_now = _clip(v_clipped + 0.5 * a_clipped * stream.apart, limits.speed)
        return _extrapolate(requested, v_now, a_clipped, t), limited
    a_requested = 0.0 if acceleration != acceleration else acceleration  # noqa: PLR0124
    v, a = _clip(velocity, limits.speed), _clip(a_requested, limits.acceleration)
    limited = v != velocity or a != a_requested
    now = _extrapolate(requested, v, a, min(t, EXTRAPOLATION_TIME))
    return (now if t <= EXTRAPOLATION_TIME else _brake_to_rest(now, limits.braking, t - EXTRAPOLATION_TIME)), limited


@law
def brake_at_border(limits, now):
    """Return a demand that brakes so as to rest at the border of the working stroke, and whether it had to.

    A demand with a constant velocity that is x beyond the point from which b just stops it at the border has been there
    for x/|v|, and has braked for that time. One that comes back from outside starts at the border.
    """
    working = limits.working
    if abs(now.velocity) <= REST_VELOCITY:
        return now, False
    s = 1.0 if now.velocity > 0.0 else -1.0
    v, q = s * now.velocity, s * now.angle
    if q < -working:
        return MovingDemand(-s * working, 0.0, 0.0), True
    b = max(limits.braking, -s * now.acceleration)
    beyond = q + 0.5 * v * v / b - working
    if beyond <= STROKE_TOLERANCE:
        return now, False
    t = min(beyond / v, v / b)
    slower = v - b * t
    angle = min(q - 0.5 * b * t * t, working - 0.5 * slower * slower / b)
    return MovingDemand(s * angle, s * slower, -s * b if slower > 0.0 else 0.0), True


@law
def reverses_joint(limits, angle, velocity, now):
    """Return whether a joint faster than `REVERSAL_VELOCITY` (rad, rad/s) would overshoot a demand, braking with b."""
    s = 1.0 if velocity > 0.0 else -1.0
    stops = s * angle + 0.5 * velocity * velocity / limits.braking
    return abs(velocity) > REVERSAL_VELOCITY and stops > s * now.angle


@law
def is_jump(before, velocity, now, elapsed):
    """Return whether a demand is further than `JUMP_ANGLE` from the extrapolated one before it (rad, rad/s)."""
    return abs(now.angle - before - velocity * elapsed) > JUMP_ANGLE


@law
def gate_demand(limits, before, requested, now, limited, elapsed):
    """Return the demand that passes after the one before (rad), and its outcome: 0, DEMAND_LIMITED or DEMAND_REFUSED.

    A refused one leaves the demand before it at rest; one faster than `limits.pace` moves at that speed.


    Args: requested angle (rad), the demand extrapolated to now, whether that was limited, and the time of a cycle (s).
    """
    kept, leaves = brake_at_border(limits, now)
    outcome = DEMAND_LIMITED if limited or leaves else 0
    if not (isfinite(requested) and abs(kept.angle) <= limits.working + STROKE_TOLERANCE):
        return MovingDemand(before, 0.0, 0.0), DEMAND_REFUSED
    step, left = limits.pace * elapsed, kept.angle - before
    if abs(left) > step + STROKE_TOLERANCE:
        v = limits.pace if left > 0.0 else -limits.pace
        return MovingDemand(before + v * elapsed, v, 0.0), DEMAND_LIMITED
    return kept, outcome
