"""Iterative learning control: the demand of a repeated motion is corrected by the errors of its repeats.

| symbol | meaning | unit |
|---|---|---|
| u_k | correction of the k-th repeat: the demand is the reference motion plus u_k | rad |
| e_k | its error: reference less measured angles | rad |
| L | filter of corrections.py | 1 |
| g | gain | 1 |
| d | time by which a log's cycles come after those of the demand: a part of a cycle | s |

u_(k+1) = u_b + g L e_b (arimoto1984, bristow2006), where b is the best repeat so far: a worse one is not learnt from,
and reduces g. A demand carries its velocities and accelerations, so that a law with feed-forward follows u_k over its
bandwidth, but for model errors; then each repeat leaves 1 - g of the error that L passes.
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
from layflat.motion.learning.corrections import CorrectionFilter, CorrectionSplines, choose_filter
from layflat.motion.limits import joint_capabilities
from layflat.motion.path import half_strokes
from layflat.motion.trajectory import States

__all__ = ["LearntCorrections", "align_measurement", "begin_learning", "path_error"]

DEMAND_MATCH_TOLERANCE = 1e-3  # difference of the demand in a log from the one that was sent, rad
MAX_CYCLE_OFFSET = 0.6  # greatest |d| in cycles: a half, and noise


def align_measurement(demand: States, logged: Array, measured: Array, cycle: float) -> Array | None:
    """Return measured angles of a log at the control cycles of a demand.

    A rig's host has a clock of its own: the cycles of its log lie between those of the demand that it sent.

    Args:
        demand: sent demand, a row per cycle.
        logged: demands in the log, (cycles of the log, joints), rad.
        measured: angles in the log, likewise.
        cycle: s.

    Returns:
        Angles (cycles, joints), rad; None if the log does not contain this demand.
    """
    count = len(demand.angles)
    if len(logged) < count:
        return None
    windows = np.lib.stride_tricks.sliding_window_view(logged, count, axis=0)
    difference = np.nan_to_num(np.abs(windows - demand.angles.T).max(axis=(1, 2)), nan=np.inf)
    first = int(np.argmin(difference))
    error, v = logged[first : first + count] - demand.angles, demand.velocities
    d = float(
        np.clip(np.sum(error * v) / max(np.sum(v * v), 1e-12), -MAX_CYCLE_OFFSET * cycle, MAX_CYCLE_OFFSET * cycle)
    )
    if not np.abs(error - d * v - 0.5 * d * d * demand.accelerations).max() <= DEMAND_MATCH_TOLERANCE:
        return None
    instants, cycles = first + np.arange(count) - d / cycle, np.arange(len(measured))
    return np.stack([np.interp(instants, cycles, column) for column in measured.T], axis=1)


INITIAL_GAIN = 1.0
GAIN_REDUCTION = 0.7  # factor on the gain after a worse repeat
MAX_STEP_HALVINGS = 10  # of a step that exceeds strokes or speeds
LANDING_DISTANCE = 0.002  # distance of the tip from the end of the motion within which it has landed, m
LANDING_ALLOWANCE = 0.05  # delay of a repeat's landing against the first, s
LIMIT_ROUNDING = 1e-9  # excess over a limit, rad or rad/s


@dataclass(frozen=True)
class RepeatedMotion:
    """Reference motion that is repeated, a row per control cycle, (cycles, joints) each; it begins and ends at rest."""

    cycle: float  # s
    angles: Array  # rad
    velocities: Array  # rad/s
    accelerations: Array  # rad/s2

    @property
    def fingerprint(self) -> str:
        """SHA-256 of its cycle and its rows, these rounded to 0.001 deg, deg/s and deg/s2."""
        rows = np.round(np.degrees(np.hstack([self.angles, self.velocities, self.accelerations])), 3) + 0.0
        return sha256(f"{self.cycle!r} {rows.shape}".encode() + rows.astype("<f8").tobytes()).hexdigest()


@dataclass(frozen=True)
class Repeat:
    """Result of a repeat, by its sensors."""

    rms: float  # distance of the tip from its reference along the path, m
    max: float  # the greatest such distance, m
    arrival: float  # last arrival of the tip near the end of the motion, after that end, s; negative: before it
    kept: bool  # whether the repeat was the best so far


@dataclass(frozen=True)
class LearntCorrections:
    """Corrections learnt for a motion of a machine's arm; their coefficients are (splines, joints), rad."""

    machine: Machine
    motion: RepeatedMotion
    filter: CorrectionFilter
    gain: float
    sent: Array  # coefficients of the demand to send next
    best: Array  # coefficients of the best repeat so far
    step: Array  # L e of that repeat
    history: tuple[Repeat, ...] = ()

    @cached_property
    def lead_in_cycles(self) -> int:
        """Control cycles of the demand before the motion begins."""
        return round(self.filter.lead_in / self.motion.cycle)

    @cached_property
    def uncorrected(self) -> States:
        """Demand without a correction: the reference motion with rests before and after it."""
        pads = (self.lead_in_cycles, round(self.filter.tail / self.motion.cycle)), (0, 0)
        rates = (np.pad(rate, pads) for rate in (self.motion.velocities, self.motion.accelerations))
        return States(np.pad(self.motion.angles, pads, mode="edge"), *rates)

    @cached_property
    def corrections(self) -> CorrectionSplines:
        """Splines of which corrections are composed."""
        return CorrectionSplines(self.motion.cycle, len(self.uncorrected.angles), self.filter)

    def demand(self) -> States:
        """Return the demand of the next repeat, a row per control cycle."""
        return self._demand(self.sent)

    def best_demand(self) -> States:
        """Return the demand of the best repeat so far."""
        return self._demand(self.best)

    def learn_from(self, measured: Array) -> "LearntCorrections":
        """Return the corrections after a repeat.

        Args:
            measured: sensed angles at the control cycles of `demand()`, (cycles, joints), rad; later rows are ignored.

        Raises:
            InputError: rows or joints are missing, or values are not numbers.
        """
        reference = self.uncorrected.angles
        if measured.ndim != 2 or measured.shape[1] != reference.shape[1] or len(measured) < len(reference):
            what = f"measured angles of shape {measured.shape} do not fit"
            raise InputError(what, right=f"give those of the whole demand, of shape {reference.shape}")
        measured = measured[: len(reference)]
        if not np.isfinite(measured).all():
            what = f"{(~np.isfinite(measured)).any(axis=1).sum()} of {len(reference)} cycles lack measured angles"
            raise InputError(what, right="give a run without gaps")
        repeat = self._evaluate_repeat(measured)
        repeats = (*self.history, repeat)
        if repeat.kept:
            step = self.corrections.filter_errors(self._fading * (reference - measured))
            return self._take_step(replace(self, best=self.sent, step=step, history=repeats))
        return self._take_step(replace(self, gain=GAIN_REDUCTION * self.gain, history=repeats))

    @cached_property
    def _fading(self) -> Array:
        """Weights of errors, (cycles, 1): those after the motion fade, so that the correction ends without a jerk."""
        after = np.arange(len(self.uncorrected.angles)) + 1 - self.lead_in_cycles - len(self.motion.angles)
        fraction = np.clip(self.motion.cycle * after / self.filter.tail, 0.0, 1.0)
        fading: Array = (0.5 + 0.5 * np.cos(np.pi * fraction))[:, None]
        return fading

    def _demand(self, coefficients: Array) -> States:
        return States(*(a + b for a, b in zip(self.uncorrected, self.corrections.states(coefficients), strict=True)))

    def _evaluate_repeat(self, measured: Array) -> Repeat:
        """Return the result of a repeat, kept if its rms error is the least and it lands as early as the first one.

        `LANDING_ALLOWANCE` of delay is allowed.
        """
        rms, most = path_error(self.machine, self.motion, measured[self.lead_in_cycles :])
        landed = landing_time(self.machine, self.motion, measured[self.lead_in_cycles :])
        better = all(rms < other.rms for other in self.history)
        in_time = landed <= max([repeat.arrival for repeat in self.history[:1]], default=landed) + LANDING_ALLOWANCE
        return Repeat(rms, most, landed, kept=better and in_time)

    def _take_step(self, learnt: "LearntCorrections") -> "LearntCorrections":
        """Return corrections `learnt` with the demand to send next: a step from the best, halved until it is feasible.

        After `MAX_STEP_HALVINGS` it is the best itself.
        """
        step = learnt.gain * learnt.step
        for _ in range(MAX_STEP_HALVINGS):
            if learnt._is_feasible(learnt.best + step):
                return replace(learnt, sent=learnt.best + step)
            step = 0.5 * step
        return replace(learnt, sent=learnt.best)

    def _is_feasible(self, coefficients: Array) -> bool:
        """Return whether a correction keeps strokes and speeds, or exceeds them no more than the reference motion."""
        reference, corrected = self.uncorrected, self._demand(coefficients)
        limits = [(half_strokes(self.machine), reference.angles, corrected.angles)]
        if self.machine.valve is not None:
            limits.append((joint_capabilities(self.machine).speed, reference.velocities, corrected.velocities))
        return all(
            bool(np.all(np.abs(now) <= np.maximum(limit, np.abs(before).max(axis=0)) + LIMIT_ROUNDING))
            for limit, before, now in limits
        )


