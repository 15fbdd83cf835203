"""Motions of an arm while a person holds its lease: jogging, and sequences of steps that are kept in files."""

import tomllib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from math import degrees, radians
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
import tomli_w

from layflat.arrays import Array
from layflat.description.names import file_name
from layflat.errors import InputError
from layflat.files import write_text
from layflat.machine import Machine
from layflat.machine.parameters import check_inside_stroke
from layflat.motion.path import half_strokes
from layflat.motion.trajectory import States
from layflat.rig.abilities import DemandLimits, demand_limits, plan_smooth_motion
from layflat.rig.session import RigSession, RigSnapshot

JOG_RISE_TIME = 0.25  # of a jogged joint from rest to its speed, and back, s
ARRIVAL_ANGLE, ARRIVAL_SPEED = np.radians(1.0), np.radians(2.0)  # below which the arm has arrived, rad and rad/s
ARRIVAL_TIMEOUT = 3.0  # for the joints to arrive after the motion of a step, s
MAX_LISTED = 200  # sequences that a page offers
SUFFIX = ".sequence.toml"
MAX_PAUSE, MAX_STEPS = 3600.0, 500  # of a step, s, and of a sequence


class ArmMotion(Protocol):
    """Motion of an arm, which `send_demand` advances; `is_over` once it has ended."""

    is_over: bool

    def send_demand(self, session: RigSession, shot: RigSnapshot, now: float) -> None:
        """Send the demand that is due.

        Args:
            session: session of the rig.
            shot: last cycle.
            now: present time, s, monotonic.
        """


class SequenceStep(NamedTuple):
    """Step of a sequence: target angles, a pause, and digital outputs."""

    angles: tuple[float, ...]  # rad
    pause: float = 0.0  # after the arm has arrived, s
    outputs: frozenset[str] | None = None  # digital outputs that are on from its arrival; None: as before


def active_outputs(machine: Machine, shot: RigSnapshot) -> frozenset[str]:
    """Return the names of the digital outputs that are on."""
    bits = int(shot["outputs"])
    return frozenset(name for number, name in enumerate(machine.interface.outputs) if bits >> number & 1)


class JogMotion:
    """Motion of jogged joints at demanded velocities, with a limited acceleration and inside the working stroke."""

    def __init__(self, machine: Machine, start: Array) -> None:
        """Begin at rest at the demand `start`, rad, (joints,)."""
        self.is_over = False
        self.demand_velocity: Array = np.zeros(len(start))  # velocities, rad/s
        self._at, self._half = start.copy(), half_strokes(machine)
        self._velocity = self._peak_velocity = np.zeros(len(start))  # present, and greatest demanded so far, rad/s
        self._last_time: float | None = None

    def send_demand(self, session: RigSession, shot: RigSnapshot, now: float) -> None:  # noqa: ARG002  (as of `Move`)
        """Advance the demand by the time since the last call, at most `JOG_RISE_TIME`, and send it with its velocity.

        A velocity takes `JOG_RISE_TIME` from 0 to its greatest demanded value, and is 0 at the end of the stroke.

        Args:
            session: session of the rig.
            shot: last cycle.
            now: present time, s, monotonic.
        """
        elapsed = 0.0 if self._last_time is None else min(now - self._last_time, JOG_RISE_TIME)
        self._last_time = now
        self._peak_velocity = np.maximum(self._peak_velocity, np.abs(self.demand_velocity))
        change = self._peak_velocity * elapsed / JOG_RISE_TIME
        self._velocity = self._velocity + np.clip(self.demand_velocity - self._velocity, -change, change)
        after = np.clip(self._at + elapsed * self._velocity, -self._half, self._half)
        self._velocity[np.abs(after) >= self._half] = 0.0
        self._at = after
        session.ask(after.tolist(), self._velocity.tolist())
        self.is_over = not self._velocity.any() and not self.demand_velocity.any()


