"""Quasi-static rotation of a joint at constant pressure, without inertia or air flow: torque = K p - losses - friction.

Symbols: q angle (rad); p_a, p_b gauge pressures of hoses A and B (Pa); K torque per pressure (N m/Pa); `increment`
rotation since the last angle (rad).
"""

from math import inf
from typing import Any, NamedTuple

from layflat.jit import law, portable_kernel
from layflat.lanes import in_lanes, read_lanes, select, total, width, write_lanes
from layflat.physics.friction import slip_torque
from layflat.physics.hose import torque_per_pressure
from layflat.physics.hysteresis import at_rest, torques
from layflat.physics.hysteresis import turned as losses_turned


class SlowSweep(NamedTuple):
    """State of a joint on a slow sweep."""

    direction: float  # sign of the rotation, 1 or -1
    loss_a: Any
    loss_b: Any
    pull: float  # sum of both hoses' torques, N m
    lossless: float  # torque of the joint without losses and friction, N m
    torque: float  # torque of the joint with losses, N m


@law
def initial_sweep(hose_a, hose_b):
    """Return the state of a joint before its first rotation."""
    return SlowSweep(1.0, at_rest(hose_a.loss), at_rest(hose_b.loss), 0.0, 0.0, 0.0)


@law
def turn_frictionless(slow, hose_a, hose_b, q, increment, p_a, p_b):
    """Return the state after a rotation by `increment` to angle q, without friction of the shaft."""
    direction = select(increment > 0.0, 1.0, select(increment < 0.0, -1.0, slow.direction))
    loss_a = losses_turned(hose_a.loss, slow.loss_a, increment, p_a, inf)
    loss_b = losses_turned(hose_b.loss, slow.loss_b, increment, p_b, inf)
    pull = torque_per_pressure(hose_a.stroke, hose_a.neutral + q) * p_a
    push = torque_per_pressure(hose_b.stroke, hose_b.neutral - q) * p_b
    lossless = pull - push
    lost = total(torques(hose_a.loss, loss_a) + torques(hose_b.loss, loss_b))
    return SlowSweep(direction, loss_a, loss_b, max(pull + push, 0.0), lossless, lossless - lost)


@law
def turn_with_friction(slow, hose_a, hose_b, friction, q, increment, p_a, p_b, brake):
    """Return the state after a rotation as `turn_frictionless` does, less the static friction of shaft and brake."""
    after = turn_frictionless(slow, hose_a, hose_b, q, increment, p_a, p_b)
    static = slip_torque(friction, brake, 0.0 * q, after.pull)
    torque = after.torque - after.direction * static
    return SlowSweep(after.direction, after.loss_a, after.loss_b, after.pull, after.lossless, torque)


@portable_kernel()
def sweep_joint(hose_a, hose_b, friction, q, p_a, p_b, brake, torque, lossless):
    """Write the torques with and without losses and friction (N m) along angles q (rad) at constant gauge pressures.

    Args: hoses A and B; friction of the shaft; angles q, (instants,), rad; gauge pressures p_a, p_b, Pa; brake, N m;
    torques with and without, (instants,), which are filled.
    """
    slow = initial_sweep(hose_a, hose_b)
    for i in range(len(q)):
        increment = q[i] - q[i - 1] if i > 0 else 0.0
        slow = turn_with_friction(slow, hose_a, hose_b, friction, q[i], increment, p_a, p_b, brake)
        torque[i], lossless[i] = slow.torque, slow.lossless


@portable_kernel(in_lanes=True)
def sweep_many(like, numbers, forward, results):
    """Compute loop height and maximum lossless torque (N m) of many joints swept back and forth, a joint per lane.

    The second of two laps counts, once the losses repeat.

    Args: the `Like` of a case (hose A, hose B, friction, brake torque, gauge pressure of hose A, stroke); the numbers
    of all joints, a column each; work array for the torques of a forward half-lap, (points, lanes); results,
    (2, joints), which are filled.
    """
    points = len(forward)
    for first in range(0, len(results[0]), width(like, numbers)):
        hose_a, hose_b, friction, brake, p, stroke = read_lanes(like, numbers[:, first:])
        zero = 0.0 * p
        slow, q = in_lanes(initial_sweep(hose_a, hose_b), zero), -0.5 * stroke
        height, max_torque = zero, zero
        for i in range(4 * points):
            lap, k = i // points, i % points
            last = q
            q = stroke * ((k if lap % 2 == 0 else points - 1 - k) / (points - 1.0) - 0.5)
            slow = turn_with_friction(slow, hose_a, hose_b, friction, q, q - last, p, zero, brake)
            if lap == 2:
                write_lanes(forward[k : k + 1], slow.torque)
                max_torque = max(max_torque, abs(slow.lossless))
            if lap == 3:
                forward_torque = read_lanes(0.0, forward[points - 1 - k : points - k], zero)
                height = max(height, abs(forward_torque - slow.torque))
        write_lanes(results[:, first:], (height, max_torque))
