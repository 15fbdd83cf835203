import numpy as np
from test_controller import GAINS

from layflat.control.controller import start, step
from layflat.control.gains import Measurement
from layflat.control.update import MEMORY, STATUS, flat, update, wake


def test_a_cycle_of_all_joints_is_that_of_each() -> None:
    rng, n = np.random.default_rng(1), 3
    each = [GAINS._replace(null=5.0 + 0.1 * j, integral_gain=20.0 + j) for j in range(n)]
    rows = np.array([flat(gains) for gains in each])
    memory, status, voltages = np.zeros((1, n, MEMORY)), np.zeros((1, n, STATUS)), np.zeros(n)
    angles, pressures = 0.01 * rng.standard_normal(n), 1e4 * rng.standard_normal(n)
    wake(memory, angles, pressures)
    memories = [start(Measurement(angles[j], pressures[j], 1.0)) for j in range(n)]
    for _ in range(30):
        angles, pressures = 0.01 * rng.standard_normal(n), 1e4 * rng.standard_normal(n)
        demands, elapsed = 0.02 * rng.standard_normal(n), rng.uniform(0.001, 0.01)
        update(rows, memory, angles, pressures, elapsed, demands, voltages, status)
        for j in range(n):
            seen = Measurement(angles[j], pressures[j], elapsed)
            memories[j], voltage, found = step(each[j], memories[j], seen, demands[j])
            assert voltages[j] == voltage
            assert tuple(status[0, j]) == tuple(found)
            assert tuple(memory[0, j]) == tuple(memories[j])
