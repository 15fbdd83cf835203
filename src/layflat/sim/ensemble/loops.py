"""Hysteresis of many machines: the slow sweeps of `sim/sweep.py`, with a machine per SIMD lane."""

from collections import deque
from concurrent.futures import ThreadPoolExecutor
from itertools import product
from math import ceil
from typing import TYPE_CHECKING

import numpy as np

from layflat.arrays import Array
from layflat.lanes import Like, leaves
from layflat.registers import host_width
from layflat.sim.ensemble.cases import parameter_columns
from layflat.sim.slow import sweep_many

if TYPE_CHECKING:
    from layflat.sim.ensemble.cases import Cases

SWEEP_POINTS = 201  # in each direction; more change the height by less than a thousandth
MAX_BATCH = 4096  # machines whose numbers are in memory at once


def hysteresis(prepared: "Cases", workers: int = 1) -> Array:
    """Return loop height over maximum torque at supply pressure, of every joint with its brake on: (runs, joints)."""
    height, torque = loop_heights(prepared, workers=workers)
    return height / torque


def loop_heights(prepared: "Cases", share: float = 1.0, workers: int = 1) -> tuple[Array, Array]:
    """Return loop height and maximum torque at supply pressure of every joint with its brake on.

    Args:
        prepared: the ensemble.
        share: fraction of the working stroke, about its centre, that is swept.
        workers: threads.

    Returns:
        Two arrays, (runs, joints), N m.
    """
    machine, count = prepared.machine, prepared.count
    heights = np.empty((2, count, len(prepared.base.joints)))
    lanes = host_width()
    size = lanes * ceil(min(MAX_BATCH, count / workers) / lanes)
    cases = []
    for joint, described in zip(prepared.case.joints, machine.joints.values(), strict=True):
        swept = (joint.hose_a, joint.hose_b, joint.friction, joint.brake_torque)
        cases.append((*swept, machine.supply.pressure_gauge, share * described.stops.working_stroke))

    def sweep(batch: tuple[int, int]) -> None:
        """Fill `heights` for joint j of a batch of runs from number `first` on."""
        j, first = batch
        rows = np.minimum(np.arange(first, first + size), count - 1)
        forward, results = np.empty((SWEEP_POINTS, lanes)), np.empty((2, size))
        sweep_many(Like.from_tuple(cases[j]), parameter_columns(list(leaves(cases[j])), rows), forward, results)
        part = heights[:, first : first + size, j]
        part[:] = results[:, : part.shape[1]]

    with ThreadPoolExecutor(workers) as pool:
        deque(pool.map(sweep, product(range(len(cases)), range(0, count, size))), maxlen=0)
    return heights[0], heights[1]
