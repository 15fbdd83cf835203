"""Points on moving belts that arms follow, many at once: angles of the joints and positions of the tip over time.

| symbol | meaning | unit |
|---|---|---|
| q | joint angles, (arms, joints) | rad |
| J | Jacobian of the tip, (arms, 3, joints) | m/rad |
| x | position of the point on the belt, (arms, 3) | m |

Each instant the angles move by (J^T J + e)^-1 J^T (x - tip(q)), twice, from those of the instant before.
"""

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import Kinematics

SPEED_RANGE = 0.05, 0.3  # range of the belt's speed, m/s
RAMP_TIME = 0.2  # in which the belt comes to its speed, s
MAX_DRAWS, SPEED_FACTOR = 12, 0.7  # draws for belts that leave the range of the joints, and the factor of their speed
DAMPING = 1e-9  # e, m^2
TOLERANCE = 1e-5  # distance of the tip from the point that is allowed, m
NEWTON_ITERATIONS = 2  # of Newton's method in an instant: points of neighbouring instants are millimetres apart


def belt_goals(machine: Machine, starts: Array, times: Array, limits: Array, seed: int) -> tuple[Array, Array]:
    """Return points on belts of random directions and speeds, level or in the plane, which begin at the tips.

    Args:
        machine: machine whose geometry all arms have.
        starts: angles in which the arms begin, (arms, joints), rad.
        times: instants, (instants,), s, from 0.
        limits: greatest angle of each joint that the points may demand, (joints,), rad.
        seed: seed of directions and speeds.

    Returns:
        Angles (instants, joints, arms), rad, and positions (instants, 3, arms), m.
    """
    draw, kinematics = np.random.default_rng(seed), Kinematics(machine)
    left = np.arange(len(starts))
    limit = limits[:, None]
    angles = np.repeat(starts.T[None], len(times), axis=0)
    tips = np.repeat(kinematics.tip(starts).T[None], len(times), axis=0)
    travel = np.where(times < RAMP_TIME, 0.5 * times**2 / RAMP_TIME, times - 0.5 * RAMP_TIME)
    for k in range(MAX_DRAWS):
        direction = draw.uniform(-np.pi, np.pi, len(left))
        speed = draw.uniform(*SPEED_RANGE, len(left)) * SPEED_FACTOR**k
        unit = np.stack([np.cos(direction), np.sin(direction), np.zeros(len(left))])
        points = tips[:1, :, left] + (travel[:, None] * speed)[:, None] * unit
        followed, distance = _follow(kinematics, starts[left], points)
        inside = (np.abs(followed) <= limit).all(axis=(0, 1)) & (distance < TOLERANCE)
        angles[:, :, left[inside]], tips[:, :, left[inside]] = followed[:, :, inside], points[:, :, inside]
        left = left[~inside]
        if left.size == 0:
            break
    return angles, tips


def _follow(kinematics: Kinematics, starts: Array, points: Array) -> tuple[Array, Array]:
    """Return angles (instants, joints, arms) of arms whose tips follow points, and the greatest distance, (arms,).

    Args:
        kinematics: of the arms.
        starts: angles to begin with, (arms, joints), rad.
        points: (instants, 3, arms), m.
    """
    q, angles, furthest = starts.copy(), np.empty((len(points), starts.shape[1], len(starts))), np.zeros(len(starts))
    damping = DAMPING * np.eye(starts.shape[1])
    for k, point in enumerate(points):
        for _ in range(NEWTON_ITERATIONS):
            tip, jacobian = kinematics.tip_and_jacobian(q)
            across = jacobian.swapaxes(1, 2)
            step = np.linalg.solve(across @ jacobian + damping, across @ (point.T - tip)[:, :, None])[:, :, 0]
            q = q + np.clip(step, -0.1, 0.1)
        angles[k] = q.T
        furthest = np.maximum(furthest, np.linalg.norm(kinematics.tip(q) - point.T, axis=1))
    return angles, furthest
