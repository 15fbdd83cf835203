"""Motions through time: angles, velocities and accelerations of all joints at any instant."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from math import ceil
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from layflat.arrays import Array
from layflat.motion.path import Path

QUINTIC_PEAKS = 15.0 / 8.0, 10.0 / 3.0**0.5  # of `quintic`: velocity over L/T, acceleration over L/T2

Timing = Callable[[Array], tuple[Array, Array, Array]]
"""From times (s) to how far along a path, how fast, and with which acceleration, one of each a time."""


class States(NamedTuple):
    """States of all joints at several instants, (instants, joints) each, or at one, (joints,) each."""

    angles: Array  # rad
    velocities: Array  # rad/s
    accelerations: Array  # rad/s2


def quintic(share: Array) -> tuple[Array, Array, Array]:
    """Return how much of its way the motion with the least jerk has gone at shares of its time, and two derivatives.

    It goes from rest to rest: 10 u^3 - 15 u^4 + 6 u^5. Source: flash1985.
    """
    u = np.minimum(share, 1.0)
    return u**3 * (10.0 - 15.0 * u + 6.0 * u**2), 30.0 * (u - u**2) ** 2, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u)


def at_rest(angles: Array) -> States:
    """Return joints that stand still at angles, rad."""
    return States(angles, np.zeros_like(angles), np.zeros_like(angles))


@dataclass(frozen=True)
class Trajectory(ABC):
    """A motion of an arm's joints."""

    duration: float  # s

    def states(self, times: ArrayLike) -> States:
        """Return what the joints do at times (instants,) from the beginning on, s; before and after it, at its ends."""
        return self._states(np.clip(np.asarray(times, dtype=np.float64), 0.0, self.duration))

    def at(self, times: ArrayLike) -> Array:
        """Return angles (instants, joints), rad, at times (s)."""
        return self.states(times).angles

    def cycles(self, cycle: float) -> int:
        """Return how many control cycles (s) the motion takes: one at least."""
        return max(ceil(self.duration / cycle - 1e-9), 1)

    def times(self, cycle: float) -> Array:
        """Return the instants of control cycles (s) from the beginning until the motion has ended."""
        return cycle * np.arange(self.cycles(cycle) + 1, dtype=np.float64)

    def rows(self, cycle: float) -> States:
        """Return one row a control cycle (s): what a scenario takes as demand, with its velocity and acceleration."""
        return self.states(self.times(cycle))

    @abstractmethod
    def _states(self, times: Array) -> States:
        """Return what the joints do at times within the duration."""


@dataclass(frozen=True)
class Along(Trajectory):
    """A motion along a path, by a law of how far it is along it."""

    path: Path
    timing: Timing

    def _states(self, times: Array) -> States:
        s, speed, acceleration = (column[:, None] for column in self.timing(times))
        q, first, second = self.path.at(s[:, 0])
        return States(q, first * speed, second * speed**2 + first * acceleration)


@dataclass(frozen=True)
class Rest(Trajectory):
    """A pause at the same angles (joints,), rad."""

    angles: Array

    def _states(self, times: Array) -> States:
        still = np.zeros((len(times), len(self.angles)))
        return States(still + self.angles, still, still)


@dataclass(frozen=True)
class Chain(Trajectory):
    """Motions one after another."""

    parts: tuple[Trajectory, ...]

    @classmethod
    def of(cls, *parts: Trajectory) -> "Chain":
        """Return a chain of one or more motions."""
        return cls(sum(part.duration for part in parts), parts)

    @cached_property
    def begins(self) -> Array:
        """When each of the motions begins, s."""
        return np.cumsum([0.0, *(part.duration for part in self.parts[:-1])])

    def _states(self, times: Array) -> States:
        which = np.searchsorted(self.begins, times, side="right") - 1
        made = [part.states(times[which == i] - self.begins[i]) for i, part in enumerate(self.parts)]
        return States(*map(np.concatenate, zip(*made, strict=True)))
