"""One step of an arm under given valve openings: where its tip ends up, and what each opening changes of that."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.kinematics import tip_position
from layflat.motion.scenario import Scenario
from layflat.physics.step import STEP
from layflat.sim.ensemble.parallel import traced

REST = 4  # control cycles at rest before the step: a period of the dither
CHANGE = 0.1  # of an opening, for its sensitivity: large enough to see past stick and slip
LOST = 10.0  # error of a run that diverged, m


@dataclass(frozen=True)
class Shooting:
    """A step that is run with openings in place of a controller, from rest at its start.

    Args:
        machine: whose plant it is.
        start: angles at which the arm rests, rad.
        end: angles whose tip is the goal, rad.
        step: of the plant, s.
    """

    machine: Machine
    start: Sequence[float]
    end: Sequence[float]
    step: float = STEP

    @cached_property
    def goal(self) -> Array:
        """Return where the tip is to come, m, (2,)."""
        return tip_position(self.machine, np.array(self.end, dtype=float))

    def errors(self, openings: Array) -> Array:
        """Return the tip's place less its goal at the end of every cycle, m, (runs, cycles, 2).

        Args:
            openings: -1..1, (runs, cycles, joints).
        """
        runs, cycles, _ = openings.shape
        # What is recorded is how a cycle begins.
        padded = np.pad(openings, ((0, 0), (REST, 1), (0, 0)))
        duration = (REST + cycles + 1) * self.machine.cycle
        scenarios = [Scenario(start=self.start, opening=one, duration=duration, noise=False) for one in padded]
        which = {"scenario": np.arange(runs)}
        angles = traced(self.machine, scenarios, which, ("angle",), step=self.step)[:, REST + 1 :, :, 0]
        errors: Array = tip_position(self.machine, np.nan_to_num(angles)) - self.goal
        errors[np.isnan(angles).any(axis=2)] = LOST
        return errors

    def sensitivities(self, openings: Array, free: int) -> Array:
        """Return the change of the tip's errors with each opening of the first cycles, m, (free, joints, cycles, 2).

        Args:
            openings: -1..1, (cycles, joints).
            free: how many cycles.
        """
        joints = openings.shape[1]
        changes = np.where(openings[:free] > 0.0, -CHANGE, CHANGE)
        runs = np.repeat(openings[None], 1 + free * joints, axis=0)
        for i, (k, j) in enumerate(np.ndindex(free, joints)):
            runs[1 + i, k, j] += changes[k, j]
        errors = self.errors(runs)
        found: Array = (errors[1:] - errors[0]).reshape(free, joints, *errors.shape[1:])
        return found / changes[:, :, None, None]


def settled(errors: Array, band: float) -> Array:
    """Return after how many cycles the tip stays within a band (m) of its goal, (...); cycles + 1 if it does not.

    Args:
        errors: at the end of every cycle, m, (..., cycles, 2).
        band: m.
    """
    outside = np.linalg.norm(errors, axis=-1) > band
    cycles = outside.shape[-1]
    last = cycles - np.argmax(outside[..., ::-1], axis=-1)
    found: Array = np.where(outside.any(axis=-1), last + 1, 0)
    return found