def begin_learning(machine: Machine, motion: Sequence[Array | None]) -> LearntCorrections:
    """Return corrections of zero for a motion that is to be learnt.

    Args:
        machine: machine whose controller gets the demands.
        motion: reference angles (cycles, joints), rad, a row per control cycle of the machine; their velocities and
            accelerations, or None for zeros: a `States`, or the `DemandSeries` of a file.

    Raises:
        MachineError: the machine has no controller.
        InputError: the motion is not of its joints, or is too short.
    """
    if machine.controller is None:
        raise MachineError("has no controller", where=machine.origin, right="give a machine that follows demands")
    angles, *rates = motion
    if angles is None or angles.ndim != 2 or angles.shape[1] != len(machine.joints) or len(angles) < 2:
        shape = None if angles is None else angles.shape
        right = f"give two rows and more of {len(machine.joints)} angles"
        raise InputError(f"a motion of shape {shape} is not one of {machine.name}", right=right)
    velocities, accelerations = (np.zeros_like(angles) if rate is None else rate for rate in rates)
    reference = RepeatedMotion(machine.cycle, angles, velocities, accelerations)
    nothing = np.zeros((0, angles.shape[1]))
    blank = LearntCorrections(machine, reference, choose_filter(machine), INITIAL_GAIN, nothing, nothing, nothing)
    zero = np.zeros((blank.corrections.count, angles.shape[1]))
    return replace(blank, sent=zero, best=zero, step=zero)


