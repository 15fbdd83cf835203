"""Inputs of a control law that were recorded in a simulated run, with the voltages that the host computes of them.

A microcontroller without a plant gets them with its example, and compares its own voltages to the bit.
"""

from math import degrees, floor, radians
from typing import NamedTuple

import numpy as np

from layflat.export.host import HostControl, Numbers
from layflat.machine import Machine
from layflat.sim import Scenario, rollout

DURATION = 2.0  # of the examples, s
MOVE_TIME = 0.1  # at which the demand steps, s
MOVED_FRACTION = 0.125  # of a joint's working stroke that the demand steps by from mid-stroke
NOISE_SEED = 1  # of the sensors' noise


class RecordedCycles(NamedTuple):
    """Inputs of a law and its voltages, a row a cycle."""

    rest: Numbers  # readings without noise at rest: angles (rad), differential pressures (Pa)
    sensed: Numbers  # readings likewise, (cycles, 2 joints)
    demand: Numbers  # angles, velocities, accelerations, stiffnesses, (cycles, 4 joints)
    voltage: Numbers  # (cycles, joints), V


def move_target(machine: Machine) -> tuple[float, ...]:
    """Return the angle of each joint that the examples move to, whole degrees, rad."""
    strokes = (degrees(joint.stops.working_stroke) for joint in machine.joints.values())
    return tuple(radians(max(floor(MOVED_FRACTION * stroke), 1)) for stroke in strokes)


def cycles_of(duration: float, machine: Machine) -> int:
    """Return the number of control cycles of a duration (s)."""
    return round(duration / machine.cycle)


def record(machine: Machine, control: HostControl) -> RecordedCycles:
    """Return the inputs of a law in a simulated closed loop with noise, and its voltages.

    Args:
        machine: the machine.
        control: the law on this computer, in the precision of the voltages.
    """
    n, target = len(machine.joints), dict(zip(machine.joints, move_target(machine), strict=True))
    cycles, first = cycles_of(DURATION, machine), cycles_of(MOVE_TIME, machine)
    scenario = Scenario(
        demand=[(0.0, dict.fromkeys(target, 0.0)), (first * machine.cycle, target)],
        start=0.0, duration=cycles * machine.cycle, seed=NOISE_SEED,
    )  # fmt: skip
    run, quiet = rollout(machine, scenario=scenario), rollout(machine, scenario=scenario, noise=False)
    readings = [np.hstack([one["measured_angle"], one["measured_pressure"]]) for one in (run, quiet)]
    demand = np.zeros((cycles, 4 * n))
    demand[first:, :n] = tuple(target.values())
    control.wake(readings[1][0])
    voltage = [control.step(readings[0][k], demand[k], machine.cycle)[:n] for k in range(cycles)]
    return RecordedCycles(readings[1][0], readings[0][:cycles], demand, np.array(voltage))
