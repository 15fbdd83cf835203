"""What was learnt of a repeated move, from how its repeats went.

| symbol | meaning | unit |
|---|---|---|
| u_k | correction of the k-th repeat: the demand is the wanted motion plus u_k | rad |
| e_k | its error: wanted less measured angles | rad |
| L | filter of corrections.py | 1 |
| g | gain | 1 |

u_(k+1) = u_b + g L e_b (arimoto1984, bristow2006), where b is the best repeat so far: one that was worse is not learnt
from, and lessens g. A demand carries its velocities and accelerations, so that a law with feed-forward answers with
a_k = u_k over its bandwidth, but for the errors of its model; where it does, each repeat leaves 1 - g of what L passes.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from hashlib import sha256

import numpy as np

from layflat.arrays import Array
from layflat.errors import InputError, MachineError
from layflat.machine import Machine
from layflat.motion.kinematics import tip_position
from layflat.motion.learning.corrections import Corrections, Filtering, filtering
from layflat.motion.limits import abilities
from layflat.motion.path import half_strokes
from layflat.motion.trajectory import States

GAIN = 1.0
LESS = 0.7  # factor of the gain after a repeat that was worse
HALVINGS = 10  # of a step that leaves strokes or speeds, at most
ARRIVED = 0.002  # distance of the tip from the end of the motion within which it has landed, m
LATER = 0.05  # by which a repeat may land later than the first, s
INSIDE = 1e-9  # rad or rad/s


@dataclass(frozen=True)
class Wanted:
    """A motion that is repeated, a row a control cycle, (cycles, joints) each: it begins and ends at rest."""

    cycle: float  # s
    angles: Array  # rad
    velocities: Array  # rad/s
    accelerations: Array  # rad/s2

    @property
    def fingerprint(self) -> str:
        """SHA-256 of its rows, rounded as in demand files."""
        rows = np.round(np.degrees(np.hstack([self.angles, self.velocities, self.accelerations])), 3) + 0.0
        return sha256(f"{self.cycle!r} {rows.shape}".encode() + rows.astype("<f8").tobytes()).hexdigest()


@dataclass(frozen=True)
class Repeat:
    """How a repeat went, by what the sensors said."""

    rms: float  # of the tip's distance from where it should be, along the path, m
    most: float  # of it, m
    landed: float  # after the end of the motion, when the tip is near its end for good, s; negative: before it
    kept: bool  # whether it was the best so far


@dataclass(frozen=True)
class Learnt:
    """What was learnt of a motion of a machine's arm; coefficients of corrections are (splines, joints), rad."""

    machine: Machine
    wanted: Wanted
    how: Filtering
    gain: float
    sent: Array  # of the demand to send next
    best: Array  # of the best repeat so far
    step: Array  # L e of that repeat
    history: tuple[Repeat, ...] = ()

    @cached_property
    def lead_in(self) -> int:
        """Control cycles of the demand before the motion begins."""
        return round(self.how.lead_in / self.wanted.cycle)

    @cached_property
    def rested(self) -> States:
        """The wanted motion with rests before and after it: what the demand would be without a correction."""
        pads = (self.lead_in, round(self.how.tail / self.wanted.cycle)), (0, 0)
        rates = (np.pad(of, pads) for of in (self.wanted.velocities, self.wanted.accelerations))
        return States(np.pad(self.wanted.angles, pads, mode="edge"), *rates)

    @cached_property
    def corrections(self) -> Corrections:
        """Splines that corrections are made of."""
        return Corrections(self.wanted.cycle, len(self.rested.angles), self.how)

    def demand(self) -> States:
        """Return the demand of the next repeat, a row a control cycle."""
        return self._demand(self.sent)

    def best_demand(self) -> States:
        """Return the demand of the best repeat so far."""
        return self._demand(self.best)

    def after(self, measured: Array) -> "Learnt":
        """Return what is learnt from a repeat.

        Args:
            measured: angles that sensors said at the control cycles of `demand()`, (cycles, joints), rad.

        Raises:
            InputError: there are too few of them, of other joints, or some are missing (not a number).
        """
        rested = self.rested.angles
        if measured.ndim != 2 or measured.shape[1] != rested.shape[1] or len(measured) < len(rested):
            what = f"measured angles of shape {measured.shape} do not fit"
            raise InputError(what, right=f"give those of the whole demand, of shape {rested.shape}")
        measured = measured[: len(rested)]
        if not np.isfinite(measured).all():
            what = f"{(~np.isfinite(measured)).any(axis=1).sum()} of {len(rested)} cycles lack measured angles"
            raise InputError(what, right="give a run without gaps")
        went = self._went(measured)
        repeats = (*self.history, went)
        if went.kept:
            step = self.corrections.filtered(self._fading * (rested - measured))
            return self._stepped(replace(self, best=self.sent, step=step, history=repeats))
        return self._stepped(replace(self, gain=LESS * self.gain, history=repeats))

    @cached_property
    def _fading(self) -> Array:
        """Weights of errors, (cycles, 1): those after the motion fade, so that the correction ends without a jerk."""
        after = np.arange(len(self.rested.angles)) + 1 - self.lead_in - len(self.wanted.angles)
        share = np.clip(self.wanted.cycle * after / self.how.tail, 0.0, 1.0)
        fading: Array = (0.5 + 0.5 * np.cos(np.pi * share))[:, None]
        return fading

    def _demand(self, coefficients: Array) -> States:
        return States(*(a + b for a, b in zip(self.rested, self.corrections.states(coefficients), strict=True)))

    def _went(self, measured: Array) -> Repeat:
        """Return how a repeat went: it is kept if it is closer to the path, and lands no later than the first."""
        rms, most = path_error(self.machine, self.wanted, measured[self.lead_in :])
        landed = landing(self.machine, self.wanted, measured[self.lead_in :])
        better = all(rms < other.rms for other in self.history)
        in_time = landed <= max([repeat.landed for repeat in self.history[:1]], default=landed) + LATER
        return Repeat(rms, most, landed, kept=better and in_time)

    def _stepped(self, taken: "Learnt") -> "Learnt":
        """Return it with the demand to send next: a step from the best, as far as strokes and speeds allow."""
        step = taken.gain * taken.step
        for _ in range(HALVINGS):
            if taken._allowed(taken.best + step):
                return replace(taken, sent=taken.best + step)
            step = 0.5 * step
        return replace(taken, sent=taken.best)

    def _allowed(self, coefficients: Array) -> bool:
        """Whether a correction leaves the demand inside strokes and speeds, or as far outside as the wanted motion."""
        rested, asked = self.rested, self._demand(coefficients)
        limits = [(half_strokes(self.machine), rested.angles, asked.angles)]
        if self.machine.valve is not None:
            limits.append((abilities(self.machine).speed, rested.velocities, asked.velocities))
        return all(
            bool(np.all(np.abs(now) <= np.maximum(limit, np.abs(before).max(axis=0)) + INSIDE))
            for limit, before, now in limits
        )