def path_error(machine: Machine, motion: RepeatedMotion, angles: Array) -> tuple[float, float]:
    """Return rms and greatest distance of the tip from its reference at the same instant, m.

    Args:
        machine: machine with the arm.
        motion: reference.
        angles: (cycles, joints), rad, from the beginning of the motion on.
    """
    count = len(motion.angles)
    distance = np.linalg.norm(tip_position(machine, angles[:count]) - tip_position(machine, motion.angles), axis=1)
    return float(np.sqrt(np.mean(distance**2))), float(distance.max())


def landing_time(machine: Machine, motion: RepeatedMotion, angles: Array) -> float:
    """Return the time after which the tip stays within 2 mm of the end of the reference motion.

    Args:
        machine: machine with the arm.
        motion: reference.
        angles: (cycles, joints), rad, from the beginning of the motion on.

    Returns:
        Time from the end of the motion on, s, negative before it; infinite if the last angles are further away.
    """
    distance = np.linalg.norm(tip_position(machine, angles) - tip_position(machine, motion.angles[-1:]), axis=1)
    away = np.flatnonzero(distance > LANDING_DISTANCE)
    if len(away) == 0:
        return -motion.cycle * (len(motion.angles) - 1)
    if away[-1] == len(angles) - 1:
        return float("inf")
    return float(motion.cycle * (away[-1] + 1 - (len(motion.angles) - 1)))
