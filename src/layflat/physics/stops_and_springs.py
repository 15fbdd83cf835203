"""End stops and springs of a joint's shaft.

At an end the collapsed hose is squeezed first, then the arm meets the mechanical stop. A spring brings back a joint
that has a single hose, or bears part of what an arm weighs.

| symbol | meaning | unit |
|---|---|---|
| q | joint angle from the middle of the stroke | rad |
| k_h, q_h | stiffness of the squeezed hose, and the angle at which squeezing begins | N m/rad, rad |
| k_s, q_s | stiffness of the mechanical stop, and its angle | N m/rad, rad |
| d_s | damping while the mechanical stop is touched | N m s/rad |
"""

from typing import NamedTuple

from layflat.jit import by_kind, law
from layflat.lanes import select
from layflat.physics.arms.kind import NONE


class Stops(NamedTuple):
    """Parameters of the end stops on both sides (units as in the module's table)."""

    squeeze_angle: float
    squeeze_stiffness: float
    stop_angle: float
    stop_stiffness: float
    stop_damping: float


@law
def _past(q, limit):
    return max(q - limit, 0.0) + min(q + limit, 0.0)


@law
def stop_torque(stops, q):
    """Torque of the stops on the joint, N m."""
    return -stops.squeeze_stiffness * _past(q, stops.squeeze_angle) - stops.stop_stiffness * _past(q, stops.stop_angle)


@law
def stop_damping(stops, q):
    """Damping of the mechanical stop at q, N m s/rad."""
    return select(abs(q) > stops.stop_angle, stops.stop_damping, 0.0)


@law
def stop_energy(stops, q):
    """Energy stored in squeezed hose and stop, J."""
    squeezed, past = _past(q, stops.squeeze_angle), _past(q, stops.stop_angle)
    return 0.5 * (stops.squeeze_stiffness * squeezed * squeezed + stops.stop_stiffness * past * past)


class NoSpring(NamedTuple):
    """A joint without one."""


class Spring(NamedTuple):
    """Torque at q = 0 (N m; positive turns the joint forward), and stiffness (N m/rad)."""

    torque: float
    stiffness: float


@law
def _nothing(spring, q):  # noqa: ARG001
    return NONE


@law
def _torque(spring, q):
    return spring.torque - spring.stiffness * q


spring_torque = by_kind({NoSpring: _nothing, Spring: _torque})
"""Torque of a spring on the joint, N m: `spring_torque(spring, q)`."""


def spring_energy(spring: Spring, q: float) -> float:
    """Return the energy that is stored in a spring beyond that at q = 0, J."""
    return q * (0.5 * spring.stiffness * q - spring.torque)
