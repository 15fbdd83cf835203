"""Motions through time: angles, velocities and accelerations of all joints at any instant.

The rates of a demand that consists of angles alone are their differences. A jump of the demand is a change of position,
not a motion: a difference counts as a rate only if it lasts for more than a cycle.

| symbol | meaning | unit |
|---|---|---|
| f_k | (x_(k+1) - x_k) / T, the rate from sample k to the next | |
| T | control cycle | s |
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.motion.path import JointPath

QUINTIC_PEAKS = 15.0 / 8.0, 10.0 / 3.0**0.5  # of `quintic`: velocity over L/T, acceleration over L/T^2

Timing = Callable[[Array], tuple[Array, Array, Array]]
"""Function from times (s) to distances along a path, speeds and accelerations, (instants,) each."""


class States(NamedTuple):
    """States of all joints at several instants, (instants, joints) each, or at one, (joints,) each."""

    angles: Array  # rad
    velocities: Array  # rad/s
    accelerations: Array  # rad/s2


def quintic(time_fraction: Array) -> tuple[Array, Array, Array]:
    """Return the minimum-jerk profile 10 u^3 - 15 u^4 + 6 u^5 from rest to rest, and its two derivatives by u.

    u is the fraction of the duration, 1 after it; the profile is the fraction of the distance. Source: flash1985.
    """
    u = np.minimum(time_fraction, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * (u - u**2) ** 2, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


def rest_states(angles: Array) -> States:
    """Return states of rest at angles, rad."""
    return States(angles, np.zeros_like(angles), np.zeros_like(angles))


@dataclass(frozen=True)
class Trajectory(ABC):
    """Motion of an arm's joints over time."""

    duration: float  # s

    def states(self, times: ArrayLike) -> States:
        """Return the states of the joints at times (instants,), s; beyond the motion, those at its ends."""
        return self._states(np.clip(np.asarray(times, dtype=np.float64), 0.0, self.duration))

    def angles_at(self, times: ArrayLike) -> Array:
        """Return angles (instants, joints), rad, at times (s), as `states` does."""
        return self.states(times).angles

    def cycles(self, cycle: float) -> int:
        """Return the number of control cycles of `cycle` s that the motion takes, rounded up, at least one."""
        return max(ceil(self.duration / cycle - 1e-9), 1)

    def times(self, cycle: float) -> Array:
        """Return the instants (s) of control cycles of `cycle` s, from 0 to the first at or after the end."""
        return cycle * np.arange(self.cycles(cycle) + 1, dtype=np.float64)

    def rows(self, cycle: float) -> States:
        """Return the states at every control cycle (s), as a scenario's demand with velocity and acceleration."""
        return self.states(self.times(cycle))

    @abstractmethod
    def _states(self, times: Array) -> States:
        """Return the states of the joints at times (s) within the duration."""


@dataclass(frozen=True)
class PathMotion(Trajectory):
    """Motion along a path, with the distance along it as a function of time."""

    path: JointPath
    timing: Timing

    def _states(self, times: Array) -> States:
        s, speed, acceleration = (column[:, None] for column in self.timing(times))
        q, first, second = self.path.evaluate(s[:, 0])
        return States(q, first * speed, second * speed**2 + first * acceleration)


@dataclass(frozen=True)
class RestMotion(Trajectory):
    """Pause at constant angles (joints,), rad."""

    angles: Array

    def _states(self, times: Array) -> States:
        still = np.zeros((len(times), len(self.angles)))
        return States(still + self.angles, still, still)


@dataclass(frozen=True)
class MotionSequence(Trajectory):
    """Sequence of motions."""

    parts: tuple[Trajectory, ...]

    @classmethod
    def join(cls, *parts: Trajectory) -> "MotionSequence":
        """Return one or more motions, one after another."""
        return cls(sum(part.duration for part in parts), parts)

    @cached_property
    def start_times(self) -> Array:
        """Start time of each motion, s."""
        return np.cumsum([0.0, *(part.duration for part in self.parts[:-1])])

    def _states(self, times: Array) -> States:
        """Return the states of the motion that holds at each of the times (s)."""
        which = np.searchsorted(self.start_times, times, side="right") - 1
        states = [part.states(times[which == i] - self.start_times[i]) for i, part in enumerate(self.parts)]
        rows = np.argsort(np.argsort(which, kind="stable"))  # in the joined states, of each time
        return States(*(np.concatenate(signal)[rows] for signal in zip(*states, strict=True)))


JUMP_ACCELERATION = 100.0  # greatest change of velocity per time of a motion, rad/s2; more is a jump
JUMP_JERK = 5e3  # greatest change of acceleration per time of a motion, rad/s3; more is a jump


def lasting_rate(x: Array, cycle: float, limit: float = JUMP_JERK) -> Array:
    """Return the rate of change of rows to the next cycle, where it lasts for more than a cycle; zero elsewhere.

    Args:
        x: values, (cycles, joints).
        cycle: control cycle, s.
        limit: greatest change of a lasting rate from cycle to cycle, over the cycle.

    Returns:
        Rates (cycles, joints).
    """
    f = np.diff(x, axis=0, append=x[-1:]) / cycle
    if len(x) > 1:
        f[-1] = f[-2]
    close = np.abs(np.diff(f, axis=0)) <= limit * cycle
    never = np.zeros_like(x, dtype=bool)
    after, before = never.copy(), never.copy()
    after[:-1], before[1:] = close, close
    return np.where(after | before, f, 0.0)


def derived_rates(angles: Array, cycle: float) -> tuple[Array, Array]:
    """Return velocity (rad/s) and acceleration (rad/s2), (cycles, joints) each, of angles (rad) a `cycle` (s) apart.

    They are 0 where the angles jump.
    """
    velocity = lasting_rate(angles, cycle, JUMP_ACCELERATION)
    return velocity, lasting_rate(velocity, cycle)