def begin(machine: Machine, motion: Sequence[Array | None]) -> Learnt:
    """Return nothing learnt yet of a motion.

    Args:
        machine: whose controller is sent the demands.
        motion: its angles (cycles, joints) in rad, a row a control cycle of the machine; their velocities and
            accelerations, or None, which are zero then: a `States`, or the `Demand` of a file.

    Raises:
        MachineError: the machine has no controller.
        InputError: the motion is not of its joints, is too short, or does not end at rest.
    """
    if machine.controller is None:
        raise MachineError("has no controller", where=machine.origin, right="give a machine that follows demands")
    angles, *rates = motion
    if angles is None or angles.ndim != 2 or angles.shape[1] != len(machine.joints) or len(angles) < 2:
        shape = None if angles is None else angles.shape
        right = f"give two rows and more of {len(machine.joints)} angles"
        raise InputError(f"a motion of shape {shape} is not one of {machine.name}", right=right)
    velocities, accelerations = (np.zeros_like(angles) if of is None else of for of in rates)
    wanted, how = Wanted(machine.cycle, angles, velocities, accelerations), filtering(machine)
    nothing = np.zeros((0, angles.shape[1]))
    blank = Learnt(machine, wanted, how, GAIN, nothing, nothing, nothing)
    zero = np.zeros((blank.corrections.count, angles.shape[1]))
    return replace(blank, sent=zero, best=zero, step=zero)


def path_error(machine: Machine, wanted: Wanted, angles: Array) -> tuple[float, float]:
    """Return rms and greatest distance (m) of the tip from where it should be along the path.

    `angles`: (cycles, joints), rad, from the beginning of the motion on.
    """
    count = len(wanted.angles)
    apart = np.linalg.norm(tip_position(machine, angles[:count]) - tip_position(machine, wanted.angles), axis=1)
    return float(np.sqrt(np.mean(apart**2))), float(apart.max())


def landing(machine: Machine, wanted: Wanted, angles: Array) -> float:
    """Return when the tip is within 2 mm of the end of the motion for good, from that end on, s.

    `angles`: (cycles, joints), rad, from the beginning of the motion on. Infinite if it is not by their end.
    """
    apart = np.linalg.norm(tip_position(machine, angles) - tip_position(machine, wanted.angles[-1:]), axis=1)
    away = np.flatnonzero(apart > ARRIVED)
    if len(away) == 0:
        return -wanted.cycle * (len(wanted.angles) - 1)
    if away[-1] == len(angles) - 1:
        return float("inf")
    return float(wanted.cycle * (away[-1] + 1 - (len(wanted.angles) - 1)))
