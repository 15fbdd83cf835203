"""Demands that move, for control laws that plan their own motion: where they are by now, and what is let through.

A demand is an angle with velocity and acceleration at an instant. From there on its motion goes on, for a while, unless
another one comes: a host may ask less often than the loop cycles, or late. Where a host gives angles alone, velocity
and acceleration are derived from them, by the rule of `motion/rates.py`: what lasts from one to the next is a motion,
what does not is a jump. Here nothing is known of what comes, so that rates are those of the past, led on to now.

A step inside the working stroke is let through whole; what moves is slowed so that it comes to rest at the border.
One that would turn a fast joint round waits until the arm has all but come to the demand before it: torques that do so
fling the other joints out of their strokes.

| symbol | meaning | unit |
|---|---|---|
| q, v, a | angle, velocity and acceleration of a demand | rad, rad/s, rad/s2 |
| b | deceleration that the arm has in every posture | rad/s2 |
| s | sign of the velocity | 1 |
| t | time since the instant for which the demand was meant | s |
"""

from math import isfinite, nan
from typing import NamedTuple

from layflat.jit import law
from layflat.rig.safety.demands import LIMITED, REFUSED, TOLERANCE

GOES_ON = 0.05  # for so long a motion goes on that was given with its velocity, unless another demand comes, s
STREAM = 0.05  # angles that come so far apart at most may be a motion, s
LATE = 1.5  # times as long as angles are apart, a derived motion goes on: then the angle stands as it was asked for
REST = 1e-3  # velocity below which a demand is at rest, rad/s
JUMP = 0.1  # by which a demand is elsewhere than it was led to, rad
ON_ITS_WAY = 1.0  # velocity from which a joint flings the others if it is turned round, rad/s
SAME = 1e-6  # instants that are closer are the same, s


class Limits(NamedTuple):
    """What demands of a joint may do."""

    working: float  # half the working stroke, rad
    pace: float  # with which demands go on where the machine's file says so; infinite: jumps are let through, rad/s
    speed: float  # that the joint can have, rad/s
    acceleration: float  # that no posture exceeds, rad/s2
    braking: float  # b
    cycle: float  # s
    surge: float  # change of velocity per time up to which a stream of angles is a motion, rad/s2
    jerk: float  # the same of an acceleration, rad/s3


class Stream(NamedTuple):
    """What the last angles of a host tell of their motion."""

    angle: float = nan  # the last one, rad
    rate: float = nan  # of the last two, rad/s
    velocity: float = 0.0  # the same where it lasts, else zero
    change: float = 0.0  # rate of that velocity, rad/s2
    acceleration: float = 0.0  # the same where it lasts, else zero
    since: float = 0.0  # t
    apart: float = 0.0  # time between the last two, s


class Moving(NamedTuple):
    """A demand."""

    angle: float  # q
    velocity: float  # v
    acceleration: float  # a


@law
def derived(limits, before, asked, since, elapsed):
    """The stream after a cycle of `elapsed` seconds in which this angle (rad) was asked for, meant `since` seconds ago.

    The same instant as before is the same demand.
    """
    apart = before.since + elapsed - since
    if apart < SAME:
        return Stream(
            before.angle, before.rate, before.velocity, before.change, before.acceleration, since, before.apart
        )
    rate = (asked - before.angle) / apart
    lasts = apart <= STREAM and abs(rate - before.rate) <= limits.surge * limits.cycle
    velocity = rate if lasts else 0.0
    change = (velocity - before.velocity) / apart
    acceleration = change if abs(change - before.change) <= limits.jerk * limits.cycle else 0.0
    return Stream(asked, rate, velocity, change, acceleration, since, apart)


@law
def _kept(value, most):
    # Within a limit either way; what is not a number is none.
    return 0.0 if value != value else min(max(value, -most), most)  # noqa: PLR0124


@law
def _after(q, v, a, t):
    return Moving(q + t * (v + 0.5 * t * a), v + t * a, a)


@law
def _at_rest_after(now, b, t):
    # A motion that comes to rest, t seconds after it began to.
    lasts = abs(now.velocity) / b
    u, s = min(t, lasts), 1.0 if now.velocity > 0.0 else -1.0
    brakes = b if t < lasts else 0.0
    return Moving(now.angle + u * (now.velocity - 0.5 * s * b * u), now.velocity - s * b * u, -s * brakes)


@law
def by_now(limits, stream, asked, velocity, acceleration):
    """Where a demand is by now, and 1 where its rates had to be limited; rates that are not numbers are derived."""
    t = stream.since
    if velocity != velocity:  # noqa: PLR0124
        v, a = stream.velocity, stream.acceleration
        v_most, a_most = _kept(v, limits.speed), _kept(a, limits.acceleration)
        limited = v != v_most
        if t > LATE * stream.apart:
            return Moving(asked, 0.0, 0.0), limited
        # Means over the time between two angles are those of half of it before.
        return _after(asked, _kept(v_most + 0.5 * a_most * stream.apart, limits.speed), a_most, t), limited
    given = 0.0 if acceleration != acceleration else acceleration  # noqa: PLR0124
    v, a = _kept(velocity, limits.speed), _kept(given, limits.acceleration)
    limited = v != velocity or a != given
    now = _after(asked, v, a, min(t, GOES_ON))
    return (now if t <= GOES_ON else _at_rest_after(now, limits.braking, t - GOES_ON)), limited


@law
def inside(limits, now):
    """A demand, as it comes to rest at the border where it would leave the working stroke, and whether it would.

    Beyond the place from which b just stops it by x, a demand with a constant velocity has been for x/|v|; so long it
    has been braked. One that comes back is let in at the border.
    """
    working = limits.working
    if abs(now.velocity) <= REST:
        return now, False
    s = 1.0 if now.velocity > 0.0 else -1.0
    v, q = s * now.velocity, s * now.angle
    if q < -working:
        return Moving(-s * working, 0.0, 0.0), True
    b = max(limits.braking, -s * now.acceleration)
    beyond = q + 0.5 * v * v / b - working
    if beyond <= TOLERANCE:
        return now, False
    t = min(beyond / v, v / b)
    slower = v - b * t
    angle = min(q - 0.5 * b * t * t, working - 0.5 * slower * slower / b)
    return Moving(s * angle, s * slower, -s * b if slower > 0.0 else 0.0), True


@law
def turns(limits, angle, velocity, now):
    """Whether a joint (rad, rad/s) that is on its way would pass a demand, since b does not bring it to rest before."""
    s = 1.0 if velocity > 0.0 else -1.0
    stops = s * angle + 0.5 * velocity * velocity / limits.braking
    return abs(velocity) > ON_ITS_WAY and stops > s * now.angle


@law
def jumps(before, velocity, now, elapsed):
    """Whether a demand is elsewhere than the one before (rad, rad/s) would be by now."""
    return abs(now.angle - before - velocity * elapsed) > JUMP


@law
def let_through(limits, before, asked, now, limited, elapsed):
    """The demand that is let through after the one before (rad), and what became of it.

    Args: what was asked for (rad), where it is by now, whether it was limited for that, and the time of a cycle (s).
    """
    kept, leaves = inside(limits, now)
    outcome = LIMITED if limited or leaves else 0
    if not (isfinite(asked) and abs(kept.angle) <= limits.working + TOLERANCE):
        return Moving(before, 0.0, 0.0), REFUSED
    way, left = limits.pace * elapsed, kept.angle - before
    if abs(left) > way + TOLERANCE:
        v = limits.pace if left > 0.0 else -limits.pace
        return Moving(before + v * elapsed, v, 0.0), LIMITED
    return kept, outcome
