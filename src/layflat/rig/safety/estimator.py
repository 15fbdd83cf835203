"""Estimator of a joint, the same under any control law: angle, velocity and differential pressure without dither.

Also the holding torque of a joint: that part of its torque which balances gravity and the moving joints, and reveals
nothing of the joint itself. While the joints T turn and j is at rest, M_TT a_T = t_T, and j needs M_jT a_T. Gravity and
the others' velocities supply g_j of it: b_j = M_jT a_T - g_j. Other joints at rest are held by their brakes.

| symbol | meaning | unit |
|---|---|---|
| x, p | angle and differential pressure as sampled | rad, Pa |
| M | mass matrix of the arm | kg m2 |
| t | torques: of hoses, gravity and velocities, less friction | N m |
| j, T | a joint, and the set of the others that turn | |
| b_j | torque of its hoses with which joint j stays at rest | N m |
"""

from typing import NamedTuple

from layflat.control.signals import mean4, ripple4
from layflat.jit import composition, law


class EstimatorMemory(NamedTuple):
    """Memory of an estimator: the last three samples of angle and pressure, newest first, and the last mean angle."""

    angle_0: float
    angle_1: float
    angle_2: float
    pressure_0: float
    pressure_1: float
    pressure_2: float
    last_angle: float


class JointEstimate(NamedTuple):
    """Estimate of a joint in a cycle; names are those of the recorded signals."""

    averaged_angle: float  # rad
    averaged_velocity: float  # rad/s
    averaged_pressure: float  # differential, Pa
    ripple: float  # amplitude of the pressure at the dither's frequency, Pa


@law
def start_estimator(x, p):
    """Return the memory of an estimator that starts with these samples."""
    return EstimatorMemory(x, x, x, p, p, p, x)


@law
def update_estimate(memory, x, p, averaged, elapsed):
    """Return memory and estimate after samples `elapsed` seconds after the last; averaged: 1, or 0 without dither."""
    x_mean = mean4(x, memory.angle_0, memory.angle_1, memory.angle_2)
    p_mean = mean4(p, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    ripple = ripple4(p, memory.pressure_0, memory.pressure_1, memory.pressure_2)
    x_used = x + averaged * (x_mean - x)
    p_used = p + averaged * (p_mean - p)
    after = EstimatorMemory(x, memory.angle_0, memory.angle_1, p, memory.pressure_0, memory.pressure_1, x_used)
    return after, JointEstimate(x_used, (x_used - memory.last_angle) / elapsed, p_used, ripple)


@composition
def write_holding_torques(mass, torques, pulls, turns, work, out):
    """Write the holding torque b_j of each joint into `out`, (joints,).

    Args: M, (joints, joints); t and g, (joints,); 1 where a joint turns, else 0; workspace for M_TT and a_T, (joints,
    joints + 1).
    """
    n = len(torques)
    for j in range(n):
        m = 0
        for i in range(n):
            if i != j and turns[i] > 0.0:
                column = 0
                for k in range(n):
                    if k != j and turns[k] > 0.0:
                        work[m, column] = mass[i, k]
                        column += 1
                work[m, n] = torques[i]
                m += 1
        _solve_in_place(work, m, n)
        needed, m = -pulls[j], 0
        for i in range(n):
            if i != j and turns[i] > 0.0:
                needed += mass[j, i] * work[m, n]
                m += 1
        out[j] = needed


@composition
def _solve_in_place(work, m, right):
    """Solve m symmetric, positive definite equations in place by Gaussian elimination without pivots.

    `work` holds the matrix in its first m columns, and the right side, which the solution replaces, in column `right`.
    """
    for i in range(m):
        for k in range(i + 1, m):
            factor = work[k, i] / work[i, i]
            for column in range(i, m):
                work[k, column] -= factor * work[i, column]
            work[k, right] -= factor * work[i, right]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            work[i, right] -= work[i, k] * work[k, right]
        work[i, right] /= work[i, i]
