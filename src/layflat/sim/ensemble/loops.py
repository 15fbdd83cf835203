"""Hysteresis of many machines: the slow sweeps of `sim/sweep.py`, a machine in each lane."""

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.lanes import Like, host_width, leaves
from layflat.sim.ensemble.cases import columns
from layflat.sim.slow import sweep_many

if TYPE_CHECKING:
    from layflat.sim.ensemble.cases import Cases

POINTS = 201  # of a way; more change the height by less than a thousandth
AT_A_TIME = 4096  # machines whose numbers are there at once


def hysteresis(prepared: "Cases", workers: int = 1) -> Array:
    """Loop height over greatest torque at supply pressure, of every joint with its brake on: (runs, joints)."""
    height, torque = heights(prepared, workers=workers)
    return height / torque


def heights(prepared: "Cases", share: float = 1.0, workers: int = 1) -> tuple[Array, Array]:
    """Loop height and greatest torque at supply pressure, N m, of every joint with its brake on: (runs, joints).

    The sweep takes a share of the working stroke, in its middle.
    """
    machine, count = prepared.machine, prepared.count
    found = np.empty((2, count, len(prepared.base.joints)))
    lanes = host_width()
    size = lanes * ceil(min(AT_A_TIME, count / workers) / lanes)
    cases = []
    for joint, described in zip(prepared.case.joints, machine.joints.values(), strict=True):
        swept = (joint.hose_a, joint.hose_b, joint.friction, joint.brake_torque)
        cases.append((*swept, machine.supply.pressure_gauge, share * described.stops.working_stroke))

    def sweep(some: tuple[int, int]) -> None:
        j, first = some
        rows = np.minimum(np.arange(first, first + size), count - 1)
        room, own = np.empty((POINTS, lanes)), np.empty((2, size))
        sweep_many(Like.of(cases[j]), columns(list(leaves(cases[j])), rows), room, own)
        part = found[:, first : first + size, j]
        part[:] = own[:, : part.shape[1]]

    with ThreadPoolExecutor(workers) as pool:
        deque(pool.map(sweep, product(range(len(cases)), range(0, count, size))), maxlen=0)
    return found[0], found[1]
