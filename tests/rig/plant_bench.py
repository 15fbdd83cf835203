"""A machine in motion, a control cycle at a time, for tests: the laws of `sim`, and what can break in it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from layflat.jit import kernel
from layflat.machine import Machine, parameters
from layflat.physics.driver import ZERO_COMMANDS, delay_command
from layflat.physics.joint import Drive, joint_at_rest
from layflat.physics.plant import advance_arm, pack_joints
from layflat.physics.sensor import read_sensor
from layflat.physics.step import STEP
from layflat.physics.valves import commanded_opening, start_wave

Array = NDArray[np.float64]

FREE = 9.0
"""In place of an opening: the spool is not held."""


@kernel
def through_a_cycle(arm, joints, states, lines, around, voltages, held, brakes, load, k, cycle, steps):  # type: ignore[no-untyped-def]
    """States and delay lines after control cycle k; `held` are openings at which spools are stuck."""
    n = len(joints)
    joints, states, lines = list(joints), list(states), list(lines)
    h = cycle / steps
    drives = [Drive(0.0, 0.0, 0.0, 0.0) for j in range(n)]
    waves = [start_wave(joints[j].valve, 0.0, h) for j in range(n)]
    for j in range(n):
        stuck = abs(held[j]) <= 1.0
        asked = commanded_opening(joints[j].valve, voltages[j])
        opening, lines[j] = delay_command(lines[j], asked, joints[j].valve.delay / cycle)
        drives[j] = Drive(held[j] if stuck else opening, brakes[j], load[j], around.supply_pressure)
        waves[j] = start_wave(joints[j].valve, 0.0 if stuck else cycle * k, 0.0 if stuck else h)
    advance_arm(arm, pack_joints(arm, joints), states, drives, waves, around, h, steps)
    return states, lines


class PlantBench:
    """What is changed between cycles acts from the next on.

    Args:
        machine: with valve and sensors.
        angles: at which it rests at first, rad.
        seed: of the sensors' noise.
        gauge: pressure of hoses and supply at first, Pa; default: as in a run.
    """

    def __init__(self, machine: Machine, angles: Array, seed: int = 0, gauge: float | None = None) -> None:
        self.n = len(machine.joints)
        self.cycle = machine.cycle
        self._steps = round(machine.cycle / STEP)
        self._arm = parameters.arm(machine)
        self._joints: list[Any] = list(parameters.joints(machine))
        self.around = parameters.surroundings(machine)
        if gauge is not None:
            self.around = self.around._replace(supply_pressure=self.around.ambient_pressure + gauge)
        p = self.around.supply_pressure if gauge is not None else 0.75 * self.around.supply_pressure
        self.states: list[Any] = [
            joint_at_rest(joint, angle, p, p, self.around) for joint, angle in zip(self._joints, angles, strict=True)
        ]
        self._lines: list[Any] = [ZERO_COMMANDS] * self.n
        self._noise = np.random.default_rng(seed)
        self.held = np.full(self.n, FREE)
        self.brakes = np.array([joint.brake_torque for joint in self._joints])
        self.load = np.zeros(self.n)
        self.drift = np.zeros(self.n)
        self.escaping = np.zeros((self.n, 2))
        """Share of the air above atmosphere that escapes from hoses A and B in a cycle."""
        self.k = 0
        # Compiled now, not while a clock runs.
        nothing = np.zeros(self.n)
        through_a_cycle(
            self._arm, tuple(self._joints), tuple(self.states), tuple(self._lines), self.around,
            nothing, self.held, self.brakes, self.load, 0, self.cycle, self._steps,
        )  # fmt: skip

    def sense(self) -> tuple[Array, Array]:
        """Angles and differential pressures as the converters report them now."""
        return self._read(self._noise.standard_normal((self.n, 2)))

    def exact(self) -> tuple[Array, Array]:
        """The same without noise; no sample of it is used up."""
        return self._read(np.zeros((self.n, 2)))

    def _read(self, z: Array) -> tuple[Array, Array]:
        angles, pressures = [], []
        for joint, state, normal in zip(self._joints, self.states, z, strict=True):
            difference = state.hose_a.pressure - state.hose_b.pressure
            angles.append(read_sensor(joint.angle_sensor, state.motion.angle, normal[0]))
            pressures.append(read_sensor(joint.pressure_sensor, difference, normal[1]))
        return np.array(angles), np.array(pressures)

    def kink(self, joint: int, share: float) -> None:
        """Let a joint's valve pass a share of what it passes now."""
        valve = self._joints[joint].valve
        narrow = valve._replace(conductance=share * valve.conductance, leakage=share * valve.leakage)
        self._joints[joint] = self._joints[joint]._replace(valve=narrow)

    def advance(self, voltages: Array) -> None:
        """Let a control cycle pass."""
        self.states, self._lines = through_a_cycle(
            self._arm, tuple(self._joints), tuple(self.states), tuple(self._lines), self.around,
            voltages - self.drift, self.held, self.brakes, self.load, self.k, self.cycle, self._steps,
        )  # fmt: skip
        self.k += 1
        for j in range(self.n):
            for i, hose in enumerate(("hose_a", "hose_b")):
                if self.escaping[j, i]:
                    self._lose(j, hose, self.escaping[j, i])

    def _lose(self, joint: int, name: str, share: float) -> None:
        hose = getattr(self.states[joint], name)
        keep = 1.0 - share * max(1.0 - self.around.ambient_pressure / hose.pressure, 0.0)
        less = hose._replace(
            energy=keep * hose.energy, mass=keep * hose.mass, pressure=keep * hose.pressure, pressure_change=0.0
        )
        self.states[joint] = self.states[joint]._replace(**{name: less})
