"""Corrections of a demand over time, and the filter that computes them from errors.

| symbol | meaning | unit |
|---|---|---|
| u(t) = sum c_i B_i(t) | correction of an angle, a spline of fifth degree on even knots | rad |
| e(t) | error of an angle: reference less measured | rad |
| h | distance of the knots | s |
| T_s | smoothing | s |
| T_l | lead | s |

The filter computes the c that minimize |e(t + T_l) - u(t)|^2 + T_s^4 |u''(t)|^2. Far from the ends it has zero phase,
and a gain of 1/(1 + (T_s w)^4) at the angular frequency w. The splines and four derivatives are zero at both ends, so
that a correction does not jump there, and its velocities and accelerations are exact derivatives.
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

SPLINE_DEGREE = 5
MIN_INTERVALS = SPLINE_DEGREE + 1  # between knots: the support of one spline
MAX_BANDWIDTH_PER_CYCLE = 0.15  # bandwidth (1/s) times the control cycle (s)

# Ratios to the time constant of the closed loop:
SMOOTHING_RATIO, LEAD_RATIO = 0.75, 0.3
LEAD_IN_RATIO, TAIL_RATIO = 1.5, 6.0


class CorrectionFilter(NamedTuple):
    """Times of the filter from errors to corrections, s."""

    smoothing: float  # T_s, and the distance of the knots
    lead: float  # T_l
    lead_in: float  # rest before the motion, in which a correction may already act
    tail: float  # rest after the motion, in which the correction fades


def choose_filter(machine: Machine) -> CorrectionFilter:
    """Return the filter for a machine's controller, in proportion to the time constant of its loop.

    The time constant is one over the controller's bandwidth, if it has one, and at least a control cycle over 0.15. The
    times of the filter are whole control cycles.
    """
    highest = MAX_BANDWIDTH_PER_CYCLE / machine.cycle
    constant = 1.0 / min(float(getattr(machine.controller, "bandwidth", highest)), highest)
    cycles = (
        max(round(ratio * constant / machine.cycle), 1)
        for ratio in (SMOOTHING_RATIO, LEAD_RATIO, LEAD_IN_RATIO, TAIL_RATIO)
    )
    return CorrectionFilter(*(machine.cycle * count for count in cycles))


@dataclass(frozen=True)
class CorrectionSplines:
    """Splines over the control cycles of a demand, and the filter of errors into their coefficients."""

    cycle: float  # s
    cycles: int
    filter: CorrectionFilter

    @property
    def _end(self) -> float:
        return self.cycle * (self.cycles - 1)

    @cached_property
    def count(self) -> int:
        """Number of splines per joint."""
        return max(round(self._end / self.filter.smoothing), MIN_INTERVALS) - SPLINE_DEGREE

    @cached_property
    def _knots(self) -> Array:
        """Times of the knots, s, at even distances from the first cycle to the last."""
        spacing = self._end / (self.count + SPLINE_DEGREE)
        knots: Array = spacing * np.arange(self.count + SPLINE_DEGREE + 1, dtype=np.float64)
        return knots

    @cached_property
    def _times(self) -> Array:
        """Times of the control cycles, s."""
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
        return self._design(SPLINE_DEGREE)

    @cached_property
    def _solve(self) -> Callable[[Array], Array]:
        """Solver of the filter's linear system: a function from its right side to coefficients c."""
        # A spline's second derivative is that of three splines of a degree that is lower by two.
        differences = diags_array([1.0, -2.0, 1.0], offsets=[0, -1, -2], shape=(self.count + 2, self.count))
        bends = self._design(SPLINE_DEGREE - 2) @ differences / self._knots[1] ** 2
        values = self._values
        return splu(csc_array(values.T @ values + self.filter.smoothing**4 * (bends.T @ bends))).solve

    def filter_errors(self, errors: Array) -> Array:
        """Return coefficients (splines, joints), rad, of the correction for errors (cycles, joints), rad."""
        ahead = np.column_stack([np.interp(self._times + self.filter.lead, self._times, e) for e in errors.T])
        return self._solve(np.ascontiguousarray(self._values.T @ ahead))

    def states(self, coefficients: Array) -> States:
        """Return the correction of coefficients (splines, joints), rad, with its velocities and accelerations."""
        padded = np.pad(coefficients, ((SPLINE_DEGREE, SPLINE_DEGREE), (0, 0)))
        spacing, last = self._knots[1], len(self._knots) - 1
        spline = BSpline(spacing * np.arange(-SPLINE_DEGREE, last + SPLINE_DEGREE + 1), padded, SPLINE_DEGREE)
        return States(*(spline(self._times, order) for order in range(3)))
