"""Lift and suction cup: how a valve leads the piston, how the vacuum builds up and leaks, and what it can hold."""

from math import copysign, exp, pi, sqrt

from layflat.cell.file.parts import Cup, Lift
from layflat.physics.air import GAS_CONSTANT, NORMAL_DENSITY, REFERENCE_TEMPERATURE

STIFFNESS = 4000.0  # of the air in the cylinder against what keeps the piston from where its valve leads it, N/m
AMBIENT = 101325.0  # Pa


class LiftDrive:
    """A pneumatic cylinder whose valve leads it to a stroke, within speed, acceleration and force.

    Strokes count from up (0) to down, m. `air` is what it has taken so far, m^3 of normal volume: a stroke either way
    fills what the piston leaves. `force` is called once a `step` (s).
    """

    def __init__(self, described: Lift, step: float) -> None:
        self._lift, self._step = described, step
        self._damping = 2.0 * sqrt(STIFFNESS * described.mass)  # critical
        density = (described.pressure + AMBIENT) / (GAS_CONSTANT * REFERENCE_TEMPERATURE)
        self._air_per_metre = described.force / described.pressure * density / NORMAL_DENSITY
        self._at, self._speed, self._demand, self.air = 0.0, 0.0, 0.0, 0.0

    @property
    def demand(self) -> float:
        """Stroke to which it is to go, m; settable, cut to the stroke's ends."""
        return self._demand

    @demand.setter
    def demand(self, stroke: float) -> None:
        self._demand = min(max(stroke, 0.0), self._lift.stroke)

    def force(self, stroke: float, speed: float) -> float:
        """Return the force on the piston downwards (N) from where it is (m) and its speed (m/s)."""
        # What leads a blocked piston keeps within the greatest force, so that it is not shot off when freed.
        most = self._lift.force / STIFFNESS
        if abs(self._at - stroke) > most:
            self._at, self._speed = stroke + copysign(most, self._at - stroke), 0.0
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


class SuctionCup:
    """The vacuum (below ambient, Pa) in a cup and the force that it holds with; set `on` to switch the ejector.

    The ejector draws the vacuum p towards its level while it is on; air that leaks in, more through an open cup than
    through skin, draws it to zero; a valve that is off lets air in besides:
    p' = on (level - p) / build_up - p / leak - off p / release. Each step is solved exactly. `air` is what the ejector
    has taken so far, m^3 of normal volume.
    """

    def __init__(self, described: Cup) -> None:
        self._cup = described
        self._area = pi / 4.0 * described.effective_diameter**2
        self.on, self.vacuum, self.air = False, 0.0, 0.0

    @property
    def force(self) -> float:
        """Force with which the vacuum draws what is under the cup to it, N."""
        return self.vacuum * self._area

    def advance(self, sealed: bool, step: float) -> None:
        """Advance by a step (s), on a skin or open."""
        rate = 1.0 / (self._cup.leak if sealed else self._cup.open_leak)
        if self.on:
            rate += 1.0 / self._cup.build_up
            self.air += self._cup.air * step
        else:
            rate += 1.0 / self._cup.release
        end = self._cup.vacuum / (self._cup.build_up * rate) if self.on else 0.0
        self.vacuum = end + (self.vacuum - end) * exp(-rate * step)

    def holds(self, pull: float, shear: float) -> bool:
        """Return whether it holds against a force away from it and one sideways, N; to moments its bellows give way."""
        # The lip presses with what the pull leaves of the vacuum's force, and friction follows from that.
        return self.force >= pull and shear <= self._cup.friction * (self.force - pull)
