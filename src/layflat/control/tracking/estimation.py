"""Estimation of parameters while the arm moves: loads, friction and payload, from innovations of the angles.

Constant parameters are estimated separately from the state (friedland1969): the observer of the motion uses the present
estimate, and the sensitivities of the motion to the parameters are propagated along with it. The angles' innovations
are then linear measurements of the parameters, with which a Kalman filter of that order updates them. Loads follow a
random walk while the arm moves. The payload may change before every move from rest, unless the move is short: then
static friction would disturb its estimate more than the motion could correct it.

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

from layflat.control.tracking.model import joint_angle
from layflat.jit import composition, law
from layflat.lanes import each, gather, select, slots
from layflat.physics.algebra import invert_symmetric, max_magnitude, multiply_symmetric
from layflat.physics.arms import dynamics

SETTING_OUT_SPEED = 0.1  # max speed of an arm that starts to move, whose payload may have changed, rad/s
SETTING_OUT_PATH = 0.05  # min path to the goal of an arm that starts to move, rad
PAYLOAD_DEVIATIONS = 2.0  # standard deviations from the payload's estimate to its upper bound
CREDIBLE_DEVIATIONS = 3.0  # standard deviations beyond which an innovation gets less weight


class Prior(NamedTuple):
    """Prior of the parameters: tuples in the order of x."""

    usual: tuple[float, ...]  # initial values
    deviations: tuple[float, ...]  # initial standard deviations
    random_walk: tuple[float, ...]  # standard deviations of random walks of a moving arm, per square root of a second
    low: tuple[float, ...]  # lower bounds
    high: tuple[float, ...]  # upper bounds
    angle_variance: float  # of an innovation of an angle, rad2


class MatrixZeros(NamedTuple):
    """Zeros that give matrices their sizes: tuples of n n, m m and n m items."""

    joints: tuple[float, ...]  # n n zeros
    prior: tuple[float, ...]  # m m zeros
    both: tuple[float, ...]  # n m zeros


class ParameterEstimate(NamedTuple):
    """Estimate of the parameters, with the sensitivities of the motion."""

    values: tuple[float, ...]  # x
    covariance: tuple[float, ...]  # C
    angles: tuple[float, ...]  # Q
    velocities: tuple[float, ...]  # V


class LoadEstimate(NamedTuple):
    """Estimated loads, frictions and payload."""

    loads: tuple[float, ...]  # torques on the joints beyond the described, N m
    frictions: tuple[float, ...]  # of the joints, with the described friction, N m
    payload: float  # kg


@composition
def initial_estimate(prior, shapes):
    """Return the estimate at the start: the prior."""
    m, spread = len(prior.deviations), slots(prior.deviations)
    C = slots(shapes.prior)
    for p in range(m):
        C[p * m + p] = spread[p] * spread[p]
    return ParameterEstimate(prior.usual, gather(shapes.prior, C), shapes.both, shapes.both)


@composition
def load_estimate(parameters, joints, shares):
    """Return the estimated loads, frictions and payload; `shares` scale the frictions by the brakes' shares."""
    n, x, parts, factors = len(joints), slots(parameters.values), slots(joints), slots(shares)
    like = each(_zero, joints, x[0])
    frictions = slots(like)
    for j in range(n):
        frictions[j] = factors[j].brake * (parts[j].brake_torque + x[n + j])
    return LoadEstimate(gather(like, x), gather(like, frictions), x[2 * n])


@composition
def upper_payload(prior, parameters):
    """Return the payload `PAYLOAD_DEVIATIONS` above its estimate, at most the upper bound of the prior, kg."""
    m, x, C, high = len(prior.deviations), slots(parameters.values), slots(parameters.covariance), slots(prior.high)
    return min(x[m - 1] + PAYLOAD_DEVIATIONS * sqrt(max(C[m * m - 1], 0.0)), high[m - 1])


@law
def _zero(joint, x):  # noqa: ARG001  (one a joint)
    return 0.0 * x


@composition
def update_parameters(prior, parameters, errors, learns):
    """Return the estimate after innovations of the angles, the changes of angles and velocities, and the residual.

    The residual is the square of the greatest innovation over its variance: 1 on average if the model is right. An
    innovation beyond `CREDIBLE_DEVIATIONS` has less weight, and raises the payload's variance to the initial one. The
    values are clamped to the prior's bounds.

    Args: `Prior`; `ParameterEstimate` before; innovations, rad, a tuple; learns: 1, or 0 while the arm is compliant, so
    that pushes are not taken for parameters.
    """
    n, m = len(errors), len(parameters.values)
    e, C, Q = slots(errors), slots(parameters.covariance), slots(parameters.angles)
    change, gain, residual = slots(parameters.values, 0.0 * e[0]), slots(parameters.values, 0.0 * e[0]), 0.0 * e[0]
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
        residual = max(residual, left * left * per)
        taken = per * left * min(1.0, CREDIBLE_DEVIATIONS * CREDIBLE_DEVIATIONS * spread / max(left * left, 1e-30))
        for p in range(m):
            change[p] = change[p] + gain[p] * taken
            for r in range(m):
                C[p * m + r] = C[p * m + r] - gain[p] * gain[r] * per
    values = each(_add_clamped, parameters.values, gather(parameters.values, change), prior.low, prior.high)
    # Innovations that are not credible show that the payload has changed: its variance is reset.
    is_reset = (residual > CREDIBLE_DEVIATIONS * CREDIBLE_DEVIATIONS) & (learns > 0.5)
    C[m * m - 1] = select(is_reset, max(C[m * m - 1], _initial_payload_variance(prior)), C[m * m - 1])
    after = ParameterEstimate(values, gather(parameters.covariance, C), parameters.angles, parameters.velocities)
    change = each(_difference, values, parameters.values)
    turns, speeds = (
        _motion_change(parameters.angles, change, errors),
        _motion_change(parameters.velocities, change, errors),
    )
    return after, turns, speeds, residual


