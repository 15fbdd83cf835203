"""Hysteresis of many machines: the slow sweeps of `sim/sweep.py`, a machine in each lane."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel
from layflat.lanes import WIDTH, in_lanes, read_lanes, width, write_lanes
from layflat.sim.ensemble.cases import columns, first_of
from layflat.sim.sweep import UNTURNED, turned

if TYPE_CHECKING:
    from layflat.sim.ensemble.cases import Cases

POINTS = 201
"""Of a way; more change the height by less than a thousandth."""


@kernel
def _heights(like, numbers, forward, found):  # type: ignore[no-untyped-def]
    points = len(forward)
    for first in range(0, len(found[0]), width()):
        hose_a, hose_b, brake, p, stroke = read_lanes(like, numbers[:, first:])
        zero = 0.0 * p
        slow, q = in_lanes(UNTURNED, zero), -0.5 * stroke
        height, most = zero, zero
        for i in range(4 * points):
            lap, k = i // points, i % points
            last = q
            q = stroke * ((k if lap % 2 == 0 else points - 1 - k) / (points - 1.0) - 0.5)
            slow = turned(slow, hose_a, hose_b, q, q - last, p, zero, brake)
            if lap == 2:
                write_lanes(forward[k : k + 1], slow.torque)
                most = max(most, abs(slow.lossless))
            if lap == 3:
                there = read_lanes(0.0, forward[points - 1 - k : points - k])
                height = max(height, abs(there - slow.torque))
        write_lanes(found[:, first:], height / most)


def hysteresis(prepared: Cases) -> NDArray[np.float64]:
    """Loop height over greatest torque at supply pressure, of every joint with its brake on: (runs, joints)."""
    machine, count = prepared.machine, prepared.count
    found = np.empty((count, len(prepared.base.joints)))
    rows = np.minimum(np.arange(WIDTH * -(-count // WIDTH)), count - 1)
    for j, (joint, described) in enumerate(zip(prepared.case[1], machine.joints.values(), strict=True)):
        swept = (joint.hose_a, joint.hose_b, joint.brake_torque)
        case = (*swept, machine.supply.pressure_gauge, described.stops.working_stroke)
        own = np.empty((1, len(rows)))
        _heights(first_of(case), columns(case, rows), np.empty((POINTS, WIDTH)), own)
        found[:, j] = own[0, :count]
    return found