class SequenceMotion:
    """Motion through the steps of a sequence, at a fraction of the arm's limits, once or repeatedly."""

    def __init__(
        self, machine: Machine, start: Array, steps: Sequence[SequenceStep], share: float, *, repeats: bool = False,
        limits: DemandLimits | None = None,
    ) -> None:  # fmt: skip
        """Plan the motion to the first step.

        Args:
            machine: machine of the arm.
            start: present angles, rad, (joints,).
            steps: steps, one after the other.
            share: fraction of the arm's speeds and accelerations, 0..1.
            repeats: whether the sequence restarts at its end.
            limits: limits of the machine's demands; None computes them.
        """
        self.is_over, self.step, self.rounds = False, 0, 0  # index of the present step, and number of rounds done
        self._machine, self._steps, self._share, self._repeats = machine, tuple(steps), share, repeats
        self._limits = limits or demand_limits(machine)
        self._motion_start: float | None = None  # start of the present motion, s
        self._arrived: float | None = None  # arrival of the joints at its end, s
        self._rows = self._motion(start)

    @property
    def target(self) -> tuple[float, ...]:
        """Target angles of the present step, rad."""
        return self._steps[self.step].angles

    def send_demand(self, session: RigSession, shot: RigSnapshot, now: float) -> None:
        """Send the demand of the present motion; after it, wait for arrival, switch outputs, pause, and go on.

        Without arrival within `ARRIVAL_TIMEOUT` it goes on, and outputs stay as they are.

        Args:
            session: session of the rig.
            shot: last cycle.
            now: present time, s, monotonic.
        """
        self._motion_start = now if self._motion_start is None else self._motion_start
        row = int((now - self._motion_start) / self._machine.cycle)
        if row < len(self._rows.angles):
            session.ask(*(part[row].tolist() for part in self._rows), at=self._motion_start + row * self._machine.cycle)
            return
        if self._arrived is None:
            session.ask(self.target)
            late = now - self._motion_start - len(self._rows.angles) * self._machine.cycle > ARRIVAL_TIMEOUT
            if self._has_arrived(shot):
                self._arrived = now
                self._switch_outputs(session, shot)
            elif late:  # without its outputs: a gripper must not open at a wrong position
                self._arrived = now
        elif now - self._arrived >= self._steps[self.step].pause:
            self._begin_next_step(now)

    def _has_arrived(self, shot: RigSnapshot) -> bool:
        """Return whether all joints are within `ARRIVAL_ANGLE` of their targets and slower than `ARRIVAL_SPEED`."""
        deviation = np.abs(shot["averaged_angle"] - np.array(self.target)).max()
        return bool(deviation < ARRIVAL_ANGLE and np.abs(shot["averaged_velocity"]).max() < ARRIVAL_SPEED)

    def _switch_outputs(self, session: RigSession, shot: RigSnapshot) -> None:
        """Switch the digital outputs that differ from those of the present step, if the step has outputs."""
        outputs = self._steps[self.step].outputs
        if outputs is not None:
            for name in sorted(outputs ^ active_outputs(self._machine, shot)):
                session.switch(name, name in outputs)

    def _begin_next_step(self, now: float) -> None:
        """Begin the motion to the next step at time `now`, s; after the last step count a round, and restart or end."""
        start = np.array(self.target)
        if self.step + 1 == len(self._steps):
            self.rounds += 1
            self.is_over = not self._repeats
        if not self.is_over:
            self.step = (self.step + 1) % len(self._steps)
            self._motion_start, self._arrived = now, None
            self._rows = self._motion(start)

    def _motion(self, start: Array) -> States:
        """Return the states of the motion from angles `start` to the present target, a row for each control cycle."""
        return plan_smooth_motion(self._machine, start, np.array(self.target), self._share, self._limits)


def newest_names(folder: Path) -> tuple[list[str], int]:
    """Return the `MAX_LISTED` newest names of sequences in a folder, sorted by name, and the number of older ones."""
    files = []
    for path in folder.glob(f"*{SUFFIX}"):
        with suppress(OSError):  # it was deleted meanwhile
            files.append((path.stat().st_mtime, path.name.removesuffix(SUFFIX)))
    newest = sorted(files, reverse=True)[:MAX_LISTED]
    return sorted(name for _, name in newest), len(files) - len(newest)


def sequence_file(folder: Path, name: str) -> Path:
    """Return the path of a sequence, existing or not; raise InputError if the name can't be that of a file."""
    return folder / f"{file_name(name, 'name')}{SUFFIX}"


def is_saved(folder: Path, name: str) -> bool:
    """Return whether a sequence of this name exists; raise InputError if the name can't be that of a file."""
    return sequence_file(folder, name).exists()


def save_sequence(folder: Path, name: str, machine: Machine, steps: Sequence[SequenceStep]) -> Path:
    """Write a sequence of a machine's joints, in place of one of its name, and return its path.

    Args:
        folder: folder of the sequences.
        name: name of the sequence.
        machine: machine of the arm.
        steps: steps, 1 to `MAX_STEPS`.

    Raises:
        InputError: the name can't be one of a file, or there are too many steps, or none.
        OutputError: it can't be written.
    """
    if not 0 < len(steps) <= MAX_STEPS:
        raise InputError(f"has {len(steps)} steps", where=name, right=f"give 1 to {MAX_STEPS}")
    rows = [_step_table(step, machine) for step in steps]
    return write_text(sequence_file(folder, name), tomli_w.dumps({"machine": machine.name, "step": rows}))


