"""The plant of a rollout without its controller, advanced by its caller."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from layflat.arrays import Array
from layflat.description import units as u
from layflat.errors import DivergedError, InputError
from layflat.lanes import Like, leaves, read_numbers, write_numbers
from layflat.machine import Machine, load, parameters
from layflat.motion.scenario import MAX_DURATION, SIGNALS, Scenario
from layflat.motion.signal_values import Angles, Pair, SignalKind, Value, check_integer, read_number, read_row
from layflat.physics.adjustable import DriveFractions
from layflat.physics.driven import SURROUNDINGS_COLUMNS, MachinePlant
from layflat.physics.driver import CommandDelayLine
from layflat.physics.joint import JointState, Surroundings
from layflat.physics.sensor import noise_samples
from layflat.physics.step import STEP
from layflat.sim.run import make_timing, start_angles
from layflat.sim.signals import start_pressures
from layflat.sim.stepping import PlantSetting, carry_at_rest, move, sample


class SteppedPlant(MachinePlant):
    """A machine that its caller drives with voltages, advances in time, and reads through its sensors.

    It starts at rest. Driven once per control cycle by the same voltages and fractions, it passes through the states of
    a rollout, bit for bit; sample k of its sensors has the noise of the rollout's sample k.

    Args:
        machine: a description, its file, or the name of a built-in machine.
        start: angles at which it rests at the start; numbers are in rad.
        pressures: absolute pressures of hoses A and B at the start, for all joints or by joint; numbers are in Pa;
            default: those that hold the arm.
        seed: seed of the sensors' noise.
        noise: whether the sensors are noisy.
        step: time step of the plant; rounded so that a control cycle is a whole number of steps; a number is in s.
        payload: mass at the tip; a number is in kg; default: the machine's.

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
        timing = make_timing(cycle, step, 1, machine)
        scenario, n = Scenario(start=start, pressures=pressures, seed=seed, noise=noise), len(machine.joints)
        self.joints = tuple(machine.joints)
        self._steps, self._h = timing.steps, cycle / timing.steps
        around = parameters.surroundings(machine)
        if payload is not None:
            around = around._replace(payload=_payload(machine, payload))
        self._machine = PlantSetting(parameters.arm(machine), parameters.joints(machine), cycle, around)
        self._setting = np.array(list(leaves(self._machine)))
        super().__init__(self._machine.joints, self._setting[-len(Surroundings._fields) :], self._h)
        angles = start_angles(scenario, machine, np.zeros((1, n)))
        carries = carry_at_rest(self._machine, angles, start_pressures(scenario, machine), self._h)
        self._like, self._state_array = carries[0], np.array([list(leaves(carry)) for carry in carries])
        self._samples, self._readings = np.zeros((n, 2)), np.empty((2, n))
        plant = (*map(Like.from_tuple, (self._machine, carries[0])), self._setting, self._state_array)
        self._move = move.bind(*plant, self._given, self._seen, self._steps, 0, 0, -1)
        self._sample = sample.bind(*plant, self._samples, self._readings)
        self._step_count, self._due, self._grips = 0, -1, np.zeros(n)
        self._noise = noise_samples(seed if noise else None, n)
        self._move_to(0)

    @property
    def time(self) -> float:
        """Time to which it has been advanced, s."""
        return self._step_count * self._h

    @property
    def payload(self) -> float:
        """Mass at the tip, kg; settable."""
        return float(self._around[SURROUNDINGS_COLUMNS.payload])

    @payload.setter
    def payload(self, mass: Value) -> None:
        self._around[SURROUNDINGS_COLUMNS.payload] = _payload(self._described, mass)

    @property
    def states(self) -> tuple[JointState, ...]:
        """States of the joints."""
        return tuple(read_numbers(self._like, row.tolist()).state for row in self._state_array)

    def place(self, states: Sequence[JointState], openings: Sequence[float] | None = None) -> None:
        """Set the states of the joints.

        Args:
            states: of the joints.
            openings: at which the valves' drivers have been for long, -1 to 1; those of the valves are in their states;
                default: drivers stay as they are.
        """
        for j, (row, state) in enumerate(zip(self._state_array, states, strict=True)):
            carry = read_numbers(self._like, row)
            if openings is not None:
                carry = carry._replace(line=CommandDelayLine(*[openings[j]] * 3), opening=openings[j])
            write_numbers(row, carry._replace(state=state._replace(ledger=carry.state.ledger)))
        self._move_to(self._step_count)

    def shift(self, changes: Array) -> None:
        """Add to the numbers of the joints' states, (joints, numbers of a `JointState`), in SI units."""
        self._state_array[:, : changes.shape[1]] += changes
        self._move_to(self._step_count)

    def drive(self, voltages: Array, shares: Sequence[DriveFractions] | Array | None = None) -> None:
        """Set what drives the joints; it holds until the next call.

        A valve delay in control cycles counts the calls at new instants, and elapsed time without calls.

        Args:
            voltages: of the valves' drivers, (joints,), V.
            shares: fractions of brake, dither and supply that a control law commands, (joints, 3); default: those of
                the last call, at the start full ones.

        Raises:
            InputError: the voltages are not one finite number per joint.
        """
        if shares is not None:
            self._fractions[:] = shares
        row = np.asarray(voltages)
        if row.dtype != np.float64 or row.shape != self._voltages.shape or not np.isfinite(row).all():
            row = read_row(voltages, SignalKind("voltages", u.VOLTAGE, self.joints), self._voltages)
        self._voltages[:] = row
        self._due = -1

    def advance(self, until: float) -> None:
        """Advance to the last whole step up to `until` (s); do nothing if that is past.

        Raises:
            DivergedError: the machine diverged.
            InputError: `until` is no time, or further away than the maximum duration of a run.
        """
        until = read_number(until, u.TIME, "until")
        if until - self.time > MAX_DURATION:
            raise InputError(f"{until:g} s is too far away", where="until", right=f"give {MAX_DURATION:g} s at a time")
        # By rounding, a deadline of a whole number of steps may be slightly short of it.
        last = int(until / self._h + 1e-6)
        if last > self._step_count:
            self._move_to(last)

    def _move_to(self, last: int) -> None:
        """Advance the plant to step number `last`; raise DivergedError if a joint's state becomes invalid."""
        self._due, diverged = self._move(self._steps, self._step_count, last, self._due)
        self._step_count = last
        if diverged >= 0:
            raise DivergedError(self.time, self.joints[diverged])

    def sense(self) -> tuple[Array, Array]:
        """Return angles (rad) and differential pressures (Pa) as the A/D converters report them now, (joints,) each.

        Each call draws new noise.
        """
        self._samples[:] = next(self._noise)
        self._sample()
        angles, pressures = self._readings.copy()
        return angles, pressures

    def grip(self, joint: int, torque: float) -> None:
        """Set the torque of a hand that grips a joint, in addition to its brake's; 0 releases it.

        Args:
            joint: number of the joint, from 0.
            torque: friction torque, N m; replaces that of an earlier call.

        Raises:
            InputError: there is no such joint, or the torque is no number.
        """
        self._grips[check_integer(joint, "joint", 0, len(self.joints) - 1)] = read_number(torque, u.TORQUE, "torque")
        self._write_joints()

    def _write_joints(self) -> None:
        """Write the joints' parameters for the kernel, with the torques of their grips (N m), and the surroundings."""
        gripped = zip(self._joints_now(), self._grips.tolist(), strict=True)
        joints = tuple(joint._replace(brake_torque=joint.brake_torque + grip) for joint, grip in gripped)
        around = Surroundings(*self._around)
        write_numbers(self._setting, self._machine._replace(joints=joints, around=around))


def _payload(machine: Machine, mass: Value) -> float:
    """Return a payload, kg; raise InputError if it is not plausible."""
    return float(SIGNALS["payload"].check(machine, read_number(mass, u.MASS, "payload"), "payload"))
