"""The first call of a compiled function loads it, which takes many cycles: it is made before the loop runs."""

from __future__ import annotations

import numpy as np

from layflat.control.update import MEMORY, STATUS, flat, update, wake
from layflat.control.watch import SENSORS
from layflat.machine import Machine, parameters
from layflat.rig.driver import FarState, Reading
from layflat.rig.safety.limits import limits
from layflat.rig.safety.machine_watch import MachineWatch


def warm_up(machine: Machine) -> None:
    """Load what a loop of this machine calls, without a machine in motion."""
    n, each = len(machine.joints), [limits(machine, name) for name in machine.joints]
    zeros, memory, status = np.zeros(n), np.zeros((1, n, MEMORY)), np.zeros((1, n, STATUS))
    gains = np.array([flat(parameters.gains(machine, name)) for name in machine.joints])
    wake(memory, zeros, zeros)
    update(gains, memory, zeros, zeros, 0.005, zeros, np.zeros(n), status)
    reading = Reading(zeros, zeros, machine.supply.ambient_pressure, False, FarState.RUNNING)
    watch = MachineWatch(machine, 0.005, each)
    watch.begin(reading, filled=False)
    watch.look(reading, status, memory, zeros, [0.0] * n, 0.0, 0.005, SENSORS)
