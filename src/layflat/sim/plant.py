"""A machine that others move on bit by bit: the plant of a rollout without its controller."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import DivergedError, InputError
from layflat.lanes import leaves, write_numbers
from layflat.machine import Machine, load, parameters
from layflat.motion.scenario import MAX_DURATION, SIGNALS, Scenario
from layflat.motion.signal_values import Angles, Pair, SignalKind, Value, check_whole, read_number, read_row
from layflat.physics.driven import AIR, Plant
from layflat.physics.joint import Surroundings
from layflat.physics.noise import noise_samples
from layflat.physics.step import STEP
from layflat.sim.run import start_angles, timing_of
from layflat.sim.signals import start_pressures
from layflat.sim.stepping import Setting, kept_at_rest, stepping


class SteppedPlant(Plant):
    """A machine through time, at rest at first: give it voltages, let time pass, read its sensors.

    Driven once a control cycle by the same voltages it goes through the states of a rollout, bit for bit; the sample
    number k of its sensors has the noise of the rollout's.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        start: angles at which it rests at first.
        pressures: absolute pressures of the hoses A and B at first, of all joints or by joint; where not given those
            that hold the arm.
        seed: of the sensors' noise.
        noise: whether the sensors are noisy.
        step: of the plant; rounded so that a control cycle is a whole number of steps.
        payload: the machine's where not given.

    Raises:
        InputError: an option is wrong, or the machine has no valve or sensors.
    """

    def __init__(
        self,
        machine: str | Path | Machine,
        *,
        start: Angles = 0.0,
        pressures: Pair | Mapping[str, Pair] | None = None,
        seed: int = 0,
        noise: bool = True,
        step: Value = STEP,
        payload: Value | None = None,
    ) -> None:
        self._described = machine = load(machine)
        cycle = machine.cycle
        timing = timing_of(cycle, step, 1, machine)
        scenario, n = Scenario(start=start, pressures=pressures, seed=seed, noise=noise), len(machine.joints)
        self.joints = tuple(machine.joints)
        self._steps, self._h = timing.steps, cycle / timing.steps
        around = parameters.surroundings(machine)
        if payload is not None:
            around = around._replace(payload=_payload(machine, payload))
        self._machine = Setting(parameters.arm(machine), parameters.joints(machine), cycle, around)
        self._setting = np.array(list(leaves(self._machine)))
        super().__init__(self._machine.joints, self._setting[-len(Surroundings._fields) :], self._h)
        angles = start_angles(scenario, machine, np.zeros((1, n)))
        kept = kept_at_rest(self._machine, angles, start_pressures(scenario, machine), self._h)
        self._kernels, self._like = stepping(self._machine, kept[0]), kept[0]
        self._kept = np.array([list(leaves(one)) for one in kept])
        self._at, self._due, self._grips = 0, -1, np.zeros(n)
        self._noise = noise_samples(seed if noise else None, n)
        # Compiled now, not while a clock runs.
        self._move_to(0)
        self._kernels.sample(self._setting, self._kept, np.zeros((n, 2)), np.empty((2, n)))

    @property
    def time(self) -> float:
        """Time to which it has been advanced, s."""
        return self._at * self._h

    @property
    def payload(self) -> float:
        """Mass at the tip, kg; settable."""
        return float(self._around[AIR.payload])

    @payload.setter
    def payload(self, mass: Value) -> None:
        self._around[AIR.payload] = _payload(self._described, mass)

    def drive(self, voltages: Array) -> None:
        """Give the valves' drivers voltages (V, (joints,)), which hold until the next.

        Where the valves' delay counts control cycles, every call in a new instant counts as one; without calls, time.

        Raises:
            InputError: they are not one finite number a joint.
        """
        row = np.asarray(voltages)
        if row.dtype != np.float64 or row.shape != self._voltages.shape or not np.isfinite(row).all():
            row = read_row(voltages, SignalKind("voltages", u.VOLTAGE, self.joints), self._voltages)
        self._voltages[:] = row
        self._due = -1

    def advance(self, until: float) -> None:
        """Advance to the last whole step before `until` (s).

        Raises:
            DivergedError: the machine diverged.
            InputError: it is no time, or further away than a run may last.
        """
        until = read_number(until, u.TIME, "until")
        if until - self.time > MAX_DURATION:
            raise InputError(f"{until:g} s is too far away", where="until", right=f"give {MAX_DURATION:g} s at a time")
        # A deadline that is a whole number of steps may be a hair short of it.
        last = int(until / self._h + 1e-6)
        if last > self._at:
            self._move_to(last)

    def _move_to(self, last: int) -> None:
        self._due, diverged = self._kernels.move(
            self._setting, self._kept, self._given, self._seen, self._steps, self._at, last, self._due
        )
        self._at = last
        if diverged >= 0:
            raise DivergedError(self.time, self.joints[diverged])

    def sense(self) -> tuple[Array, Array]:
        """Angles (rad) and differential pressures (Pa) as the converters report them now, noise included, (joints,)."""
        out = np.empty((2, len(self.joints)))
        self._kernels.sample(self._setting, self._kept, next(self._noise), out)
        return out[0], out[1]

    def grip(self, joint: int, torque: float) -> None:
        """Hold a joint, by its number, as a brake does, by so much more than its own (N m); 0 lets it go.

        Raises:
            InputError: there is no such joint, or the torque is no number.
        """
        self._grips[check_whole(joint, "joint", 0, len(self.joints) - 1)] = read_number(torque, u.TORQUE, "torque")
        self._write_joints()

    def _write_joints(self) -> None:
        gripped = zip(self._joints_now(), self._grips.tolist(), strict=True)
        joints = tuple(joint._replace(brake_torque=joint.brake_torque + grip) for joint, grip in gripped)
        around = Surroundings(*self._around)
        write_numbers(self._setting, self._machine._replace(joints=joints, around=around))


def _payload(machine: Machine, mass: Value) -> float:
    """Return a payload, kg; raise InputError if it is not plausible."""
    return float(SIGNALS["payload"].check(machine, read_number(mass, u.MASS, "payload"), "payload"))
