"""Joints that are driven by limited torques with limited rates, of constant inertia: are so many cycles enough?

| symbol | meaning | unit |
|---|---|---|
| T | control cycle | s |
| q, v | angles of the joints less those at the goal, and velocities, at the end of each cycle | rad, rad/s |
| tau, f | torques of the air at the end of each cycle, and of friction during it | N m |
| M | mass matrix | kg m2 |
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse import csr_array

from layflat.arrays import Array

STAYING = 20  # cycles that the tip stays in its band
FASTEST = 5.0  # velocity up to which damping is counted, rad/s


@dataclass(frozen=True)
class Actuator:
    """What a joint's air and friction can do.

    Args:
        torque: greatest, N m.
        rate: greatest change of the torque by the valve, N m/s.
        stiffness: with shut hoses, N m/rad.
        friction: dry, that of the hoses included, N m.
        damping: N m s/rad.
    """

    torque: float
    rate: float
    stiffness: float
    friction: float
    damping: float


@dataclass(frozen=True)
class Motion:
    """A step of joints that are driven so.

    Args:
        mass: M, (joints, joints), kg m2.
        actuators: an item a joint.
        way: q at the start, (joints,), rad.
        sides: of a polygon about the goal: distances of the tip by q, (sides, joints), m/rad.
        band: greatest distance to which the tip is to come, m.
        cycle: T, s.
    """

    mass: Array
    actuators: Sequence[Actuator]
    way: Array
    sides: Array
    band: float
    cycle: float


def is_enough(motion: Motion, cycles: int) -> bool:
    """Tell whether the tip can stay in its band after so many cycles: whether a linear program has a solution.

    Its unknowns are q, v, tau and f of all cycles. Friction may only help against the way.
    """
    n, K, T = len(motion.actuators), cycles + STAYING, motion.cycle
    one, none = np.identity(n * K), np.zeros((n * K, n * K))
    before = np.eye(n * K, k=-n)
    push = np.kron(np.identity(K), T * np.linalg.inv(motion.mass))
    torque, rate, stiffness, friction, damping = (np.tile(each, K) for each in _columns(motion.actuators))
    onward = np.tile(-np.sign(motion.way), K)
    late = np.eye(STAYING + 1, K, k=cycles - 1)
    near = np.kron(late, motion.sides)
    moved = np.hstack([one - before, -0.5 * T * (one + before), none, none])
    pushed = np.hstack([none, one - before, -push, -push])
    changed = np.hstack([none, np.diag(T * stiffness), one - before, none])
    rubbed = np.hstack([none, np.diag(-onward * damping), none, np.diag(-onward)])
    stays = np.hstack([near, np.zeros((len(near), 3 * n * K))])
    most = friction + FASTEST * damping
    limits = np.concatenate([T * rate, T * rate, friction, np.full(len(near), motion.band)])
    start = np.concatenate([motion.way, np.zeros(2 * n * K - n)])
    bounds = np.concatenate([np.full(2 * n * K, np.inf), torque, most])
    found = milp(
        np.zeros(4 * n * K),
        constraints=[
            LinearConstraint(csr_array(np.vstack([changed, -changed, rubbed, stays])), -np.inf, limits),
            LinearConstraint(csr_array(np.vstack([moved, pushed])), start, start),
        ],
        bounds=Bounds(-bounds, bounds),
    )
    return bool(found.status == 0)


def _columns(actuators: Sequence[Actuator]) -> Array:
    """Numbers of the actuators, a row each, (5, joints)."""
    return np.array([[a.torque, a.rate, a.stiffness, a.friction, a.damping] for a in actuators]).T
