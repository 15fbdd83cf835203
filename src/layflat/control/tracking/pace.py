"""How fast the arm may go along its way: by what its joints can do, and how much of that it uses.

| symbol | meaning | unit |
|---|---|---|
| e | unit vector of the way from the reference to the goal, in joint space | 1 |
| w | torque per acceleration along the way, of each joint: M e | kg m2 |
"""

from typing import NamedTuple

from layflat.control.tracking.algebra import least, times
from layflat.control.tracking.reference import Pace, angle_of, velocity_of
from layflat.jit import composition, law
from layflat.lanes import each
from layflat.physics.arms import dynamics

LEAST_SHARE = 0.1  # of its torque that a joint is always given to accelerate, however heavy its friction is believed
LEAST_INERTIA = 1e-3  # along a way, kg m2


class Ability(NamedTuple):
    """What hoses and valve of a joint can do."""

    torque: float  # greatest, N m
    rate: float  # of the torque with the valve open, N m/s
    speed: float  # at which an open valve just feeds the hoses, rad/s


class Care(NamedTuple):
    """How much of its abilities the arm uses, and how exact it is."""

    braking: float  # share of torque that brakes on the way
    jerk: float  # share of the torque's rate
    quickest: float  # no move is meant to take less, s
    tolerance: float  # distance of the tip from its goal within which the arm has arrived, m


@law
def _most(able, friction, speed, w):
    left = max(1.0 - abs(speed) / able.speed, 0.05)
    return max(able.torque * left - friction, LEAST_SHARE * able.torque) / w


@law
def _brakes(able, friction, w):
    return (able.torque + friction) / w


@law
def _jerk(able, w):
    return able.rate / w


@law
def _speed(able, e):
    return 0.95 * able.speed / max(abs(e), 1e-6)


@law
def _heavier(here, there):
    heavier = max(abs(here), abs(there))
    return max(heavier, LEAST_INERTIA)


@composition
def pace_of(care, abilities, belief, arm, ahead, goals, way, references):
    """Limits along the way, by the torques that remain for it here and at the goal, whichever leave less."""
    there, _, _ = dynamics(arm, belief.payload, each(angle_of, goals), each(velocity_of, goals))
    w = each(_heavier, times(ahead.mass, way), times(there, way))
    speeds = each(velocity_of, references)
    return Pace(
        least(each(_most, abilities, belief.frictions, speeds, w)),
        care.braking * least(each(_brakes, abilities, belief.frictions, w)),
        care.jerk * least(each(_jerk, abilities, w)),
        least(each(_speed, abilities, way)),
    )


@law
def gentle(pace, leg, quickest):
    """The pace of a short way: limited such that it takes a certain time at least (s), were jerk the only limit."""
    acceleration = 8.0 * leg / (quickest * quickest)
    return Pace(
        min(pace.acceleration, acceleration),
        min(pace.deceleration, acceleration),
        min(pace.jerk, 4.0 * acceleration / quickest),
        pace.velocity,
    )
