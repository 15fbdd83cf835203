"""A joint that is turned slowly at constant pressure, without inertia or air flow: torque = K p - losses - friction."""

from math import inf
from typing import Any, NamedTuple

import numpy as np

from layflat.jit import kernel, law
from layflat.lanes import in_lanes, read_lanes, select, total, width, write_lanes
from layflat.physics.friction import level
from layflat.physics.hose import torque_per_pressure
from layflat.physics.hysteresis import at_rest, torques
from layflat.physics.hysteresis import turned as losses_turned


class Slow(NamedTuple):
    """A joint on a slow sweep: its way, states of its losses, and torques (N m).

    These are of both hoses added up, then of the joint without and with losses.
    """

    way: float
    loss_a: Any
    loss_b: Any
    pull: float
    lossless: float
    torque: float


@law
def unturned(hose_a, hose_b):
    """A joint before its first turn."""
    return Slow(1.0, at_rest(hose_a.loss), at_rest(hose_b.loss), 0.0, 0.0, 0.0)


@law
def free(slow, hose_a, hose_b, q, turn, p_a, p_b):
    """The joint turned by `turn` to angle q, at constant gauge pressures, without friction of its shaft."""
    way = select(turn > 0.0, 1.0, select(turn < 0.0, -1.0, slow.way))
    loss_a = losses_turned(hose_a.loss, slow.loss_a, turn, p_a, inf)
    loss_b = losses_turned(hose_b.loss, slow.loss_b, turn, p_b, inf)
    pull = torque_per_pressure(hose_a.stroke, hose_a.neutral + q) * p_a
    push = torque_per_pressure(hose_b.stroke, hose_b.neutral - q) * p_b
    lossless = pull - push
    lost = total(torques(hose_a.loss, loss_a) + torques(hose_b.loss, loss_b))
    return Slow(way, loss_a, loss_b, max(pull + push, 0.0), lossless, lossless - lost)


@law
def turned(slow, hose_a, hose_b, friction, q, turn, p_a, p_b, brake):
    """As `free`, with friction: the joint turns so slowly that it stays static."""
    after = free(slow, hose_a, hose_b, q, turn, p_a, p_b)
    held = level(friction, brake, 0.0 * q, after.pull)
    return Slow(after.way, after.loss_a, after.loss_b, after.pull, after.lossless, after.torque - after.way * held)


@kernel
def sweep_joint(hose_a, hose_b, friction, q, p_a, p_b, brake):
    """Torques with and without losses and friction along angles q (rad), N m, at constant gauge pressures."""
    torque, lossless = np.empty_like(q), np.empty_like(q)
    slow = unturned(hose_a, hose_b)
    for i in range(len(q)):
        turn = q[i] - q[i - 1] if i > 0 else 0.0
        slow = turned(slow, hose_a, hose_b, friction, q[i], turn, p_a, p_b, brake)
        torque[i], lossless[i] = slow.torque, slow.lossless
    return torque, lossless


@kernel
def sweep_many(like, numbers, forward, found):
    """Loop height and greatest torque (N m) of many joints swept to and fro, a joint in each lane.

    Args: the `Like` of a case (hose A, hose B, friction, brake torque, gauge pressure, stroke); the numbers of all, a
    column a joint; room for the torques of a way, (points, lanes). Writes into `found` (2, joints).
    """
    points = len(forward)
    for first in range(0, len(found[0]), width(like, numbers)):
        hose_a, hose_b, friction, brake, p, stroke = read_lanes(like, numbers[:, first:])
        zero = 0.0 * p
        slow, q = in_lanes(unturned(hose_a, hose_b), zero), -0.5 * stroke
        height, most = zero, zero
        for i in range(4 * points):
            lap, k = i // points, i % points
            last = q
            q = stroke * ((k if lap % 2 == 0 else points - 1 - k) / (points - 1.0) - 0.5)
            slow = turned(slow, hose_a, hose_b, friction, q, q - last, p, zero, brake)
            if lap == 2:
                write_lanes(forward[k : k + 1], slow.torque)
                most = max(most, abs(slow.lossless))
            if lap == 3:
                there = read_lanes(0.0, forward[points - 1 - k : points - k], zero)
                height = max(height, abs(there - slow.torque))
        write_lanes(found[:, first:], (height, most))
