"""Kernels of the experiments: a timed controller, and a swept valve."""

from math import pi

import numpy as np

from layflat.control import Demand, Sensed, step, wake
from layflat.jit import portable_kernel
from layflat.lanes import gather, slots
from layflat.physics.valves.spool_laws import advance_spool, path_conductance


@portable_kernel()
def control_cycles(settings, angle, pressure, demand, cycles, voltages_sum):  # type: ignore[no-untyped-def]
    """Run the control law of all axes over many cycles of 5 ms, and write the sum of their voltages, (1,).

    Samples of angle and demand (rad) and differential pressure (Pa), (samples,) each, recur, shifted from axis to axis.
    """
    like, total = settings.joints, 0.0
    angles, pressures, demands = slots(like, angle[0]), slots(like, pressure[0]), slots(like, demand[0])
    memory = wake(settings, Sensed(gather(like, angles), gather(like, pressures)))
    still = gather(like, slots(like, 0.0))
    for i in range(cycles):
        for j in range(len(like)):
            k = (i + j) % len(angle)
            angles[j], pressures[j], demands[j] = angle[k], pressure[k], demand[k]
        sensed = Sensed(gather(like, angles), gather(like, pressures))
        memory, command, _ = step(settings, memory, sensed, Demand(gather(like, demands), still, still, still), 0.005)
        voltages = slots(command.voltage)
        for j in range(len(like)):
            total += voltages[j]
    voltages_sum[0] = total


@portable_kernel()
def sweep_spool(valve, command, amplitude, frequency, h, n, opening):  # type: ignore[no-untyped-def]
    """Write the mean net opening over the last half of n steps at each command, fraction of full conductance.

    Command and dither's amplitude are fractions of full opening, the dither's frequency is in Hz, the step h in s. The
    spool's state goes on from command to command.
    """
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
