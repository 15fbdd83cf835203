"""Loops as they were measured: the motion and the pressures of a log are given, the torque or force is simulated.

The laws are those of slow sweeps (sim/sweep.py) and of a rod (physics/rod.py). An element's state when the log begins
is an initial condition that no log shows: all elements are taken to carry the same share of what they can, such that
the first sample is met as nearly as their limits allow.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel, law
from layflat.lanes import mapped
from layflat.physics.joint import Hose
from layflat.physics.loss import slip
from layflat.physics.rod import Rod, slip_force, smooth_force
from layflat.sim.slow import UNTURNED, Slow, turned

Array = NDArray[np.float64]


class TurnedLog(NamedTuple):
    """What is given of a joint's log: angle (rad), gauge pressures (Pa), the brake's share, and the first torque (N m).

    `give` is the turn after which the brake slips (rad); a brake without any would follow the noise of the angle.
    """

    angle: Array
    pressure_a: Array
    pressure_b: Array
    brake: Array
    first: float
    give: float


class RodLog(NamedTuple):
    """What is given of a rod's log: position (m), speed (m/s), gauge pressure (Pa), and the first force (N)."""

    position: Array
    speed: Array
    pressure: Array
    first: float


@law
def shared_out(wanted, limit):  # type: ignore[no-untyped-def]
    """Share of their limits that elements carry so that `wanted` is met."""
    return min(max(wanted / limit, -1.0), 1.0) if limit > 0.0 else 0.0


@law
def _limits(loss, p_g, share):  # type: ignore[no-untyped-def]
    """What the elements of a hose carry at a share of their limits, N m."""
    p_g = max(p_g, 0.0)
    return (
        share * (loss.base_1 + loss.slope_1 * p_g),
        share * (loss.base_2 + loss.slope_2 * p_g),
        share * (loss.base_3 + loss.slope_3 * p_g),
    )


@kernel
def _turned(hose_a, hose_b, brake, first, log, torque):  # type: ignore[no-untyped-def]
    q, p_a, p_b = log.angle, log.pressure_a, log.pressure_b
    slow = turned(UNTURNED, hose_a, hose_b, q[0], 0.0, p_a[0], p_b[0], 0.0)
    a, b = _limits(hose_a.loss, p_a[0], 1.0), _limits(hose_b.loss, p_b[0], 1.0)
    held = brake * log.brake[0]
    share = shared_out(slow.lossless - first, a[0] + a[1] + a[2] + b[0] + b[1] + b[2] + held)
    slow = Slow(1.0, _limits(hose_a.loss, p_a[0], share), _limits(hose_b.loss, p_b[0], share), 0.0, 0.0)
    held *= share
    for i in range(len(q)):
        turn = q[i] - q[i - 1] if i > 0 else 0.0
        slow = turned(slow, hose_a, hose_b, q[i], turn, p_a[i], p_b[i], 0.0)
        most = brake * log.brake[i]
        held = slip(held, most / log.give, most, turn)
        torque[i] = slow.torque - held


@kernel
def _pushed(rod, weights, stiffness, log, force):  # type: ignore[no-untyped-def]
    x, v, p = log.position, log.speed, log.pressure
    f = np.empty(len(weights))
    level = slip_force(rod, p[0])
    share = shared_out(log.first - smooth_force(rod, x[0], v[0], p[0]), level)
    for j in range(len(f)):
        f[j] = share * weights[j] * level
    for i in range(len(x)):
        move = x[i] - x[i - 1] if i > 0 else 0.0
        level = slip_force(rod, p[i])
        total = smooth_force(rod, x[i], v[i], p[i])
        for j in range(len(f)):
            f[j] = slip(f[j], stiffness[j], weights[j] * level, move)
            total += f[j]
        force[i] = total


def turned_torques(hose_a: Hose, hose_b: Hose, brake: Array, first: Array, log: TurnedLog) -> Array:
    """Torque of a joint through a log, (candidates, samples), N m.

    Args:
        hose_a: hose A; its numbers may be arrays, an item a candidate.
        hose_b: hose B, likewise.
        brake: torque of the brake, an item a candidate, N m.
        first: torque that the log begins with, an item a candidate, N m.
        log: what is given.
    """
    torques = np.empty((len(brake), len(log.angle)))

    def run(i: int) -> None:
        _turned(_item(hose_a, i), _item(hose_b, i), float(brake[i]), float(first[i]), log, torques[i])

    _on_all_cores(run, len(brake))
    return torques


def pushed_forces(rods: Sequence[Rod], weights: Array, stiffness: Array, log: RodLog) -> Array:
    """Force on a rod through a log, (candidates, samples), N.

    Args:
        rods: one a candidate.
        weights: share of every element in the friction, (candidates, elements).
        stiffness: of every element, N/m, (candidates, elements).
        log: what is given.
    """
    forces = np.empty((len(rods), len(log.position)))

    def run(i: int) -> None:
        _pushed(rods[i], weights[i], stiffness[i], log, forces[i])

    _on_all_cores(run, len(rods))
    return forces


def _item(parameters: Any, i: int) -> Any:
    """Parameters of one candidate."""
    return mapped(parameters, lambda leaf: float(leaf[i] if np.ndim(leaf) else leaf))


def _on_all_cores(run: Callable[[int], None], count: int) -> None:
    if count == 1:
        run(0)
        return
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(run, range(count)))
