"""Compiled run of a control law in a loop with a linear plant."""

import numpy as np

from layflat.control import Demand, Sensed, step, wake
from layflat.jit import kernel
from layflat.lanes import read_numbers, write_numbers


@kernel
def close_loop(settings, first, demand, demands, steady, plant, added, cycle, voltages):
    """Run a law with a sampled linear plant, and write the voltages that it returns.

    Args: settings of the law; first readings, and a demand with all rates; demands (cycles, joints), rad; readings
    (cycles, 2, joints) at the operating point; matrices A, B and C of the plant, from voltages to readings; voltages
    that are added, less those of the operating point (cycles, joints), V; control cycle, s; voltages (cycles, joints),
    which are filled.
    """
    A, B, C = plant
    x, n = np.zeros(len(A)), len(demands[0])
    memory = wake(settings, first)
    for k in range(len(demands)):
        y = steady[k] + (C @ x).reshape(2, n)
        sensed = Sensed(read_numbers(first.angle, y[0]), read_numbers(first.angle, y[1]))
        goal = Demand(read_numbers(first.angle, demands[k]), demand.velocity, demand.acceleration, demand.stiffness)
        memory, command, _ = step(settings, memory, sensed, goal, cycle)
        write_numbers(voltages[k], command.voltage)
        x = A @ x + B @ (voltages[k] + added[k])
