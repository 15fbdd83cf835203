"""Corrections of a demand over time, and the filter that makes them of errors.

| symbol | meaning | unit |
|---|---|---|
| u(t) = sum c_i B_i(t) | correction of an angle, a spline of fifth degree on even knots | rad |
| e(t) | error of an angle: wanted less measured | rad |
| h | distance of the knots | s |
| T_s | smoothing | s |
| T_l | lead | s |

The filter finds the c that make |e(t + T_l) - u(t)|^2 + T_s^4 |u''(t)|^2 least. Far from the ends it has zero phase,
and a sine of angular frequency w passes with 1/(1 + (T_s w)^4). Splines that are zero with four derivatives at both
ends keep a correction from jumping there, and give it the velocities and accelerations that belong to it, exactly.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.sparse import csc_array, diags_array
from scipy.sparse.linalg import splu

from layflat.arrays import Array
from layflat.machine import Machine
from layflat.motion.trajectory import States

DEGREE = 5
FEWEST = DEGREE + 1  # intervals between knots: one spline
QUICKEST = 0.15  # bandwidth in a control cycle, at most

# Of the time constant of the closed loop:
SMOOTHING, LEAD = 0.75, 0.3
LEAD_IN, TAIL = 1.5, 6.0


class Filtering(NamedTuple):
    """How errors become corrections, s each."""

    smoothing: float  # T_s, and the distance of the knots
    lead: float  # T_l
    lead_in: float  # rest before the motion in which a correction may already act
    tail: float  # rest after it, in which it comes to an end


def filtering(machine: Machine) -> Filtering:
    """Return what suits the controller of a machine: parts and multiples of the time constant of its loop.

    That is one over its bandwidth, where its description gives one, and not less than a cycle over 0.15.
    """
    highest = QUICKEST / machine.cycle
    constant = 1.0 / min(float(getattr(machine.controller, "bandwidth", highest)), highest)
    cycles = (max(round(share * constant / machine.cycle), 1) for share in (SMOOTHING, LEAD, LEAD_IN, TAIL))
    return Filtering(*(machine.cycle * count for count in cycles))


@dataclass(frozen=True)
class Corrections:
    """Splines over the instants of control cycles (s) of a demand."""

    cycle: float  # s
    cycles: int
    how: Filtering

    @property
    def _end(self) -> float:
        return self.cycle * (self.cycles - 1)

    @cached_property
    def count(self) -> int:
        """Number of splines a joint."""
        return max(round(self._end / self.how.smoothing), FEWEST) - DEGREE

    @cached_property
    def _knots(self) -> Array:
        spacing = self._end / (self.count + DEGREE)
        knots: Array = spacing * np.arange(self.count + DEGREE + 1, dtype=np.float64)
        return knots

    @cached_property
    def _times(self) -> Array:
        times: Array = self.cycle * np.arange(self.cycles, dtype=np.float64)
        return times

    def _design(self, degree: int) -> csc_array:
        """Return the values of all splines of a degree whose support lies within the knots, (cycles, splines)."""
        spacing, last = self._knots[1], len(self._knots) - 1
        wider = spacing * np.arange(-degree, last + degree + 1)
        # The last instant is the last knot, but for rounding.
        times = np.minimum(self._times, wider[degree + last])
        return csc_array(BSpline.design_matrix(times, wider, degree))[:, degree:last]

    @cached_property
    def _values(self) -> csc_array:
        return self._design(DEGREE)

    @cached_property
    def _solve(self) -> Callable[[Array], Array]:
        # A spline's second derivative is that of three splines of a degree that is lower by two.
        differences = diags_array([1.0, -2.0, 1.0], offsets=[0, -1, -2], shape=(self.count + 2, self.count))
        bends = self._design(DEGREE - 2) @ differences / self._knots[1] ** 2
        values = self._values
        return splu(csc_array(values.T @ values + self.how.smoothing**4 * (bends.T @ bends))).solve

    def filtered(self, errors: Array) -> Array:
        """Return coefficients (splines, joints), rad, of the correction for errors (cycles, joints), rad."""
        ahead = np.column_stack([np.interp(self._times + self.how.lead, self._times, e) for e in errors.T])
        return self._solve(np.ascontiguousarray(self._values.T @ ahead))

    def states(self, coefficients: Array) -> States:
        """Return the correction, and its velocities and accelerations."""
        padded = np.pad(coefficients, ((DEGREE, DEGREE), (0, 0)))
        spacing, last = self._knots[1], len(self._knots) - 1
        spline = BSpline(spacing * np.arange(-DEGREE, last + DEGREE + 1), padded, DEGREE)
        return States(*(spline(self._times, order) for order in range(3)))
