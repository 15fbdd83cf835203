"""What moves an arm as long as somebody minds it: joints that are jogged, and courses through places."""

from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.path import half_strokes
from layflat.motion.trajectory import States
from layflat.rig.abilities import DemandLimits, demand_limits
from layflat.rig.session import Session, Snapshot
from layflat.rig.smooth import smooth

GATHERS = 0.25  # in which a jogged joint comes to its speed, and back to rest, s
NEAR, STILL = np.radians(1.0), np.radians(2.0)  # of a place at which a course arrives, rad and rad/s
ARRIVES = 3.0  # after its motion a course waits so long for the joints, s


class Move(Protocol):
    """Something that moves an arm, look by look."""

    over: bool

    def ask(self, session: Session, shot: Snapshot, now: float) -> None:
        """Ask for what is due at an instant, s, monotonic; `shot` is the last cycle."""


class Step(NamedTuple):
    """A place of a sequence."""

    angles: tuple[float, ...]  # rad
    pause: float = 0.0  # after the arm has come there, s
    outputs: frozenset[str] | None = None  # digital outputs that are on from when it has come there; None: as before


def outputs_on(machine: Machine, shot: Snapshot) -> frozenset[str]:
    """Return the names of the digital outputs that are on."""
    bits = int(shot["outputs"])
    return frozenset(name for number, name in enumerate(machine.interface.outputs) if bits >> number & 1)


class Jog:
    """Joints that are moved by hand, as fast as is wanted; they come to rest within the working stroke."""

    def __init__(self, machine: Machine, start: Array) -> None:
        self.over = False
        self.wanted: Array = np.zeros(len(start))  # velocities, rad/s
        self._at, self._half = start.copy(), half_strokes(machine)
        self._velocity = self._most = np.zeros(len(start))  # now, and the greatest wanted yet, rad/s
        self._before: float | None = None

    def ask(self, session: Session, shot: Snapshot, now: float) -> None:  # noqa: ARG002  (as of `Move`)
        """Move on by what has passed since the last look."""
        passed = 0.0 if self._before is None else min(now - self._before, GATHERS)
        self._before = now
        self._most = np.maximum(self._most, np.abs(self.wanted))
        gained = self._most * passed / GATHERS
        self._velocity = self._velocity + np.clip(self.wanted - self._velocity, -gained, gained)
        after = np.clip(self._at + passed * self._velocity, -self._half, self._half)
        self._velocity[np.abs(after) >= self._half] = 0.0
        self._at = after
        session.ask(after.tolist(), self._velocity.tolist())
        self.over = not self._velocity.any() and not self.wanted.any()


class Course:
    """A motion through places, one after the other, at a share of what the arm can do, again and again if wanted."""

    def __init__(
        self, machine: Machine, start: Array, steps: Sequence[Step], share: float, *, repeats: bool = False,
        limits: DemandLimits | None = None,
    ) -> None:  # fmt: skip
        """Begin from where the joints are.

        Args:
            machine: whose arm moves.
            start: angles, rad, (joints,).
            steps: places, one after the other.
            share: of what the arm can do, 0..1.
            repeats: whether it begins anew at its end.
            limits: of the machine's demands, where they are known.
        """
        self.over, self.step, self.rounds = False, 0, 0  # which step it is at, and how often all were done
        self._machine, self._steps, self._share, self._repeats = machine, tuple(steps), share, repeats
        self._limits = limits or demand_limits(machine)
        self._begun: float | None = None  # when the present motion began, s
        self._arrived: float | None = None  # when the joints were where it ends, s
        self._rows = self._motion(start)

    @property
    def target(self) -> tuple[float, ...]:
        """Where the joints are led at present, rad."""
        return self._steps[self.step].angles

    def ask(self, session: Session, shot: Snapshot, now: float) -> None:
        """Ask for where the motion is by now, or go on with the next place."""
        self._begun = now if self._begun is None else self._begun
        row = int((now - self._begun) / self._machine.cycle)
        if row < len(self._rows.angles):
            session.ask(*(part[row].tolist() for part in self._rows), at=self._begun + row * self._machine.cycle)
            return
        if self._arrived is None:
            session.ask(self.target)
            late = now - self._begun - len(self._rows.angles) * self._machine.cycle > ARRIVES
            if self._is_there(shot):
                self._arrived = now
                self._switch(session, shot)
            elif late:  # nothing is let go of where it should not be
                self._arrived = now
        elif now - self._arrived >= self._steps[self.step].pause:
            self._next(now)

    def _is_there(self, shot: Snapshot) -> bool:
        off = np.abs(shot["averaged_angle"] - np.array(self.target)).max()
        return bool(off < NEAR and np.abs(shot["averaged_velocity"]).max() < STILL)

    def _switch(self, session: Session, shot: Snapshot) -> None:
        wanted = self._steps[self.step].outputs
        if wanted is not None:
            for name in sorted(wanted ^ outputs_on(self._machine, shot)):
                session.switch(name, name in wanted)

    def _next(self, now: float) -> None:
        start = np.array(self.target)
        if self.step + 1 == len(self._steps):
            self.rounds += 1
            self.over = not self._repeats
        if not self.over:
            self.step = (self.step + 1) % len(self._steps)
            self._begun, self._arrived = now, None
            self._rows = self._motion(start)

    def _motion(self, start: Array) -> States:
        return smooth(self._machine, start, np.array(self.target), self._share, self._limits)
