"""Operating point of an arm whose joints are held or slide: pressures, temperatures, openings and losses."""

from dataclasses import dataclass

import numpy as np

from layflat.arrays import Array
from layflat.linear.losses import LinearLosses
from layflat.linear.rates import MovingJoint, PlantLaws
from layflat.linear.valve import LinearValve
from layflat.machine import Machine


@dataclass(frozen=True)
class OperatingPoint:
    """Point about which a plant is linearized.

    Attributes:
        machine: the machine.
        plant: parameters of its laws, and which joints are held.
        states: motion and air of each joint.
        ends: deviations from them at the ends of the steps of a period of the valves' waves, where they were measured,
            (steps, joints, numbers of a `MovingJoint`), SI.
        inputs: numbers of each joint's `AirInputs`, (joints, 3), in SI units.
        valves: small-signal model of each joint's valve.
        losses: those of the losses of each joint's hoses; none of a joint that is held.
        loads: external torques that carry what sliding joints lack at given pressures, N m, (joints,).
        drift: rates of the numbers of air, (joints, numbers of a `MovingJoint`), in SI units per second: not zero where
            the valves can't hold given pressures.
    """

    machine: Machine
    plant: PlantLaws
    states: tuple[MovingJoint, ...]
    ends: Array
    inputs: Array
    valves: tuple[LinearValve, ...]
    losses: tuple[tuple[LinearLosses, ...], ...]
    loads: Array
    drift: Array

    @property
    def voltages(self) -> Array:
        """Mean voltages of the valves' drivers, V, (joints,)."""
        pairs = zip(self.plant.joints, self.valves, strict=True)
        return np.array([j.valve.centre_voltage + j.valve.volts_to_full * valve.opening for j, valve in pairs])
