"""What is let through of the demands: inside the working stroke, and no faster than joints can go."""

from __future__ import annotations

from math import isfinite


class DemandGate:
    """The gate of one joint.

    A demand may jump ahead of a reference by `lead`; the reference follows it at `speed`. Small
    steps so pass as they are, and large ones become a step and a ramp.

    Args:
        working: half the working stroke, rad.
        mechanical: half the mechanical stroke, rad.
        speed: of the reference, rad/s.
    """

    __slots__ = ("demand", "limited", "mechanical", "reference", "refused", "speed", "working")

    def __init__(self, working: float, mechanical: float, speed: float) -> None:
        self.working, self.mechanical, self.speed = working, mechanical, speed
        self.freeze(0.0)

    def margin(self, asked: float) -> float:
        """What is left to the stops where the joint goes, or comes from, rad."""
        there = abs(asked) if abs(asked) <= self.working else abs(self.demand)
        return self.mechanical - max(there, abs(self.reference))

    def freeze(self, angle: float) -> None:
        """From now on ask for this angle (rad)."""
        self.demand = self.reference = angle
        self.limited = self.refused = False

    @property
    def ahead(self) -> float:
        """How far the demand is ahead of the reference, rad."""
        return abs(self.demand - self.reference)

    def follow(self, asked: float, lead: float, elapsed: float) -> float:
        """The demand after a cycle in which this angle (rad) was asked for; one outside the stroke changes nothing."""
        self.refused = not (isfinite(asked) and abs(asked) <= self.working + 1e-9)
        if self.refused:
            asked = self.demand
        if (asked - self.demand) * (self.demand - self.reference) < 0.0:
            # It turns back while the joint is on its way: from the reference it would leap by twice the lead.
            self.reference = self.demand
        low, high = self.reference - lead, self.reference + lead
        allowed = low if asked < low else high if asked > high else asked
        self.limited = allowed != asked
        self.demand = allowed
        self.settle(elapsed)
        return allowed

    def settle(self, elapsed: float) -> None:
        """Let the reference go on towards the demand."""
        way, left = self.speed * elapsed, self.demand - self.reference
        self.reference = self.demand if abs(left) <= way else self.reference + (way if left > 0.0 else -way)