def _step_table(step: SequenceStep, machine: Machine) -> dict[str, Any]:
    """Return a step as a table of its file: angles in degrees by joint, pause in s, and outputs if it has some."""
    angles = {joint: f"{degrees(at):.3f} deg" for joint, at in zip(machine.joints, step.angles, strict=True)}
    outputs = {} if step.outputs is None else {"outputs": sorted(step.outputs)}
    return {"angles": angles, "pause": f"{step.pause:.3f} s", **outputs}


def load_sequence(folder: Path, name: str, machine: Machine) -> list[SequenceStep]:
    """Read a sequence of a machine.

    Args:
        folder: folder of the sequences.
        name: name of the sequence.
        machine: machine of the arm.

    Raises:
        InputError: the file is missing or no sequence, its joints or outputs are not those of the machine, an angle is
            outside the working stroke, or a pause is not 0 to `MAX_PAUSE`.
    """
    path = sequence_file(folder, name)
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise InputError(f"can't be read ({error})", where=str(path)) from None
    rows = table.get("step")
    if not isinstance(rows, list) or not 0 < len(rows) <= MAX_STEPS:
        count_text = f"{len(rows)} steps" if isinstance(rows, list) and rows else "no steps"
        raise InputError(f"holds {count_text}", where=str(path), right=f"give 1 to {MAX_STEPS} tables [[step]]")
    return [_read_step(row, machine, f"{path}: step {count}") for count, row in enumerate(rows, 1)]


def _read_step(row: Any, machine: Machine, where: str) -> SequenceStep:
    """Return a step of a sequence file.

    Raises:
        InputError: it has not one angle inside the stroke for each joint, or its pause or outputs are wrong.
    """
    from layflat.description import units as u  # noqa: PLC0415

    angles = row.get("angles") if isinstance(row, Mapping) else None
    if not isinstance(angles, Mapping) or set(angles) != set(machine.joints):
        right = f"give angles of {', '.join(machine.joints)}"
        raise InputError("does not give one angle for each joint of the machine", where=where, right=right)
    values = [u.quantity(angles[name], u.ANGLE, f"{where}: {name}") for name in machine.joints]
    for name, angle in zip(machine.joints, values, strict=True):
        check_inside_stroke(machine, name, angle, where)
    pause = u.quantity(row.get("pause", "0 s"), u.TIME, f"{where}: pause")
    return SequenceStep(tuple(values), check_pause(pause, where), _read_outputs(row.get("outputs"), machine, where))


def _read_outputs(names: Any, machine: Machine, where: str) -> frozenset[str] | None:
    """Return the outputs that a step switches on, None if it leaves all; raise InputError if the machine lacks one."""
    outputs = machine.interface.outputs
    if names is None:
        return None
    if not isinstance(names, list) or not set(map(str, names)) <= set(outputs):
        right = f"give a list of {', '.join(outputs)}" if outputs else "leave them out: the machine has none"
        raise InputError(f"{names!r} are not outputs of the machine", where=f"{where}: outputs", right=right)
    return frozenset(names)


def check_pause(seconds: float | None, where: str) -> float:
    """Return a pause, s; raise InputError unless it is a number, 0 to `MAX_PAUSE`, both included."""
    if seconds is None:
        raise InputError("holds no number", where=where, right=f"give 0 to {MAX_PAUSE:g} s")
    if not 0.0 <= seconds <= MAX_PAUSE:
        raise InputError(f"the pause is {seconds:g} s", where=where, right=f"give 0 to {MAX_PAUSE:g} s")
    return seconds


def read_target(machine: Machine, values: Mapping[str, float | None]) -> tuple[float, ...]:
    """Return the angles (rad) of a target in the machine's order, from degrees by joint.

    Raises:
        InputError: an angle is missing or None, or outside its joint's working stroke.
    """
    values_rad = []
    for name in machine.joints:
        value = values.get(name)
        if value is None:
            raise InputError("lacks an angle", where=name, right="give a number of degrees")
        check_inside_stroke(machine, name, radians(value), name)
        values_rad.append(radians(value))
    return tuple(values_rad)
