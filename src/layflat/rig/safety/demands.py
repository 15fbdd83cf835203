"""What is let through of the demands: inside the working stroke, and no faster than joints can go."""

from __future__ import annotations

from math import isfinite

from layflat.rig.safety.limits import Limits


class DemandGate:
    """The gate of one joint.

    A demand may jump ahead of a reference by `lead`; the reference follows it at the limits' `demand_speed`. Small
    steps so pass as they are, and large ones become a step and a ramp.

    Args:
        limits: of the joint.
    """

    __slots__ = ("demand", "limited", "limits", "reference", "refused")

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self.freeze(0.0)

    def margin(self, asked: float) -> float:
        """What is left to the stops where the joint goes, or comes from, rad."""
        there = abs(asked) if abs(asked) <= self.limits.working else abs(self.demand)
        return self.limits.mechanical - max(there, abs(self.reference))

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
        self.refused = not (isfinite(asked) and abs(asked) <= self.limits.working + 1e-9)
        if self.refused:
            asked = self.demand
        low, high = self.reference - lead, self.reference + lead
        allowed = low if asked < low else high if asked > high else asked
        self.limited = allowed != asked
        self.demand = allowed
        self.settle(elapsed)
        return allowed

    def settle(self, elapsed: float) -> None:
        """Let the reference go on towards the demand."""
        way, left = self.limits.demand_speed * elapsed, self.demand - self.reference
        self.reference = self.demand if abs(left) <= way else self.reference + (way if left > 0.0 else -way)
