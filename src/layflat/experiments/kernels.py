"""What the experiments compile for themselves: a controller that is timed, a valve whose command is swept."""

from __future__ import annotations

from math import pi

import numpy as np

from layflat.control.controller import start, step
from layflat.control.gains import Measurement
from layflat.jit import kernel
from layflat.physics.spool import advance_spool
from layflat.physics.spool_valve import path_conductance


@kernel
def control_cycles(gains, angle, pressure, demand, cycles):  # type: ignore[no-untyped-def]
    """Run the controllers of all axes over many cycles of given samples; returns the sum of their voltages."""
    total = 0.0
    memories = [start(Measurement(angle[0], pressure[0], 0.005)) for _ in range(len(gains))]
    for i in range(cycles):
        for j in range(len(gains)):
            k = (i + j) % len(angle)
            memories[j], voltage, _ = step(gains[j], memories[j], Measurement(angle[k], pressure[k], 0.005), demand[k])
            total += voltage
    return total


@kernel
def sweep_spool(valve, command, amplitude, frequency, h, n):  # type: ignore[no-untyped-def]
    """Mean net opening over the last half of n steps at each command, share of full conductance."""
    opening = np.empty_like(command)
    x, v, t = 0.0, 0.0, 0.0
    for i in range(len(command)):
        total = 0.0
        for k in range(n):
            u = command[i] + amplitude * np.sin(2.0 * pi * frequency * (t + 0.5 * h))
            x, v = advance_spool(valve.spool, u, 0.0, x, v, h)
            t += h
            net = path_conductance(valve, x) - path_conductance(valve, -x)
            total += net if k >= n // 2 else 0.0
        opening[i] = total / (n - n // 2) / valve.conductance
    return opening
