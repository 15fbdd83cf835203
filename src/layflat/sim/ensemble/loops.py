"""Hysteresis of many machines: the slow sweeps of `sim/sweep.py`, a machine in each lane."""

from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.lanes import host_width
from layflat.sim.ensemble.cases import columns, first_of
from layflat.sim.slow import sweep_many

if TYPE_CHECKING:
    from layflat.sim.ensemble.cases import Cases

POINTS = 201  # of a way; more change the height by less than a thousandth


def hysteresis(prepared: "Cases") -> Array:
    """Loop height over greatest torque at supply pressure, of every joint with its brake on: (runs, joints)."""
    height, torque = heights(prepared)
    return height / torque


def heights(prepared: "Cases", share: float = 1.0) -> tuple[Array, Array]:
    """Loop height and greatest torque at supply pressure, N m, of every joint with its brake on: (runs, joints).

    The sweep takes a share of the working stroke, in its middle.
    """
    machine, count = prepared.machine, prepared.count
    found = np.empty((2, count, len(prepared.base.joints)))
    lanes = host_width()
    rows = np.minimum(np.arange(lanes * -(-count // lanes)), count - 1)
    for j, (joint, described) in enumerate(zip(prepared.case[1], machine.joints.values(), strict=True)):
        swept = (joint.hose_a, joint.hose_b, joint.friction, joint.brake_torque)
        case = (*swept, machine.supply.pressure_gauge, share * described.stops.working_stroke)
        own = np.empty((2, len(rows)))
        sweep_many(first_of(case), columns(case, rows), np.empty((POINTS, lanes)), own)
        found[:, :, j] = own[:, :count]
    return found[0], found[1]
