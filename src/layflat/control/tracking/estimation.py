"""Estimation of parameters while the arm moves: loads, friction and payload, from innovations of the angles.

Constant unknowns beside a state are estimated apart from it (friedland1969): the observer of the motion goes by what is
known, and how the motion would differ were a parameter another (its sensitivity) is propagated along with it. What the
angles then differ by is a linear measurement of the parameters, which a Kalman filter of as many numbers takes in.
Loads may wander while the arm moves; what it carries may be another in every move of some length that begins at rest.
A short one would teach less of it than friction, as it is at rest, would pretend.

| symbol | meaning | unit |
|---|---|---|
| n, m | joints; parameters, m = 2 n + 1: a load and friction of each joint, and the payload | |
| x | the parameters: torques on the joints, friction beyond the described, mass | N m, N m, kg |
| C | their covariance, row by row | |
| Q, V | sensitivities of angle and velocity: joint j to parameter p at j m + p | rad, rad/s per unit of x |
| W | inverse of the mass matrix, row by row | 1/(kg m2) |
| T | time since the last cycle | s |
"""

from math import sqrt
from typing import NamedTuple

from layflat.control.tracking.model import angle_of_state
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import inverse, largest, times
from layflat.physics.arms import dynamics

CALM = 0.1  # speed of an arm that may have been given another payload since, rad/s
FAR = 0.05  # way to the goal from which it is open what an arm carries that sets out, rad
LIKELY = 2.0  # standard deviations within which the payload is likely to be
CREDIBLE = 3.0  # standard deviations: the further an innovation is beyond them, the less it counts


class Prior(NamedTuple):
    """What is known of the parameters beforehand: tuples with an item each, in the order of x."""

    usual: tuple[float, ...]
    spread: tuple[float, ...]  # standard deviation at first
    wander: tuple[float, ...]  # of a random walk while the arm moves, per square root of a second
    low: tuple[float, ...]
    high: tuple[float, ...]
    angle_variance: float  # of an innovation, rad2


class Shapes(NamedTuple):
    """Zeros, as many as matrices have items: of n n, m m and n m."""

    joints: tuple[float, ...]
    prior: tuple[float, ...]
    both: tuple[float, ...]


class ParameterEstimate(NamedTuple):
    """x, C, Q and V."""

    values: tuple[float, ...]
    covariance: tuple[float, ...]
    angles: tuple[float, ...]
    velocities: tuple[float, ...]


class Estimate(NamedTuple):
    """The parameters by what they are of."""

    loads: tuple[float, ...]
    frictions: tuple[float, ...]  # of each joint, the described included, N m
    payload: float


@composition
def initial_estimate(prior, shapes):
    """Return what is known beforehand."""
    m, spread = len(prior.spread), slots(prior.spread)
    C = slots(shapes.prior)
    for p in range(m):
        C[p * m + p] = spread[p] * spread[p]
    return ParameterEstimate(prior.usual, gather(shapes.prior, C), shapes.both, shapes.both)


@composition
def estimate_of(parameters, joints, shares):
    """Return the parameters by what they are of; frictions include those described, of which there is a share each."""
    n, x, parts, given = len(joints), slots(parameters.values), slots(joints), slots(shares)
    like = each(_zero, joints, x[0])
    frictions = slots(like)
    for j in range(n):
        frictions[j] = given[j].brake * (parts[j].brake_torque + x[n + j])
    return Estimate(gather(like, x), gather(like, frictions), x[2 * n])


@composition
def heaviest(prior, parameters):
    """Return the payload that is likely to be the most, kg."""
    m, x, C, high = len(prior.spread), slots(parameters.values), slots(parameters.covariance), slots(prior.high)
    return min(x[m - 1] + LIKELY * sqrt(max(C[m * m - 1], 0.0)), high[m - 1])


@law
def _zero(joint, x):  # noqa: ARG001  (one a joint)
    return 0.0 * x


@composition
def updated(prior, parameters, errors, learns):
    """Return the estimate after innovations of the angles, by how much angles and velocities change with it, and doubt.

    Doubt is the greatest innovation's square over its variance: 1 where the model is right.

    Args: learns: 0 where the arm is left to what pushes it, which is nothing to learn; else 1.
    """
    n, m = len(errors), len(parameters.values)
    e, C, Q = slots(errors), slots(parameters.covariance), slots(parameters.angles)
    change, gain, doubt = slots(parameters.values, 0.0 * e[0]), slots(parameters.values, 0.0 * e[0]), 0.0 * e[0]
    for j in range(n):
        spread, left = prior.angle_variance + 0.0 * e[0], e[j]
        for p in range(m):
            gain[p] = 0.0 * e[0]
            for r in range(m):
                gain[p] = gain[p] + learns * C[p * m + r] * Q[j * m + r]
            spread = spread + Q[j * m + p] * gain[p]
            left = left - Q[j * m + p] * change[p]
        per = 1.0 / spread
        # Squares are compared, since a root would cost more.
        doubt = max(doubt, left * left * per)
        taken = per * left * min(1.0, CREDIBLE * CREDIBLE * spread / max(left * left, 1e-30))
        for p in range(m):
            change[p] = change[p] + gain[p] * taken
            for r in range(m):
                C[p * m + r] = C[p * m + r] - gain[p] * gain[r] * per
    values = each(_within, parameters.values, gather(parameters.values, change), prior.low, prior.high)
    # Innovations beyond belief show that the payload is another than was estimated.
    doubted = (doubt > CREDIBLE * CREDIBLE) & (learns > 0.5)
    C[m * m - 1] = select(doubted, max(C[m * m - 1], _first(prior)), C[m * m - 1])
    after = ParameterEstimate(values, gather(parameters.covariance, C), parameters.angles, parameters.velocities)
    change = each(_less, values, parameters.values)
    turns, speeds = _moved(parameters.angles, change, errors), _moved(parameters.velocities, change, errors)
    return after, turns, speeds, doubt


