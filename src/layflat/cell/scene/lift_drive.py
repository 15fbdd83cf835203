"""The lift: a pneumatic cylinder whose valve leads it to a height, within speed, acceleration and force."""

from __future__ import annotations

from math import copysign, sqrt

from layflat.cell.file.parts import Lift
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY, REFERENCE_TEMPERATURE

STIFFNESS = 4000.0
"""Of the air in the cylinder against what keeps the piston from where its valve leads it, N/m."""
DAMPING_RATIO = 1.0
AMBIENT = 101325.0
"""Pa"""


class LiftDrive:
    """Where the piston is led to, and the force on it; stroke counts from up (0) to down.

    Args:
        described: the lift of a cell.
        step: time between two calls of `force`, s.

    Attributes:
        air: that it has taken so far, m^3 of normal volume: a stroke either way fills what the piston leaves.
        demand: stroke to which it is to go, m; settable, cut to the stroke's ends.
    """

    def __init__(self, described: Lift, step: float) -> None:
        self._lift, self._step = described, step
        self._damping = 2.0 * DAMPING_RATIO * sqrt(STIFFNESS * described.mass)
        density = (described.pressure + AMBIENT) / (GAS_CONSTANT * REFERENCE_TEMPERATURE)
        self._air_per_metre = described.force / described.pressure * density / NORMAL_DENSITY
        self._at, self._speed, self._demand, self.air = 0.0, 0.0, 0.0, 0.0

    @property
    def demand(self) -> float:
        """Stroke to which it is to go, m."""
        return self._demand

    @demand.setter
    def demand(self, stroke: float) -> None:
        self._demand = min(max(stroke, 0.0), self._lift.stroke)

    def force(self, stroke: float, speed: float) -> float:
        """Return the force on the piston downwards (N) from where it is (m) and its speed (m/s)."""
        self._wait_for(stroke)
        self.air += self._air_per_metre * abs(speed) * self._step
        behind = STIFFNESS * (self._at - stroke) + self._damping * (self._speed - speed)
        before = self._speed
        self._lead()
        force = behind + self._lift.mass * (self._speed - before) / self._step
        return min(max(force, -self._lift.force), self._lift.force)

    def _lead(self) -> None:
        """Move on towards the demand so that there is always room to stop: this is what the cushions do."""
        h, most = self._step, self._lift.acceleration
        way = self._demand - self._at
        # The fastest from which whole steps of deceleration still end at the demand.
        stopping = sqrt((0.5 * most * h) ** 2 + 2.0 * most * abs(way)) - 0.5 * most * h
        wanted = copysign(min(self._lift.speed, stopping, abs(way) / h), way)
        change = min(max(wanted - self._speed, -most * h), most * h)
        self._speed += change
        self._at += self._speed * h

    def _wait_for(self, stroke: float) -> None:
        """Keep what leads a blocked piston within the greatest force, so that it is not shot off when freed."""
        most = self._lift.force / STIFFNESS
        if abs(self._at - stroke) > most:
            self._at, self._speed = stroke + copysign(most, self._at - stroke), 0.0