@composition
def _initial_payload_variance(prior):
    """Return the variance of the payload at the start, kg2."""
    spread = slots(prior.deviations)[len(prior.deviations) - 1]
    return spread * spread


@law
def _add_clamped(x, change, low, high):
    return min(max(x + change, low), high)


@law
def _difference(x, y):
    return x - y


@composition
def _motion_change(sensitivities, change, like):
    """Return the change of the joints' angles (rad) or velocities (rad/s), a tuple as `like`, by that of parameters."""
    n, m, S, d = len(like), len(change), slots(sensitivities), slots(change)
    motion = slots(like, 0.0 * d[0])
    for j in range(n):
        for p in range(m):
            motion[j] = motion[j] + S[j * m + p] * d[p]
    return gather(like, motion)


@law
def _friction_direction(v, shares):
    return shares.brake * select(v > 0.0, 1.0, select(v < 0.0, -1.0, 0.0))


@law
def _is_stationary(state):
    return select(state.motion.velocity == 0.0, 1.0, 0.0)


@law
def _mean_velocity(before, after):
    return 0.5 * (before.motion.velocity + after.motion.velocity)


@law
def _acceleration(before, after, T):
    return (after.motion.velocity - before.motion.velocity) / T


@law
def _payload_torque(c_0, c_1, g_0, g_1, inertial_0, inertial_1):
    return (c_1 - c_0) + (g_1 - g_0) - (inertial_1 - inertial_0)


@composition
def propagate_parameters(prior, parameters, shapes, arm, gains, before, after, shares, remaining_path, T):
    """Return the estimate a cycle later: sensitivities after the observer's correction and the cycle's motion.

    Args: `Prior`; `ParameterEstimate`; `MatrixZeros`; parameters of the arm; gains of the observer
    (`model.ObserverGains`), states of the joints before and after the cycle, and shares of their friction in it
    (`DriveFractions`), tuples; remaining path to the goal, rad; T.
    """
    n, m, x = len(before), len(parameters.values), slots(parameters.values)
    angles, speeds, a = (
        each(joint_angle, after),
        each(_mean_velocity, before, after),
        each(_acceleration, before, after, T),
    )
    stands = each(_is_stationary, after)
    M_0, c_0, g_0 = dynamics(arm, x[m - 1], angles, speeds)
    M_1, c_1, g_1 = dynamics(arm, x[m - 1] + 1.0, angles, speeds)
    heavier = slots(each(_payload_torque, c_0, c_1, g_0, g_1, multiply_symmetric(M_0, a), multiply_symmetric(M_1, a)))
    W, friction = slots(invert_symmetric(M_0, stands, shapes.joints)), slots(each(_friction_direction, speeds, shares))
    K, held = slots(gains), slots(stands)
    Q, V = slots(parameters.angles), slots(parameters.velocities)
    for j in range(n):
        for p in range(m):
            pushed = 0.0 * x[0]
            if p < n:
                pushed = W[j * n + p]
            elif p < 2 * n:
                pushed = -friction[p - n] * W[j * n + p - n]
            else:
                for i in range(n):
                    pushed = pushed + W[j * n + i] * heavier[i]
            # The observer's correction of the motion reduces the sensitivities as well.
            was = V[j * m + p] - K[j].velocity * Q[j * m + p]
            V[j * m + p] = (1.0 - held[j]) * (was + T * pushed)
            Q[j * m + p] = (1.0 - K[j].angle) * Q[j * m + p] + 0.5 * T * (was + V[j * m + p])
    covariance = _add_random_walk(prior, parameters.covariance, max_magnitude(speeds), remaining_path, T)
    return ParameterEstimate(parameters.values, covariance, gather(shapes.both, Q), gather(shapes.both, V))


@composition
def _add_random_walk(prior, covariance, speed, remaining_path, T):
    """Return the covariance after a cycle of T seconds: while speed (rad/s) > 0, variances grow by a random walk.

    An arm that starts to move (slower than `SETTING_OUT_SPEED`, with more than `SETTING_OUT_PATH` of `remaining_path`,
    rad, to go) may have a new payload: its variance is reset to at least the initial one.
    """
    m, random_walk, C = len(prior.deviations), slots(prior.random_walk), slots(covariance)
    for p in range(m):
        C[p * m + p] = C[p * m + p] + select(speed > 0.0, T * random_walk[p] * random_walk[p], 0.0)
    starts_to_move = (speed < SETTING_OUT_SPEED) & (remaining_path > SETTING_OUT_PATH)
    C[m * m - 1] = select(starts_to_move, max(C[m * m - 1], _initial_payload_variance(prior)), C[m * m - 1])
    return gather(covariance, C)