@composition
def _first(prior):
    # Variance of the payload at first.
    spread = slots(prior.spread)[len(prior.spread) - 1]
    return spread * spread


@law
def _within(x, change, low, high):
    return min(max(x + change, low), high)


@law
def _less(x, y):
    return x - y


@composition
def _moved(sensitivities, change, like):
    # By how much the motion changes with the parameters.
    n, m, S, d = len(like), len(change), slots(sensitivities), slots(change)
    found = slots(like, 0.0 * d[0])
    for j in range(n):
        for p in range(m):
            found[j] = found[j] + S[j * m + p] * d[p]
    return gather(like, found)


@law
def _rubs(v, shares):
    return shares.brake * select(v > 0.0, 1.0, select(v < 0.0, -1.0, 0.0))


@law
def _stands(state):
    return select(state.motion.velocity == 0.0, 1.0, 0.0)


@law
def _mean_velocity(before, after):
    return 0.5 * (before.motion.velocity + after.motion.velocity)


@law
def _acceleration(before, after, T):
    return (after.motion.velocity - before.motion.velocity) / T


@law
def _lack(c_0, c_1, g_0, g_1, inertial_0, inertial_1):
    return (c_1 - c_0) + (g_1 - g_0) - (inertial_1 - inertial_0)


@composition
def propagated(prior, parameters, shapes, arm, gains, before, after, shares, left, T):
    """Return the estimate a cycle later: its sensitivities after the observer's correction and the motion since.

    Args: gains of the observer (`model.Gains`), states of the joints before and after the cycle, and shares of their
    friction in it (`Shares`), tuples; what is left of the way to the goal, rad.
    """
    n, m, x = len(before), len(parameters.values), slots(parameters.values)
    angles, speeds, a = (
        each(angle_of_state, after),
        each(_mean_velocity, before, after),
        each(_acceleration, before, after, T),
    )
    stands = each(_stands, after)
    M_0, c_0, g_0 = dynamics(arm, x[m - 1], angles, speeds)
    M_1, c_1, g_1 = dynamics(arm, x[m - 1] + 1.0, angles, speeds)
    heavier = slots(each(_lack, c_0, c_1, g_0, g_1, times(M_0, a), times(M_1, a)))
    W, way = slots(inverse(M_0, stands, shapes.joints)), slots(each(_rubs, speeds, shares))
    K, held = slots(gains), slots(stands)
    Q, V = slots(parameters.angles), slots(parameters.velocities)
    for j in range(n):
        for p in range(m):
            pushed = 0.0 * x[0]
            if p < n:
                pushed = W[j * n + p]
            elif p < 2 * n:
                pushed = -way[p - n] * W[j * n + p - n]
            else:
                for i in range(n):
                    pushed = pushed + W[j * n + i] * heavier[i]
            # What the observer takes over of the angles, it takes from the sensitivities as well.
            was = V[j * m + p] - K[j].velocity * Q[j * m + p]
            V[j * m + p] = (1.0 - held[j]) * (was + T * pushed)
            Q[j * m + p] = (1.0 - K[j].angle) * Q[j * m + p] + 0.5 * T * (was + V[j * m + p])
    covariance = _wandered(prior, parameters.covariance, largest(speeds), left, T)
    return ParameterEstimate(parameters.values, covariance, gather(shapes.both, Q), gather(shapes.both, V))


@composition
def _wandered(prior, covariance, speed, left, T):
    # An arm at rest may have been given another payload: it is as little known then as at first.
    m, wander, C = len(prior.spread), slots(prior.wander), slots(covariance)
    for p in range(m):
        C[p * m + p] = C[p * m + p] + select(speed > 0.0, T * wander[p] * wander[p], 0.0)
    sets_out = (speed < CALM) & (left > FAR)
    C[m * m - 1] = select(sets_out, max(C[m * m - 1], _first(prior)), C[m * m - 1])
    return gather(covariance, C)
