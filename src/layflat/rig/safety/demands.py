"""What is let through of the demands: inside the working stroke, and no faster than joints can go."""

from math import isfinite
from typing import NamedTuple

from layflat.jit import law

LIMITED, REFUSED = 1, 2  # what became of a demand that was not let through as it is
TOLERANCE = 1e-9  # beyond the working stroke that is rounding, rad


class Gate(NamedTuple):
    """What demands of a joint are let through by."""

    working: float  # half the working stroke, rad
    mechanical: float  # half the mechanical stroke, rad
    speed: float  # of the reference, rad/s


class Demand(NamedTuple):
    """A demand that was let through, and the reference that goes on towards it, rad."""

    demand: float
    reference: float


@law
def ahead(now):
    """How far a demand is ahead of its reference, rad."""
    return abs(now.demand - now.reference)


@law
def margin(gate, now, asked):
    """What is left to the stops where a joint goes, or comes from, rad."""
    there = abs(asked) if abs(asked) <= gate.working else abs(now.demand)
    return gate.mechanical - max(there, abs(now.reference))


@law
def settled(gate, now, elapsed):
    """Let the reference go on towards the demand for `elapsed` seconds."""
    way, left = gate.speed * elapsed, now.demand - now.reference
    reference = now.demand if abs(left) <= way else now.reference + (way if left > 0.0 else -way)
    return Demand(now.demand, reference)


@law
def followed(gate, now, asked, lead, elapsed):
    """The demand after a cycle in which this angle (rad) was asked for, and what became of it.

    A demand may jump ahead of the reference by `lead`; the reference follows it. Small steps so pass as they are, and
    large ones become a step and a ramp. One outside the stroke changes nothing.
    """
    refused = not (isfinite(asked) and abs(asked) <= gate.working + TOLERANCE)
    wanted = now.demand if refused else asked
    # One that turns back while the joint is on its way would leap by twice the lead from the reference.
    turned_back = (wanted - now.demand) * (now.demand - now.reference) < 0.0
    reference = now.demand if turned_back else now.reference
    low, high = reference - lead, reference + lead
    allowed = low if wanted < low else high if wanted > high else wanted
    outcome = REFUSED if refused else (LIMITED if allowed != wanted else 0)
    return settled(gate, Demand(allowed, reference), elapsed), outcome
