"""How strongly a simulated machine is drawn to its log while values are sought (output injection).

A valve draws its joint by the error of the angle, and its air by the error of the differential pressure; a torque draws
it as a spring and a damper would, so that its error of angle dies away, critically damped, however gravity pulls.
A joint's inertia is here what a torque on it alone meets while all others are free, the least of the log's postures: a
spring for more would be too stiff for the control cycle.
"""

from collections.abc import Sequence
from typing import NamedTuple, Self

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine, parameters
from layflat.motion.dynamics import least_inertias
from layflat.physics.hose import swept_volume
from layflat.physics.joint import FILLED
from layflat.physics.step import STEP

REFERENCE_PRESSURE = 1e5  # of the air that a sonic conductance is given for, Pa (ISO 6358)


class Stage(NamedTuple):
    """A stage of the continuation; what is zero does not draw."""

    angle: float = 0.0  # rate at which valves draw angles to the measured ones, 1/s
    air: float = 0.0  # rate at which they draw differential pressures, 1/s
    torque: float = 0.0  # natural frequency of the springs that draw angles, rad/s
    step: float = STEP  # of the simulation, s
    bodies: bool = True  # whether links are taken for the nearest that can be bodies
    share: float | None = 1.0  # of what is fitted, from the start of each log on; None: all of the log


class Leads(NamedTuple):
    """What draws joints per rate, a number each."""

    voltage: Array  # that makes a joint follow its angle at 1/s, V/rad
    pressure: Array  # the same of its differential pressure, V/Pa
    inertia: Array  # of the springs and dampers, kg m2

    @classmethod
    def of(cls, machine: Machine, postures: Array) -> Self:
        """Of a machine with a valve, as described, over postures of its logs, (postures, joints), rad."""
        assert machine.valve is not None
        middle = FILLED * machine.supply.pressure
        full, joints = machine.valve.volts_to_full, list(machine.joints.values())
        flow = machine.valve.conductance * REFERENCE_PRESSURE / FILLED * np.array([one.valve_size for one in joints])
        hoses = [one.hose_a for one in parameters.joints(machine)]
        volume = np.array([one.chamber.dead_volume + swept_volume(one.stroke, one.neutral) for one in hoses])
        per_angle = np.array([parameters.torque_constant(one) for one in joints])
        inertia = least_inertias(machine, postures, machine.arm.payload)
        return cls(full * per_angle / flow, full * volume / (2.0 * middle * flow), inertia)

    def vary(self, joints: Sequence[str], stage: Stage, count: int) -> dict[str, Array]:
        """What an ensemble of so many candidates varies by it."""
        gains = {
            "lead": stage.angle * self.voltage,
            "pressure_lead": stage.air * self.pressure,
            "spring": stage.torque**2 * self.inertia,
            "damper": 2.0 * stage.torque * self.inertia,
        }
        return {
            f"scenario.{key}.{name}": np.full(count, gain)
            for key, each in gains.items()
            for name, gain in zip(joints, each, strict=True)
        }
