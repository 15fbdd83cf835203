"""One control cycle of all joints over arrays that stay where they are: what a real-time loop calls.

The controllers are those of a run (`controller.step`), so a loop gives the voltages of a run, bit for bit.
"""

import numpy as np

from layflat.control.controller import start, step
from layflat.control.gains import Gains, Measurement, Memory, Phase, Status
from layflat.jit import kernel, law
from layflat.lanes import write_row

GAINS = 22
"""Numbers in `Gains`, those of its phases one by one."""
MEMORY = len(Memory._fields)
STATUS = len(Status._fields)


def flat(gains: Gains) -> np.ndarray:
    """The numbers of `Gains` in a row."""
    return np.array([*gains.far, *gains.near, *gains.close, *gains[3:]])


@law
def _gains(row):
    far, near, close = Phase(row[0], row[1]), Phase(row[2], row[3]), Phase(row[4], row[5])
    return Gains(
        far, near, close, row[6], row[7], row[8], row[9], row[10], row[11], row[12], row[13], row[14], row[15],
        row[16], row[17], row[18], row[19], row[20], row[21],
    )  # fmt: skip


@law
def _memory(row):
    return Memory(row[0], row[1], row[2], row[3], row[4], row[5], row[6], row[7], row[8], row[9])


@kernel
def wake(memory, angles, pressures):
    """Let all controllers begin at these measurements: rad and Pa, (joints,); writes `memory` (1, joints, MEMORY)."""
    for j in range(len(angles)):
        write_row(memory, 0, j, start(Measurement(angles[j], pressures[j], 1.0)))


@kernel
def update(gains, memory, angles, pressures, elapsed, demands, voltages, status):
    """Step all controllers.

    Args: rows of `flat` gains (joints, GAINS); `memory` (1, joints, MEMORY), changed; what was measured, rad and Pa
    (joints,); s since the last cycle; demands, rad (joints,). Writes `voltages`, V (joints,), and `status` (1, joints,
    STATUS).
    """
    for j in range(len(angles)):
        measured = Measurement(angles[j], pressures[j], elapsed)
        after, voltages[j], found = step(_gains(gains[j]), _memory(memory[0, j]), measured, demands[j])
        write_row(memory, 0, j, after)
        write_row(status, 0, j, found)
